//! One cycle of the loop: sense, render, every monitor, every shaper, actuate. Board and desktop
//! call this and nothing else.
//!
//! Whatever fails, the device is released **in the same tick** and the fault is latched. Gains
//! lowered by saturation or by an encoder that no longer counts stay low for the whole contact: a
//! gain that rises while a spring is compressed adds energy to the hand.
//!
//! * in: a device, a renderer of its pose, messages of the host since the last cycle
//! * out: a force on the device, a [`Telemetry`] record
//! * cost: up to 2100 instructions of a Cortex-M4F in addition to the patch (as its log shows),
//!   including the board's own part of the tick
//! * failures: every [`Fault`]

mod record;
mod renderer;
mod settings;

pub use record::{Ask, Command, Telemetry};
pub use renderer::{PatchRenderer, Renderer};
pub use settings::{ArmingSettings, Settings};

use nalgebra::Vector3;

use super::account::EnergyAccount;
use super::apart::Apart;
use super::ceiling::Ceiling;
use super::damping::Damping;
use super::deadline::Deadline;
use super::device::{DeviceSpec, HapticDevice};
use super::force_limits::{Longest, Plausible, Slew};
use super::gains::Gains;
use super::length;
use super::limits::{LoopLimitSettings, LoopLimits, Pose, PoseGate};
use super::mode::{Event, Mode, ModeMachine};
use super::runaway::Runaway;
use super::seen::{Monitor, Seen, Shaper};
use super::stillness::Stillness;
use super::toggle::Toggle;
use crate::fault::{BuildError, ClampFlags, Fault};
use crate::stages::output::Output;
use crate::stages::probe::ProbePose;

/// State of the haptic loop, which turns a reading of the device into a force on it once per tick.
///
/// ```
/// use palpate::haptic::cycle::{Ask, Command, Cycle, Renderer, Settings};
/// use palpate::haptic::device::{DeviceSpec, HapticDevice, Sensed, SensorStatus};
/// use palpate::haptic::mode::Mode;
/// use palpate::{BuildError, Output, ProbePose, Vector3};
///
/// /// A handle at rest in free space.
/// struct Still(u32);
/// impl HapticDevice for Still {
///     fn limits(&self) -> DeviceSpec {
///         let (workspace_low_m, workspace_high_m) = (Vector3::repeat(-0.1), Vector3::repeat(0.1));
///         DeviceSpec { workspace_low_m, workspace_high_m, ..DeviceSpec::STYLUS }
///     }
///     fn sense(&mut self) -> Sensed {
///         self.0 += 1;
///         Sensed { position_m: Vector3::zeros(), sequence: self.0, status: SensorStatus::Good }
///     }
///     fn actuate(&mut self, _force_n: Vector3<f32>) {}
///     fn release(&mut self) {}
/// }
///
/// /// Free space without tissue.
/// struct Air;
/// impl Renderer for Air {
///     fn render(&mut self, _pose: ProbePose) -> Output {
///         Output { outside: true, ..Output::NONE }
///     }
///     fn reset(&mut self) {}
/// }
///
/// let mut handle = Still(0);
/// let mut cycle = Cycle::build(&Settings::safe(&handle.limits()), &handle.limits())?;
/// let mut mode = Mode::Boot;
/// for tick in 0..1000 {
///     // the board passes its self-test, and the host asks to arm the loop
///     let asked = [Ask::Booted, Ask::TestPassed, Ask::Arm].get(tick).copied();
///     mode = cycle.tick(&mut handle, &mut Air, Command { asked, ..Command::HEARD }).mode;
/// }
/// assert_eq!(mode, Mode::Active);
/// # Ok::<(), BuildError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Cycle {
    arming: ArmingSettings,
    /// One over the duration of `SafeRamp` in ticks.
    per_ramp: f32,
    limits: LoopLimits,
    gate: PoseGate,
    deadline: Deadline,
    toggle: Toggle,
    damping: Damping,
    account: EnergyAccount,
    apart: Apart,
    plausible: Plausible,
    runaway: Runaway,
    ceiling: Ceiling,
    gains: Gains,
    stillness: Stillness,
    slew: Slew,
    machine: ModeMachine,
    ticks: u32,
    position_m: Option<Vector3<f32>>,
    touched: bool,
    /// Force sent in the last tick [N].
    sent_n: Vector3<f32>,
    /// Magnitude of the force when `SafeRamp` began [N].
    ramp_from_n: f32,
    /// Ticks in a row in which the condition for leaving the mode has held.
    calm: u16,
    /// Ticks since the host's last keep-alive.
    silence: u16,
}

impl Cycle {
    /// Creates a cycle in [`Mode::Boot`].
    ///
    /// # Errors
    /// [`BuildError::OutOfRange`] names the setting, of the device or of the loop.
    #[inline]
    pub fn build(settings: &Settings, device: &DeviceSpec) -> Result<Self, BuildError> {
        settings.arming.check()?;
        Ok(Self {
            arming: settings.arming,
            per_ramp: 1.0 / f32::from(settings.arming.ramp_ticks),
            limits: LoopLimits::build(&settings.limits, device, settings.tick_s)?,
            gate: PoseGate::default(),
            deadline: Deadline::default(),
            toggle: Toggle::new(device.count_m),
            damping: Damping::build(&settings.damping, settings.tick_s, device.count_m)?,
            account: EnergyAccount::build(&settings.account, device, settings.tick_s)?,
            apart: Apart::new(device.count_m),
            plausible: Plausible::default(),
            runaway: Runaway::default(),
            ceiling: Ceiling::new(device.ceiling_n_per_m(settings.tick_s)),
            gains: Gains::new(&settings.arming),
            stillness: Stillness::new(&settings.arming, settings.tick_s),
            slew: Slew::build(settings.tick_s),
            machine: ModeMachine::BOOT,
            ticks: 0,
            position_m: None,
            touched: false,
            sent_n: Vector3::zeros(),
            ramp_from_n: 0.0,
            calm: 0,
            silence: 0,
        })
    }

    /// Everything that judges a tick, in this order.
    fn monitors(&mut self) -> [&mut dyn Monitor; 6] {
        [&mut self.account, &mut self.apart, &mut self.plausible, &mut self.runaway, &mut self.gains, &mut self.stillness]
    }

    /// Everything that shapes the damped force, in this order. None of them lengthens it.
    fn shapers(&mut self) -> [&mut dyn Shaper; 4] {
        [&mut self.gains, &mut self.stillness, &mut self.slew, &mut self.account]
    }

    /// Mode at the end of the last cycle.
    #[must_use]
    pub fn mode(&self) -> Mode {
        self.machine.mode()
    }

    /// Whether the last pose rendered touched the patch. A change that stiffens the tissue has to
    /// wait until this is false, because under the probe it would give energy to the hand; a change
    /// that softens the tissue need not wait.
    #[must_use]
    pub fn in_contact(&self) -> bool {
        self.touched
    }

    /// Limits in effect.
    #[must_use]
    pub fn limits(&self) -> &LoopLimitSettings {
        self.limits.values()
    }

    /// Makes limits stricter, in any mode, from the next cycle on.
    ///
    /// # Errors
    /// [`BuildError::OutOfRange`] names the limit that would rise; nothing changes then.
    pub fn lower_limits(&mut self, values: &LoopLimitSettings) -> Result<(), BuildError> {
        self.limits = self.limits.lowered(values)?;
        Ok(())
    }

    /// Runs one cycle; call this once per tick.
    pub fn tick(&mut self, device: &mut impl HapticDevice, renderer: &mut impl Renderer, command: Command) -> Telemetry {
        self.ticks = self.ticks.wrapping_add(1);
        self.machine.count();
        let mut record = Telemetry::begin(self.ticks, self.mode(), command);
        match self.answer(device, renderer, command, &mut record) {
            Ok(force_n) => record.applied_n = force_n,
            Err(fault) => self.fail(fault),
        }
        if self.mode().allows_force() {
            device.actuate(record.applied_n);
        } else {
            record.applied_n = Vector3::zeros();
            // what the model asks for while no force may act is no reason for a fault or for relief
            self.plausible.reset();
            Monitor::reset(&mut self.gains);
            device.release();
            self.account.released();
        }
        self.sent_n = record.applied_n;
        self.account.sent(record.applied_n);
        record.mode = self.mode();
        record.fault = self.machine.fault();
        record.position_m = self.position_m.unwrap_or_default();
        record.energy = self.account.energy();
        record
    }

    /// Computes the force of this tick [N].
    fn answer(
        &mut self,
        device: &mut impl HapticDevice,
        renderer: &mut impl Renderer,
        command: Command,
        record: &mut Telemetry,
    ) -> Result<Vector3<f32>, Fault> {
        let (pose, late) = self.sense(device, command)?;
        let displacement_m = pose.position_m - self.position_m.replace(pose.position_m).unwrap_or(pose.position_m);
        let shown_m = self.toggle.show(&pose.position_m);
        let per_s = self.limits.ticks_per_s() / f32::from(pose.ticks);
        if !pose.held {
            // a position that was not read says nothing of the velocity, and not that it is zero
            self.damping.track(shown_m, per_s);
        }
        record.refused = !self.listen(command, renderer);
        let runs = self.mode().runs_patch();
        let mut output = if runs { renderer.render(ProbePose { tip_m: shown_m }) } else { Output::NONE };
        if let Some(fault) = output.fault {
            return Err(fault);
        }
        self.ceiling.follow(renderer.stiffness_n_per_m(), self.touched);
        self.ceiling.soften(&mut output);
        let limits = self.limits;
        let mut seen = Seen {
            position_m: pose.position_m,
            displacement_m,
            per_s,
            shown_m,
            velocity_m_per_s: self.damping.velocity_m_per_s(),
            output,
            was_touched: self.touched,
            touched: !output.outside && (output.depth_m > 0.0 || output.force_n != Vector3::zeros()),
            sent_n: self.sent_n,
            relieved_n: self.gains.relief() * limits.values().max_force_n,
            ..Seen::none(&limits)
        };
        for monitor in self.monitors() {
            monitor.judge(&seen)?;
        }
        if !runs {
            self.calm = self.calm.saturating_add(1);
            return Ok(Vector3::zeros());
        }
        if output.outside {
            // whatever the renderer answers, no force acts on a tip that is outside
            let none = Vector3::zeros();
            seen.output = Output { force_n: none, depth_m: 0.0, normal: none, grip_n: 0.0, continuation_n: 0.0, ..output };
        }
        self.touched = seen.touched;
        self.toggle.answered(&seen.output.force_n);
        record.output = seen.output;
        let flags = &mut record.limiters;
        flags.set(output.limiters);
        if pose.held {
            flags.set(ClampFlags::HELD);
        }
        if late {
            flags.set(ClampFlags::GAIN);
        }
        seen.tangent_n_per_m = renderer.tangent_n_per_m(&seen.output);
        let model_n = Longest.shape(seen.output.force_n, &seen, flags);
        let mut force_n = self.damping.shape(model_n, &seen, flags);
        record.wanted_n = force_n;
        if !force_n.dot(&force_n).is_finite() {
            return Err(Fault::ForceNotFinite);
        }
        self.follow(&seen);
        seen.cap_n = self.cap_n(late);
        for shaper in self.shapers() {
            force_n = shaper.shape(force_n, &seen, flags);
        }
        if self.mode() == Mode::SafeRamp && force_n == Vector3::zeros() {
            self.enter(Event::RampEnded);
        }
        Ok(force_n)
    }

    /// Reads the device; returns the pose and whether this tick is late.
    fn sense(&mut self, device: &mut impl HapticDevice, command: Command) -> Result<(Pose, bool), Fault> {
        let sensed = device.sense();
        // before anything can fail
        self.account.charge(command.late_ticks, self.gate.news(&sensed), self.touched);
        if let Some(fault) = command.found {
            return Err(fault);
        }
        let late = if self.mode().runs_patch() { self.deadline.judge(command.late_ticks)? } else { false };
        self.gate.skip(command.late_ticks);
        Ok((self.gate.admit(&self.limits, &sensed, self.account.acts())?, late))
    }

    /// Largest force that the mode allows [N], and after a late tick at most half of the last one.
    /// In `SafeRamp` it falls to zero in a fixed time and never rises.
    fn cap_n(&self, late: bool) -> f32 {
        let sent_n = length(&self.sent_n);
        let cap_n = match self.mode() {
            Mode::Active | Mode::Degraded => self.limits.values().max_force_n,
            Mode::SafeRamp => {
                let ticks_left = u32::from(self.arming.ramp_ticks).saturating_sub(self.machine.ticks());
                let falling_n = self.ramp_from_n * (ticks_left as f32 * self.per_ramp);
                if falling_n < sent_n { falling_n } else { sent_n }
            }
            _ => 0.0,
        };
        // the last force has acted for two periods in place of one
        let half_n = 0.5 * sent_n;
        if late && half_n < cap_n { half_n } else { cap_n }
    }

    /// Follows the host's request, and reacts to its silence. Returns false if the request cannot
    /// be followed now.
    fn listen(&mut self, command: Command, renderer: &mut impl Renderer) -> bool {
        self.silence = if command.heard { 0 } else { self.silence.saturating_add(1) };
        if self.silence >= self.arming.silence_ticks {
            self.enter(Event::HostLost);
        }
        if command.operator_absent {
            self.enter(Event::OperatorLeft);
        }
        let Some(asked) = command.asked else { return true };
        let event = match asked {
            Ask::Booted => Event::Booted,
            Ask::TestPassed => Event::TestPassed,
            Ask::Arm => Event::ArmAsked,
            Ask::Stop => Event::StopAsked,
            Ask::Clear => Event::Cleared,
        };
        // a fault is not cleared before poses have been good for a while
        let ready = event != Event::Cleared || self.calm >= self.arming.calm_ticks;
        let allowed = event != Event::ArmAsked || !command.operator_absent;
        let followed = ready && allowed && self.enter(event);
        if followed && matches!(event, Event::ArmAsked | Event::Cleared) {
            renderer.reset();
            self.toggle.reset();
            self.touched = false;
        }
        followed
    }

    /// Raises the event for the mode machine, if any, that the patch's output causes.
    fn follow(&mut self, seen: &Seen) {
        match self.mode() {
            Mode::Arming => {
                let outside = !seen.touched && !seen.output.limiters.contains(ClampFlags::BURIED);
                let slow = length(&seen.velocity_m_per_s) < self.arming.slow_m_per_s;
                let weak = length(&seen.output.force_n) < self.arming.weak_n;
                self.calm = if outside && slow && weak { self.calm.saturating_add(1) } else { 0 };
                if self.calm >= self.arming.calm_ticks {
                    self.enter(Event::Armed);
                }
            }
            Mode::Active if self.gains.strained() || self.stillness.gain() < 1.0 => {
                self.enter(Event::Strained);
            }
            Mode::Degraded if !seen.touched && self.stillness.gain() == 1.0 => {
                self.enter(Event::Recovered);
            }
            _ => {}
        }
    }

    /// Follows an event; returns false if the mode does not accept it.
    fn enter(&mut self, event: Event) -> bool {
        let moved = self.machine.handle(event);
        if moved {
            self.calm = 0;
            match self.mode() {
                Mode::Active if event == Event::Armed => self.gains.begin(),
                Mode::SafeRamp => self.ramp_from_n = length(&self.sent_n),
                _ => {}
            }
        }
        moved
    }

    /// Latches a fault and returns everything to its state before the first tick.
    fn fail(&mut self, fault: Fault) {
        self.machine.fail(fault);
        self.monitors().into_iter().for_each(Monitor::reset);
        self.shapers().into_iter().for_each(Shaper::reset);
        self.damping.reset();
        self.deadline = Deadline::default();
        self.toggle.reset();
        (self.position_m, self.touched, self.calm) = (None, false, 0);
    }
}
