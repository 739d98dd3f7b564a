//! The invariants of the loop, checked from outside in every tick: from its inputs, its reports and
//! the force on the device.
//!
//! I1 the force is finite and no longer than the limit; I2 it grows no faster than the slew limit
//! and keeps its direction, except for the part that the bound on its work removes; I3 no force
//! acts without a mode that allows it; in `SafeRamp` the force only falls, after arming it is a
//! rising share, and after a late tick at most half; I4 a fault stays latched until it is cleared
//! after good poses; I5 the tissue's state is finite and near its patch; I7 no old reading is
//! rendered; I8 limits are never raised; I9 the force reported is the one applied, and the position
//! reported is one that was read; I10 ticks count up by one; I11 the energy account is the work of
//! the force that acted, no contact is forgotten before 20 ms without a force, a contact that
//! created too much energy is faded out, and so many contacts within seconds end in a fault. I6, no
//! allocation and no panic, is proven on the image and not checked here. I12 to I14 determine
//! contact from the sensed tip and geometry at rest, never from the renderer: I12 no force acts
//! without contact, I13 none points into the tissue, I14 none oscillates at rest.

mod box_tree;
mod by_geometry;
mod rest_shape;

pub use by_geometry::{ByGeometry, Seen};
pub use rest_shape::{HalfSpace, Placed, RestShape, RestSolid};

use palpate::haptic::cycle::{Ask, Command, Settings, Telemetry};
use palpate::haptic::device::{DeviceSpec, Sensed, SensorStatus};
use palpate::haptic::limits::LoopLimitSettings;
use palpate::haptic::mode::Mode;
use palpate::{ClampFlags, Fault, Vector3};
use std::collections::VecDeque;
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
    /// Number of the invariant, I1 .. I14.
    pub id: &'static str,
    /// Description of the violation.
    pub what: &'static str,
}

/// Largest number of ticks over which the loop averages a force.
const MOST_MEAN_TICKS: f32 = 100.0;

/// Time after the last force for which a contact is kept [s], and the lags of the amplifier that
/// are added to it (1).
const KEPT: (f32, f32) = (0.02, 3.0);

/// Time constant with which the energy that contacts created is forgotten [s].
const FORGOTTEN_S: f32 = 5.0;

/// Checks the invariants tick by tick.
#[derive(Clone, Debug, Default)]
pub struct Watch {
    /// The last three ticks, newest first.
    past: [Option<Tick>; 3],
    /// Forces of the last ticks that a device may delay, newest first [N].
    sent_n: VecDeque<Vector3<f32>>,
    /// Ticks without a force.
    idle: u32,
    /// Whether the patch was touched when it ran last.
    touched: bool,
    /// Energy that the last contacts created, each counted up to the alarm [J].
    recent_j: f32,
    silent: u32,
    old: u32,
    arming: u32,
    /// Good readings in a row during a fault.
    good: u32,
    /// Ticks without contact since the last arming.
    free: u32,
    /// Ticks in a row at the force limit in `Active`.
    saturated: u32,
    /// Ticks in a row with a created energy above the alarm.
    alarmed: i32,
    settled: Option<Settled>,
    /// Position of each axis within the backlash that a displacement passes before it counts as
    /// work [m]; unknown after a fault.
    slack_m: [Slack; 3],
    /// Force along each axis since its last displacement.
    since: [Since; 3],
    amplifier: Amplifier,
    by_geometry: Option<ByGeometry>,
}

/// Position within a backlash, once it is known.
#[derive(Clone, Copy, Debug)]
struct Slack(Option<f32>);

impl Default for Slack {
    fn default() -> Self {
        Self(Some(0.0))
    }
}

impl Slack {
    /// Returns the part of a displacement that passes the backlash; `None` while the position is
    /// unknown.
    fn pass(&mut self, displacement_m: f32, play_m: f32) -> Option<f32> {
        let Some(at_m) = self.0 else {
            // a displacement longer than the backlash ends at its border, wherever it began
            self.0 = if displacement_m > play_m { Some(play_m) } else { (displacement_m < -play_m).then_some(0.0) };
            return None;
        };
        let place_m = (at_m + displacement_m).clamp(0.0, play_m);
        self.0 = Some(place_m);
        Some(at_m + displacement_m - place_m)
    }
}

/// Sum of the force along an axis since its last displacement [N], and its ticks.
#[derive(Clone, Copy, Debug, Default)]
struct Since {
    sum_n: f32,
    ticks: f32,
}

impl Since {
    /// Mean force, that of this tick included; a new mean begins after a displacement and outside
    /// of contact.
    fn mean_n(&mut self, force_n: f32, ends: bool) -> f32 {
        // beyond this number of ticks the loop forgets the oldest
        let kept = if self.ticks < MOST_MEAN_TICKS { 1.0 } else { 1.0 - 1.0 / MOST_MEAN_TICKS };
        let (sum_n, ticks) = (self.sum_n * kept + force_n, (self.ticks + 1.0).min(MOST_MEAN_TICKS));
        *self = if ends { Self::default() } else { Self { sum_n, ticks } };
        sum_n / ticks
    }
}

/// Force of an amplifier with a lag of first order, at the end of a tick [N].
#[derive(Clone, Copy, Debug, Default)]
struct Amplifier(Vector3<f64>);

impl Amplifier {
    /// Mean force over a tick in which this force is asked for [N].
    fn mean_n(&mut self, asked_n: Vector3<f32>, lag_ticks: f64) -> Vector3<f32> {
        if lag_ticks == 0.0 {
            return asked_n;
        }
        let asked_n: Vector3<f64> = asked_n.cast();
        let (gap_n, left) = (self.0 - asked_n, (-1.0 / lag_ticks).exp());
        self.0 = asked_n + gap_n * left;
        (asked_n + gap_n * (lag_ticks * (1.0 - left))).cast()
    }
}

/// Parameters of the checked loop.
#[derive(Clone, Copy, Debug)]
struct Settled {
    delay_ticks: usize,
    /// Time constant of the amplifier [ticks].
    lag_ticks: f64,
    alarm_j: f32,
    /// Largest energy that the contacts of the last seconds may create together [J].
    most_recent_j: f32,
    /// Share of it that a tick leaves (1).
    remembered: f32,
    /// Ticks without a force after which a contact may end.
    kept_ticks: u32,
    ramp_in_per_tick: f32,
    play_m: f32,
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
    /// Creates a watch that also checks ramp-in and energy, for a loop with these settings.
    #[must_use]
    pub fn of(settings: &Settings, device: &DeviceSpec) -> Self {
        let settled = Settled {
            delay_ticks: device.delay_ticks.into(),
            lag_ticks: f64::from(device.lag_s / settings.tick_s),
            alarm_j: settings.passivity.alarm_j,
            most_recent_j: f32::from(settings.passivity.alarms) * settings.passivity.alarm_j,
            remembered: 1.0 - settings.tick_s / FORGOTTEN_S,
            kept_ticks: u32::from(device.delay_ticks) + ((KEPT.0 + KEPT.1 * device.lag_s) / settings.tick_s).round() as u32,
            ramp_in_per_tick: settings.arming.ramp_in_per_tick,
            play_m: 1.01 * device.count_m,
        };
        Self { settled: Some(settled), ..Self::default() }
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
        self.sent_n.truncate(usize::from(DeviceSpec::MOST_DELAY_TICKS));
        self.sent_n.push_front(now.force_n());
        self.idle = if now.force_n() == Vector3::zeros() { self.idle + 1 } else { 0 };
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
        let over = self.settled.is_some_and(|s| telemetry.energy.created_j > s.alarm_j);
        self.alarmed = if over { self.alarmed + 1 } else { 0 };
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
        if let Some(settled) = self.settled
            && matches!(telemetry.mode, Mode::Active | Mode::Degraded)
        {
            let risen = self.free as f32 * settled.ramp_in_per_tick;
            hold("I3", "ramp-in", length_n <= 1.001 * risen * wanted_n + ROUNDING_N)?;
            hold("I11", "energy fades", length_n <= 1.01 * 0.8_f32.powi(self.alarmed) * wanted_n + ROUNDING_N)?;
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
        self.energy(now, before)?;

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

    /// Checks that the loop's energy account equals the work of the force that acted.
    fn energy(&mut self, now: &Tick, before: &Tick) -> Result<(), Broken> {
        let hold = |id, what, holds: bool| if holds { Ok(()) } else { Err(Broken { id, what }) };
        let Some(settled) = self.settled else { return Ok(()) };
        if now.telemetry.fault.is_some() || before.telemetry.fault.is_some() {
            (self.slack_m, self.since) = ([Slack(None); 3], [Since::default(); 3]);
            (self.amplifier, self.recent_j, self.touched) = (Amplifier::default(), 0.0, false);
            return Ok(());
        }
        // until a contact ends, the energy that it created does not fall
        let ends = self.idle > settled.kept_ticks;
        let (energy, last) = (&now.telemetry.energy, &before.telemetry.energy);
        let rises = energy.created_j >= energy.given_j && (ends || energy.created_j >= last.created_j);
        let counted_j = |created_j: f32| created_j.clamp(0.0, settled.alarm_j);
        let more_j = (counted_j(energy.created_j) - counted_j(last.created_j)).max(0.0);
        self.recent_j = self.recent_j * settled.remembered + more_j;
        hold("I11", "energy created", rises)?;
        hold("I11", "energy of contacts", self.recent_j <= 1.001 * settled.most_recent_j)?;
        let displacement_m = now.telemetry.position_m - before.telemetry.position_m;
        let mut passed_m = [None; 3];
        for ((passed, slack), way) in passed_m.iter_mut().zip(&mut self.slack_m).zip(displacement_m.iter()) {
            *passed = slack.pass(*way, settled.play_m);
        }
        let Some(acted_n) = self.sent_n.get(settled.delay_ticks).copied() else { return Ok(()) };
        let force_n = self.amplifier.mean_n(acted_n, settled.lag_ticks);
        // where the patch does not run, as after a ramp to Idle, the last answer is the one known
        if [Some(before), self.past[1].as_ref()].into_iter().flatten().any(|tick| tick.telemetry.mode.runs_patch()) {
            let output = &before.telemetry.output;
            self.touched = output.depth_m > 0.0 || output.force_n != Vector3::zeros();
        }
        let free = !self.touched;
        let mut mean_n = force_n;
        for axis in 0..3 {
            let ends = free || settled.play_m == 0.0 || displacement_m[axis] != 0.0;
            mean_n[axis] = self.since[axis].mean_n(force_n[axis], ends);
        }
        let [Some(x), Some(y), Some(z)] = passed_m else { return Ok(()) };
        if ends {
            return Ok(());
        }
        let work_j = mean_n.dot(&Vector3::new(x, y, z));
        let off_j = energy.given_j - last.given_j - work_j;
        hold("I11", "energy counted", off_j.abs() <= 1e-7 + 1e-3 * work_j.abs() + 1e-5 * energy.given_j.abs())
    }
}
