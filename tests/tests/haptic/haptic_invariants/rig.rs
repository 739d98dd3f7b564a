//! A scripted device on an elastic half-space, checked in every tick.

use palpate::haptic::account::AccountSettings;
use palpate::haptic::cycle::{Ask, Command, Cycle, Renderer, Settings};
use palpate::haptic::damping::DampingSettings;
use palpate::haptic::device::{DeviceSpec, HapticDevice, Sensed, SensorStatus};
use palpate::haptic::limits::LoopLimitSettings;
use palpate::haptic::mode::Mode;
use palpate::stages::probe::ProbePose;
use palpate::{ClampFlags, Fault, Output, Vector3};
use palpate_loop::closed_loop::drive::Drive;
use palpate_loop::closed_loop::watch::{self, Broken, PortWatch, Tick, Watch};
use std::sync::Arc;

/// Outward normal of the half-space, tilted so that it is not along an axis.
pub const NORMAL: Vector3<f32> = Vector3::new(0.48, 0.6, 0.64);
/// Largest way of a tip in a tick [m], at twice the speed of a hand. A reading further away is
/// wrong, and the tip is not there.
const WAY_M: f64 = 3e-3;

/// An elastic half-space below a plane through the origin, with injectable errors.
pub struct HalfSpace {
    pub n_per_m: f32,
    /// Error that is added to the force of the next tick only.
    pub sick_n: Option<Vector3<f32>>,
}

impl Renderer for HalfSpace {
    fn render(&mut self, pose: ProbePose) -> Output {
        let depth_m = -pose.tip_m.dot(&NORMAL);
        let sick_n = self.sick_n.take().unwrap_or_default();
        if depth_m <= 0.0 {
            return Output { force_n: sick_n, point_m: pose.tip_m, ..Output::NONE };
        }
        Output { force_n: NORMAL * (self.n_per_m * depth_m) + sick_n, depth_m, normal: NORMAL, ..Output::NONE }
    }

    fn reset(&mut self) {}
}

/// A device whose position the script sets.
pub struct Scripted {
    pub reading: Sensed,
    pub delay_ticks: u8,
    /// Last output: a force, or `None` if the device was released.
    pub got_n: Option<Vector3<f32>>,
}

impl HapticDevice for Scripted {
    fn limits(&self) -> DeviceSpec {
        DeviceSpec {
            max_force_n: 3.3,
            workspace_low_m: Vector3::new(-0.2, -0.2, -0.2),
            workspace_high_m: Vector3::new(0.2, 0.2, 0.2),
            count_m: 55e-6,
            delay_ticks: self.delay_ticks,
            lag_s: 0.0,
            mass_kg: 0.045,
            stiffness_ceiling_n_per_m: 1e5,
            commissioned: true,
        }
    }

    fn sense(&mut self) -> Sensed {
        self.reading
    }

    fn actuate(&mut self, force_n: Vector3<f32>) {
        self.got_n = Some(force_n);
    }

    fn release(&mut self) {
        self.got_n = None;
    }
}

/// A change to the results of a tick that makes them those of a loop with a defect.
pub type Defect = fn(before: &Tick, now: &mut Tick);

/// Device, tissue and loop; the invariants are checked in every tick.
pub struct Rig {
    pub device: Scripted,
    pub tissue: HalfSpace,
    pub cycle: Cycle,
    pub defect: Option<Defect>,
    /// Violated invariants.
    pub broken: Vec<Broken>,
    pub last: Option<Tick>,
    /// Modes and limiters that occurred.
    pub modes: Vec<Mode>,
    pub limiters: ClampFlags,
    watch: Watch,
    /// Drive between the device and the hand, and the true position of the tip [m].
    drive: Drive,
    at_m: Vector3<f64>,
    pub port: PortWatch,
}

impl Rig {
    /// A rig that is switched on at this depth [m] in tissue of 400 N/m.
    pub fn at(depth_m: f32) -> Self {
        Self::with(depth_m, 1, |settings| settings)
    }

    /// A rig 5 mm outside the tissue that is armed and ramped in, on a device with this delay.
    pub fn delayed(delay_ticks: u8) -> Self {
        Self::with(-5e-3, delay_ticks, |settings| settings).activated()
    }

    fn with(depth_m: f32, delay_ticks: u8, change: fn(Settings) -> Settings) -> Self {
        let reading = Sensed { position_m: NORMAL * -depth_m, sequence: 0, status: SensorStatus::Good };
        let device = Scripted { reading, delay_ticks, got_n: None };
        let settings = change(Settings::safe(&device.limits()));
        let cycle = Cycle::build(&settings, &device.limits()).unwrap();
        let watch = Watch::of(&settings);
        let shape = watch::HalfSpace { at_m: Vector3::zeros(), normal: NORMAL.cast() };
        let port = PortWatch::over(Arc::new(shape), &device.limits());
        let (drive, at_m) = (Drive::new(delay_ticks, 0.0), reading.position_m.cast());
        let tissue = HalfSpace { n_per_m: 400.0, sick_n: None };
        let (broken, modes, limiters) = (Vec::new(), Vec::new(), ClampFlags::default());
        Self { device, tissue, cycle, defect: None, broken, last: None, modes, limiters, watch, drive, at_m, port }
    }

    /// A rig 5 mm outside the tissue that is booted, tested, armed and ramped in.
    pub fn active() -> Self {
        Self::at(-5e-3).activated()
    }

    /// Like [`Rig::delayed`], without damping, so that the energy account alone stands between the
    /// tissue and the hand; with `account` false it pays for every force.
    pub fn undamped(delay_ticks: u8, account: bool) -> Self {
        let settings = |s: Settings| Settings { damping: DampingSettings::NONE, ..s };
        let lavish = |s: Settings| Settings { damping: DampingSettings::NONE, account: AccountSettings::HIGHEST, ..s };
        Self::with(-5e-3, delay_ticks, if account { settings } else { lavish }).activated()
    }

    fn activated(mut self) -> Self {
        self.arm();
        assert_eq!(self.hold(700), Mode::Active);
        self
    }

    /// Sends all requests from power-on to arming.
    pub fn arm(&mut self) {
        for asked in [Ask::Booted, Ask::TestPassed, Ask::Arm] {
            self.ask(asked);
        }
    }

    /// Runs one tick with a request.
    pub fn ask(&mut self, asked: Ask) -> Tick {
        self.tick(Command { asked: Some(asked), ..Command::HEARD }, true)
    }

    /// Runs one tick, with a new reading if `fresh` is true and with the last one otherwise.
    pub fn tick(&mut self, command: Command, fresh: bool) -> Tick {
        if fresh {
            self.device.reading.sequence = self.device.reading.sequence.wrapping_add(1);
        }
        self.carry();
        let limits: LoopLimitSettings = *self.cycle.limits();
        let telemetry = self.cycle.tick(&mut self.device, &mut self.tissue, command);
        self.limiters.set(telemetry.limiters);
        if !self.modes.contains(&telemetry.mode) {
            self.modes.push(telemetry.mode);
        }
        let mut tick = Tick { command, reading: self.device.reading, limits, telemetry, got_n: self.device.got_n, unsound: None };
        if let (Some(defect), Some(before)) = (self.defect, &self.last) {
            defect(before, &mut tick);
        }
        match tick.got_n {
            Some(force_n) => self.drive.send(force_n.cast()),
            None => self.drive.release(),
        }
        if let Err(broken) = self.watch.check(&tick) {
            self.broken.push(broken);
        }
        self.last = Some(tick);
        tick
    }

    /// Puts the tip, and its reading, somewhere else [m]; nothing acts meanwhile.
    pub fn move_to(&mut self, at_m: Vector3<f32>) {
        (self.device.reading.position_m, self.at_m) = (at_m, at_m.cast());
    }

    /// Moves the tip to the position that is about to be read, under the force that acts.
    fn carry(&mut self) {
        let to_m = self.device.reading.position_m.cast::<f64>();
        // written so that NaN is wrong
        let to_m = if (to_m - self.at_m).norm() <= WAY_M { to_m } else { self.at_m };
        let truth = self.drive.carry(&self.at_m, &to_m);
        self.at_m = to_m;
        if let Err(broken) = self.port.check(&truth) {
            self.broken.push(broken);
        }
    }

    /// Runs ticks at the same position; returns the mode after them.
    pub fn hold(&mut self, ticks: u32) -> Mode {
        for _ in 0..ticks {
            self.tick(Command::HEARD, true);
        }
        self.cycle.mode()
    }

    /// Moves to a depth [m] at a speed [m/s]; returns the last tick.
    pub fn go(&mut self, depth_m: f32, m_per_s: f32) -> Tick {
        let mut at_m = -self.device.reading.position_m.dot(&NORMAL);
        loop {
            let left_m = depth_m - at_m;
            at_m += left_m.clamp(-1e-3 * m_per_s, 1e-3 * m_per_s);
            self.device.reading.position_m = NORMAL * -at_m;
            let tick = self.tick(Command::HEARD, true);
            if left_m.abs() <= 1e-3 * m_per_s {
                return tick;
            }
        }
    }

    /// Moves 5 mm outside, clears a fault and arms again.
    pub fn recover(&mut self) {
        self.device.reading.status = SensorStatus::Good;
        self.move_to(NORMAL * 5e-3);
        self.hold(120);
        for asked in [Ask::Clear, Ask::TestPassed, Ask::Arm] {
            assert!(!self.ask(asked).telemetry.refused, "{asked:?}: {:?}", self.last);
        }
        assert_eq!(self.hold(700), Mode::Active);
    }

    /// Asserts that the last tick ended with this fault and a released device.
    #[track_caller]
    pub fn expect_fault(&self, fault: Fault) {
        let tick = self.last.unwrap();
        assert_eq!((tick.telemetry.mode, tick.telemetry.fault, tick.got_n), (Mode::Fault, Some(fault), None), "{tick:?}");
        assert_eq!(tick.telemetry.applied_n, Vector3::zeros());
    }

    /// Asserts that no invariant was violated.
    #[track_caller]
    pub fn expect_clean(&self) {
        assert!(self.broken.is_empty(), "{:?}; last {:?}", self.broken, self.last);
    }
}
