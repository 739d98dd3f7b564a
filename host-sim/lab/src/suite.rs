//! Scenes that differ from the plain block in one thing each, and every method on each of them:
//! what a scene needs at least.
//!
//! The references are stored: finite elements of held presses and of motions, at places and depths
//! that no fit saw, and Coulomb's law. The product's law and its calibrated patch are fitted to
//! each tissue, as `fit` does, and all other methods keep the parameters that they have on the
//! chart. For another tip, friction and a region that changes, the law is that of the plain block:
//! there it ends.

mod measure;
mod own;
mod scenes;
mod slide;

use palpate_tissue::answer::Answer;
use palpate_tissue::error::Error as TissueError;
use serde::{Deserialize, Serialize};

use crate::chart::{Survival, least_substeps, tick_time};
use crate::error::Error;
use crate::methods::{Block, Method};
use measure::{held_pct, ramp_pct, rms, stored_motions_pct};
use own::Own;
pub use own::{DEPTH_M, SPEEDS_MM_PER_S, folder};
use scenes::{CHANGE, Kind, Presses};
pub use scenes::{SCENES, SuiteScene};
pub use slide::RETURN;

/// Longest tick of a method whose errors are measured [us]: one that takes longer than its
/// millisecond is no rival, and would press for hours.
const MOST_US: f64 = 1000.0;
/// Deepest press that a method must survive to be run [m].
const DEEPEST_M: f64 = 4e-3;
/// Number of nodes beside which the methods of one size are run.
pub const FIRST_NODES: usize = 130;

/// Result of a method on a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SuiteRow {
    /// Name of the scene.
    pub scene: String,
    /// Name of the method.
    pub method: String,
    /// Number of nodes; 0 for a law.
    pub nodes: usize,
    /// Substeps of a tick.
    pub substeps: u16,
    /// CPU time of a tick [us].
    pub tick_us: f64,
    /// Root mean square force error of held presses [%]; `None` if the method diverges, or cannot
    /// hold the scene.
    pub held_pct: Option<f64>,
    /// Root mean square force error of motions [% of the peak]; `None` without a motion, and as
    /// above.
    pub moving_pct: Option<f64>,
}

impl SuiteRow {
    /// The larger error [%]; `None` if one that the scene has was not measured.
    pub fn worst_pct(&self) -> Option<f64> {
        let scene = SCENES.iter().find(|scene| scene.name == self.scene)?;
        let moving = if scene.moves() { self.moving_pct? } else { 0.0 };
        Some(self.held_pct?.max(moving))
    }

    /// Whether the method is a patch of the product.
    pub fn is_patch(&self) -> bool {
        [Method::Palpate, Method::Calibrated].iter().any(|method| method.name() == self.method)
    }

    /// Whether the method is the product's law.
    pub fn is_law(&self) -> bool {
        self.method == Method::Law.name()
    }
}

/// Runs every method with a mesh of about this many nodes on a scene; a law and a patch of one size
/// are run beside [`FIRST_NODES`] alone. Methods that are not available or do not survive the
/// press are left out.
pub fn run(scene: &SuiteScene, nodes: usize) -> Result<Vec<SuiteRow>, Error> {
    let (own, cuboid) = match scene.kind {
        Kind::Own(name, cuboid) => (Some(Own::load(name)?), cuboid),
        _ => (None, None),
    };
    // to mesh an organ takes seconds
    let own_block = own.as_ref().and_then(|own| own.block(cuboid, Method::Springs, nodes));
    let mut rows = Vec::new();
    for method in Method::ALL {
        let fitted = own.as_ref().is_some_and(|own| own.fitted.patch.is_some());
        let once = method == Method::Law || method == Method::Calibrated && fitted;
        if once && nodes != FIRST_NODES {
            continue;
        }
        let block = match (&own, method) {
            (Some(own), Method::Calibrated) => own.block(cuboid, method, nodes),
            // a law needs no mesh of this size
            (Some(own), Method::Law) => own_block.clone().or_else(|| own.block(cuboid, Method::Calibrated, nodes)),
            (Some(_), _) => own_block.clone(),
            (None, Method::Calibrated) => Block::calibrated(nodes, scene.modulus_pa()),
            (None, _) => Some(Block::standard(nodes, scene.modulus_pa())?),
        };
        let Some(mut block) = block else { continue };
        if method == Method::Law && matches!(scene.kind, Kind::Stored { nodule: true, .. }) {
            block.fitted.law = Some(own::patch(&folder().join("nodule-law.patch"))?.0);
        }
        rows.extend(row(scene, own.as_ref(), method, &Block { deepest_m: DEEPEST_M, ..block })?);
    }
    Ok(rows)
}

fn row(scene: &SuiteScene, own: Option<&Own>, method: Method, block: &Block) -> Result<Option<SuiteRow>, Error> {
    let Some(Ok(Survival { substeps, trial })) = least_substeps(method, block)? else { return Ok(None) };
    if trial.failure.is_some() {
        return Ok(None);
    }
    let Some(Ok(time)) = tick_time(method, block, substeps)? else { return Ok(None) };
    let in_time = time.min_us <= MOST_US;
    let [held_pct, moving_pct] = if in_time { errors(scene, own, method, block, substeps)? } else { [None, None] };
    let fitted = block.fitted.patch.as_ref().filter(|_| method == Method::Calibrated);
    let nodes = match method {
        Method::Law => 0,
        _ => fitted.map_or(block.size().nodes, |(patch, _)| patch.mesh().nodes_m.len()),
    };
    let (scene, method) = (scene.name.into(), method.name().into());
    Ok(Some(SuiteRow { scene, method, nodes, substeps, tick_us: time.min_us, held_pct, moving_pct }))
}

/// Errors of held presses and of motions.
fn errors(
    scene: &SuiteScene,
    own: Option<&Own>,
    method: Method,
    block: &Block,
    substeps: u16,
) -> Result<[Option<f64>; 2], Error> {
    match &scene.kind {
        Kind::Stored { presses, motions, nodule } => {
            let block = if *nodule { scenes::with_nodule(block.clone()) } else { block.clone() };
            let mut held = Vec::new();
            for presses in *presses {
                held.extend(pressed(presses, method, &block, substeps)?);
            }
            Ok([rms(&held), rms(&stored_motions_pct(motions, method, &block, substeps)?)])
        }
        Kind::Own(..) => {
            let Some(own) = own else { return Ok([None, None]) };
            let held = rms(&held_pct(&own.held.holds, method, block, substeps)?);
            let ramps = own.ramps.iter().map(|ramp| ramp_pct(ramp, [0.0; 3], method, block, substeps));
            Ok([held, rms(&ramps.collect::<Result<Vec<_>, _>>()?)])
        }
        Kind::Slide => Ok([slide::friction_pct(method, block, substeps)?, None]),
        Kind::Return => Ok([slide::return_pct(method, block, substeps)?, None]),
        Kind::Change => {
            // what is computed from the whole tissue beforehand cannot follow
            if matches!(method, Method::Law | Method::Implicit | Method::Compliance) {
                return Ok([None, None]);
            }
            let [before, after] = &CHANGE;
            let mut held = pressed(before, method, block, substeps)?;
            held.extend(pressed(after, method, &scenes::with_nodule(block.clone()), substeps)?);
            Ok([rms(&held), None])
        }
    }
}

fn pressed(presses: &Presses, method: Method, block: &Block, substeps: u16) -> Result<Vec<Option<f64>>, Error> {
    let damaged = |_| TissueError::Check("a stored answer of the block is damaged: take the files as they ship".into());
    let answer: Answer = serde_json::from_str(presses.answer).map_err(damaged)?;
    let mut block = block.clone();
    if let Some((shape, radius_m)) = presses.tip {
        (block.params.probe.shape, block.params.probe.radius_m) = (shape, radius_m);
    }
    let holds = answer.holds.iter().filter(|hold| {
        let away_m = hold.place_m[0].hypot(hold.place_m[1]);
        away_m <= presses.within_m + 1e-9 && (1e-3 - 1e-9..=DEEPEST_M + 1e-9).contains(&hold.depth_m)
    });
    held_pct(holds, method, &block, substeps)
}

/// The cheapest method within an error [%] on a scene.
pub fn cheapest<'r>(rows: &'r [SuiteRow], scene: &str, most_pct: f64) -> Option<&'r SuiteRow> {
    let within = rows.iter().filter(|row| row.scene == scene && row.worst_pct().is_some_and(|pct| pct <= most_pct));
    within.min_by(|a, b| a.tick_us.total_cmp(&b.tick_us))
}
