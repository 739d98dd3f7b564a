//! Fits a law without nodes: its held part to the forces over places and depths, its branches to
//! stored ramps.
//!
//! The held part is linear in its constants and is solved by least squares of the relative errors.
//! The branches are linear in their dashpots for given lengths; for every choice of lengths the
//! dashpots are solved by non-negative least squares, and the best choice is taken. One set of
//! branches serves every Young's modulus, because times scale with the waves of the tissue.

mod held;
pub mod motions;
mod moving;
mod squares;

use palpate::{Branch, LawShape, MOST_BRANCHES, Params};

use crate::calibrate::targets::Reference;
use palpate_tissue::answer::Answer;
use palpate_tissue::error::Error;
use palpate_tissue::mesh::TetMesh;
use palpate_tissue::organ::tangents;
use palpate_tissue::patch::{OwnLaw, Patch};
use palpate_tissue::scene::Scene;
use palpate_tissue::tissue::Tissue;

/// Rows of the table of a site that is not the top of a block, along each side.
const SIDE: usize = 7;
/// Depths of the stored answer that a law is fitted to [m]; at the others it is judged.
const FITTED_M: [f64; 5] = [5e-4, 1e-3, 2e-3, 4e-3, 8e-3];
/// Radius of the disc of places on the stored block [probe radii].
pub const STORED_RADII: f64 = 1.65;
/// Radius of the probe for which [`HEMISPHERE`] was fitted [m].
const FITTED_RADIUS_M: f64 = 8e-3;
/// Branches of the shipped block under its hemisphere, as [`branches`] finds them from ramps of 40,
/// 100 and 200 mm/s at 3.5 and 100 kPa. They stand in where no ramp of a scene is stored: under
/// another radius, dashpots and lengths scale with it.
pub const HEMISPHERE: [Branch; MOST_BRANCHES] = [
    Branch { c: 5.28e-4, length_m: 0.024 },
    Branch { c: 2.39e-4, length_m: f32::INFINITY },
    Branch { c: 0.01432, length_m: 0.012 },
    Branch { c: 0.01357, length_m: 0.024 },
];

/// The branches of [`HEMISPHERE`] for another radius of a round tip [m].
#[must_use]
pub fn scaled_branches(radius_m: f64) -> [Branch; MOST_BRANCHES] {
    let ratio = radius_m / FITTED_RADIUS_M;
    let mut scaled = HEMISPHERE;
    for (n, branch) in scaled.iter_mut().enumerate() {
        // force over E is an area; g^2 is sqrt(d) in the first two, d in the others
        let c = if n < 2 { ratio.powf(1.5) } else { ratio };
        (branch.c, branch.length_m) = (branch.c * c as f32, branch.length_m * ratio as f32);
    }
    scaled
}

/// The rest shape of a block: tets from the site to the halves of the other five faces. Only the
/// top can be touched.
#[must_use]
pub fn block_shape(size_m: [f64; 3], site_m: [f64; 3], depth_limit_m: f64) -> Tissue {
    let corner = |n: usize| {
        let side = |k: usize| if n >> k & 1 == 1 { 0.5 } else { -0.5 };
        [side(0) * size_m[0], side(1) * size_m[1], if n >> 2 & 1 == 1 { 0.0 } else { -size_m[2] }]
    };
    let nodes_m: Vec<[f64; 3]> = (0..8).map(corner).chain([site_m]).collect();
    let site = 8;
    // corners of each face in order, counter-clockwise seen from outside
    let faces = [[0, 2, 3, 1], [0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6]];
    let tets: Vec<[u32; 4]> = faces.iter().flat_map(|[a, b, c, d]| [[site, *a, *b, *c], [site, *a, *c, *d]]).collect();
    let skin = vec![[site, 4, 5], [site, 5, 7], [site, 7, 6], [site, 6, 4]];
    let (stiffness_ratio, regions) = (vec![1.0; tets.len()], vec![0; tets.len()]);
    let mesh = TetMesh { nodes_m, tets, regions };
    Tissue { mesh, stiffness_ratio, skin, anchors: vec![0, 1, 2, 3], site_m, depth_limit_m }
}

/// Presses that a law is fitted to and judged by.
pub struct LawPresses<'a> {
    /// Forces over places and depths, for the fit.
    pub known: &'a dyn Reference,
    /// Shallowest and deepest press of the fit [m].
    pub depths_m: [f64; 2],
    /// Radius of the disc of places [probe radii].
    pub reach_radii: f64,
}

/// Fits the law of a scene's site, with the rest shape and the direction of its press.
///
/// # Errors
/// The presses lack places or depths, or a stored ramp cannot be read.
pub fn fit(scene: &Scene, rest: &Tissue, axis: [f64; 3], presses: &LawPresses) -> Result<(Patch, Params), Error> {
    // the table contains the stiffening
    let params = Params { stiffening_b: 0.0, ..scene.params(axis) };
    let reach_m = presses.reach_radii * scene.probe.radius_m;
    let side = if scene.tissue.block_m.is_some() { 1 } else { SIDE };
    let lacks = || Error::Check(format!("{}: the finite elements lack presses that a law needs: fit it anew", scene.file));
    let table = held::fit(presses, side, reach_m, axis.into()).ok_or_else(lacks)?;
    let ramps = motions::ramps(scene)?;
    let branches = match table.first() {
        Some(row) if !ramps.is_empty() => moving::branches(row, &ramps, &params)?,
        _ => scaled_branches(scene.probe.radius_m),
    };
    let [along, _] = tangents(axis);
    let shape = LawShape {
        origin_m: rest.site_m.map(|c| c as f32),
        along: along.map(|c| c as f32),
        reach_m: reach_m as f32,
        side: side as u32,
        branches,
    };
    let rest = Tissue { depth_limit_m: presses.depths_m[1], ..rest.clone() };
    let mut patch = Patch::of_law(&rest, scene.tissue.poisson_ratio, OwnLaw { shape, table });
    patch.set_fitted_places(held::PLACES as u32);
    Ok((patch, params))
}

/// The stored answer of the preset block, if it is that of the scene and deep enough: the presses
/// that a law is fitted to and those that it does not see, and their depths [m].
#[must_use]
pub fn stored(scene: &Scene) -> Option<(Answer, Answer, Vec<f64>)> {
    let centred = scene.probe.position_m.unwrap_or_default() == [0.0; 2];
    let deep = crate::far_field::prepared::deepest_hold_m(scene).is_some_and(|m| m > FITTED_M[4]);
    let answer = Some(Answer::block()).filter(|answer| centred && !deep && answer.is_for(scene))?;
    let (mut known, mut unseen) = (answer.clone(), answer);
    let fitted = |depth_m: f64| FITTED_M.iter().any(|m| (m - depth_m).abs() < 1e-7);
    known.holds.retain(|hold| fitted(hold.depth_m));
    unseen.holds.retain(|hold| {
        !fitted(hold.depth_m) && hold.depth_m <= FITTED_M[4] && hold.place_m[0] <= STORED_RADII * scene.probe.radius_m
    });
    unseen.holds.iter_mut().for_each(|hold| hold.surface = None);
    unseen.glued.clear();
    Some((known, unseen, FITTED_M.to_vec()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::force_map::BlockForces;
    use crate::scene_fit::{Judging, PLACES};
    use palpate_tissue::budget::MACHINES;
    use palpate_tissue::session::Session;

    #[test]
    fn the_rest_shape_of_a_block_fills_it() {
        let rest = block_shape([0.08, 0.06, 0.04], [0.003, -0.004, 0.0], 0.005);
        assert!((rest.mesh.volume_m3() / (0.08 * 0.06 * 0.04) - 1.0).abs() < 1e-12);
        let six_m3 = rest.mesh.tets.iter().map(|tet| {
            let [a, b, c, d] = tet.map(|n| nalgebra::Vector3::from(rest.mesh.nodes_m[n as usize]));
            (b - a).cross(&(c - a)).dot(&(d - a))
        });
        assert!(six_m3.clone().all(|six_m3| six_m3 > 0.0), "{:?}", six_m3.collect::<Vec<_>>());
    }

    #[test]
    fn a_law_of_the_block_holds_where_and_as_it_was_not_fitted() {
        let scene = Scene::load("block").unwrap();
        let (known, unseen, depths_m) = stored(&scene).unwrap();
        let known = BlockForces::of(&known).unwrap();
        let rest = block_shape(scene.tissue.block_m.unwrap(), [0.0; 3], 8e-3);
        let presses = LawPresses { known: &known, depths_m: [depths_m[0], depths_m[4]], reach_radii: STORED_RADII };
        let (patch, params) = fit(&scene, &rest, [0.0, 0.0, 1.0], &presses).unwrap();
        let all = BlockForces::of(&Answer::block()).unwrap();
        let session = Session::of_fitted(&MACHINES[0], patch, params).unwrap();
        let judging =
            Judging { known: &all, fitted_m: &depths_m, unseen: &unseen, disc_radii: 1.5, places: PLACES, reference_error: 0.0 };
        let verdict = judging.judge(&session).unwrap();
        assert!(verdict.rms_pct() < 1.0 && verdict.worst_pct().abs() < 2.0 && verdict.lost_presses == 0, "{verdict:?}");
        let errors = motions::errors(&scene, &session.patch, &session.params).unwrap();
        let most = |fast: bool| {
            let own = errors.iter().filter(|error| error.name.ends_with("-500") == fast);
            own.map(|error| error.rms_pct).fold(0.0, f64::max)
        };
        assert!(errors.len() == 27 && most(false) < 1.6 && most(true) < 3.5, "{errors:?}");
    }
}
