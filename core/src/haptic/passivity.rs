//! Observes in every tick the energy that the loop gives to the hand, bounds the force on a probe
//! that leaves, and fades out the force of a contact that gave too much energy nevertheless.
//!
//! The observer of Hannaford and Ryu (Time-domain passivity control of haptic interfaces, IEEE
//! Trans. Robotics and Automation 18, 2002) sums `F dx` with the force that really acted during the
//! displacement: the one sent `delay` ticks before, behind the lag of the amplifier. A spring takes
//! energy during loading and returns it; energy that it gives beyond that, counted from the touch,
//! was created. Our controller differs from theirs, which injects damping as soon as the sum is
//! negative and thereby makes a quantised encoder buzz. Ours reduces the force on a probe that
//! leaves until the work that the force can do while it acts is within the energy that the contact
//! has taken, as in the energy-bounding algorithm (Kim and Ryu, Robotics and Autonomous Systems 58,
//! 2010). That algorithm bounds the change of the force in each sample from the hand's own damping;
//! ours bounds the force by the observed sum, over the time from sending a force until it ceases to
//! act.
//!
//! The last resort is an alarm, at a threshold above the energy that quantisation can fake (about
//! `F_max` times one count): it fades the contact's force out until the probe has left. By then
//! most of a bounce's energy has been given, so the next contact begins, and stays, at half the
//! gain. The stiffness thus falls until the loop is stable, and doubles again with every good
//! contact. Several contacts in a row that end in the alarm are a fault, and so is as much energy
//! from the contacts of the last seconds together.
//!
//! A sensor with counts reports a displacement late: the probe made it in the ticks since the last
//! count. So the work of a displacement is that of the *mean* force along its axis since that axis
//! last moved. Just after a count, the tissue's force is larger during loading, and smaller during
//! unloading, than the settled force in the tick of the next count. With the settled force alone,
//! the observer would miss energy that the tissue takes in both directions, and a hand that kneads
//! slowly would seem to have used up the energy of its contact within a minute.
//!
//! * in: displacement and velocity of the probe [m, m/s], the force sent [N], whether the patch is
//!   touched
//! * out: energy [J], gain (0 .. 1) on the force, the bounded force [N]
//! * cost: up to 290 instructions of a Cortex-M4F, estimated
//! * failures: [`Fault::EnergyCreated`]

use nalgebra::Vector3;

use super::device::DeviceSpec;
use super::{Range, between, each_within};
use crate::fault::{BuildError, Fault};

/// Number of sent forces that are kept until they act.
const LINE: usize = DeviceSpec::MOST_DELAY_TICKS as usize + 1;
/// Share of the force that remains from tick to tick after the alarm (1): it is down to a hundredth
/// in 20 ms.
const FADE: f32 = 0.8;
/// A gain below this value is set to zero (1).
const FADED: f32 = 0.01;
/// Largest number of ticks over which the force is averaged (1): a force that fades or relaxes is
/// forgotten.
const MEAN_TICKS: f32 = 100.0;
/// Share of a count (1). A probe is at rest if its displacement while the force acts is shorter
/// than this: the low-passed velocity after a count takes 0.5 s to become zero exactly.
const REST_COUNTS: f32 = 0.02;
/// Time after the last force [s] within which a new touch belongs to the same contact. During
/// unloading, a count lifts the shown tip off the tissue, which follows within some ticks. No hand
/// taps so fast: touches that follow each other sooner are a limit cycle, and the energy that each
/// creates adds up.
const KEPT_S: f32 = 0.02;
/// Lags of the amplifier after which its force has all but faded (1).
const LAGS: f32 = 3.0;
/// Time constant with which the energy that contacts created is forgotten [s]. A handle that
/// bounces more slowly than [`KEPT_S`] ends in the alarm only now and then, because the next
/// contact, at half the gain, creates less than the alarm.
const FORGOTTEN_S: f32 = 5.0;

/// Thresholds at which the observer intervenes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PassivitySettings {
    /// Energy that a contact may give beyond what it took before its force is reduced [J].
    pub allowance_j: f32,
    /// Energy that a contact has to give beyond what it took to raise the alarm [J].
    pub alarm_j: f32,
    /// Number of contacts in a row with an alarm that is a fault.
    pub alarms: u16,
}

static RANGES: [Range; 3] = [
    ("passivity.allowance_j", 0.0, PassivitySettings::HIGHEST.allowance_j),
    ("passivity.alarm_j", 1e-6, PassivitySettings::HIGHEST.alarm_j),
    ("passivity.alarms", 1.0, PassivitySettings::HIGHEST.alarms as f32),
];

impl PassivitySettings {
    /// No allowance; the alarm at half a millijoule, which is three times what 3 N and counts of 55
    /// um can fake; a fault at five contacts.
    pub const DEFAULT: Self = Self { allowance_j: 0.0, alarm_j: 0.5e-3, alarms: 5 };
    /// Upper bounds of the settings.
    pub const HIGHEST: Self = Self { allowance_j: 0.1, alarm_j: 0.1, alarms: 100 };

    /// Checks every setting.
    ///
    /// # Errors
    /// [`BuildError::OutOfRange`] names the setting.
    pub fn check(&self) -> Result<(), BuildError> {
        each_within(&RANGES, [self.allowance_j, self.alarm_j, f32::from(self.alarms)])
    }
}

/// Energy at the hand.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energy {
    /// Energy given to the hand since the touch [J]; negative while the tissue stores energy.
    pub given_j: f32,
    /// Largest `given_j` so far in this contact, at least zero: the energy that this contact
    /// created [J].
    pub created_j: f32,
    /// Energy created by all contacts that have ended [J].
    pub total_created_j: f32,
}

/// Displacement and force along an axis.
#[derive(Clone, Copy, Debug, Default)]
struct Axis {
    /// Position of the probe in the backlash (0 .. `play_m`) [m].
    slack_m: f32,
    /// Mean of the force that acted since the last displacement [N].
    mean_n: f32,
    /// Ticks that the mean covers (1).
    mean_ticks: f32,
}

impl Axis {
    /// Work that a force [N] did in this tick over a displacement [m], in joules. A sensor without
    /// counts (`play_m` is zero) reports every displacement in the tick in which it happens, so the
    /// mean covers one tick and equals the force.
    #[inline(never)] // three copies would take 200 bytes more of the board's flash
    fn work_j(&mut self, acting_n: f32, displacement_m: f32, play_m: f32, touched: bool) -> f32 {
        let ticks = between(self.mean_ticks + 1.0, 1.0, MEAN_TICKS);
        self.mean_n += (acting_n - self.mean_n) / ticks;
        let begins = !touched || play_m == 0.0 || displacement_m != 0.0;
        self.mean_ticks = if begins { 0.0 } else { ticks };
        let moved_m = self.slack_m + displacement_m;
        self.slack_m = between(moved_m, 0.0, play_m);
        self.mean_n * (moved_m - self.slack_m)
    }
}

/// Observes the energy, and derives from it the bound and the gain on the force.
#[derive(Clone, Copy, Debug)]
pub struct PassivityObserver {
    settings: PassivitySettings,
    /// Backlash applied to the displacement [m], so that a flipping count adds no energy while the
    /// hand rests.
    play_m: f32,
    /// Largest displacement of a probe at rest while a force acts [m].
    rest_m: f32,
    axes: [Axis; 3],
    /// Force that the amplifier gives at the end of the tick: it follows the delayed force with the
    /// declared lag [N].
    lagging_n: Vector3<f32>,
    /// Share of the gap between the two that a tick leaves, and its mean over the tick (1).
    lag_left: f32,
    lag_mean: f32,
    /// Ring of the forces sent.
    line_n: [Vector3<f32>; LINE],
    /// Index at which the next force is stored in the ring.
    next: u8,
    /// Ticks between sending and acting.
    delay_ticks: u8,
    /// Time from sending a force to its end [s]: whole ticks, the lag, and the tick for which it is
    /// held.
    acts_s: f32,
    /// Ticks since a force was sent.
    idle_ticks: u16,
    /// Ticks without a force after which the contact has ended.
    kept_ticks: u16,
    energy: Energy,
    /// True if a force was sent in this contact.
    open: bool,
    gain: f32,
    /// Gain at which the contact began (1).
    touch_gain: f32,
    /// True if this contact passed the alarm.
    fading: bool,
    /// Number of contacts in a row that passed the alarm.
    alarms: u16,
    /// Energy that the last contacts created, each counted up to the alarm [J].
    recent_j: f32,
    /// Share of `recent_j` that a tick leaves (1).
    remembered: f32,
}

impl PassivityObserver {
    /// Creates an observer with zero energy.
    ///
    /// # Errors
    /// [`BuildError::OutOfRange`] names the setting or `device.delay_ticks`.
    pub fn build(settings: &PassivitySettings, device: &DeviceSpec, tick_s: f32) -> Result<Self, BuildError> {
        settings.check()?;
        device.check()?;
        let delay_ticks = device.delay_ticks;
        let energy = Energy::default();
        let line_n = [Vector3::zeros(); LINE];
        let (mut lag_left, mut lag_mean) = (0.0, 0.0);
        if device.lag_s > 0.0 {
            // exp(-x) from the series of exp(x / 4)
            let x = tick_s / device.lag_s;
            let y = 0.25 * x;
            let quarter = 1.0 + y * (1.0 + y * (1.0 / 2.0 + y * (1.0 / 6.0 + y / 24.0)));
            let half = quarter * quarter;
            lag_left = 1.0 / (half * half);
            lag_mean = (1.0 - lag_left) / x;
        }
        Ok(Self {
            settings: *settings,
            // rounding in the last bit of a position is no count
            play_m: 1.01 * device.count_m,
            rest_m: REST_COUNTS * device.count_m,
            axes: [Axis::default(); 3],
            lagging_n: Vector3::zeros(),
            lag_left,
            lag_mean,
            line_n,
            next: 0,
            delay_ticks,
            acts_s: device.delay_s(tick_s) + tick_s,
            idle_ticks: u16::MAX,
            kept_ticks: u16::from(delay_ticks) + ((KEPT_S + LAGS * device.lag_s) / tick_s + 0.5) as u16,
            energy,
            open: false,
            gain: 1.0,
            touch_gain: 1.0,
            fading: false,
            alarms: 0,
            recent_j: 0.0,
            remembered: 1.0 - tick_s / FORGOTTEN_S,
        })
    }

    /// Observes the displacement since the last tick [m], and whether the patch was touched then.
    /// Call this before this tick's force is sent.
    ///
    /// # Errors
    /// [`Fault::EnergyCreated`] if several contacts in a row end in the alarm, or the contacts of
    /// the last seconds together create as much as these.
    pub fn observe(&mut self, displacement_m: &Vector3<f32>, touched: bool) -> Result<(), Fault> {
        let behind = self.delay_ticks;
        let acting = usize::from(self.next.wrapping_sub(1 + behind)) % LINE;
        let delayed_n = self.line_n.get(acting).copied().unwrap_or_default();
        let gap_n = self.lagging_n - delayed_n;
        let acting_n = delayed_n + gap_n * self.lag_mean;
        self.lagging_n = delayed_n + gap_n * self.lag_left;
        let mut work_j = 0.0;
        for ((axis, force_n), moved_m) in self.axes.iter_mut().zip(acting_n.iter()).zip(displacement_m.iter()) {
            work_j += axis.work_j(*force_n, *moved_m, self.play_m, touched);
        }
        let energy = &mut self.energy;
        energy.given_j += work_j;
        self.recent_j *= self.remembered;
        if energy.given_j > energy.created_j {
            let counted_j = |created_j: f32| between(created_j, 0.0, self.settings.alarm_j);
            self.recent_j += counted_j(energy.given_j) - counted_j(energy.created_j);
            energy.created_j = energy.given_j;
            if self.recent_j > f32::from(self.settings.alarms) * self.settings.alarm_j {
                return Err(Fault::EnergyCreated);
            }
        }
        if energy.created_j > self.settings.alarm_j {
            if !self.fading {
                self.alarms = self.alarms.saturating_add(1);
            }
            self.fading = true;
            self.gain *= FADE;
            if self.gain < FADED {
                self.gain = 0.0;
            }
            if self.alarms >= self.settings.alarms {
                return Err(Fault::EnergyCreated);
            }
        }
        if !touched && self.idle_ticks > self.kept_ticks {
            self.leave();
        }
        Ok(())
    }

    /// Returns the force [N] to send to a probe with this velocity [m/s], on a surface with this
    /// normal: while it acts, it does no more work than this contact took. The push is reduced
    /// first, then the force along the surface, so that friction is not lost with the push and the
    /// force never pulls. A probe at rest gets the whole force.
    #[must_use]
    pub fn bound(&self, force_n: &Vector3<f32>, velocity_m_per_s: &Vector3<f32>, normal: &Vector3<f32>) -> Vector3<f32> {
        let work_j = force_n.dot(velocity_m_per_s) * self.acts_s;
        let left_j = self.settings.allowance_j - self.energy.given_j;
        let left_j = if left_j > 0.0 { left_j } else { 0.0 };
        let rests = work_j * work_j <= force_n.dot(force_n) * (self.rest_m * self.rest_m);
        if work_j <= left_j || rests {
            return *force_n;
        }
        let push_n = force_n.dot(normal);
        if push_n <= 0.0 {
            return force_n * (left_j / work_j);
        }
        let (left_w, along_n) = (left_j / self.acts_s, force_n - normal * push_n);
        let (leaves_m_per_s, along_w) = (velocity_m_per_s.dot(normal), along_n.dot(velocity_m_per_s));
        let kept_n = if leaves_m_per_s > 0.0 { (left_w - along_w) / leaves_m_per_s } else { push_n };
        let kept_n = between(kept_n, 0.0, push_n);
        let may_w = left_w - kept_n * leaves_m_per_s;
        let share = if along_w > may_w { may_w / along_w } else { 1.0 };
        // without a force along the surface, rounding may divide a negative power by zero
        along_n * between(share, 0.0, 1.0) + normal * kept_n
    }

    /// Ends the contact.
    fn leave(&mut self) {
        if !self.open {
            return;
        }
        self.open = false;
        let total_created_j = self.energy.total_created_j + self.energy.created_j;
        self.energy = Energy { total_created_j, ..Energy::default() };
        if self.fading {
            self.touch_gain *= 0.5;
        } else {
            self.alarms = 0;
            let doubled = 2.0 * self.touch_gain;
            self.touch_gain = if doubled < 1.0 { doubled } else { 1.0 };
        }
        self.fading = false;
        self.gain = self.touch_gain;
    }

    /// Records the force sent in this tick [N].
    pub fn sent(&mut self, force_n: Vector3<f32>) {
        if let Some(newest) = self.line_n.get_mut(usize::from(self.next) % LINE) {
            *newest = force_n;
        }
        self.next = self.next.wrapping_add(1);
        let idle = force_n.dot(&force_n) == 0.0;
        self.idle_ticks = if idle { self.idle_ticks.saturating_add(1) } else { 0 };
        self.open |= !idle;
    }

    /// Clears the alarms, the contact and the forces on their way, which end when the device is
    /// released; the total stays.
    pub fn clear(&mut self) {
        // also without a force, since an alarm would keep the gain at zero and no contact would end
        self.open = true;
        self.leave();
        (self.line_n, self.lagging_n) = ([Vector3::zeros(); LINE], Vector3::zeros());
        (self.alarms, self.recent_j, self.touch_gain, self.gain) = (0, 0.0, 1.0, 1.0);
    }

    /// Energy given to the hand.
    #[must_use]
    pub fn energy(&self) -> Energy {
        self.energy
    }

    /// Gain on the force (1): one until an alarm; it falls during a contact and rises only between
    /// contacts.
    #[must_use]
    pub fn gain(&self) -> f32 {
        self.gain
    }
}

#[cfg(test)]
mod tests;
