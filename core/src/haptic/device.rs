//! Interface of a haptic device, which reports the position of its probe and applies a force.
//!
//! * in: nothing / a force [N]
//! * out: a position [m] with a sequence number and the sensor's own status / nothing
//! * cost: depends on the device
//! * failures: a sensor reports one in [`Sensed::status`]; an actuator cannot refuse

use nalgebra::Vector3;

use super::{Range, each_within};
use crate::fault::BuildError;

/// Limits and resolution of a device. They belong to its profile and are constant while it runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeviceSpec {
    /// Largest force that its actuators give in every direction [N].
    pub max_force_n: f32,
    /// Corner of its workspace with the smallest coordinates [m], patch frame.
    pub workspace_low_m: Vector3<f32>,
    /// Corner of its workspace with the largest coordinates [m], patch frame.
    pub workspace_high_m: Vector3<f32>,
    /// One encoder count at the probe [m]; zero for an ideal sensor.
    pub count_m: f32,
    /// Whole ticks from computing a force to the actuators applying it, not counting the tick for
    /// which it is held.
    pub delay_ticks: u8,
    /// Time constant of amplifier and motor [s].
    pub lag_s: f32,
    /// Mass of the handle at the probe [kg]. The lightest handle that the device may have is the
    /// cautious value: a light handle is accelerated most by its own motors.
    pub mass_kg: f32,
    /// Largest contact stiffness that the device renders without a limit cycle [N/m], as stated.
    pub stiffness_ceiling_n_per_m: f32,
    /// Whether sign, order, unit, friction, delay and lag of the axes were measured on the device
    /// itself.
    pub commissioned: bool,
}

/// Largest step of the force that a count may cause [N]. A contact that is stiffer shakes: with
/// counts of 55 um, a flat tip and hands of 21 to 200 g, contacts of 1200 N/m shake with 74 mN at
/// most and those of 2000 N/m with up to 0.45 N (`palpate faults --hands`). Diolaiti et al. (The
/// effect of quantization and Coulomb friction on the stability of haptic rendering, IEEE Trans.
/// Robotics 22, 2006) bound the step by twice the friction of the device.
/// Source: measured by that command; with counts of 55 um it is the step of 1090 N/m.
const COUNT_STEP_N: f32 = 0.06;

/// Ranges that a device may declare; the sides of the workspace are in the order x, y, z.
/// Source: chosen; wider than all shipped profiles, so that a mistyped unit is refused.
static RANGES: [Range; 12] = [
    ("device.max_force_n", 0.01, DeviceSpec::MOST_FORCE_N),
    ("device.count_m", 0.0, 1e-3),
    ("device.delay_ticks", 0.0, DeviceSpec::MOST_DELAY_TICKS as f32),
    ("device.lag_s", 0.0, DeviceSpec::MOST_LAG_S),
    ("device.mass_kg", 1e-3, 5.0),
    ("device.stiffness_ceiling_n_per_m", 1.0, 1e5),
    (LOW, -2.0, 2.0),
    (LOW, -2.0, 2.0),
    (LOW, -2.0, 2.0),
    (SIZE, 1e-3, 2.0),
    (SIZE, 1e-3, 2.0),
    (SIZE, 1e-3, 2.0),
];
const LOW: &str = "device.workspace_low_m";
const SIZE: &str = "device.workspace size in m";

impl DeviceSpec {
    /// Largest [`DeviceSpec::delay_ticks`] that is supported.
    /// Source: chosen; the ring of forces on their way then has eight places ([`super::account`]);
    /// shipped profiles state one tick.
    pub const MOST_DELAY_TICKS: u8 = 7;
    /// Largest [`DeviceSpec::lag_s`] that is supported [s]. With 6 ms and five ticks of delay, a
    /// handle that bounces on a wall of 250 N/m is given 13 mJ in 10 s.
    /// Source: chosen; above the 6 ms that a commissioning can measure; shipped profiles state 1 ms
    /// at most.
    pub const MOST_LAG_S: f32 = 10e-3;
    /// Largest force that any device may declare [N]; a hand can withstand it.
    /// Source: chosen; above the 12 N of the strongest shipped profile.
    pub const MOST_FORCE_N: f32 = 20.0;
    /// Largest force on a device that was not commissioned [N]. A hand holds against it with two
    /// fingers, and tissue of 3 kPa can be felt with it.
    /// Source: chosen by those two.
    pub const UNCOMMISSIONED_N: f32 = 0.5;
    /// A commissioned desktop stylus of 3.3 N and 45 g with an ideal sensor and a delay of one
    /// tick, in a workspace of 0.2 m around the origin. Source: the profile `touch` in
    /// `host-sim/devices`, which names its own sources.
    pub const STYLUS: Self = Self {
        max_force_n: 3.3,
        workspace_low_m: Vector3::new(-0.1, -0.1, -0.1),
        workspace_high_m: Vector3::new(0.1, 0.1, 0.1),
        count_m: 0.0,
        delay_ticks: 1,
        lag_s: 0.0,
        mass_kg: 0.045,
        stiffness_ceiling_n_per_m: 1e5,
        commissioned: true,
    };

    /// Time from computing a force to its acting [s]: whole ticks and the lag.
    #[must_use]
    pub fn delay_s(&self, tick_s: f32) -> f32 {
        f32::from(self.delay_ticks) * tick_s + self.lag_s
    }

    /// Largest contact stiffness that a loop with this tick [s] renders on this device [N/m]: the
    /// lowest of the stated ceiling, that at which a count steps the force by 60 mN, and that which
    /// the delay allows.
    ///
    /// If the hand lets go, the force `F` that is on its way acts for a time `t`, delay and lag and
    /// the tick itself, before any answer. It moves the handle of mass `m` by `F t^2 / (2 m)` and
    /// does the work `F^2 t^2 / (2 m)`, while a contact of stiffness `K` stores `F^2 / (2 K)`.
    /// Above `K = m / t^2` no loop keeps the hand from getting more than it gave, unless it sends
    /// less than `K` asks for. A third of that leaves the rest to the motion of the hand itself: of
    /// 291 random hands with delays of 5.5 to 17 ms, those that owe no energy then lose half of the
    /// force in 0.08 % of the ticks, with half of it in 0.6 %, and feel 0.53 of the tissue's own
    /// push (`palpate faults --hands`).
    #[must_use]
    #[inline]
    pub fn ceiling_n_per_m(&self, tick_s: f32) -> f32 {
        let late_s = self.delay_s(tick_s) + tick_s;
        let late_n_per_m = self.mass_kg / 3.0 / (late_s * late_s);
        let stated = self.stiffness_ceiling_n_per_m;
        let most = if stated < late_n_per_m { stated } else { late_n_per_m };
        if most * self.count_m > COUNT_STEP_N { COUNT_STEP_N / self.count_m } else { most }
    }

    /// Checks every number.
    ///
    /// # Errors
    /// [`BuildError::OutOfRange`] names the first value out of range; NaN is out of every range.
    pub fn check(&self) -> Result<(), BuildError> {
        let (low_m, size_m) = (self.workspace_low_m, self.workspace_high_m - self.workspace_low_m);
        let sides = [low_m.x, low_m.y, low_m.z, size_m.x, size_m.y, size_m.z];
        let [a, b, c, d, e, f] = sides;
        let delay_ticks = f32::from(self.delay_ticks);
        let (mass_kg, ceiling_n_per_m) = (self.mass_kg, self.stiffness_ceiling_n_per_m);
        let scalars = [self.max_force_n, self.count_m, delay_ticks, self.lag_s, mass_kg, ceiling_n_per_m];
        let [force, count, delay, lag, mass, ceiling] = scalars;
        each_within(&RANGES, [force, count, delay, lag, mass, ceiling, a, b, c, d, e, f])
    }
}

/// A sensor's verdict on its own reading.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SensorStatus {
    /// The reading can be trusted.
    Good,
    /// Lost index, broken cable or bad checksum: the reading cannot be trusted.
    Failed,
}

/// Reading of the device's sensors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensed {
    /// Tip of the probe [m], patch frame.
    pub position_m: Vector3<f32>,
    /// Number of the reading, which increases by one with every new reading and wraps. A reading
    /// whose number repeats or decreases is old.
    pub sequence: u32,
    /// Whether the reading can be trusted.
    pub status: SensorStatus,
}

/// A device in the loop: real, emulated, or a wrapper that injects faults into another.
///
/// An implementation converts counts into metres of the patch frame and forces into counts. It
/// neither filters nor limits; the cycle does both.
///
/// ```
/// use palpate::Vector3;
/// use palpate::haptic::device::{DeviceSpec, HapticDevice, Sensed, SensorStatus};
///
/// /// One axis with an encoder of 20 um and a motor of 10 mN per step.
/// struct Slider {
///     counts: i32,
///     readings: u32,
///     steps: i32,
/// }
///
/// impl HapticDevice for Slider {
///     fn limits(&self) -> DeviceSpec {
///         let [workspace_low_m, workspace_high_m] = [-0.05, 0.05].map(Vector3::repeat);
///         DeviceSpec { workspace_low_m, workspace_high_m, count_m: 20e-6, ..DeviceSpec::STYLUS }
///     }
///     fn sense(&mut self) -> Sensed {
///         self.readings += 1;
///         let position_m = Vector3::z() * (self.counts as f32 * 20e-6);
///         Sensed { position_m, sequence: self.readings, status: SensorStatus::Good }
///     }
///     fn actuate(&mut self, force_n: Vector3<f32>) {
///         self.steps = (force_n.z * 100.0) as i32;
///     }
///     fn release(&mut self) {
///         self.steps = 0;
///     }
/// }
///
/// let mut slider = Slider { counts: -500, readings: 0, steps: 0 };
/// assert_eq!(slider.sense().position_m.z, -0.01);
/// slider.actuate(Vector3::z() * 1.5);
/// assert_eq!(slider.steps, 150);
/// ```
pub trait HapticDevice {
    /// Limits of the device.
    fn limits(&self) -> DeviceSpec;

    /// Returns the newest reading, without waiting.
    fn sense(&mut self) -> Sensed;

    /// Applies this force [N], patch frame, until the next call. It is finite and within
    /// [`DeviceSpec::max_force_n`].
    fn actuate(&mut self, force_n: Vector3<f32>);

    /// Applies no force and takes the power off the actuators, as far as the device can. May be
    /// called in every tick.
    fn release(&mut self);
}
