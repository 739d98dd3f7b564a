//! A finger that moves to a depth and is held there.

use palpate::Vector3;

use super::rest::NoRest;
use crate::methods::{Block, RunningMethod};

/// Speed of the finger [m/s], and duration of the hold [s].
const SPEED_M_PER_S: f64 = 0.04;
const STAY_S: f64 = 0.3;
/// Time at the end of the hold over which the force is averaged [s].
const READ_S: f64 = 0.02;

/// State of a press at the end of the hold.
#[derive(Clone, Debug)]
pub struct RestingPress {
    /// Mean force on the finger at the end of the hold [N].
    pub force_n: f64,
    /// Node positions [m], shape \[nodes\].
    pub position_m: Vec<Vector3<f64>>,
}

/// Presses tissue that is at rest and untouched to `depth_m` and holds the finger there.
pub fn hold(block: &Block, running: &mut dyn RunningMethod, depth_m: f64) -> Result<RestingPress, NoRest> {
    let tick_s = f64::from(block.params.tick_s);
    let clear_m = 1e-4;
    let travel = ((depth_m + clear_m) / (SPEED_M_PER_S * tick_s)).ceil() as usize;
    let (stay, read) = ((STAY_S / tick_s) as usize, (READ_S / tick_s).ceil() as usize);
    let mut sum = 0.0;
    for n in 0..=travel + stay {
        let tip_m = (n as f64 * SPEED_M_PER_S * tick_s - clear_m).min(depth_m);
        let diverged = NoRest::Diverged { depth_mm: tip_m * 1e3 };
        let force = f64::from(running.tick(block.tip_m(tip_m)).map_err(|_| diverged)?.dot(&block.params.probe.axis));
        if !force.is_finite() {
            return Err(diverged);
        }
        if n + read > travel + stay {
            sum += force;
        }
    }
    let position_m = (0..block.tissue.mesh.nodes_m.len()).map(|n| running.position_m(n).cast()).collect();
    Ok(RestingPress { force_n: sum / read as f64, position_m })
}
