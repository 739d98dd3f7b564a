//! Presses for the fit of a block, and those for its evaluation.
//!
//! The centre is solved on fine meshes of the piece that symmetry leaves. Elsewhere only the ratio
//! to the centre is taken, from one mesh of the whole block whose nodes around the probe move with
//! it ([`super::shifted`]): what the mesh does to the force is the same at every place.

use palpate_tissue::scene::Scene;
use palpate_tissue::tissue::{DEPTH_MARGIN, Tissue};
use serde::{Deserialize, Serialize};

use crate::calibrate::places::random;

/// Depths of the fit and of the evaluation, as shares of the deepest hold: for 6 mm 0.5, 1, 2, 4, 6
/// and 0.75, 1.5, 3, 5 mm.
const FITTED: [f64; 5] = [1.0 / 12.0, 1.0 / 6.0, 1.0 / 3.0, 2.0 / 3.0, 1.0];
const UNSEEN: [f64; 4] = [1.0 / 8.0, 1.0 / 4.0, 1.0 / 2.0, 5.0 / 6.0];
/// Fitted depths at which dents are fitted, and unseen ones at which they are evaluated as well.
pub(super) const DENTS: [usize; 3] = [2, 3, 4];
const DENTS_UNSEEN: [usize; 2] = [2, 3];
/// Depths at which the ratio to the centre is solved, of the fitted and of the unseen ones.
const RATIO_FITTED: [usize; 2] = [1, 4];
const RATIO_UNSEEN: [usize; 2] = [0, 2];
/// Fitted places off the centre [probe radii], on an axis and on a diagonal; if the two axes
/// differ, in a block that is not square or under a tip that is not round, also on the other.
const ASIDE: [[f64; 2]; 5] = [[0.7, 0.0], [1.25, 0.0], [1.75, 0.0], [0.75, 0.75], [1.2, 1.2]];
/// Radius of the disc over which a patch is evaluated [probe radii], and the seed of its places.
pub const JUDGED_RADII: f64 = 1.5;
pub(super) const UNSEEN_PLACES: usize = 4;
pub(super) const UNSEEN_SEED: u64 = 77;
/// Corner nodes of the piece of the block that is solved for the centre, of the coarser and the
/// finer mesh; of the whole block for the places.
const CENTRE_NODES: [usize; 2] = [300, 600];
const WHOLE_NODES: usize = 300;
const COARSE_CENTRE_NODES: [usize; 2] = [60, 110];
const COARSE_WHOLE_NODES: usize = 80;
/// Largest factor on the number of nodes for a contact that is longer than wide.
const MOST_MORE: f64 = 2.5;
/// Depths up to this share of the deepest have meshes of their own, finer.
const SHALLOW: f64 = 0.26;

/// Resolution of the finite elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Level {
    /// Meshes of a published fit.
    Full,
    /// A trial of the command, under a minute.
    Quick,
}

/// One mesh, pressed to several depths: what is solved, stored and found again.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PressJob {
    /// Place on the top [m].
    pub place_m: [f64; 2],
    /// Rising [m].
    pub depths_m: Vec<f64>,
    /// Depths whose surface is kept [m].
    pub surfaces_m: Vec<f64>,
    /// Corner nodes of the mesh.
    pub nodes: usize,
    /// Elements are smallest this far around the place [m].
    pub fine_radius_m: f64,
    /// Whether the whole block is solved, with the nodes around the probe moved to the place;
    /// otherwise the piece that symmetry leaves.
    pub whole: bool,
}

/// All presses of a fit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Presses {
    /// Depths for the fit [m].
    pub fitted_m: Vec<f64>,
    /// Depths for the evaluation alone [m].
    pub unseen_m: Vec<f64>,
    /// The centre: shallow and deep, each on a coarser and a finer mesh.
    pub centre: Vec<PressJob>,
    /// The centre again, on the mesh of the places.
    pub again: PressJob,
    /// Places for the fit.
    pub aside: Vec<PressJob>,
    /// Places for the evaluation alone.
    pub unseen: Vec<PressJob>,
}

impl Presses {
    /// The presses that a scene on a block needs.
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

    /// Every press, the longest first.
    pub fn jobs(&self) -> impl Iterator<Item = &PressJob> {
        std::iter::once(&self.again).chain(self.centre.iter().rev()).chain(&self.aside).chain(&self.unseen)
    }
}

/// Corner nodes of a mesh for a long contact: its elements have to be as fine as under a ball, over
/// a correspondingly wider disc.
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
