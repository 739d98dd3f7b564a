//! Nodes that sleep in place: a node at rest is frozen until the force on it would move it. The
//! active region then follows the motion, not the contact.

use palpate::method::Method;
use palpate::stages::integrate;
use palpate::{Fault, Model, State, Tuned, Vector3};

/// Number of quiet ticks after which a node falls asleep.
const QUIET_TICKS: u16 = 20;
/// Number of ticks over which a node's travel is measured.
const TRAVEL_TICKS: u64 = 10;

/// The product's forces and time step, applied to the nodes that are awake.
#[derive(Clone, Debug)]
pub struct Sleeping {
    /// A sleeping node wakes when the force on it, divided by its mean diagonal stiffness, exceeds
    /// this threshold [m]. An awake node counts as quiet while that quotient and its travel both
    /// stay below half the threshold.
    threshold_m: f32,
    nodes: Vec<Sleeper>,
    steps: u64,
}

#[derive(Clone, Copy, Debug)]
struct Sleeper {
    /// Number of quiet ticks in a row.
    quiet: u16,
    /// Position at which the node sleeps [m]; `None` while it is awake.
    at_m: Option<Vector3<f32>>,
    /// Position of the node when its travel was last measured [m].
    was_m: Vector3<f32>,
}

impl Sleeping {
    /// Creates the method with all nodes awake.
    #[must_use]
    pub fn new(threshold_m: f64, model: &Model) -> Self {
        let awake = |n: &palpate::NodeRest| Sleeper { quiet: 0, at_m: None, was_m: n.rest_m.into() };
        Self { threshold_m: threshold_m as f32, nodes: model.nodes.iter().map(awake).collect(), steps: 0 }
    }
}

impl Method for Sleeping {
    fn advance(&mut self, model: &Model, tuned: &Tuned, state: &mut State) -> Result<u16, Fault> {
        let quiet_m = 0.5 * self.threshold_m;
        let looked_at = self.steps.is_multiple_of(TRAVEL_TICKS);
        for ((sleeper, node), rest) in self.nodes.iter_mut().zip(state.nodes()).zip(model.nodes) {
            let pull_m = node.force_over_modulus().norm() / rest.stiffness_m;
            let here_m = node.position_m();
            if sleeper.at_m.is_some() {
                if pull_m > self.threshold_m {
                    *sleeper = Sleeper { quiet: 0, at_m: None, was_m: here_m };
                }
                continue;
            }
            let travelled = (here_m - sleeper.was_m).norm() > quiet_m;
            sleeper.quiet = if pull_m > quiet_m || travelled { 0 } else { sleeper.quiet + 1 };
            if looked_at {
                sleeper.was_m = here_m;
            }
            if sleeper.quiet >= QUIET_TICKS {
                sleeper.at_m = Some(here_m);
            }
        }
        self.steps += 1;
        let mut active = integrate::advance(model, tuned, state)?;
        for (n, sleeper) in self.nodes.iter().enumerate() {
            if let Some(at_m) = sleeper.at_m {
                state.place(n, at_m, Vector3::zeros());
                let free = tuned.mass_kg(n).is_some_and(f32::is_finite);
                active -= u16::from(free);
            }
        }
        Ok(active)
    }
}
