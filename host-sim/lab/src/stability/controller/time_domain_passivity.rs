//! Time-domain passivity control (Hannaford and Ryu, IEEE Trans. Robotics and Automation 18, 2002):
//! as soon as the port has delivered more energy than it absorbed, damping in this tick dissipates
//! the excess.
//!
//! With a *reference energy* (Ryu, Preusche, Hannaford and Hirzinger, IEEE Trans. Control Systems
//! Technology 13, 2005) the energy absorbed at the port may never fall below the energy that the
//! model stores at that depth, so damping acts as soon as energy is created, not only when all
//! stored energy has been returned.

use std::collections::VecDeque;

use super::{Known, Law, Seen, TICK_S, Velocity};

/// Largest damping coefficient [N s/m].
const MOST_N_S_PER_M: f32 = 5.0;
/// Speed below which no damping is applied [m/s].
const STILL_M_PER_S: f32 = 1e-4;

#[derive(Clone, Debug)]
pub(super) struct TimeDomainPassivity {
    reference: bool,
    velocity: Velocity,
    max_force_n: f32,
    /// Forces that were sent but do not act yet [N], in the order in which they will act.
    line_n: VecDeque<f32>,
    depth_m: f32,
    model_n: f32,
    taken_j: f32,
    reference_j: f32,
}

impl TimeDomainPassivity {
    pub(super) fn new(device: &Known, reference: bool) -> Self {
        Self {
            reference,
            velocity: Velocity::new(Velocity::SHARE_100_HZ),
            max_force_n: device.max_force_n,
            line_n: VecDeque::from(vec![0.0; device.delay_ticks + 1]),
            depth_m: 0.0,
            model_n: 0.0,
            taken_j: 0.0,
            reference_j: 0.0,
        }
    }
}

impl Law for TimeDomainPassivity {
    fn force_n(&mut self, seen: &Seen) -> f32 {
        let in_m_per_s = self.velocity.track(seen.depth_m);
        let displacement_m = seen.depth_m - self.depth_m;
        let acted_n = self.line_n.pop_front().unwrap_or(0.0);
        // at the start of a contact the energy account is reset to zero
        if seen.model_n > 0.0 && self.model_n == 0.0 && self.line_n.iter().all(|f| *f == 0.0) && acted_n == 0.0 {
            (self.taken_j, self.reference_j) = (0.0, 0.0);
        }
        self.taken_j += acted_n * displacement_m;
        self.reference_j += 0.5 * (seen.model_n + self.model_n) * displacement_m;
        (self.depth_m, self.model_n) = (seen.depth_m, seen.model_n);

        let left_j = if self.reference { self.taken_j - self.reference_j } else { self.taken_j };
        let mut force_n = seen.model_n;
        if force_n > 0.0 && left_j < 0.0 && in_m_per_s.abs() > STILL_M_PER_S {
            let damping = (-left_j / (TICK_S * in_m_per_s * in_m_per_s)).min(MOST_N_S_PER_M);
            force_n += damping * in_m_per_s;
        }
        let force_n = force_n.clamp(0.0, self.max_force_n);
        self.line_n.push_back(force_n);
        force_n
    }
}
