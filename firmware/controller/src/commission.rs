//! Commissioning on a board: encoder counts go into the procedure of
//! [`palpate::haptic::commission`], and its forces become converter codes.
//!
//! The loop runs on meanwhile, in `Idle`, with the reading that it had at the beginning: a unit or
//! a sign that is still wrong is no fault then. The outputs are on only while a motor is driven,
//! and anything unusual ends the measurement: a fault, a stop, a host that is silent, a late tick,
//! a released switch, or encoders that cannot be trusted.

use palpate::haptic::commission::{Commissioned, Commissioning, Plan, Stage, Trouble, Wiring};
use palpate::haptic::cycle::{Ask, Command, Telemetry};
use palpate::haptic::device::{DeviceSpec, SensorStatus};
use palpate::haptic::mode::Mode;
use serde::{Deserialize, Serialize};

use crate::force_out::{DacCode, Outputs};
use crate::port::Port;
use crate::probe_in::{EncoderCounts, JointReading, Reading};

/// Ticks without a message from the host after which it counts as lost while a motor is driven.
const SILENCE_TICKS: u16 = 20;
/// Such ticks while the outputs are off: a busy host may pause.
const PAUSE_TICKS: u16 = 500;

/// A commissioning in progress, or its outcome until another one begins.
#[derive(Clone, Copy, Debug)]
pub struct Bench {
    commissioning: Commissioning,
    /// Share of the converter's range per newton at the tip, for each joint.
    share_per_n: [f32; 3],
    /// Counts at the beginning; `None` before the first reading.
    from: Option<[i32; 3]>,
    /// Reading that the loop sees meanwhile.
    shown: Reading,
    confirmed: bool,
    silent_ticks: u16,
}

/// Knowledge of the host of the device before its commissioning. The board's own profile is not
/// used, since it may be that of another device.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Setup {
    /// Axes or joints of the device.
    pub axes: [bool; 3],
    /// Distance by which the user moves the tip along each axis or by each joint [m].
    pub distance_m: f32,
    /// Force limit of the profile [N].
    pub force_limit_n: f32,
    /// Metres at the tip per count by the profile.
    pub stated_m_per_count: [f32; 3],
    /// Share of the converter's range per newton at the tip (1/N).
    pub share_per_n: [f32; 3],
}

impl Setup {
    /// The device of a profile.
    #[must_use]
    pub fn of(port: &Port, force_limit_n: f32, distance_m: f32) -> Self {
        let (axes, stated_m_per_count, share_per_n) = port.joints();
        Self { axes, distance_m, force_limit_n, stated_m_per_count, share_per_n }
    }

    /// Whether every number is in its range. NaN is in none.
    #[must_use]
    pub fn sound(&self) -> bool {
        let joint = |(there, (count_m, share)): (bool, (f32, f32))| {
            !there || ((1e-8..=1e-2).contains(&count_m) && (1e-4..=2.0).contains(&share))
        };
        let numbers = self.stated_m_per_count.into_iter().zip(self.share_per_n);
        (5e-3..=0.5).contains(&self.distance_m)
            && (0.01..=DeviceSpec::MOST_FORCE_N).contains(&self.force_limit_n)
            && self.axes.contains(&true)
            && self.axes.into_iter().zip(numbers).all(joint)
    }
}

/// State of a commissioning, as sent to the host.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Progress {
    /// 0 start, 1 move, 2 let go, 3 drive, 4 done, 5 stopped.
    pub step: u8,
    /// Axis, motor, or number of the [`Trouble`].
    pub number: u8,
}

impl Progress {
    fn of(stage: Stage) -> Self {
        let (step, number) = match stage {
            Stage::Start(axis) => (0, axis),
            Stage::Move(axis) => (1, axis),
            Stage::LetGo => (2, 0),
            Stage::Drive(motor) => (3, motor),
            Stage::Done => (4, 0),
            Stage::Stopped(trouble) => (5, trouble.number()),
        };
        Self { step, number }
    }

    /// The stage; `None` if it is none of this version.
    #[must_use]
    pub fn stage(self) -> Option<Stage> {
        match self.step {
            0 => Some(Stage::Start(self.number)),
            1 => Some(Stage::Move(self.number)),
            2 => Some(Stage::LetGo),
            3 => Some(Stage::Drive(self.number)),
            4 => Some(Stage::Done),
            5 => Trouble::of_number(self.number).map(Stage::Stopped),
            _ => None,
        }
    }
}

/// Result of a commissioning, as sent to the host.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct WireResult {
    /// Encoder and motor of each axis or joint.
    pub order: [[u8; 3]; 2],
    /// Metres at the tip per count, and sign of the motor, of each axis or joint.
    pub m_per_count: [f32; 3],
    /// 1 or -1 for each axis or joint.
    pub motor_sign: [i8; 3],
    /// Friction [N] and mass [kg] at the tip.
    pub friction_n: [f32; 3],
    /// Mass at the tip [kg].
    pub mass_kg: [f32; 3],
    /// Delay in whole ticks.
    pub delay_ticks: u8,
    /// Time constant of amplifier and motor [s].
    pub lag_s: f32,
}

impl From<&Commissioned> for WireResult {
    fn from(found: &Commissioned) -> Self {
        let wiring = &found.wiring;
        Self {
            order: [wiring.sensor, wiring.motor],
            m_per_count: wiring.per_unit,
            motor_sign: wiring.motor_sign.map(|sign| if sign < 0.0 { -1 } else { 1 }),
            friction_n: found.friction_n,
            mass_kg: found.mass_kg,
            delay_ticks: found.delay_ticks,
            lag_s: found.lag_s,
        }
    }
}

impl From<&WireResult> for Commissioned {
    fn from(sent: &WireResult) -> Self {
        let [sensor, motor] = sent.order;
        let per_unit = sent.m_per_count;
        Self {
            wiring: Wiring { sensor, per_unit, motor, motor_sign: sent.motor_sign.map(f32::from) },
            friction_n: sent.friction_n,
            mass_kg: sent.mass_kg,
            count_m: per_unit.map(f32::abs),
            delay_ticks: sent.delay_ticks,
            lag_s: sent.lag_s,
        }
    }
}

impl Bench {
    /// Begins a commissioning; `shown` is the reading that the loop sees meanwhile.
    #[must_use]
    pub fn new(setup: &Setup, shown: Reading) -> Self {
        let Setup { axes, distance_m, force_limit_n, stated_m_per_count, share_per_n } = *setup;
        let plan = Plan { axes, distance_m, force_limit_n, stated_m_per_unit: stated_m_per_count, tick_s: 1e-3 };
        Self { commissioning: Commissioning::new(plan), share_per_n, from: None, shown, confirmed: false, silent_ticks: 0 }
    }

    /// The user confirms the step that is asked for.
    pub fn confirm(&mut self) {
        self.confirmed = true;
    }

    /// Ends it without a result.
    pub fn stop(&mut self, trouble: Trouble) {
        self.commissioning.stop(trouble);
    }

    /// Whether it has ended.
    #[must_use]
    pub fn ended(&self) -> bool {
        self.commissioning.stage().ended()
    }

    /// Step and, once it is complete, the result, for the host.
    #[must_use]
    pub fn told(&self) -> (Progress, Option<WireResult>) {
        (Progress::of(self.commissioning.stage()), self.commissioning.result().map(WireResult::from))
    }

    /// The reading for the loop: as at the beginning, under a new number.
    #[must_use]
    pub fn shown(&mut self, reading: &Reading) -> Reading {
        let number = match reading {
            Reading::Joints(JointReading { sequence, .. }) => *sequence,
            Reading::Tip(sensed) => sensed.sequence,
        };
        match &mut self.shown {
            Reading::Joints(JointReading { sequence, .. }) => *sequence = number,
            Reading::Tip(sensed) => sensed.sequence = number,
        }
        self.shown
    }

    /// Runs one tick after that of the loop, and returns the outputs.
    #[inline(never)]
    pub fn tick(&mut self, reading: &Reading, command: &Command, record: &Telemetry) -> Outputs {
        self.silent_ticks = if command.heard { 0 } else { self.silent_ticks.saturating_add(1) };
        if record.fault.is_some() || record.mode != Mode::Idle {
            self.stop(Trouble::Faulted);
        }
        let left = command.late_ticks > 0 || command.operator_absent || command.asked == Some(Ask::Stop);
        let drives = matches!(self.commissioning.stage(), Stage::Drive(_));
        let most_ticks = if drives { SILENCE_TICKS } else { PAUSE_TICKS };
        if left || self.silent_ticks >= most_ticks {
            self.stop(Trouble::Interrupted);
        }
        let Reading::Joints(JointReading { counts, status: SensorStatus::Good, .. }) = reading else {
            self.stop(Trouble::Faulted);
            return Outputs::OFF;
        };
        let counts = counts.map(|EncoderCounts(counts)| counts);
        let [from_a, from_b, from_c] = *self.from.get_or_insert(counts);
        let [a, b, c] = counts;
        let sensors = [a.wrapping_sub(from_a) as f32, b.wrapping_sub(from_b) as f32, c.wrapping_sub(from_c) as f32];
        let confirmed = core::mem::take(&mut self.confirmed);
        let [x, y, z] = self.commissioning.tick(sensors, confirmed);
        if !matches!(self.commissioning.stage(), Stage::Drive(_)) {
            return Outputs::OFF;
        }
        let [per_x, per_y, per_z] = self.share_per_n;
        let code = |force_n: f32, share_per_n: f32| {
            let most_n = DeviceSpec::UNCOMMISSIONED_N;
            // independent of the code that computed the force
            let bounded_n = if force_n.abs() <= most_n { force_n } else { 0.0 };
            DacCode::from_share(bounded_n * share_per_n)
        };
        Outputs { enabled: true, codes: [code(x, per_x), code(y, per_y), code(z, per_z)] }
    }
}
