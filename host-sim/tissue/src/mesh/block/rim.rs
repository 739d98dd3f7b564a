//! Meshes a block around a patch, with given element sizes, and with nodes on the half sphere along
//! which the patch is cut out.

use super::grading::Grading;
use super::relax::relax;
use super::seed::{Side, seed};
use super::sliver::remove_slivers;
use super::vector::{Vec3, add_scaled};
use super::{BlockError, MAX_GROWTH, MAX_NODES, MIN_QUALITY, check_size, check_spot, radius_ratio, to_metres, to_unit, unit_box};
use crate::mesh::TetMesh;

/// Element sizes of a whole organ around the patch that will be cut out of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sizes {
    /// Radius of the patch around the site [m].
    pub radius_m: f64,
    /// Edge length at the site [m].
    pub fine_m: f64,
    /// Distance from the site within which edges have that length [m].
    pub fine_radius_m: f64,
    /// Growth of the edge length per distance beyond that (1).
    pub growth: f64,
}

/// Number of arrangements that are tried until no tet crosses the shell; otherwise the one with the
/// fewest crossings is used.
const ATTEMPTS: u32 = 6;
/// Number of bisections in the search for the nearest sizes that work.
const HALVINGS: usize = 24;

/// Meshes a block (`size_m` along x, y, z, top face at z = 0) around a site on its top face.
///
/// Edges have the length that `sizes` asks for, but no more than half the gap between patch and
/// wall. The tets whose centroid is within `sizes.radius_m` of the site are
/// connected by faces and end on that half sphere: the rim nodes are on it, except at a few faces
/// where no sound tets would fit. Another `variant` arranges the same number of nodes differently;
/// for the same arguments the mesh is bit-identical on every machine.
///
/// # Errors
/// Fails if a size is not positive, if the sizes do not fit the block, or if they require more
/// nodes than a patch file can index.
pub fn block_with_rim(size_m: [f64; 3], at_m: [f64; 2], sizes: &Sizes, variant: u32) -> Result<TetMesh, BlockError> {
    let grading = checked(size_m, at_m, sizes)?;
    let budget = grading.with_shell();
    let mut best: Option<(usize, TetMesh)> = None;
    for attempt in 0..ATTEMPTS {
        let mut cloud = seed(&grading, &budget, variant.wrapping_mul(ATTEMPTS).wrapping_add(attempt));
        let Some(tets) = relax(&mut cloud, &grading) else { continue };
        let tets = remove_slivers(&mut cloud, &grading, tets);
        let sound = tets.iter().all(|t| radius_ratio(t.map(|n| cloud.at[n as usize])) >= MIN_QUALITY);
        let inside: Vec<bool> = tets.iter().map(|t| grading.side_of(centroid(&cloud.at, *t)) == Side::Inside).collect();
        if !(sound && [true, false].into_iter().all(|side| in_one_piece(&tets, &inside, side))) {
            continue;
        }
        let crossing = tets.iter().filter(|t| cloud.crosses_shell(**t)).count();
        if best.as_ref().is_none_or(|(least, _)| crossing < *least) {
            best = Some((crossing, to_metres(size_m, &cloud, tets)));
        }
        if crossing == 0 {
            break;
        }
    }
    best.map(|(_, mesh)| mesh).ok_or(BlockError::UnsoundPatch { value: sizes.fine_m })
}

fn checked(size_m: [f64; 3], at_m: [f64; 2], sizes: &Sizes) -> Result<Grading, BlockError> {
    check_size(size_m)?;
    check_spot(size_m, at_m)?;
    for (key, value) in [("radius_m", sizes.radius_m), ("fine_m", sizes.fine_m), ("fine_radius_m", sizes.fine_radius_m)] {
        if !(value.is_finite() && value > 0.0) {
            return Err(BlockError::Length { key, value });
        }
    }
    if !(0.0..=MAX_GROWTH).contains(&sizes.growth) {
        return Err(BlockError::Growth { value: sizes.growth });
    }
    let side = |k: usize| 0.5 * size_m[k] - at_m[k].abs();
    let wall = side(0).min(side(1)).min(size_m[2]);
    let (radius, fine) = (sizes.radius_m, sizes.fine_m);
    if wall <= 0.0 {
        return Err(BlockError::AtWall { wall, least: 2.0 * fine });
    }
    let most = radius.min(0.5 * wall);
    if fine > most {
        return Err(BlockError::Fine { value: fine, most });
    }
    let widest = wall - fine;
    if radius > widest {
        return Err(BlockError::Swallows { value: radius, most: widest });
    }
    let unit = |x: f64| to_unit(size_m, x);
    let mut grading = unit_box(size_m, at_m, sizes.fine_radius_m);
    grading.shell = Some(unit(radius));
    grading.fine_size = unit(fine);
    grading.growth = sizes.growth;
    check_nodes(&grading, sizes, most.min(wall - radius))?;
    Ok(grading)
}

/// Refuses more nodes than a patch file can index; `most_m` is the largest element that the patch
/// admits.
fn check_nodes(grading: &Grading, sizes: &Sizes, most_m: f64) -> Result<(), BlockError> {
    let with = |fine_m: f64, growth: f64| {
        let fine_size = grading.fine_size * (fine_m / sizes.fine_m);
        Grading { fine_size, growth, ..*grading }.with_shell().total()
    };
    let nodes = with(sizes.fine_m, sizes.growth);
    if nodes <= MAX_NODES {
        return Ok(());
    }
    if with(most_m, sizes.growth) <= MAX_NODES {
        let least = least(sizes.fine_m, most_m, |fine_m| with(fine_m, sizes.growth) <= MAX_NODES);
        return Err(BlockError::TooMany { value: sizes.fine_m, nodes, least });
    }
    let least = least(sizes.growth, MAX_GROWTH, |growth| with(most_m, growth) <= MAX_NODES);
    Err(BlockError::TooEven { value: sizes.growth, nodes, least })
}

/// The least value that works, between `low`, which does not work, and `high`, which does.
fn least(mut low: f64, mut high: f64, works: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if works(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    high
}

fn centroid(at: &[Vec3], tet: [u32; 4]) -> Vec3 {
    tet.into_iter().fold([0.0; 3], |sum, n| add_scaled(sum, 0.25, at[n as usize]))
}

/// Whether the tets on one side are connected by faces.
fn in_one_piece(tets: &[[u32; 4]], inside: &[bool], side: bool) -> bool {
    let chosen: Vec<usize> = (0..tets.len()).filter(|t| inside[*t] == side).collect();
    let mut faces: Vec<([u32; 3], usize)> = vec![];
    for (place, t) in chosen.iter().enumerate() {
        let mut tet = tets[*t];
        tet.sort_unstable();
        let [a, b, c, d] = tet;
        faces.extend([[b, c, d], [a, c, d], [a, b, d], [a, b, c]].map(|face| (face, place)));
    }
    faces.sort_unstable();
    let mut links = vec![vec![]; chosen.len()];
    for pair in faces.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        let (i, j) = (pair[0].1, pair[1].1);
        links[i].push(j);
        links[j].push(i);
    }
    let mut seen = vec![false; chosen.len()];
    let mut open = vec![0];
    while let Some(place) = open.pop() {
        if place < seen.len() && !std::mem::replace(&mut seen[place], true) {
            open.extend(&links[place]);
        }
    }
    !seen.is_empty() && seen.into_iter().all(|s| s)
}

#[cfg(test)]
#[path = "rim_tests.rs"]
mod tests;
