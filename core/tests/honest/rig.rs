//! A scripted device over a shipped patch, driven through [`Cycle::tick`].

use std::path::Path;

use palpate::haptic::cycle::{Ask, Command, Cycle, PatchRenderer, Settings, Telemetry};
use palpate::haptic::device::{DeviceSpec, HapticDevice, Sensed, SensorStatus};
use palpate::haptic::mode::Mode;
use palpate::{Fault, Model, Node, NodeStep, Params, PatchFile, State, TetShapes, Tuned, Vector3};

/// Height above the surface at which the probe waits [m].
pub const CLEAR_M: f32 = 5e-3;
/// Deceleration of the hand, and its acceleration unless another is set [m/s^2].
const M_PER_S2: f32 = 60.0;
/// Amplitude of the tremor of a hand at rest [m].
const TREMOR_M: f32 = 60e-6;

/// A device that reads a position set by the test, in whole counts.
pub struct Scripted {
    limits: DeviceSpec,
    sequence: u32,
    /// True position [m].
    pub at_m: Vector3<f32>,
    /// Force on the hand [N]; zero when released.
    pub got_n: Vector3<f32>,
    /// The next reading is missing.
    pub missing: bool,
    /// The next reading is off by this [m].
    pub shift_m: Option<Vector3<f32>>,
    /// Scale of the readings about the middle of the workspace (1).
    pub scale: f32,
}

impl HapticDevice for Scripted {
    fn limits(&self) -> DeviceSpec {
        self.limits
    }

    fn sense(&mut self) -> Sensed {
        self.sequence = self.sequence.wrapping_add(u32::from(!std::mem::take(&mut self.missing)));
        let count_m = self.limits.count_m;
        let counted = |x: f32| if count_m > 0.0 { (x / count_m).floor() * count_m } else { x };
        let at_m = self.at_m + self.shift_m.take().unwrap_or_default();
        let middle_m = (self.limits.workspace_low_m + self.limits.workspace_high_m) * 0.5;
        let position_m = middle_m + ((at_m - middle_m).map(counted)) * self.scale;
        Sensed { position_m, sequence: self.sequence, status: SensorStatus::Good }
    }

    fn actuate(&mut self, force_n: Vector3<f32>) {
        self.got_n = force_n;
    }

    fn release(&mut self) {
        self.got_n = Vector3::zeros();
    }
}

/// A device, a patch and the loop between them.
pub struct Rig {
    model: &'static Model<'static>,
    tuned: Tuned<'static>,
    state: State<'static>,
    pub device: Scripted,
    pub cycle: Cycle,
    /// Point of the rest surface that the patch was made for [m], its outward normal, a tangent.
    pub site_m: Vector3<f32>,
    pub normal: Vector3<f32>,
    pub along: Vector3<f32>,
    /// Acceleration of the hand [m/s^2].
    pub m_per_s2: f32,
}

impl Rig {
    /// Creates a rig on a patch of the repository, given by its path there, with this modulus and
    /// without any request.
    pub fn powered(patch: &str, youngs_modulus_pa: f32, count_m: f32) -> Self {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(patch);
        let bytes = std::fs::read(file).unwrap();
        let words: &'static mut [u32] = Vec::leak(vec![0; bytes.len().div_ceil(4)]);
        let on_words = &mut bytemuck::cast_slice_mut(words)[..bytes.len()];
        on_words.copy_from_slice(&bytes);
        let packed = PatchFile::open(on_words).unwrap();
        let model: &'static Model = Box::leak(Box::new(packed.model));
        let params = Params { youngs_modulus_pa, ..packed.params };
        let (nodes, triangles) = (model.nodes.len(), model.triangles.len());
        let tuned = params.build(model, vec![NodeStep::ZERO; nodes].leak()).unwrap();
        let shapes = vec![TetShapes::ZERO; TetShapes::count(model)].leak();
        let state = State::new(model, vec![Node::ZERO; nodes].leak(), vec![0; triangles].leak(), shapes).unwrap();
        let (site_m, normal) = (packed.site_m, params.probe.axis);
        let aside = if normal.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
        let along = (aside - normal * aside.dot(&normal)).normalize();
        let half = Vector3::repeat(0.2);
        let limits = DeviceSpec {
            max_force_n: 3.3,
            workspace_low_m: site_m - half,
            workspace_high_m: site_m + half,
            count_m,
            delay_ticks: 1,
            lag_s: 0.0,
            mass_kg: 0.045,
            stiffness_ceiling_n_per_m: 1e5,
            commissioned: true,
        };
        let at_m = site_m + normal * CLEAR_M;
        let device = Scripted { limits, sequence: 0, at_m, got_n: Vector3::zeros(), missing: false, shift_m: None, scale: 1.0 };
        let cycle = Cycle::build(&Settings::safe(&limits), &limits).unwrap();
        Self { model, tuned, state, device, cycle, site_m, normal, along, m_per_s2: M_PER_S2 }
    }

    /// Creates a rig that is armed and ramped in.
    pub fn armed(patch: &str, youngs_modulus_pa: f32, count_m: f32) -> Self {
        let mut rig = Self::powered(patch, youngs_modulus_pa, count_m);
        assert_eq!(rig.arm(700), None);
        assert_eq!(rig.cycle.mode(), Mode::Active);
        rig
    }

    /// Asks for arming and trembles in place for this many ticks; returns the fault.
    pub fn arm(&mut self, ticks: u32) -> Option<Fault> {
        for asked in [Ask::Booted, Ask::TestPassed, Ask::Arm] {
            self.tick(Command { asked: Some(asked), ..Command::HEARD });
        }
        let at_m = self.device.at_m;
        let fault = (0..ticks).find_map(|n| self.tremble(at_m, n).fault);
        self.device.at_m = at_m;
        fault
    }

    /// Runs one tick of a hand at rest, with its tremor of 9 Hz and slow drift.
    pub fn tremble(&mut self, at_m: Vector3<f32>, tick: u32) -> Telemetry {
        let t_s = 1e-3 * (tick % 100_000) as f32;
        let aside_m = TREMOR_M * ((56.5 * t_s).sin() + 2.0 * (1.9 * t_s).sin());
        self.device.at_m = at_m + (self.normal + self.along * 0.3) * aside_m;
        self.tick(Command::HEARD)
    }

    /// Runs one tick.
    pub fn tick(&mut self, command: Command) -> Telemetry {
        let mut patch = PatchRenderer { model: self.model, tuned: &self.tuned, state: &mut self.state };
        self.cycle.tick(&mut self.device, &mut patch, command)
    }

    /// Direction along the surface, `turned` from the tangent [rad].
    pub fn heading(&self, turned: f32) -> Vector3<f32> {
        self.along * turned.cos() + self.normal.cross(&self.along) * turned.sin()
    }

    /// Moves the probe in a straight line, with a hand's acceleration at both ends, and returns the
    /// largest force [N].
    ///
    /// # Errors
    /// Returns the fault that stopped the motion.
    pub fn go(&mut self, to_m: Vector3<f32>, m_per_s: f32) -> Result<f32, Fault> {
        let (from_m, displacement_m) = (self.device.at_m, to_m - self.device.at_m);
        let (length_m, mut gone_m, mut speed, mut most_n) = (displacement_m.norm(), 0.0_f32, 0.0_f32, 0.0_f32);
        while gone_m < length_m {
            let braking = (2.0 * M_PER_S2 * (length_m - gone_m)).sqrt();
            speed = (speed + 1e-3 * self.m_per_s2).min(m_per_s).min(braking.max(0.01));
            gone_m = (gone_m + 1e-3 * speed).min(length_m);
            self.device.at_m = from_m + displacement_m * (gone_m / length_m);
            let telemetry = self.tick(Command::HEARD);
            most_n = most_n.max(telemetry.applied_n.norm());
            if let Some(fault) = telemetry.fault {
                return Err(fault);
            }
        }
        Ok(most_n)
    }
}
