//! Checks that a solid can be simulated: its size, its nodes, the shape and orientation of its
//! tets.

use super::error::{Defect, MeshError};
use super::quality::{corners, quality, six_volumes};
use super::solid::Solid;
use super::topology;
use super::unit::LengthUnit;

/// Lower bound of a mesh's largest extent [m]: below it the length unit must be wrong. A probe tip
/// is millimetres wide, and an organ in metres that is read as millimetres is 0.1 mm long.
pub const MIN_SIZE_M: f64 = 1e-3;

/// Upper bound of a mesh's largest extent [m]: above it the length unit must be wrong. Nothing that
/// is palpated is larger than a body, and an organ in millimetres that is read as metres is 100 m
/// long.
pub const MAX_SIZE_M: f64 = 2.0;

/// Largest distance of a mesh from the origin of its coordinates [m]: at 10 m a position in single
/// precision is known to a micrometre, far below what a probe feels.
pub const MAX_OFFSET_M: f64 = 10.0;

/// Least quality of a tet (1); the regular tet has 1. In an organ a hundred edges wide, rounding to
/// `f32` moves a node by 1e-5 of an edge: a flatter tet could be inside out before it is touched.
pub const MIN_QUALITY: f64 = 1e-4;

/// Results of the check of a sound solid.
pub(super) struct Findings {
    pub flipped_tets: usize,
    /// Extents along x, y, z [m].
    pub size_m: [f64; 3],
    pub volume_m3: f64,
    /// Index and quality of the flattest tet.
    pub worst: (usize, f64),
}

/// Checks a solid and orients its tets positively; fails with the first kind of defect that is
/// present.
pub(super) fn check(solid: &mut Solid, unit_m: f64) -> Result<Findings, MeshError> {
    let size_m = size(&solid.mesh.nodes_m, unit_m).map_err(|defect| solid.error(defect))?;
    no_coincident_nodes(solid)?;
    let worst = no_flat_tets(solid)?;
    let flipped_tets = orient(solid);
    topology::check(solid)?;
    Ok(Findings { flipped_tets, size_m, volume_m3: solid.mesh.volume_m3(), worst })
}

/// Checks that the extents [m] are plausible; the unit of the file is `unit_m` metres.
pub(super) fn size(nodes_m: &[[f64; 3]], unit_m: f64) -> Result<[f64; 3], Defect> {
    let mut low = [f64::INFINITY; 3];
    let mut high = [f64::NEG_INFINITY; 3];
    for node in nodes_m {
        for axis in 0..3 {
            low[axis] = low[axis].min(node[axis]);
            high[axis] = high[axis].max(node[axis]);
        }
    }
    let size_m = [high[0] - low[0], high[1] - low[1], high[2] - low[2]];
    let largest_m = size_m.into_iter().fold(0.0, f64::max);
    if (MIN_SIZE_M..=MAX_SIZE_M).contains(&largest_m) {
        let farthest_m = low.iter().chain(&high).fold(0.0, |farthest: f64, x| farthest.max(x.abs()));
        if farthest_m > MAX_OFFSET_M {
            let middle = [0, 1, 2].map(|k| 0.5 * (low[k] + high[k]) / unit_m);
            // adding zero turns -0 into 0
            let place = middle.map(|x| format!("{:.0}", 0.0 - x.round())).join(", ");
            return Err(Defect::Far { farthest_m, most_m: MAX_OFFSET_M, place });
        }
        return Ok(size_m);
    }
    let [x, y, z] = size_m.map(millimetres);
    let named =
        LengthUnit::NAMED.into_iter().find(|(_, named_m)| (MIN_SIZE_M..=MAX_SIZE_M).contains(&(largest_m / unit_m * named_m)));
    let example = match named {
        Some((name, named_m)) => {
            let size_mm = millimetres(largest_m / unit_m * named_m);
            format!(" (\"{name}\" would make it {size_mm} mm)")
        }
        None => String::new(),
    };
    Err(Defect::Size {
        size_mm: format!("{x} x {y} x {z}"),
        hint: format!(
            "a file unit is taken as {} mm, set length_unit (--unit) to \"m\", \"cm\", \"mm\", \"um\" or the metres in a file unit{example}",
            millimetres(unit_m)
        ),
    })
}

/// A length as text in millimetres, with few digits.
fn millimetres(length_m: f64) -> String {
    let mm = 1e3 * length_m;
    if (0.01..1e6).contains(&mm) {
        let text = format!("{mm:.2}");
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        format!("{mm:.1e}")
    }
}

fn no_coincident_nodes(solid: &Solid) -> Result<(), MeshError> {
    let nodes_m = &solid.mesh.nodes_m;
    let mut order: Vec<usize> = (0..nodes_m.len()).collect();
    // Adding zero makes -0 and 0 equal.
    let place = |index: usize| nodes_m[index].map(|x| x + 0.0);
    order.sort_unstable_by(|&i, &j| {
        let ([ax, ay, az], [bx, by, bz]) = (place(i), place(j));
        ax.total_cmp(&bx).then(ay.total_cmp(&by)).then(az.total_cmp(&bz)).then(i.cmp(&j))
    });
    let pairs = order.windows(2).filter_map(|pair| match *pair {
        [first, second] if place(first) == place(second) => Some((second, first)),
        _ => None,
    });
    match pairs.min() {
        None => Ok(()),
        Some((node, first)) => Err(solid.error_at_node(
            node,
            Defect::CoincidentNodes {
                node: solid.node(node).number,
                first: solid.node(first).number,
                first_line: solid.node(first).line,
            },
        )),
    }
}

/// Index and quality of the flattest tet; an error if it is too flat.
fn no_flat_tets(solid: &Solid) -> Result<(usize, f64), MeshError> {
    let mesh = &solid.mesh;
    let mut worst = (0, f64::INFINITY);
    for (index, &tet) in mesh.tets.iter().enumerate() {
        let quality = quality(corners(&mesh.nodes_m, tet));
        if quality.is_nan() || quality < MIN_QUALITY {
            let tet = solid.tet(index).number;
            return Err(solid.error_at_tet(index, Defect::Flat { tet, quality, least: MIN_QUALITY }));
        }
        if quality < worst.1 {
            worst = (index, quality);
        }
    }
    Ok(worst)
}

/// Swaps two nodes of every inverted tet and counts these tets.
fn orient(solid: &mut Solid) -> usize {
    let mesh = &mut solid.mesh;
    let mut flipped = 0;
    for tet in &mut mesh.tets {
        if six_volumes(corners(&mesh.nodes_m, *tet)) < 0.0 {
            tet.swap(2, 3);
            flipped += 1;
        }
    }
    flipped
}
