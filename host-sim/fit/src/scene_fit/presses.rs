//! Chooses the presses for the fit of a block, and those for its evaluation.
//!
//! The centre is solved on fine meshes of the piece that remains after the block is cut at its
//! planes of symmetry. At other places only the ratio to the centre is solved, on one mesh of the
//! whole block whose nodes around the probe move with it ([`super::shifted`]), so that the effect
//! of the mesh on the force is the same at every place.

use palpate_tissue::scene::Scene;
use palpate_tissue::tissue::{DEPTH_MARGIN, Tissue};
use serde::{Deserialize, Serialize};

use crate::calibrate::places::random;

/// Depths of the fit and of the evaluation, as shares of the deepest hold (1): for 6 mm they are
/// 0.5, 1, 2, 4, 6 mm and 0.75, 1.5, 3, 5 mm.
const FITTED: [f64; 5] = [1.0 / 12.0, 1.0 / 6.0, 1.0 / 3.0, 2.0 / 3.0, 1.0];
const UNSEEN: [f64; 4] = [1.0 / 8.0, 1.0 / 4.0, 1.0 / 2.0, 5.0 / 6.0];
/// Indices of fitted depths at which dents are fitted, and of unseen depths at which dents are
/// evaluated too.
pub(super) const DENTS: [usize; 3] = [2, 3, 4];
const DENTS_UNSEEN: [usize; 2] = [2, 3];
/// Indices of the fitted and of the unseen depths at which the ratio to the centre is solved.
const RATIO_FITTED: [usize; 2] = [1, 4];
const RATIO_UNSEEN: [usize; 2] = [0, 2];
/// Fitted places away from the centre, on an axis and on a diagonal [probe radii]. If the two axes
/// differ, because the block is not square or the tip is not round, the places on the axis are also
/// used on the other axis.
const ASIDE: [[f64; 2]; 5] = [[0.7, 0.0], [1.25, 0.0], [1.75, 0.0], [0.75, 0.75], [1.2, 1.2]];
/// Radius of the disc over which a patch is evaluated [probe radii], number of unseen places on it,
/// and their seed.
pub const JUDGED_RADII: f64 = 1.5;
pub(super) const UNSEEN_PLACES: usize = 4;
pub(super) const UNSEEN_SEED: u64 = 77;
/// Numbers of corner nodes, first for a full fit and then with `--quick`: for the centre, those of
/// the coarser and the finer mesh of the piece of the block that is solved; for the other places,
/// that of the whole block.
const CENTRE_NODES: [usize; 2] = [300, 600];
const WHOLE_NODES: usize = 300;
const COARSE_CENTRE_NODES: [usize; 2] = [60, 110];
const COARSE_WHOLE_NODES: usize = 80;
/// Largest factor on the number of nodes for a contact that is longer than wide (1).
const MOST_MORE: f64 = 2.5;
/// Share of the deepest hold up to which depths are solved on finer meshes of their own (1).
const SHALLOW: f64 = 0.26;

/// Resolution of the finite elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Level {
    /// Meshes for a fit that is published.
    Full,
    /// Meshes for trying the command out, in less than a minute.
    Quick,
}

/// Presses on one mesh to several depths: the unit that is solved, stored and reused.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PressJob {
    /// Place of the press on the top [m].
    pub place_m: [f64; 2],
    /// Depths in ascending order [m].
    pub depths_m: Vec<f64>,
    /// Depths for which the surface is stored [m].
    pub surfaces_m: Vec<f64>,
    /// Number of corner nodes of the mesh.
    pub nodes: usize,
    /// Distance from the place within which elements are smallest [m].
    pub fine_radius_m: f64,
    /// Whether the whole block is solved, with the nodes around the probe moved to the place;
    /// otherwise the piece that remains after the block is cut at its planes of symmetry.
    pub whole: bool,
}

/// All presses of a fit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Presses {
    /// Depths for the fit [m].
    pub fitted_m: Vec<f64>,
    /// Depths for the evaluation alone [m].
    pub unseen_m: Vec<f64>,
    /// Presses at the centre, shallow and deep, each on a coarser and on a finer mesh.
    pub centre: Vec<PressJob>,
    /// Presses at the centre on the mesh of the other places.
    pub again: PressJob,
    /// Presses at places for the fit.
    pub aside: Vec<PressJob>,
    /// Presses at places for the evaluation alone.
    pub unseen: Vec<PressJob>,
}

impl Presses {
    /// The presses that the fit of a scene on a block needs.
    #[must_use]
    pub fn of(scene: &Scene, tissue: &Tissue, level: Level) -> Self {
        let radius_m = scene.probe.radius_m;
        let deepest_m = tissue.depth_limit_m / DEPTH_MARGIN;
        let size_m = scene.tissue.block_m.unwrap_or_default();
        let of = |shares: &[f64]| shares.iter().map(|share| rounded(share * deepest_m)).collect::<Vec<f64>>();
        let (fitted_m, unseen_m) = (of(&FITTED), of(&UNSEEN));
        let mut all_m: Vec<f64> = fitted_m.iter().chain(&unseen_m).copied().collect();
        all_m.sort_by(f64::total_cmp);
        let contact_m = |depth_m: f64| scene.probe.tip().contact_radius_m(depth_m);
        let (centre_nodes, whole_nodes) = match level {
            Level::Full => (CENTRE_NODES, WHOLE_NODES),
            Level::Quick => (COARSE_CENTRE_NODES, COARSE_WHOLE_NODES),
        };
        let unseen = DENTS_UNSEEN.iter().map(|n| unseen_m[*n]);
        let surfaces_m: Vec<f64> = DENTS.iter().map(|n| fitted_m[*n]).chain(unseen).collect();
        let (shallow_m, deep_m): (Vec<f64>, Vec<f64>) = all_m.iter().partition(|d| **d <= SHALLOW * deepest_m);
        let batches = [shallow_m, deep_m];
        let centre = batches.iter().flat_map(|depths_m| {
            let batch_m = depths_m.last().copied().unwrap_or(deepest_m);
            let fine_radius_m = 1.1 * contact_m(batch_m);
            centre_nodes.map(|nodes| more_nodes(scene, nodes, batch_m)).map(|nodes| PressJob {
                place_m: [0.0; 2],
                depths_m: depths_m.clone(),
                surfaces_m: surfaces_m.iter().filter(|d| depths_m.contains(d)).copied().collect(),
                nodes,
                fine_radius_m,
                whole: false,
            })
        });
        let mut ratio_m: Vec<f64> =
            RATIO_FITTED.iter().map(|n| fitted_m[*n]).chain(RATIO_UNSEEN.iter().map(|n| unseen_m[*n])).collect();
        ratio_m.sort_by(f64::total_cmp);
        let whole = |place_m: [f64; 2], depths_m: Vec<f64>| PressJob {
            place_m,
            depths_m,
            surfaces_m: Vec::new(),
            nodes: more_nodes(scene, whole_nodes, deepest_m),
            fine_radius_m: 0.75 * contact_m(deepest_m),
            whole: true,
        };
        let known = |n: &usize| fitted_m[*n];
        let square = size_m[0] == size_m[1] && scene.probe.shape.is_round();
        let aside = ASIDE.iter().flat_map(|at| {
            let other = (!square && at[1] == 0.0).then_some([at[1], at[0]]);
            [Some(*at), other].into_iter().flatten()
        });
        let aside = aside.map(|at| whole(at.map(|x| rounded(x * radius_m)), RATIO_FITTED.iter().map(known).collect()));
        let unseen = random(UNSEEN_PLACES, JUDGED_RADII * radius_m, UNSEEN_SEED).into_iter();
        let unseen = unseen.map(|at| whole(at.map(rounded), RATIO_UNSEEN.iter().map(|n| unseen_m[*n]).collect()));
        Self {
            centre: centre.collect(),
            again: whole([0.0; 2], ratio_m),
            aside: aside.collect(),
            unseen: unseen.collect(),
            fitted_m,
            unseen_m,
        }
    }

    /// All presses, those that take longest first.
    pub fn jobs(&self) -> impl Iterator<Item = &PressJob> {
        std::iter::once(&self.again).chain(self.centre.iter().rev()).chain(&self.aside).chain(&self.unseen)
    }
}

/// Number of corner nodes of a mesh for a long contact: its elements must be as small as under a
/// ball, over a correspondingly wider disc.
fn more_nodes(scene: &Scene, nodes: usize, depth_m: f64) -> usize {
    let tip = scene.probe.tip();
    if tip.shape.is_round() {
        return nodes;
    }
    let ball_m = (tip.radius_m * depth_m.min(tip.radius_m)).sqrt();
    (nodes as f64 * (tip.contact_radius_m(depth_m) / ball_m).clamp(1.0, MOST_MORE)) as usize
}

/// Rounds to tenths of a micrometre, so that files and scenes agree to the last bit.
fn rounded(m: f64) -> f64 {
    (m * 1e7).round() / 1e7
}
