//! Path from a force that is sent to the force that acts: whole ticks of delay, and the lag
//! of amplifier and motor.

use std::collections::VecDeque;

use palpate::Vector3;

use super::watch::Truth;
use palpate_tissue::scene::TICK_S;

/// Steps per tick, as those of the plant.
const STEPS: u32 = 50;

/// Forces on their way, and the force that acts.
#[derive(Clone, Debug)]
pub struct Drive {
    /// Forces not yet at the amplifier [N], the oldest first.
    line_n: VecDeque<Vector3<f64>>,
    acting_n: Vector3<f64>,
    lag_s: f64,
}

impl Drive {
    /// A drive at rest with this delay and lag [s].
    #[must_use]
    pub fn new(delay_ticks: u8, lag_s: f64) -> Self {
        Self { line_n: vec![Vector3::zeros(); usize::from(delay_ticks) + 1].into(), acting_n: Vector3::zeros(), lag_s }
    }

    /// Sends a force [N]; called once per tick.
    pub fn send(&mut self, force_n: Vector3<f64>) {
        self.line_n.pop_front();
        self.line_n.push_back(force_n);
    }

    /// Cuts the power: no force that is on its way arrives.
    pub fn release(&mut self) {
        self.line_n.iter_mut().for_each(|force_n| *force_n = Vector3::zeros());
        self.acting_n = Vector3::zeros();
    }

    /// Carries the tip straight from one position to another [m] within a tick, whatever acts.
    pub fn carry(&mut self, from_m: &Vector3<f64>, to_m: &Vector3<f64>) -> Truth {
        let asked_n = self.line_n.front().copied().unwrap_or_default();
        let left = if self.lag_s > 0.0 { (-TICK_S / f64::from(STEPS) / self.lag_s).exp() } else { 0.0 };
        let step_m = (to_m - from_m) / f64::from(STEPS);
        let mut sum_n = Vector3::zeros();
        for _ in 0..STEPS {
            self.acting_n = asked_n + (self.acting_n - asked_n) * left;
            sum_n += self.acting_n;
        }
        Truth { at_m: *to_m, mean_n: sum_n / f64::from(STEPS), work_j: sum_n.dot(&step_m) }
    }
}
