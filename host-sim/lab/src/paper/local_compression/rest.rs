//! From load to rest: a finger with a constant force is released at the surface, and time is
//! measured until nothing moves.
//!
//! The stop criterion is the same for every dynamic method: the tip moves by less than a micrometre
//! in 10 ms of virtual time, and in the following millisecond no node moves faster than two
//! millimetres per second. The time is CPU time of the thread, measured in the ticks only.

use palpate::Vector3;

use crate::methods::{Block, RunningMethod};
use palpate_tissue::clock::thread_time;
use palpate_tissue::finger::{FINGER, Impedance};

/// Displacement of the tip in [`STILL_MS`] below which it counts as at rest [m].
pub const STILL_TIP_M: f64 = 1e-6;
/// Virtual time over which the displacement of the tip is measured [ms].
pub const STILL_MS: usize = 10;
/// Largest mean speed of a node in the following millisecond at which the tissue counts as at rest
/// [m/s].
pub const STILL_NODE_M_PER_S: f64 = 2e-3;
/// Virtual time within which a press must come to rest [ms].
pub const LONGEST_MS: usize = 2000;
/// Initial height of the tip above the surface [m]: the finger must start outside, because a probe
/// that starts inside the tissue gets no force.
const CLEAR_M: f64 = 1e-5;

/// A finger that is driven by a constant force against the force of the tissue.
#[derive(Clone, Copy, Debug)]
pub struct Push {
    /// Force that drives the finger [N].
    pub force_n: f64,
    depth_m: f64,
    speed_m_per_s: f64,
    felt_n: f64,
}

/// State of a press that has come to rest.
#[derive(Clone, Debug)]
pub struct AtRest {
    /// Force on the finger [N].
    pub force_n: f64,
    /// Depth of the finger's tip below the rest surface [m].
    pub depth_m: f64,
    /// Virtual time to rest [s].
    pub virtual_s: f64,
    /// CPU time to rest [s].
    pub cpu_s: f64,
    /// Node positions [m], shape \[nodes\].
    pub position_m: Vec<Vector3<f64>>,
}

/// Reason why a press does not come to rest.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NoRest {
    /// The tick reported a fault, or the force is not finite.
    #[error("diverges {depth_mm:.1} mm deep")]
    Diverged {
        /// Depth of the tip when the model diverged [mm].
        depth_mm: f64,
    },
    /// The tip or a node still moves.
    #[error("still moves after {seconds} s: the tip by {tip_um:.1} um in {STILL_MS} ms")]
    Restless {
        /// Virtual time [s].
        seconds: f64,
        /// Displacement of the tip in the last 10 ms [um].
        tip_um: f64,
    },
    /// The tip exceeds the depth limit.
    #[error("sinks deeper than {depth_mm:.0} mm")]
    Sunk {
        /// Depth limit [mm].
        depth_mm: f64,
    },
}

impl Push {
    /// Starts a finger just above the surface, at zero speed.
    pub fn new(force_n: f64) -> Self {
        Self { force_n, depth_m: -CLEAR_M, speed_m_per_s: 0.0, felt_n: 0.0 }
    }

    /// Depth of the tip [m].
    pub fn depth_m(&self) -> f64 {
        self.depth_m
    }

    /// Moves the tip and runs one tick of a method.
    pub fn tick(&mut self, block: &Block, running: &mut dyn RunningMethod) -> Result<(), NoRest> {
        let Impedance { mass_kg, damping_n_s_per_m, .. } = FINGER;
        let tick_s = f64::from(block.params.tick_s);
        // the finger's own damping is implicit in the new speed, so it is stable at any length of
        // the tick
        let pushed = self.speed_m_per_s + (self.force_n - self.felt_n) / mass_kg * tick_s;
        self.speed_m_per_s = pushed / (1.0 + damping_n_s_per_m / mass_kg * tick_s);
        self.depth_m += self.speed_m_per_s * tick_s;
        if self.depth_m >= block.tissue.depth_limit_m {
            return Err(NoRest::Sunk { depth_mm: block.tissue.depth_limit_m * 1e3 });
        }
        let diverged = NoRest::Diverged { depth_mm: self.depth_m * 1e3 };
        let force = running.tick(block.tip_m(self.depth_m)).map_err(|_| diverged)?;
        self.felt_n = f64::from(force.dot(&block.params.probe.axis));
        if self.felt_n.is_finite() { Ok(()) } else { Err(diverged) }
    }
}

/// Presses tissue that is at rest and untouched.
pub fn to_rest(block: &Block, running: &mut dyn RunningMethod, force_n: f64) -> Result<AtRest, NoRest> {
    let ticks_per_ms = (1e-3 / f64::from(block.params.tick_s)).round().max(1.0) as usize;
    let nodes = block.tissue.mesh.nodes_m.len();
    let positions = |running: &dyn RunningMethod| (0..nodes).map(|n| running.position_m(n).cast()).collect::<Vec<Vector3<f64>>>();
    let mut push = Push::new(force_n);
    running.tick(block.tip_m(push.depth_m())).map_err(|_| NoRest::Diverged { depth_mm: 0.0 })?;
    let (mut tips, mut cpu_s, mut before) = (vec![push.depth_m()], 0.0, None::<Vec<Vector3<f64>>>);
    for ms in 1..=LONGEST_MS {
        let begun = thread_time();
        for _ in 0..ticks_per_ms {
            push.tick(block, running)?;
        }
        cpu_s += (thread_time() - begun).as_secs_f64();
        tips.push(push.depth_m());
        if let Some(before) = before.take() {
            let position_m = positions(running);
            let furthest = before.iter().zip(&position_m).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
            if furthest <= STILL_NODE_M_PER_S * 1e-3 {
                return Ok(AtRest {
                    force_n: push.felt_n,
                    depth_m: push.depth_m,
                    virtual_s: ms as f64 * 1e-3,
                    cpu_s,
                    position_m,
                });
            }
        }
        if ms >= STILL_MS && displacement_m(&tips[ms - STILL_MS..]) < STILL_TIP_M {
            before = Some(positions(running));
        }
    }
    Err(NoRest::Restless { seconds: LONGEST_MS as f64 * 1e-3, tip_um: displacement_m(&tips[LONGEST_MS - STILL_MS..]) * 1e6 })
}

/// Difference between the largest and the smallest depth of the tip [m].
fn displacement_m(tips: &[f64]) -> f64 {
    let (low, high) = tips.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), t| (l.min(*t), h.max(*t)));
    high - low
}
