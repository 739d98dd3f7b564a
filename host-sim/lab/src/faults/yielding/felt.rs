//! The force that a hand feels, against the patch's push.

use palpate::ClampFlags;
use palpate::haptic::cycle::Telemetry;
use palpate::haptic::limits::LoopLimitSettings;
use palpate_tissue::scene::TICK_S;

/// Push of the patch from which a loss counts [N].
const FELT_N: f32 = 0.1;
/// Ticks in a row with less than half of the force that are not yet a loss.
const SHORT_TICKS: u32 = 20;
/// Flags that tell that a force was shortened on purpose.
const FLAGS: [ClampFlags; 3] = [ClampFlags::ENERGY, ClampFlags::GAIN, ClampFlags::SLEW];

/// Force that was felt in a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Felt {
    /// Ticks in which the patch pushed with a force that is felt.
    pub asked_ticks: u64,
    /// Those among them in which more than half of the force was lost for more than 20 ticks.
    pub lost_ticks: u64,
    /// Those among the lost ticks in which the hand owed energy.
    pub owed_ticks: u64,
    /// Those among the lost ticks that no flag tells.
    pub unflagged_ticks: u64,
    /// Impulse of the patch's push, as far as the profile's limits of the force and of its growth
    /// allow it [N s].
    pub asked_n_s: f64,
    /// Impulse of the force along that push that was sent to the device [N s].
    pub felt_n_s: f64,
    /// Push that the limits allowed in the last tick [N].
    allowed_n: f32,
    /// Ticks in a row with less than half of the force.
    weak_ticks: u32,
}

impl Felt {
    /// Counts a tick of a loop with these limits; `owes` tells whether the hand has been given
    /// energy that it has not given back, so that the bound requires the loss.
    pub fn tick(&mut self, seen: &Telemetry, limits: &LoopLimitSettings, owes: bool) {
        let (normal, limit_n) = (seen.output.normal, limits.max_force_n);
        let push_n = seen.output.force_n.dot(&normal).min(limit_n);
        let felt_n = seen.applied_n.dot(&normal);
        self.allowed_n = push_n.min(self.allowed_n + limits.max_slew_n_per_s * TICK_S as f32).max(0.0);
        if push_n > 0.0 {
            self.asked_n_s += f64::from(self.allowed_n) * TICK_S;
            self.felt_n_s += f64::from(felt_n) * TICK_S;
        }
        if push_n <= FELT_N {
            return;
        }
        self.asked_ticks += 1;
        // damping is no loss
        if felt_n >= 0.5 * seen.wanted_n.dot(&normal).min(limit_n) {
            self.weak_ticks = 0;
            return;
        }
        self.weak_ticks += 1;
        if self.weak_ticks > SHORT_TICKS {
            self.lost_ticks += 1;
            self.owed_ticks += u64::from(owes);
            self.unflagged_ticks += u64::from(!FLAGS.iter().any(|flag| seen.limiters.contains(*flag)));
        }
    }
}
