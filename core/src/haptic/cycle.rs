//! One cycle of the loop: sense, tick, damp, limit, actuate. Board and desktop call this and
//! nothing else.
//!
//! Whatever fails, the device is released **in the same tick** and the fault is latched. Gains
//! lowered at the first touch, by saturation or by created energy stay low for the whole contact: a
//! gain that rises while a spring is compressed adds energy to the hand.
//!
//! * in: a device, a renderer of its pose, messages of the host since the last cycle
//! * out: a force on the device, a [`Telemetry`] record
//! * cost: up to 2100 instructions of a Cortex-M4F in addition to the patch (as its log shows),
//!   including the board's own part of the tick
//! * failures: every [`Fault`]

mod gains;
mod record;
mod renderer;
mod settings;

pub use record::{Ask, Command, Telemetry};
pub use renderer::{PatchRenderer, Renderer};
pub use settings::{ArmingSettings, Settings};

use nalgebra::Vector3;

use super::apart::Apart;
use super::damping::Damping;
use super::deadline::Deadline;
use super::device::{DeviceSpec, HapticDevice};
use super::length;
use super::limits::{ForceLimiter, LoopLimitSettings, LoopLimits, PoseGate};
use super::mode::{Event, Mode, ModeMachine};
use super::passivity::PassivityObserver;
use super::runaway::Runaway;
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
    damping: Damping,
    gate: PoseGate,
    limiter: ForceLimiter,
    observer: PassivityObserver,
    deadline: Deadline,
    runaway: Runaway,
    stillness: Stillness,
    toggle: Toggle,
    apart: Apart,
    machine: ModeMachine,
    ticks: u32,
    position_m: Option<Vector3<f32>>,
    touched: bool,
    /// Ramp-in gain (1); it rises in free space only.
    ramp: f32,
    /// Relief gain (1); it falls while a contact is saturated and returns to one after the contact.
    relief: f32,
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
    pub fn build(settings: &Settings, device: &DeviceSpec) -> Result<Self, BuildError> {
        settings.arming.check()?;
        Ok(Self {
            arming: settings.arming,
            per_ramp: 1.0 / f32::from(settings.arming.ramp_ticks),
            limits: LoopLimits::build(&settings.limits, device, settings.tick_s)?,
            damping: Damping::build(&settings.damping, settings.tick_s, device.count_m)?,
            gate: PoseGate::default(),
            limiter: ForceLimiter::default(),
            observer: PassivityObserver::build(&settings.passivity, device, settings.tick_s)?,
            deadline: Deadline::default(),
            runaway: Runaway::default(),
            stillness: Stillness::build(settings.tick_s),
            toggle: Toggle::new(device.count_m),
            apart: Apart::new(device.count_m),
            machine: ModeMachine::BOOT,
            ticks: 0,
            position_m: None,
            touched: false,
            ramp: 0.0,
            relief: 1.0,
            ramp_from_n: 0.0,
            calm: 0,
            silence: 0,
        })
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
            self.limiter.release();
            device.release();
        }
        self.observer.sent(record.applied_n);
        record.mode = self.mode();
        record.fault = self.machine.fault();
        record.position_m = self.position_m.unwrap_or_default();
        record.energy = self.observer.energy();
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
        if let Some(fault) = command.found {
            return Err(fault);
        }
        let late = if self.mode().runs_patch() { self.deadline.judge(command.late_ticks)? } else { false };
        self.gate.skip(command.late_ticks);
        let force_acts = self.limiter.last_n() != Vector3::zeros();
        let pose = self.gate.admit(&self.limits, &device.sense(), force_acts)?;
        if pose.held {
            record.limiters.set(ClampFlags::HELD);
        }
        let displacement_m = pose.position_m - self.position_m.replace(pose.position_m).unwrap_or(pose.position_m);
        self.observer.observe(&displacement_m, self.touched)?;
        let shown_m = self.toggle.show(&pose.position_m);
        self.damping.track(shown_m);
        record.refused = !self.listen(command, renderer);
        if !self.mode().runs_patch() {
            self.calm = self.calm.saturating_add(1);
            return Ok(Vector3::zeros());
        }

        let mut output = renderer.render(ProbePose { tip_m: shown_m });
        if let Some(fault) = output.fault {
            return Err(fault);
        }
        if !self.apart.judge(&pose.position_m, &shown_m, &output, &self.limiter.last_n())? {
            output = Output { force_n: Vector3::zeros(), depth_m: 0.0, normal: Vector3::zeros(), grip_n: 0.0, ..output };
        }
        self.toggle.answered(&output.force_n);
        record.output = output;
        record.limiters.set(output.limiters);
        self.touched = output.depth_m > 0.0 || output.force_n != Vector3::zeros();
        self.limiter.judge(&self.limits, &output.force_n)?;
        let per_s = match command.late_ticks {
            0 => self.limits.ticks_per_s(),
            late => self.limits.ticks_per_s() / f32::from(late.saturating_add(1)),
        };
        self.runaway.judge(&displacement_m, per_s, &output.normal, &self.limiter.last_n())?;
        let (force_n, shortened) = ForceLimiter::shorten(&self.limits, &output.force_n);
        if shortened {
            record.limiters.set(ClampFlags::FORCE);
        }
        record.wanted_n = self.damping.damp(&Output { force_n, ..output }, renderer.tangent_n_per_m(&output));
        let max_force_n = self.relief * self.limits.values().max_force_n;
        self.stillness.judge(&displacement_m, &force_n, &self.limiter.last_n(), max_force_n, self.touched);
        self.follow(&output);

        let gain = self.gain(record);
        let cap_n = if late { self.half_n(record) } else { self.cap_n() };
        let gained_n = record.wanted_n * gain;
        let bound_n = self.observer.bound(&gained_n, &self.damping.velocity_m_per_s(), &output.normal);
        if bound_n != gained_n {
            record.limiters.set(ClampFlags::ENERGY);
        }
        let limited = self.limiter.limit(&self.limits, bound_n, cap_n)?;
        record.limiters.set(limited.limiters);
        if self.mode() == Mode::SafeRamp && limited.force_n == Vector3::zeros() {
            self.enter(Event::RampEnded);
        }
        Ok(limited.force_n)
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
    fn follow(&mut self, output: &Output) {
        match self.mode() {
            Mode::Arming => {
                let outside = !self.touched && !output.limiters.contains(ClampFlags::BURIED);
                let slow = length(&self.damping.velocity_m_per_s()) < self.arming.slow_m_per_s;
                let weak = length(&output.force_n) < self.arming.weak_n;
                self.calm = if outside && slow && weak { self.calm.saturating_add(1) } else { 0 };
                if self.calm >= self.arming.calm_ticks {
                    self.enter(Event::Armed);
                }
            }
            Mode::Active if self.strained() => {
                self.enter(Event::Strained);
            }
            Mode::Degraded if !self.touched && self.observer.gain() == 1.0 && self.stillness.gain() == 1.0 => {
                self.enter(Event::Recovered);
            }
            _ => {}
        }
    }

    /// Whether the force is to be scaled down for the rest of this contact.
    fn strained(&self) -> bool {
        self.limiter.strained(&self.limits) || self.observer.gain() < 1.0 || self.stillness.gain() < 1.0
    }

    /// Follows an event; returns false if the mode does not accept it.
    fn enter(&mut self, event: Event) -> bool {
        let moved = self.machine.handle(event);
        if moved {
            self.calm = 0;
            match self.mode() {
                Mode::Active if event == Event::Armed => {
                    (self.ramp, self.relief) = (0.0, 1.0);
                }
                Mode::SafeRamp => self.ramp_from_n = length(&self.limiter.last_n()),
                _ => {}
            }
        }
        moved
    }

    fn fail(&mut self, fault: Fault) {
        self.machine.fail(fault);
        self.observer.clear();
        self.damping.reset();
        self.deadline = Deadline::default();
        self.runaway = Runaway::default();
        self.stillness.reset();
        self.toggle.reset();
        self.apart.reset();
        self.position_m = None;
        self.touched = false;
        self.calm = 0;
    }
}
