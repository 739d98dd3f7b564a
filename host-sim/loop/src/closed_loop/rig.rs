//! A loop under watch: the cycle, the checks of its every tick, and what they found.
//!
//! All emulated loops are driven through a [`Rig`]; they differ in device, renderer and judgement.
//! Terms: a reading is *sensed*, the tip that the renderer gets is *shown*, the force that reaches
//! the hand after delay and lag has *acted*.

use std::sync::Arc;

use palpate::haptic::cycle::{Ask, Command, Cycle, Renderer, Settings, Telemetry};
use palpate::haptic::device::{DeviceSpec, HapticDevice, Sensed};
use palpate::haptic::limits::LoopLimitSettings;
use palpate::haptic::mode::Mode;
use palpate::{BuildError, Vector3};

use super::stimulus::Change;
use super::surface::Surface;
use super::watch::{Broken, PortWatch, RestShape, Tick, Truth, Watch};

/// Ticks for arming and ramp-in.
pub const ARMING_TICKS: u32 = 700;
/// Reading every node is expensive, and a value that is not finite does not become finite again, so
/// every 16th tick suffices.
const NODES_EVERY_TICKS: u32 = 16;

/// A second controller: it receives the same inputs as the loop's own controller, and its force
/// goes to the device.
pub trait Beside {
    /// Called if the tissue is to change before the next tick.
    fn change(&mut self, change: Change);

    /// Called once per tick with what the loop's own controller read, was asked, reported and
    /// applied. Returns the force to apply to the device [N], or `None` to release it.
    fn tick(
        &mut self,
        reading: Option<Sensed>,
        command: Command,
        telemetry: &Telemetry,
        got_n: Option<Vector3<f32>>,
    ) -> Option<Vector3<f32>>;
}

/// Without a second controller, the device receives the force of the loop's own controller.
impl Beside for () {
    fn change(&mut self, _: Change) {}

    fn tick(&mut self, _: Option<Sensed>, _: Command, _: &Telemetry, got_n: Option<Vector3<f32>>) -> Option<Vector3<f32>> {
        got_n
    }
}

/// A loop whose every tick is checked.
#[derive(Clone, Debug)]
pub struct Rig {
    cycle: Cycle,
    watch: Watch,
    /// Nothing is promised at the port once another controller's force has acted, or once the
    /// device is not what its profile says.
    port: Option<PortWatch>,
    broken: Vec<(Broken, u32)>,
    ticks: u32,
    last: Option<Tick>,
}

impl Rig {
    /// Builds the loop for a device; its own reports are checked.
    ///
    /// # Errors
    /// Errors of [`Cycle::build`].
    pub fn build(settings: &Settings, device: &DeviceSpec) -> Result<Self, BuildError> {
        let cycle = Cycle::build(settings, device)?;
        Ok(Self { cycle, watch: Watch::of(settings), port: None, broken: Vec::new(), ticks: 0, last: None })
    }

    /// Also checks the force against this geometry.
    #[must_use]
    pub fn over(self, shape: Arc<dyn RestShape>) -> Self {
        Self { watch: self.watch.over(shape), ..self }
    }

    /// Also checks what truly happens at the port of a device that keeps its profile.
    #[must_use]
    pub fn at_port(self, shape: Arc<dyn RestShape>, device: &DeviceSpec) -> Self {
        Self { port: Some(PortWatch::over(shape, device)), ..self }
    }

    /// Builds the loop for a device that keeps its profile on this surface, with all checks.
    ///
    /// # Errors
    /// Errors of [`Cycle::build`].
    pub fn on(settings: &Settings, device: &DeviceSpec, surface: &impl Surface) -> Result<Self, BuildError> {
        let shape = surface.rest_shape();
        Ok(Self::build(settings, device)?.over(shape.clone()).at_port(shape, device))
    }

    /// Arms the idle loop, and waits until the force has its full share. The device is outside the
    /// tissue; `wait` is called after every tick.
    pub fn arm<D: HapticDevice>(
        &mut self,
        device: &mut D,
        renderer: &mut impl Renderer,
        beside: &mut impl Beside,
        mut wait: impl FnMut(&Self, &mut D),
    ) {
        for n in 0..ARMING_TICKS as usize {
            let asked = [Ask::Booted, Ask::TestPassed, Ask::Arm].get(n).copied();
            self.tick_beside(device, renderer, Command { asked, ..Command::HEARD }, beside, |_| None);
            wait(self, device);
        }
    }

    /// Runs one tick.
    pub fn tick(&mut self, device: &mut impl HapticDevice, renderer: &mut impl Renderer, command: Command) -> Telemetry {
        self.tick_beside(device, renderer, command, &mut (), |_| None)
    }

    /// Runs one tick on a surface, whose state is checked as well.
    pub fn tick_on(&mut self, device: &mut impl HapticDevice, surface: &mut impl Surface, command: Command) -> Telemetry {
        self.tick_beside(device, surface, command, &mut (), Surface::unsound)
    }

    /// Runs one tick with a second controller, whose force the device gets. `unsound` names a
    /// defect in the renderer's state.
    pub fn tick_beside<R: Renderer>(
        &mut self,
        device: &mut impl HapticDevice,
        renderer: &mut R,
        command: Command,
        beside: &mut impl Beside,
        unsound: impl Fn(&R) -> Option<&'static str>,
    ) -> Telemetry {
        let limits = *self.cycle.limits();
        let mut heard = Heard { device, reading: None, got_n: None };
        let telemetry = self.cycle.tick(&mut heard, renderer, command);
        let Heard { reading, got_n, .. } = heard;
        let given_n = beside.tick(reading, command, &telemetry, got_n);
        if given_n != got_n {
            self.leave_port();
        }
        match given_n {
            Some(force_n) => device.actuate(force_n),
            None => device.release(),
        }
        self.ticks += 1;
        let unsound = if self.ticks.is_multiple_of(NODES_EVERY_TICKS) { unsound(renderer) } else { None };
        // a cycle that ends before its sensor is read takes no new reading
        if let Some(reading) = reading.or(self.last.map(|tick| tick.reading)) {
            let tick = Tick { command, reading, limits, telemetry, got_n, unsound };
            let answer = self.watch.check(&tick);
            self.last = Some(tick);
            self.note(answer);
        }
        telemetry
    }

    /// Checks what truly happened at the port in a tick.
    pub fn acted(&mut self, truth: &Truth) {
        let answer = self.port.as_mut().map_or(Ok(()), |port| port.check(truth));
        self.note(answer);
    }

    /// Lowers limits of the loop, as [`Cycle::lower_limits`] does.
    ///
    /// # Errors
    /// Errors of [`Cycle::lower_limits`].
    pub fn lower_limits(&mut self, asked: &LoopLimitSettings) -> Result<(), BuildError> {
        self.cycle.lower_limits(asked)
    }

    /// Ends the checks at the port: the device is no longer what its profile says.
    pub fn leave_port(&mut self) {
        self.port = None;
    }

    fn note(&mut self, answer: Result<(), Broken>) {
        if let Err(broken) = answer
            && !self.broken.iter().any(|(known, _)| *known == broken)
        {
            self.broken.push((broken, self.last.map_or(0, |tick| tick.telemetry.tick)));
        }
    }

    /// Invariants that were broken, each once, with the number of the tick.
    #[must_use]
    pub fn broken(&self) -> &[(Broken, u32)] {
        &self.broken
    }

    /// Inputs and outputs of the last tick.
    #[must_use]
    pub fn last(&self) -> Option<&Tick> {
        self.last.as_ref()
    }

    /// The loop.
    #[must_use]
    pub fn cycle(&self) -> &Cycle {
        &self.cycle
    }

    /// The checks of the loop's reports.
    #[must_use]
    pub fn watch(&self) -> &Watch {
        &self.watch
    }

    /// The checks at the port, unless they have ended.
    #[must_use]
    pub fn port(&self) -> Option<&PortWatch> {
        self.port.as_ref()
    }

    /// Mode of the loop.
    #[must_use]
    pub fn mode(&self) -> Mode {
        self.cycle.mode()
    }
}

/// A device whose inputs and outputs are recorded; its force is withheld until the tick is over.
struct Heard<'a, D> {
    device: &'a mut D,
    reading: Option<Sensed>,
    got_n: Option<Vector3<f32>>,
}

impl<D: HapticDevice> HapticDevice for Heard<'_, D> {
    fn limits(&self) -> DeviceSpec {
        self.device.limits()
    }

    fn sense(&mut self) -> Sensed {
        let reading = self.device.sense();
        self.reading = Some(reading);
        reading
    }

    fn actuate(&mut self, force_n: Vector3<f32>) {
        self.got_n = Some(force_n);
    }

    fn release(&mut self) {
        self.got_n = None;
    }
}
