//! A cycle on the bench: a device with readings set by the test, a wall that answers, and a host.

use palpate::haptic::cycle::{Ask, Command, Cycle, Renderer, Settings, Telemetry};
use palpate::haptic::device::{DeviceSpec, HapticDevice, Sensed, SensorStatus};
use palpate::haptic::limits::{LoopLimitSettings, LoopLimits};
use palpate::haptic::mode::Mode;
use palpate::{ClampFlags, Fault, Output, ProbePose, Vector3};

/// Tick of every loop here [s].
pub const TICK_S: f32 = 1e-3;
/// Height of a tip that is clear of the wall [m].
pub const CLEAR_M: f32 = 10e-3;

/// A desktop stylus of 3.3 N with a delay of one tick and an ideal sensor.
pub fn stylus() -> DeviceSpec {
    DeviceSpec {
        max_force_n: 3.3,
        workspace_low_m: Vector3::new(-0.08, -0.07, -0.06),
        workspace_high_m: Vector3::new(0.09, 0.065, 0.055),
        count_m: 0.0,
        delay_ticks: 1,
        lag_s: 0.0,
        mass_kg: 0.045,
        stiffness_ceiling_n_per_m: 1e5,
        commissioned: true,
    }
}

/// The default limits on that stylus.
pub fn limits() -> LoopLimits {
    LoopLimits::build(&LoopLimitSettings::DESKTOP, &stylus(), TICK_S).unwrap()
}

/// A device whose reading is set by the test.
#[derive(Clone)]
pub struct Device {
    pub limits: DeviceSpec,
    pub sensed: Sensed,
    /// Force on the actuators [N]; `None` while they are released.
    pub drive_n: Option<Vector3<f32>>,
}

impl HapticDevice for Device {
    fn limits(&self) -> DeviceSpec {
        self.limits
    }

    fn sense(&mut self) -> Sensed {
        self.sensed
    }

    fn actuate(&mut self, force_n: Vector3<f32>) {
        self.drive_n = Some(force_n);
    }

    fn release(&mut self) {
        self.drive_n = None;
    }
}

/// A linear wall below z = 0, unless an answer is set.
#[derive(Clone)]
pub struct Wall {
    pub n_per_m: f32,
    /// Stiffness that the wall reports at its depth limit [N/m].
    pub stiffness_n_per_m: f32,
    /// Answer to every pose, in place of the wall's.
    pub answer: Option<Output>,
    /// Poses that were rendered.
    pub rendered: u32,
    /// Number of resets requested.
    pub resets: u32,
    /// Pose rendered last [m].
    pub shown_m: Vector3<f32>,
}

impl Renderer for Wall {
    fn render(&mut self, pose: ProbePose) -> Output {
        self.rendered += 1;
        self.shown_m = pose.tip_m;
        let depth_m = (-pose.tip_m.z).max(0.0);
        self.answer.unwrap_or_else(|| pushing(depth_m, self.n_per_m * depth_m))
    }

    fn reset(&mut self) {
        self.resets += 1;
    }

    fn stiffness_n_per_m(&self) -> f32 {
        self.stiffness_n_per_m
    }
}

/// An output that pushes upwards with `force_n` at `depth_m`; no contact if both are zero.
pub fn pushing(depth_m: f32, force_n: f32) -> Output {
    let normal = if force_n == 0.0 { Vector3::zeros() } else { Vector3::z() };
    Output { force_n: normal * force_n, normal, depth_m, ..Output::NONE }
}

/// A cycle with its device, its wall and its host.
#[derive(Clone)]
pub struct Bench {
    pub cycle: Cycle,
    pub device: Device,
    pub wall: Wall,
}

impl Bench {
    /// Creates a loop in `Boot`, with the tip clear of a wall of stiffness `n_per_m`.
    pub fn new(n_per_m: f32) -> Self {
        Self::with(n_per_m, stylus(), |_| ())
    }

    /// Creates a loop on another device, with settings changed by `change`.
    pub fn with(n_per_m: f32, device: DeviceSpec, change: impl Fn(&mut Settings)) -> Self {
        let mut settings = Settings::safe(&device);
        change(&mut settings);
        let position_m = Vector3::new(0.0, 0.0, CLEAR_M);
        Self {
            cycle: Cycle::build(&settings, &device).unwrap(),
            device: Device {
                limits: device,
                sensed: Sensed { position_m, sequence: 0, status: SensorStatus::Good },
                drive_n: None,
            },
            wall: Wall { n_per_m, stiffness_n_per_m: 0.0, answer: None, rendered: 0, resets: 0, shown_m: Vector3::zeros() },
        }
    }

    /// Runs one cycle with a new reading of the tip's position.
    pub fn run(&mut self, command: Command) -> Telemetry {
        self.device.sensed.sequence = self.device.sensed.sequence.wrapping_add(1);
        self.repeat(command)
    }

    /// Runs one cycle without a new reading.
    pub fn repeat(&mut self, command: Command) -> Telemetry {
        self.cycle.tick(&mut self.device, &mut self.wall, command)
    }

    /// Runs one cycle with a keep-alive from the host.
    pub fn tick(&mut self) -> Telemetry {
        self.run(Command::HEARD)
    }

    /// Runs one cycle with the tip at this height [m].
    pub fn at(&mut self, z_m: f32) -> Telemetry {
        self.device.sensed.position_m.z = z_m;
        self.tick()
    }

    /// Runs one cycle with a request.
    pub fn ask(&mut self, asked: Ask) -> Telemetry {
        self.run(Command { asked: Some(asked), ..Command::HEARD })
    }

    /// Runs this many cycles with the tip unmoved; returns the last record.
    pub fn ticks(&mut self, ticks: usize) -> Telemetry {
        (0..ticks).map(|_| self.tick()).last().expect("at least one")
    }

    /// Starts the loop up to `Idle`.
    pub fn idle(mut self) -> Self {
        self.ask(Ask::Booted);
        self.ask(Ask::TestPassed);
        assert_eq!(self.cycle.mode(), Mode::Idle);
        self
    }

    /// Arms the loop and waits for full gain, clear of the wall; it is then in `Active`.
    pub fn active(self) -> Self {
        let mut bench = self.idle();
        bench.arm();
        bench.ticks(600);
        bench
    }

    /// Arms from `Idle` to `Active`; returns the number of ticks that this took.
    pub fn arm(&mut self) -> usize {
        self.ask(Ask::Arm);
        let ticks = (1..2_000).find(|_| self.tick().mode == Mode::Active);
        ticks.expect("a calm probe in free space is armed")
    }

    /// Moves the tip to a height at this speed [m/s], tick by tick; returns the last record.
    pub fn move_to(&mut self, z_m: f32, m_per_s: f32) -> Telemetry {
        let step_m = m_per_s * TICK_S;
        loop {
            let left_m = z_m - self.device.sensed.position_m.z;
            let record = self.at(if left_m.abs() <= step_m { z_m } else { z_m - left_m + step_m.copysign(left_m) });
            if left_m.abs() <= step_m {
                return record;
            }
        }
    }

    /// Presses slowly until the wall's force is this [N], and waits until nothing moves.
    pub fn press_n(&mut self, force_n: f32) -> Telemetry {
        self.move_to(-force_n / self.wall.n_per_m, 0.05);
        self.ticks(100)
    }

    /// Runs one cycle in which the board reports `found`.
    pub fn find(&mut self, fault: Fault) -> Telemetry {
        self.run(Command { found: Some(fault), ..Command::HEARD })
    }

    /// Runs one cycle after this many missed periods.
    pub fn late(&mut self, late_ticks: u16) -> Telemetry {
        self.run(Command { late_ticks, ..Command::HEARD })
    }
}

/// Whether any of these limiters is set.
pub fn set(record: &Telemetry, limiter: ClampFlags) -> bool {
    record.limiters.contains(limiter)
}
