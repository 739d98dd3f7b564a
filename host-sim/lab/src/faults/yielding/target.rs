//! The point that a hand moves towards.

use palpate::Vector3;
use palpate_tissue::scene::TICK_S;

use palpate_loop::closed_loop::hand;

/// Fastest that a person moves a stylus [m/s].
pub(super) const HAND_M_PER_S: f64 = 1.5;
/// Speed at which a person takes the stylus out of the tissue after a fault [m/s].
pub(super) const WITHDRAW_M_PER_S: f64 = 0.2;

/// The point that a hand moves towards.
#[derive(Clone, Copy, Debug)]
pub(super) struct Target {
    pub at_m: Vector3<f64>,
}

impl Target {
    /// Moves towards `to_m` for a tick, no faster than `most_m_per_s`, and returns the motion.
    pub fn follow(&mut self, to_m: &Vector3<f64>, most_m_per_s: f64) -> hand::Aim {
        let (from_m, way_m) = (self.at_m, to_m - self.at_m);
        let share = (most_m_per_s * TICK_S / way_m.norm().max(f64::MIN_POSITIVE)).min(1.0);
        self.at_m += way_m * share;
        hand::Aim {
            at_m: from_m,
            velocity_m_per_s: way_m * (share / TICK_S),
            push_n: Vector3::zeros(),
            let_go: false,
            steady: false,
        }
    }
}
