//! Finds the number of substeps that a method needs to survive the deepest press of the chart.
//!
//! The tissue is pressed at 0.1 m/s, held and released. A method survives if every number stays
//! finite, the tissue comes to rest in the hold, and it returns to its rest shape after the
//! release. Bounded motion is not enough: methods that never diverge can leave tets inside out.

use crate::study::number;
use palpate::Vector3;
use serde::{Deserialize, Serialize};

use crate::error::Error;
use crate::methods::{Block, Method, RunningMethod};

/// Largest number of substeps that is tried: a method that needs more takes far longer than a
/// millisecond per tick.
pub const MOST_SUBSTEPS: u16 = 64;
/// Speed of the press [m/s].
pub(super) const SPEED_M_PER_S: f64 = 0.1;
/// Height above the surface at which the tip starts and ends [m].
pub const CLEAR_M: f64 = 5e-4;
/// Number of ticks of the hold, and of the wait after the release.
pub(super) const WAIT_TICKS: usize = 400;
/// Number of ticks at the end of the hold over which the tissue must be at rest.
pub(super) const STILL_TICKS: usize = 20;
/// Largest accepted displacement of a node over these ticks [m], and largest accepted change of the
/// force as a share of its largest value (1).
pub(super) const STILL_M: f64 = 5e-5;
pub(super) const STILL_FORCE: f64 = 0.05;
/// Largest accepted distance of a node from its rest position after the release [m].
pub(super) const RETURNED_M: f64 = 2.5e-4;

/// Reason why a method did not survive a press.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error, Serialize, Deserialize)]
pub enum Failure {
    /// The tick reported a fault, or the force is not finite.
    #[error("diverges at {depth_mm:.1} mm")]
    Diverged {
        /// Depth of the tip when the method diverged [mm].
        depth_mm: f64,
    },
    /// The tissue still moves at the end of the hold.
    #[error("does not come to rest: {moved_mm:.2} mm and {force_pct:.0} % of the force in 20 ms")]
    Restless {
        /// Largest displacement of a node over the last 20 ticks [mm].
        #[serde(with = "number")]
        moved_mm: f64,
        /// Change of the force over these ticks [%].
        #[serde(with = "number")]
        force_pct: f64,
    },
    /// The tissue is still deformed after the release.
    #[error("does not return: {left_mm:.2} mm left after the release")]
    Deformed {
        /// Largest distance of a node from its rest position [mm].
        #[serde(with = "number")]
        left_mm: f64,
    },
}

/// Outcome of a press.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PressResult {
    /// Reason for the failure, if the press failed.
    pub failure: Option<Failure>,
    /// Smallest ratio of a tet's volume to its rest volume at the end of the hold (1); NaN if the
    /// method diverged before.
    #[serde(with = "number")]
    pub min_j: f64,
}

/// Number of substeps that a method needs, and outcome of the press with that number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Survival {
    /// Smallest number of substeps with which the method survives; if there is none, the smallest
    /// with which it does not diverge.
    pub substeps: u16,
    /// Outcome of the press with that number of substeps.
    pub trial: PressResult,
}

/// Searches the smallest number of substeps by doubling, then by bisection. `None` if the method is
/// not available; the inner error is the failure of a method that diverges with every number tried.
pub fn least_substeps(method: Method, block: &Block) -> Result<Option<Result<Survival, Failure>>, Error> {
    let most = if method.takes_substeps() { MOST_SUBSTEPS } else { 1 };
    let mut tried = Vec::new();
    let mut substeps = 1;
    while substeps <= most {
        let Some(trial) = method.run(block, substeps, |running| try_press(block, running))? else { return Ok(None) };
        tried.push(Survival { substeps, trial });
        if trial.failure.is_none() {
            break;
        }
        substeps *= 2;
    }
    let (mut low, mut best) = match tried.iter().position(|s| s.trial.failure.is_none()) {
        Some(0) => return Ok(Some(Ok(tried[0]))),
        Some(n) => (tried[n - 1].substeps, tried[n]),
        None => {
            let finite = |s: &&Survival| !matches!(s.trial.failure, Some(Failure::Diverged { .. }));
            let last = tried.last().and_then(|s| s.trial.failure).unwrap_or(Failure::Diverged { depth_mm: 0.0 });
            return Ok(Some(tried.iter().find(finite).copied().ok_or(last)));
        }
    };
    while best.substeps - low > 1 {
        let middle = low + (best.substeps - low) / 2;
        let Some(trial) = method.run(block, middle, |running| try_press(block, running))? else { return Ok(None) };
        match trial.failure {
            None => best = Survival { substeps: middle, trial },
            Some(_) => low = middle,
        }
    }
    Ok(Some(Ok(best)))
}

/// Presses to the largest depth, holds and releases.
pub fn try_press(block: &Block, running: &mut dyn RunningMethod) -> PressResult {
    let mut trial = PressResult { failure: None, min_j: f64::NAN };
    let step_m = SPEED_M_PER_S * f64::from(block.params.tick_s);
    let deepest_m = block.deepest_m;
    let travel = ((deepest_m + CLEAR_M) / step_m).round() as usize;
    let mut go = |depth_m: f64| match running.tick(block.tip_m(depth_m)) {
        Ok(force) if force.iter().all(|f| f.is_finite()) => Ok(f64::from(force.dot(&block.params.probe.axis))),
        _ => Err(Failure::Diverged { depth_mm: depth_m * 1e3 }),
    };
    let way_down = (0..=travel).map(|n| n as f64 * step_m - CLEAR_M);
    let hold = std::iter::repeat_n(deepest_m, WAIT_TICKS - STILL_TICKS);
    let mut force_n = 0.0;
    for depth_m in way_down.chain(hold) {
        match go(depth_m) {
            Ok(force) => force_n = force,
            Err(failure) => return PressResult { failure: Some(failure), ..trial },
        }
    }
    let nodes = block.tissue.mesh.nodes_m.len();
    let before = positions(running, nodes);
    let (mut least_n, mut most_n) = (force_n, force_n);
    for _ in 0..STILL_TICKS {
        match running.tick(block.tip_m(deepest_m)) {
            Ok(force) => {
                let force = f64::from(force.dot(&block.params.probe.axis));
                (least_n, most_n) = (least_n.min(force), most_n.max(force));
            }
            Err(_) => return PressResult { failure: Some(Failure::Diverged { depth_mm: deepest_m * 1e3 }), ..trial },
        }
    }
    let held = positions(running, nodes);
    trial.min_j = min_j(block, &held);
    let moved = before.iter().zip(&held).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    let change = (most_n - least_n) / most_n.abs().max(f64::MIN_POSITIVE);
    if !(moved <= STILL_M && change <= STILL_FORCE) {
        trial.failure = Some(Failure::Restless { moved_mm: moved * 1e3, force_pct: change * 100.0 });
    }
    let way_up = (0..=travel).rev().map(|n| n as f64 * step_m - CLEAR_M);
    for depth_m in way_up.chain(std::iter::repeat_n(-CLEAR_M, WAIT_TICKS)) {
        if running.tick(block.tip_m(depth_m)).is_err() {
            return PressResult { failure: Some(Failure::Diverged { depth_mm: depth_m * 1e3 }), ..trial };
        }
    }
    let rest = block.tissue.mesh.nodes_m.iter().map(|x| Vector3::from(*x));
    let left = positions(running, nodes).iter().zip(rest).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    // positions are finite here: the tick reports a NaN as a fault
    if trial.failure.is_none() && left > RETURNED_M {
        trial.failure = Some(Failure::Deformed { left_mm: left * 1e3 });
    }
    trial
}

/// Positions of all nodes [m].
pub(super) fn positions(running: &dyn RunningMethod, nodes: usize) -> Vec<Vector3<f64>> {
    (0..nodes).map(|n| running.position_m(n).cast()).collect()
}

/// Smallest ratio of a tet's volume to its rest volume (1).
fn min_j(block: &Block, positions_m: &[Vector3<f64>]) -> f64 {
    let six = |[a, b, c, d]: [Vector3<f64>; 4]| (b - a).dot(&(c - a).cross(&(d - a)));
    let mesh = &block.tissue.mesh;
    let ratio =
        |tet: &[u32; 4]| six(tet.map(|n| positions_m[n as usize])) / six(tet.map(|n| Vector3::from(mesh.nodes_m[n as usize])));
    mesh.tets.iter().map(ratio).fold(f64::INFINITY, f64::min)
}
