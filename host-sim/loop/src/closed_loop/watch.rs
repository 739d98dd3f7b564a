//! The invariants of the loop, checked from outside in every tick.
//!
//! [`Watch`] checks the loop's inputs, its reports and the force on the device:
//!
//! * I1 the force is finite, no longer than the limit, and never pulls;
//! * I2 it grows no faster than the slew limit and keeps its direction, except where the energy
//!   account shortens it;
//! * I3 no force acts without a mode that allows it; in `SafeRamp` the force only falls, after
//!   arming it is a rising share, and after a late tick at most half;
//! * I4 a fault stays latched until it is cleared after good poses;
//! * I5 the tissue's state is finite and near its patch;
//! * I7 no old reading is rendered;
//! * I8 limits are never raised;
//! * I9 the force reported is the one applied, and the position reported is one that was read;
//! * I10 ticks count up by one.
//!
//! [`ByGeometry`] determines contact from the sensed tip and geometry at rest, never from the
//! renderer:
//!
//! * I12 no force acts without contact;
//! * I13 no force points into the tissue;
//! * I14 no force oscillates at rest.
//!
//! [`PortWatch`] believes neither the loop nor its sensor. From the true position of the tip and
//! the force that truly acted, it checks what the hand gets while the device is what its profile
//! says:
//!
//! * I11 the work given to the hand in any window of time, of 5 s as of any other length, is at
//!   most the device's bound for that window and what the tissue could return when it began;
//! * I15 the force above 15 Hz does not exceed 50 mN RMS for a second within 2 s, unless the hand's
//!   own motion explains it.
//!
//! I6, no allocation and no panic, is proven on the image and not checked here.

mod box_tree;
mod by_geometry;
mod port;
mod rest_shape;

pub use by_geometry::{ByGeometry, Seen};
pub use port::{Contact, EnergyWatch, PortBound, PortWatch, Truth};
pub use rest_shape::{HalfSpace, Placed, RestShape, RestSolid};

use palpate::haptic::cycle::{Ask, Command, Settings, Telemetry};
use palpate::haptic::device::{Sensed, SensorStatus};
use palpate::haptic::limits::LoopLimitSettings;
use palpate::haptic::mode::Mode;
use palpate::{ClampFlags, Fault, Vector3};
use std::sync::Arc;

/// Allowance for rounding in a force of a few newtons [N].
const ROUNDING_N: f32 = 2e-6;

/// All inputs and outputs of the loop in one tick.
#[derive(Clone, Copy, Debug)]
pub struct Tick {
    /// Command from the host.
    pub command: Command,
    /// Reading that the loop took.
    pub reading: Sensed,
    /// Limits in force.
    pub limits: LoopLimitSettings,
    /// Telemetry of the loop.
    pub telemetry: Telemetry,
    /// Output to the device: a force [N], or `None` for its release.
    pub got_n: Option<Vector3<f32>>,
    /// Defect of the tissue's state, if any.
    pub unsound: Option<&'static str>,
}

impl Tick {
    /// Force on the hand [N].
    #[must_use]
    pub fn force_n(&self) -> Vector3<f32> {
        self.got_n.unwrap_or_default()
    }
}

/// An invariant that was broken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Broken {
    /// Number of the invariant, I1 .. I15.
    pub id: &'static str,
    /// Description of the violation.
    pub what: &'static str,
}

/// Checks the invariants tick by tick.
#[derive(Clone, Debug, Default)]
pub struct Watch {
    /// The last three ticks, newest first.
    past: [Option<Tick>; 3],
    silent: u32,
    old: u32,
    arming: u32,
    /// Good readings in a row during a fault.
    good: u32,
    /// Ticks without contact since the last arming.
    free: u32,
    /// Ticks in a row at the force limit in `Active`.
    saturated: u32,
    /// Rise of the ramp-in gain per tick (1), if ramp-in is checked.
    ramp_in_per_tick: Option<f32>,
    by_geometry: Option<ByGeometry>,
}

/// Whether no limit is higher than it was.
fn lower(now: &LoopLimitSettings, before: &LoopLimitSettings) -> bool {
    now.max_force_n <= before.max_force_n
        && now.max_slew_n_per_s <= before.max_slew_n_per_s
        && now.max_speed_m_per_s <= before.max_speed_m_per_s
        && now.max_age_ticks <= before.max_age_ticks
        && now.workspace_margin <= before.workspace_margin
}

fn allows_force(mode: Mode) -> bool {
    matches!(mode, Mode::Active | Mode::Degraded | Mode::SafeRamp)
}

impl Watch {
    /// Creates a watch that also checks ramp-in, for a loop with these settings.
    #[must_use]
    pub fn of(settings: &Settings) -> Self {
        Self { ramp_in_per_tick: Some(settings.arming.ramp_in_per_tick), ..Self::default() }
    }

    /// Makes the watch also check the force against the geometry of the surface.
    #[must_use]
    pub fn over(self, shape: Arc<dyn RestShape>) -> Self {
        Self { by_geometry: Some(ByGeometry::over(shape)), ..self }
    }

    /// Extremes found by the geometric check so far; zeros without a shape.
    #[must_use]
    pub fn seen(&self) -> Seen {
        self.by_geometry.as_ref().map(ByGeometry::seen).unwrap_or_default()
    }

    /// Checks a tick against all invariants.
    ///
    /// # Errors
    /// Returns the first invariant that this tick breaks.
    pub fn check(&mut self, now: &Tick) -> Result<(), Broken> {
        self.silent = if now.command.heard { 0 } else { self.silent + 1 };
        self.count(now);
        let by_geometry = self.by_geometry.as_mut().map_or(Ok(()), |g| g.check(&now.reading, now.force_n()));
        let answer = self.judge(now).and(by_geometry);
        self.arming = if now.telemetry.mode == Mode::Arming { self.arming + 1 } else { 0 };
        self.past = [Some(*now), self.past[0], self.past[1]];
        answer
    }

    fn count(&mut self, now: &Tick) {
        let telemetry = &now.telemetry;
        let touched = telemetry.output.depth_m > 0.0 || telemetry.output.force_n != Vector3::zeros();
        self.free = match telemetry.mode {
            Mode::Active | Mode::Degraded => self.free + u32::from(!touched),
            _ => 0,
        };
        let at_end = telemetry.mode == Mode::Active && telemetry.output.force_n.norm() >= now.limits.max_force_n;
        self.saturated = if at_end { self.saturated + 1 } else { 0 };
    }

    fn judge(&mut self, now: &Tick) -> Result<(), Broken> {
        let hold = |id, what, holds: bool| if holds { Ok(()) } else { Err(Broken { id, what }) };
        let (telemetry, force_n) = (&now.telemetry, now.force_n());
        let length_n = force_n.norm();
        hold("I1", "finite", force_n.iter().all(|c| c.is_finite()))?;
        hold("I9", "told is given", telemetry.applied_n == force_n)?;
        hold("I5", now.unsound.unwrap_or_default(), now.unsound.is_none() || telemetry.mode == Mode::Fault)?;
        hold("I1", "longest", length_n <= now.limits.max_force_n + ROUNDING_N)?;
        hold("I3", "force without mode", allows_force(telemetry.mode) || now.got_n.is_none())?;
        hold("I4", "fault without mode", telemetry.fault.is_some() == (telemetry.mode == Mode::Fault))?;

        let pose = now.reading.position_m;
        let readable = pose.iter().all(|c| c.is_finite()) && now.reading.status == SensorStatus::Good;
        hold("I7", "bad reading", readable || telemetry.mode == Mode::Fault)?;
        let held = self.past[0].map(|before| before.telemetry.position_m);
        let read = telemetry.position_m == pose || held == Some(telemetry.position_m);
        hold("I9", "position read", read || telemetry.mode == Mode::Fault)?;
        hold("I4", "board's finding", now.command.found.is_none() || telemetry.mode == Mode::Fault)?;
        hold(
            "I3",
            "free space",
            telemetry.output.depth_m > 0.0 || telemetry.output.force_n != Vector3::zeros() || length_n == 0.0,
        )?;
        // on a flank only friction may point inward; without it the model never pulls
        let pushes = telemetry.output.force_n.dot(&telemetry.output.normal) >= 0.0;
        hold("I1", "pull", !pushes || force_n.dot(&telemetry.output.normal) >= -telemetry.output.grip_n - ROUNDING_N)?;
        if !telemetry.limiters.contains(ClampFlags::SLEW) && length_n > 1e-3 {
            let (aside, along) = (force_n.cross(&telemetry.wanted_n).norm(), force_n.dot(&telemetry.wanted_n));
            // a force that the bound on its work shortens ends inside the sphere whose diameter is
            // the wanted force
            let bounded = telemetry.limiters.contains(ClampFlags::ENERGY) && along >= 0.99 * length_n * length_n;
            let keeps = aside <= 0.03 * length_n * telemetry.wanted_n.norm() && along > 0.0;
            hold("I2", "direction", keeps || bounded)?;
        }
        let wanted_n = telemetry.wanted_n.norm();
        hold("I2", "longer than wanted", length_n <= 1.0001 * wanted_n + ROUNDING_N || telemetry.mode == Mode::Fault)?;
        hold("I3", "saturation", self.saturated <= u32::from(now.limits.saturated_ticks) + 1)?;
        if let Some(per_tick) = self.ramp_in_per_tick
            && matches!(telemetry.mode, Mode::Active | Mode::Degraded)
        {
            let risen = self.free as f32 * per_tick;
            hold("I3", "ramp-in", length_n <= 1.001 * risen * wanted_n + ROUNDING_N)?;
        }
        hold("I3", "host silence", self.silent < 150 || length_n <= 0.05)?;

        let Some(before) = self.past[0] else {
            return hold("I3", "boot", !allows_force(telemetry.mode) && telemetry.mode != Mode::Arming);
        };
        hold("I8", "a limit rose", lower(&now.limits, &before.limits))?;
        hold("I10", "count", telemetry.tick == before.telemetry.tick.wrapping_add(1))?;
        self.against(now, &before)
    }

    fn against(&mut self, now: &Tick, before: &Tick) -> Result<(), Broken> {
        let hold = |id, what, holds: bool| if holds { Ok(()) } else { Err(Broken { id, what }) };
        let (telemetry, force_n, last_n) = (&now.telemetry, now.force_n(), before.force_n());

        // the force is some share of the last one, plus at most the slew
        let square = last_n.norm_squared();
        let share = if square > 0.0 { (force_n.dot(&last_n) / square).clamp(0.0, 1.0) } else { 0.0 };
        hold("I2", "slew", (force_n - last_n * share).norm() <= now.limits.max_slew_n_per_s * 1e-3 + 10.0 * ROUNDING_N)?;
        hold("I3", "ramp falls", telemetry.mode != Mode::SafeRamp || force_n.norm() <= last_n.norm() + ROUNDING_N)?;

        let late = now.command.late_ticks > 0 && allows_force(before.telemetry.mode);
        hold("I3", "late", !late || force_n.norm() <= 0.5 * last_n.norm() + ROUNDING_N)?;
        let twice = now.command.late_ticks > 1 || before.command.late_ticks > 0 && before.telemetry.fault.is_none();
        hold("I3", "late twice", !(late && twice) || telemetry.mode == Mode::Fault)?;

        let (from, to) = (before.telemetry.mode, telemetry.mode);
        let comes_from = match to {
            Mode::Active => matches!(from, Mode::Active | Mode::Arming | Mode::Degraded),
            Mode::Degraded => matches!(from, Mode::Active | Mode::Degraded),
            Mode::SafeRamp => matches!(from, Mode::Active | Mode::Degraded | Mode::SafeRamp),
            Mode::Arming => matches!(from, Mode::Idle | Mode::Arming),
            _ => true,
        };
        hold("I3", "way to force", comes_from)?;
        hold("I3", "calm arming", to != Mode::Active || from != Mode::Arming || self.arming >= 99)?;

        let healed = from == Mode::Fault && to != Mode::Fault;
        hold("I4", "latched", !healed || (now.command.asked == Some(Ask::Clear) && self.good >= 100))?;
        let first = telemetry.fault == before.telemetry.fault || telemetry.fault == Some(Fault::EmergencyStop);
        hold("I4", "first fault", from != Mode::Fault || healed || first)?;
        self.good = if from == Mode::Fault && now.command.found.is_none() { self.good + 1 } else { 0 };

        let fresh = now.reading.sequence.wrapping_sub(before.reading.sequence).cast_signed() > 0;
        self.old = if fresh { 0 } else { self.old + 1 };
        hold("I7", "stale", self.old <= 2 || to == Mode::Fault)?;

        if let [Some(one), Some(two), _] = self.past {
            let believed = two.telemetry.fault.is_none() && !two.telemetry.limiters.contains(ClampFlags::HELD);
            let forced = one.force_n() != Vector3::zeros() && two.force_n() != Vector3::zeros();
            let new = fresh && one.reading.sequence.wrapping_sub(two.reading.sequence).cast_signed() > 0;
            let far = |t: &Tick| (t.reading.position_m - two.reading.position_m).norm() > 3.3e-3;
            hold("I7", "speed", !(believed && forced && new && far(&one) && far(now)) || to == Mode::Fault)?;
        }
        Ok(())
    }
}
