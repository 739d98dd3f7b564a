//! Commissioning: which sensor and which motor belong to which axis, with sign, unit, friction,
//! mass, delay and lag, measured on the device itself instead of guessed in the loop.
//!
//! ```text
//! by hand    for each axis: start, move by the stated distance, done     sensor, sign, unit
//! hand off   for each motor: rest, ramp until it moves, both ways        motor, sign, friction
//!                            strokes: push, reverse, rest, both ways     mass, delay, lag
//! ```
//!
//! No force acts while a hand moves the handle. With the hand off, one motor at a time is driven:
//! first slowly harder until the handle moves, then with that force and a few per cent of the
//! limit, and never with more than [`DeviceSpec::UNCOMMISSIONED_N`]. A handle that moves without a
//! force, that springs back, that does not move, or that goes far ends the measurement with a
//! [`Trouble`], and every ending means zero force.
//!
//! The caller runs it tick by tick: readings of the sensors in any unit go in, and forces for the
//! motors [N] come out, each number in the order of the wires. Reading and forces are of one time:
//! the force is sent in the tick of the reading, as in the loop itself.
//!
//! * in: three readings, and whether the user confirms a step
//! * out: three forces [N]
//! * cost: 12 000 instructions of a Cortex-M4F in the longest tick, estimated; no loop runs then
//! * failures: [`Trouble`]

mod hands_off;
mod response;
mod trouble;
mod wiring;

pub use trouble::Trouble;
pub use wiring::Wiring;

use self::hands_off::HandsOff;
use self::wiring::nth;
use super::device::DeviceSpec;

/// Knowledge before the measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// Those of the axes x, y and z, or of the joints, that the device has.
    pub axes: [bool; 3],
    /// Distance by which the user moves the handle along each axis, in its positive direction [m].
    pub distance_m: f32,
    /// Force limit of the loop [N]; the strokes add a few per cent of it to the friction.
    pub force_limit_n: f32,
    /// Metres per unit of each axis' sensor by the data sheet. It is kept where the measurement by
    /// hand agrees with it within a tenth, since a ruler is less exact than a data sheet.
    pub stated_m_per_unit: [f32; 3],
    /// Period of the ticks [s].
    pub tick_s: f32,
}

impl Plan {
    /// Relative difference up to which a stated unit is kept (1).
    /// Source: chosen; a distance by ruler is closer than that, and a wrong unit is not
    /// (`a_distance_that_is_a_little_wrong_keeps_the_data_sheets_unit`).
    pub const SAME_UNIT: f32 = 0.1;
}

/// Step of a commissioning; the number is that of the axis or motor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Waits for the user to hold the handle still before the motion along this axis.
    Start(u8),
    /// Waits for the user to move the handle along this axis, hold it still and confirm.
    Move(u8),
    /// Waits for the user to put the handle into the middle of the workspace and let it go.
    LetGo,
    /// Measures with this motor, hand off.
    Drive(u8),
    /// The result is complete.
    Done,
    /// It ended without a result.
    Stopped(Trouble),
}

impl Stage {
    /// Whether a step of the user is waited for.
    #[must_use]
    #[inline]
    pub fn asks(self) -> bool {
        matches!(self, Self::Start(_) | Self::Move(_) | Self::LetGo)
    }

    /// Whether it has ended.
    #[must_use]
    #[inline]
    pub fn ended(self) -> bool {
        matches!(self, Self::Done | Self::Stopped(_))
    }
}

/// Result of a commissioning. Entries of axes that the device does not have are those of
/// [`Wiring::STRAIGHT`], or zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Commissioned {
    /// Sensors and motors of the axes; the unit is metres per unit of the sensor.
    pub wiring: Wiring,
    /// Friction along each axis [N].
    pub friction_n: [f32; 3],
    /// Mass that each motor moves [kg].
    pub mass_kg: [f32; 3],
    /// Smallest step of each axis' reading [m]; zero if the readings have no visible steps.
    pub count_m: [f32; 3],
    /// Whole ticks from computing a force to the amplifiers applying it.
    pub delay_ticks: u8,
    /// Time constant of amplifier and motor [s].
    pub lag_s: f32,
}

/// Steps of a reading below this length are those of an ideal sensor [m].
/// Source: chosen; a twentieth of the finest count of the shipped profiles, 10 um.
const IDEAL_M: f32 = 0.5e-6;
/// Smallest number of steps of a reading in a motion by hand.
/// Source: derived; a count is then 5 % of the motion, within [`Plan::SAME_UNIT`].
const LEAST_STEPS: f32 = 20.0;
/// Largest share that the second reading may have in a motion by hand (1).
/// Source: derived; a motion that slants by 27 degrees.
const ASIDE: f32 = 0.5;

/// A commissioning in progress.
#[derive(Clone, Copy, Debug)]
pub struct Commissioning {
    plan: Plan,
    stage: Stage,
    wiring: Wiring,
    /// Sensors that were assigned.
    taken: [bool; 3],
    /// Readings at the start of the motion by hand, and of the last tick.
    from: [f32; 3],
    last: Option<[f32; 3]>,
    /// Smallest change of each reading between two ticks.
    step: [f32; 3],
    hands_off: HandsOff,
    result: Option<Commissioned>,
}

impl Commissioning {
    /// Begins with the first axis.
    #[must_use]
    #[inline]
    pub fn new(plan: Plan) -> Self {
        let first = (0..3).find(|axis| has(&plan, *axis));
        Self {
            plan,
            stage: first.map_or(Stage::Stopped(Trouble::Unclear), Stage::Start),
            wiring: Wiring::STRAIGHT,
            taken: [false; 3],
            from: [0.0; 3],
            last: None,
            step: [f32::MAX; 3],
            hands_off: HandsOff::new(&plan),
            result: None,
        }
    }

    /// Step that is in progress.
    #[must_use]
    #[inline]
    pub fn stage(&self) -> Stage {
        self.stage
    }

    /// Result, once it is complete.
    #[must_use]
    #[inline]
    pub fn result(&self) -> Option<&Commissioned> {
        self.result.as_ref()
    }

    /// Ends it without a result, unless it has ended.
    #[inline]
    pub fn stop(&mut self, trouble: Trouble) {
        if !self.stage.ended() {
            self.stage = Stage::Stopped(trouble);
        }
    }

    /// Runs one tick: takes the readings of the sensors, and whether the user confirms the step
    /// that [`Self::stage`] asks for. Returns the forces for the motors [N].
    #[inline]
    pub fn tick(&mut self, sensors: [f32; 3], confirmed: bool) -> [f32; 3] {
        if !sensors.iter().all(|reading| reading.is_finite()) {
            self.stop(Trouble::Faulted);
        }
        for ((step, now), before) in self.step.iter_mut().zip(sensors).zip(self.last.replace(sensors).unwrap_or(sensors)) {
            let change = (now - before).abs();
            if change > 0.0 && change < *step {
                *step = change;
            }
        }
        let mut forces_n = [0.0; 3];
        let next = match self.stage {
            Stage::Start(axis) if confirmed => {
                self.from = sensors;
                Ok(Stage::Move(axis))
            }
            Stage::Move(axis) if confirmed => self.moved(axis, sensors),
            Stage::LetGo if confirmed => {
                let at_m = self.wiring.read(sensors);
                self.hands_off.begin(at_m, self.count_m());
                Ok(Stage::Drive(0))
            }
            Stage::Drive(_) => match self.hands_off.tick(self.wiring.read(sensors)) {
                Ok((motor, force_n)) => {
                    if let Some(place) = forces_n.get_mut(usize::from(motor)) {
                        *place = force_n;
                    }
                    match self.hands_off.result(&self.wiring) {
                        Some(Ok(mut result)) => {
                            result.count_m = self.count_m();
                            self.result = Some(result);
                            Ok(Stage::Done)
                        }
                        Some(Err(trouble)) => Err(trouble),
                        None => Ok(Stage::Drive(motor)),
                    }
                }
                Err(trouble) => Err(trouble),
            },
            stage => Ok(stage),
        };
        self.stage = next.unwrap_or_else(Stage::Stopped);
        if self.stage.ended() { [0.0; 3] } else { forces_n }
    }

    /// Assigns a sensor to an axis after a motion by hand.
    #[inline]
    fn moved(&mut self, axis: u8, sensors: [f32; 3]) -> Result<Stage, Trouble> {
        let (mut best, mut second) = ((0_u8, 0.0_f32), 0.0_f32);
        for sensor in 0..3 {
            let change = nth(sensors, sensor) - nth(self.from, sensor);
            if change.abs() > best.1.abs() {
                second = best.1.abs();
                best = (sensor, change);
            } else if change.abs() > second {
                second = change.abs();
            }
        }
        let (sensor, change) = best;
        let at = usize::from(axis);
        let enough = change.abs() > LEAST_STEPS * nth(self.step, sensor);
        if !enough || second > ASIDE * change.abs() {
            return Err(if enough { Trouble::Slanted(axis) } else { Trouble::NotMoved(axis) });
        }
        match self.taken.get_mut(usize::from(sensor)) {
            Some(taken) if !*taken => *taken = true,
            _ => return Err(Trouble::SameSensor(axis)),
        }
        let stated = nth(self.plan.stated_m_per_unit, axis).abs();
        let measured = self.plan.distance_m / change.abs();
        let same = (measured - stated).abs() <= Plan::SAME_UNIT * stated;
        let per_unit = if same { stated } else { measured };
        if let (Some(place), Some(unit)) = (self.wiring.sensor.get_mut(at), self.wiring.per_unit.get_mut(at)) {
            (*place, *unit) = (sensor, per_unit.copysign(change));
        }
        match (axis + 1..3).find(|axis| has(&self.plan, *axis)) {
            Some(axis) => Ok(Stage::Start(axis)),
            None => {
                self.spare();
                Ok(Stage::LetGo)
            }
        }
    }

    /// Gives the axes that the device does not have the sensors that are left.
    #[inline]
    fn spare(&mut self) {
        for axis in 0..3_u8 {
            if has(&self.plan, axis) {
                continue;
            }
            let left = self.taken.iter().position(|taken| !taken);
            if let (Some(sensor), Some(place)) = (left, self.wiring.sensor.get_mut(usize::from(axis))) {
                *place = sensor as u8;
                self.taken.iter_mut().skip(sensor).take(1).for_each(|taken| *taken = true);
            }
        }
    }

    /// Smallest step of each axis' reading [m].
    #[inline]
    fn count_m(&self) -> [f32; 3] {
        let mut count_m = [0.0; 3];
        for (axis, place) in (0..3).zip(&mut count_m) {
            let sensor = self.wiring.sensor.get(usize::from(axis)).copied().unwrap_or(axis);
            let step_m = nth(self.step, sensor) * nth(self.wiring.per_unit, axis).abs();
            if has(&self.plan, axis) && step_m >= IDEAL_M && step_m.is_finite() && nth(self.step, sensor) < f32::MAX {
                *place = step_m;
            }
        }
        count_m
    }
}

#[inline]
fn has(plan: &Plan, axis: u8) -> bool {
    plan.axes.get(usize::from(axis)).copied().unwrap_or(false)
}

/// Largest force of a commissioning [N].
const MOST_N: f32 = DeviceSpec::UNCOMMISSIONED_N;
