//! Builds the tissue of a scene: its mesh ([`organ`] and [`organ_source`] if it is not a block),
//! its material ([`Layout`]), its fixed nodes and the site of the press.

mod body;
mod material;
pub mod organ;
pub mod organ_source;
mod steepness;

use crate::error::Error;
use crate::mesh::{BlockError, BlockSpec, ImportReport, SurfaceReport, TetMesh, block, block_of_at_least, fit_facets, surface};
use crate::scene::{Drive, Inclusion, Scene, SceneError};
pub use body::{Joint, Tissue};
pub use material::Layout;
use nalgebra::Vector3;
pub use organ::DEFAULT_ORGAN_NODES;
use organ_source::OrganSource;
pub use steepness::steepness;

/// A mesh rests on its underside. A surface triangle is fixed if the cosine between its outward
/// normal and the axis of the press is below this value (1).
pub const UNDERSIDE_COSINE: f64 = -0.5;
/// Depth limit of the patch as a multiple of the deepest hold.
pub const DEPTH_MARGIN: f64 = 1.25;
/// Deepest press that is assumed for a force drive, and for a trace that never touches, in probe
/// radii (1): the depth up to which the contact law was measured.
const DEFAULT_DEPTH_RADII: f64 = 0.75;

/// Number of nodes of a block if the scene gives none.
pub const DEFAULT_NODES: usize = 410;

/// A tissue with the direction of the press.
#[derive(Clone, Debug)]
pub struct Placed {
    /// Tissue that is pressed.
    pub tissue: Tissue,
    /// Unit vector from the tip to the handle: the outward normal of the surface at the site.
    pub axis: [f64; 3],
    /// Report of the import, for a mesh file.
    pub import: Option<ImportReport>,
    /// Report of the import, for a surface file.
    pub surface: Option<SurfaceReport>,
}

/// Meshes or imports the tissue of a scene.
///
/// # Errors
/// A scene or a mesh file that the generator or the import refuses; a place or a press outside the
/// tissue.
pub fn place(scene: &Scene, tips_m: &[[f32; 3]]) -> Result<Placed, Error> {
    place_fine(scene, tips_m, 1.0)
}

/// Meshes or imports the tissue of a scene as [`place`] does, with a block's elements smallest
/// within `fine_radii` probe radii of the site.
///
/// # Errors
/// Errors of [`place`].
pub fn place_fine(scene: &Scene, tips_m: &[[f32; 3]], fine_radii: f64) -> Result<Placed, Error> {
    // a region that the organ does not have is refused before anything is meshed
    Layout::of(scene)?;
    match OrganSource::of(scene)? {
        Some(OrganSource::File(_, mesh, report)) => return place_imported(scene, tips_m, mesh, report),
        Some(shape) => {
            let site = shape.near_site(scene)?;
            let mesh = organ::graded(scene, &shape, &site)?;
            return on_shape(scene, tips_m, &shape, mesh, (site.at_m, site.axis));
        }
        None => {}
    }
    let size_m = scene.tissue.block_m.unwrap_or_default();
    let [x, y] = scene.probe.position_m.unwrap_or_default();
    let fine_radius_m = fine_radii * scene.probe.tip().mean_radius_m();
    let of = |nodes| BlockSpec { size_m, nodes, fine_at_m: [x, y], fine_radius_m };
    let mesh = match scene.tissue.nodes {
        Some(nodes) => block(&of(nodes)),
        None => block_of_at_least(&of(DEFAULT_NODES)),
    };
    let mesh = mesh.map_err(|cause| not_meshed(scene, cause))?;
    place_block(scene, tips_m, mesh)
}

/// Makes the tissue of a block from its mesh.
pub fn place_block(scene: &Scene, tips_m: &[[f32; 3]], mesh: TetMesh) -> Result<Placed, Error> {
    let size_m = scene.tissue.block_m.unwrap_or_default();
    let [x, y] = scene.probe.position_m.unwrap_or_default();
    // the generator places the bottom nodes at exactly this height
    let anchors = anchored(&mesh, |x| x[2] <= -size_m[2] * (1.0 - 1e-9));
    let axis = [0.0, 0.0, 1.0];
    let tissue = finish(scene, tips_m, mesh, anchors, [x, y, 0.0], axis)?;
    Ok(Placed { tissue, axis, import: None, surface: None })
}

/// Makes the tissue from the mesh of a file as it is.
fn place_imported(scene: &Scene, tips_m: &[[f32; 3]], mesh: TetMesh, report: ImportReport) -> Result<Placed, Error> {
    let site = scene.probe.site.unwrap_or_default();
    let (site_m, axis) = nearest_on_surface(&boundary(&mesh), site, scene.probe.radius_m);
    let (away, long) = (Vector3::from(site) - Vector3::from(site_m), report.size_m.into_iter().fold(0.0, f64::max));
    if away.dot(&away) > long * long {
        let why =
            format!("= {site:?} is further from the mesh than that is long ({long:.4} m): give metres, in the mesh's frame");
        return Err(SceneError::value(&scene.file, "probe.site", &why).into());
    }
    let anchors = underside(&mesh, axis);
    let tissue = finish(scene, tips_m, mesh, anchors, site_m, axis)?;
    Ok(Placed { tissue, axis, import: Some(report), surface: None })
}

/// Makes the tissue from a mesh whose surface nodes lie on a shape: its facets are fitted to the
/// shape, and it is fixed where the shape is fixed.
pub fn on_shape(
    scene: &Scene,
    tips_m: &[[f32; 3]],
    shape: &OrganSource,
    mut mesh: TetMesh,
    (site_m, axis): ([f64; 3], [f64; 3]),
) -> Result<Placed, Error> {
    fit_facets(&mut mesh, site_m, |at_m| shape.distance_m(at_m));
    let anchors = shape.anchors(&mesh, axis);
    if anchors.is_empty() {
        let why = "leaves nothing of the surface that faces away from the press to rest on: press another side";
        return Err(SceneError::value(&scene.file, "probe.site", why).into());
    }
    let tissue = finish(scene, tips_m, mesh, anchors, site_m, axis)?;
    let (import, surface) = match shape {
        OrganSource::File(_, _, report) => (Some(report.clone()), None),
        OrganSource::Surface(_, report) => (None, Some(report.clone())),
        OrganSource::Organ(_) => (None, None),
    };
    Ok(Placed { tissue, axis, import, surface })
}

fn not_meshed(scene: &Scene, cause: BlockError) -> SceneError {
    let key = if matches!(cause, BlockError::Aspect { .. }) { "tissue.block_m:" } else { "tissue.nodes:" };
    SceneError::value(&scene.file, key, &cause.to_string())
}

/// Depth limit of the patch [m]: the deepest press of the drive with a margin, or the limit that a
/// trace gives.
fn depth_limit_m(scene: &Scene, tips_m: &[[f32; 3]], site_m: [f64; 3], axis: [f64; 3]) -> f64 {
    let deepest = match &scene.drive {
        Drive::Depth { holds_m, .. } | Drive::Hand { holds_m, .. } => holds_m.iter().copied().fold(0.0, f64::max),
        Drive::Force { .. } => DEFAULT_DEPTH_RADII * scene.probe.radius_m,
        Drive::Trace { depth_limit_m: Some(limit_m), .. } => return *limit_m,
        Drive::Trace { .. } => {
            // where the tip touches the site: of a tilted one another point is the deepest
            let touch_m = Vector3::from(site_m) + scene.params(axis).touch_offset_m().cast();
            let depths = tips_m.iter().map(|tip| (touch_m - Vector3::from(tip.map(f64::from))).dot(&Vector3::from(axis)));
            let deepest = depths.fold(0.0, f64::max);
            if deepest > 0.0 { deepest } else { DEFAULT_DEPTH_RADII * scene.probe.radius_m }
        }
    };
    DEPTH_MARGIN * deepest
}

fn finish(
    scene: &Scene,
    tips_m: &[[f32; 3]],
    mesh: TetMesh,
    anchors: Vec<u32>,
    site_m: [f64; 3],
    axis: [f64; 3],
) -> Result<Tissue, SceneError> {
    let heights = mesh.nodes_m.iter().map(|x| Vector3::from(*x).dot(&Vector3::from(axis)));
    let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), h| (low.min(h), high.max(h)));
    scene.refuse_deeper_than(high - low, "the tissue is thick")?;
    let depth_limit_m = depth_limit_m(scene, tips_m, site_m, axis);
    refuse_inclusions_outside(scene, &mesh)?;
    let layout = Layout::of(scene)?;
    let stiffness_ratio = mesh.tets.iter().map(|tet| layout.of_tet(&mesh, tet)).collect();
    Ok(Tissue::closed(mesh, stiffness_ratio, anchors, site_m, depth_limit_m))
}

/// Refuses a ball that overlaps no tet or contains all nodes: a unit or the sign of a coordinate is
/// wrong.
fn refuse_inclusions_outside(scene: &Scene, mesh: &TetMesh) -> Result<(), SceneError> {
    for (n, ball) in scene.tissue.inclusion.iter().enumerate() {
        if mesh.nodes_m.iter().all(|node| ball.holds(*node)) {
            return scene.refuse_all_inclusion(n);
        }
        if filled(mesh, ball).0 > 0 {
            continue;
        }
        let bounds = [0, 1, 2].map(|k| {
            let along = mesh.nodes_m.iter().map(|x| x[k]);
            let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
            format!("{low:.4} .. {high:.4}")
        });
        let why = format!(
            "= {:?} with radius_m = {}: the ball fills no tet, it lies outside the tissue or is far smaller than the elements there: give metres within x {}, y {}, z {}",
            ball.center_m, ball.radius_m, bounds[0], bounds[1], bounds[2]
        );
        return scene.bad(&format!("tissue.inclusion[{n}].center_m"), &why);
    }
    Ok(())
}

fn anchored(mesh: &TetMesh, fixed: impl Fn(&[f64; 3]) -> bool) -> Vec<u32> {
    (0_u32..).zip(&mesh.nodes_m).filter(|(_, x)| fixed(x)).map(|(n, _)| n).collect()
}

/// Whether a surface triangle is part of the underside, which faces away from a press along `axis`.
pub(crate) fn faces_away(triangle: [Vector3<f64>; 3], axis: [f64; 3]) -> bool {
    let n = normal(triangle);
    n.dot(&Vector3::from(axis)) < UNDERSIDE_COSINE * n.dot(&n).sqrt()
}

/// The boundary triangles of a mesh, counter-clockwise seen from outside [m].
fn boundary(mesh: &TetMesh) -> Vec<[Vector3<f64>; 3]> {
    surface::surface(&mesh.tets).iter().map(|t| corners(mesh, t)).collect()
}

/// Nodes of the surface that faces away from a press along `axis`, ascending. The roof of an
/// internal cavity is not part of that surface.
pub fn underside(mesh: &TetMesh, axis: [f64; 3]) -> Vec<u32> {
    let hollow = surface::hollow(mesh);
    let away = |t: &[u32; 3]| !hollow[t[0] as usize] && faces_away(corners(mesh, t), axis);
    let mut nodes: Vec<u32> = surface::surface(&mesh.tets).into_iter().filter(away).flatten().collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

/// Stiffness ratio of a tet that may contain balls (1), averaged by [`blended`].
pub fn ratio_of(mesh: &TetMesh, tet: &[u32; 4], inclusions: &[Inclusion]) -> f64 {
    if inclusions.is_empty() {
        return 1.0;
    }
    blended(mesh, tet, |x| inclusions.iter().rev().find(|ball| ball.holds(x)).map_or(1.0, |ball| ball.stiffness_ratio))
}

/// Stiffness of a tet, averaged over many points in it, so that a small ball or a thin layer
/// between the centroids is not missed and its effective size does not jump with the mesh. The
/// average is Hill's (1952), half way between equal strain and equal stress: with equal strain
/// alone a ball smaller than the elements is 8 % too stiff.
pub fn blended(mesh: &TetMesh, tet: &[u32; 4], stiffness: impl Fn([f64; 3]) -> f64) -> f64 {
    let (mut sum, mut inverse, mut count) = (0.0, 0.0, 0.0);
    for at in samples(mesh, tet) {
        let ratio = stiffness(at);
        sum += ratio;
        inverse += 1.0 / ratio;
        count += 1.0;
    }
    0.5 * (sum / count + count / inverse)
}

/// Points spread evenly over a tet [m].
pub(crate) fn samples(mesh: &TetMesh, tet: &[u32; 4]) -> impl Iterator<Item = [f64; 3]> {
    const STEPS: usize = 6;
    let corners = tet.map(|n| mesh.nodes_m[n as usize]);
    let triples = (0..STEPS).flat_map(|i| (0..STEPS - i).flat_map(move |j| (0..STEPS - i - j).map(move |k| [i, j, k])));
    triples.map(move |[i, j, k]| {
        let w = [i, j, k, STEPS - 1 - i - j - k].map(|n| (n as f64 + 0.25) / STEPS as f64);
        [0, 1, 2].map(|c| (0..4).map(|n| w[n] * corners[n][c]).sum::<f64>())
    })
}

/// Number of tets that a ball fills or cuts, and the volume of the ball within them [m^3].
#[must_use]
pub fn filled(mesh: &TetMesh, ball: &Inclusion) -> (usize, f64) {
    let (mut tets, mut volume_m3) = (0, 0.0);
    for tet in &mesh.tets {
        let (inside, all) =
            samples(mesh, tet).fold((0.0, 0.0), |(inside, all), at| (inside + f64::from(ball.holds(at)), all + 1.0));
        if inside > 0.0 {
            let [a, b, c, d] = tet.map(|n| Vector3::from(mesh.nodes_m[n as usize]));
            tets += 1;
            volume_m3 += inside / all * normal([a, b, c]).dot(&(d - a)) / 6.0;
        }
    }
    (tets, volume_m3)
}

/// Distance below which a triangle meets a site, in probe radii (1).
const SAME_PLACE: f64 = 1e-9;

/// The surface point nearest to a place, and the mean outward normal of the surface within a probe
/// radius of it.
fn nearest_on_surface(triangles: &[[Vector3<f64>; 3]], place: [f64; 3], radius_m: f64) -> ([f64; 3], [f64; 3]) {
    let place = Vector3::from(place);
    let mut best = (f64::INFINITY, place);
    for &corners in triangles {
        let p = nearest_on_triangle(corners, place);
        let d = p - place;
        if d.dot(&d) < best.0 {
            best = (d.dot(&d), p);
        }
    }
    let (_, site) = best;
    // of a corner or an edge, all triangles there: on a point, none of them looks where it points
    let meets = |corners: &[Vector3<f64>; 3]| (nearest_on_triangle(*corners, site) - site).norm() <= SAME_PLACE * radius_m;
    let unit = |corners: &[Vector3<f64>; 3]| normal(*corners).try_normalize(0.0).unwrap_or_default();
    let own = triangles.iter().filter(|corners| meets(corners)).map(unit).fold(Vector3::zeros(), |s, n| s + n);
    let near = triangles.iter().copied().filter(|c| {
        let d = nearest_on_triangle(*c, site) - site;
        d.dot(&d) <= radius_m * radius_m
    });
    let sum = near.map(normal).filter(|n| n.dot(&own) > 0.0).fold(Vector3::zeros(), |s, n| s + n);
    (site.into(), (sum / sum.dot(&sum).sqrt()).into())
}

/// Corners of a triangle of the mesh [m].
fn corners(mesh: &TetMesh, triangle: &[u32; 3]) -> [Vector3<f64>; 3] {
    triangle.map(|n| mesh.nodes_m[n as usize].into())
}

/// Twice the area times the outward unit normal [m^2].
fn normal([a, b, c]: [Vector3<f64>; 3]) -> Vector3<f64> {
    (b - a).cross(&(c - a))
}

/// Point of a triangle that is nearest to `p` [m]: the foot of the perpendicular on its plane if
/// that is inside, else the nearest point of its sides.
fn nearest_on_triangle(corners: [Vector3<f64>; 3], p: Vector3<f64>) -> Vector3<f64> {
    let n = normal(corners);
    let height = (p - corners[0]).dot(&n) / n.dot(&n);
    let foot = p - height * n;
    let inside = (0..3).all(|k| normal([corners[k], corners[(k + 1) % 3], foot]).dot(&n) >= 0.0);
    if inside {
        return foot;
    }
    let side = |k: usize| {
        let (a, b) = (corners[k], corners[(k + 1) % 3]);
        let along = b - a;
        let s = ((p - a).dot(&along) / along.dot(&along)).clamp(0.0, 1.0);
        a + s * along
    };
    let squared = |q: Vector3<f64>| (p - q).dot(&(p - q));
    [side(0), side(1), side(2)].into_iter().min_by(|a, b| squared(*a).total_cmp(&squared(*b))).unwrap_or(foot)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trace_of_a_tilted_tip_is_as_deep_as_its_deepest_point() {
        let scene = Scene::parse(
            "tilted",
            "name = \"tilted\"\n[tissue]\nblock_m = [0.08, 0.08, 0.04]\nyoungs_modulus_pa = 3500.0\npoisson_ratio = 0.45\n\
             density_kg_per_m3 = 1060.0\n[probe]\nshape = \"capsule\"\nradius_m = 0.006\nlength_m = 0.012\nalong = [1.0, 0.0, 0.0]\n\
             tilt_deg = [0.0, 15.0, 0.0]\n[drive]\nkind = \"depth\"\nholds_m = [0.004]\nramp_m_per_s = 0.04\nhold_s = 0.1\n",
        );
        let mut scene = scene.unwrap();
        let (site_m, axis) = ([0.0, 0.0, 0.04], [0.0, 0.0, 1.0]);
        let pressed_m = depth_limit_m(&scene, &[], site_m, axis);
        let touch_m = Vector3::new(0.0, 0.0, 0.04) + scene.params(axis).touch_offset_m();
        scene.drive = Drive::Trace { trace: "trace.csv".into(), depth_limit_m: None };
        let traced_m = depth_limit_m(&scene, &[(touch_m - Vector3::z() * 0.004).into()], site_m, axis);
        assert!((traced_m - pressed_m).abs() < 1e-6, "{traced_m} m, pressed: {pressed_m} m");
    }

    #[test]
    fn a_wide_slab_has_the_nodes_that_it_needs_unless_the_scene_says_how_many() {
        let place = |nodes: &str| {
            let text = format!(
                "name = \"slab\"\n[tissue]\nblock_m = [0.1, 0.1, 0.005]\n{nodes}youngs_modulus_pa = 3500.0\npoisson_ratio = 0.45\n\
                 density_kg_per_m3 = 1060.0\n[probe]\nshape = \"hemisphere\"\nradius_m = 0.004\n[drive]\nkind = \"depth\"\n\
                 holds_m = [0.002]\nramp_m_per_s = 0.04\nhold_s = 0.1\n"
            );
            place(&Scene::parse("slab", &text).unwrap(), &[])
        };
        assert!(place("").unwrap().tissue.mesh.nodes_m.len() > DEFAULT_NODES);
        assert!(place("nodes = 410\n").is_err());
    }
}
