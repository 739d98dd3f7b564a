//! One path from arming to the end of its rest, with every tick checked.

use palpate::haptic::cycle::{Command, PatchRenderer, Renderer, Settings, Telemetry};
use palpate::haptic::device::{DeviceSpec, HapticDevice, Sensed, SensorStatus};
use palpate::haptic::mode::Mode;
use palpate::stages::probe::ProbePose;
use palpate::{BuildError, Fault, Model, Output, Params, Vector3};

use super::case::PathCase;
use super::ground::PathGround;
use palpate_loop::closed_loop::device::DeviceProfile;
use palpate_loop::closed_loop::drive::Drive;
use palpate_loop::closed_loop::rig::Rig;
use palpate_loop::closed_loop::watch::{Broken, Contact, Seen};
use palpate_tissue::patch::Memory;
use palpate_tissue::scene::TICK_S;

/// Number of ticks that are still run after a fault.
const AFTER_FAULT_TICKS: u32 = 20;
/// Half a side of the workspace: every path stays inside [m].
const REACH_M: f32 = 0.5;
/// Largest speed that a hand can reach [m/s]; no fault may end slower motion.
const HONEST_M_PER_S: f64 = 1.5;
/// Largest deceleration at a corner or stop that cannot be mistaken for a stuck encoder [m/s^2]: no
/// hand decelerates a stylus faster.
const SHARPEST_M_PER_S2: f64 = 200.0;

/// Result of one path.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PathOutcome {
    /// Ticks along the path.
    pub ticks: u64,
    /// Extremes seen by the geometric watch.
    pub seen: Seen,
    /// Invariants that were broken, each once, with the tick along the path.
    pub broken: Vec<(Broken, u32)>,
    /// Fault that ended the path.
    pub fault: Option<Fault>,
    /// Whether a fault on this path would be wrong: until the path ended the tip was no faster than
    /// a hand, and no corner was so sharp that a fault of the encoder is justified.
    pub honest: bool,
    /// Whether the motion is within the speed and acceleration of a hand.
    pub by_hand: bool,
    /// Energy created by the worst contact, from true positions and the force that acted [J].
    pub created_j: f64,
    /// Largest force [N].
    pub peak_n: f32,
}

/// One tick of a run, for closer inspection.
#[derive(Clone, Copy, Debug)]
pub struct Track {
    /// True position [m].
    pub at_m: Vector3<f64>,
    /// The loop's record of this tick.
    pub telemetry: Telemetry,
    /// Energy created by the contact so far [J].
    pub created_j: f64,
}

/// Runs a case.
pub(super) fn run(ground: &PathGround, case: &PathCase) -> Result<PathOutcome, BuildError> {
    case.follow(ground, |_| ())
}

impl PathCase {
    /// Runs the case; `see` is called for every tick along the path.
    pub fn follow(&self, ground: &PathGround, mut see: impl FnMut(&Track)) -> Result<PathOutcome, BuildError> {
        let (on, profile) = (&ground.patches[self.patch], &ground.devices[self.device]);
        let e = self.youngs_modulus_pa;
        let mut model = on.patch.wide_model();
        if self.guarded {
            model = Model { depth_limit_m: on.guard_depth_m(e, profile.force_limit_n) as f32, ..model };
        }
        let params = Params { youngs_modulus_pa: e as f32, ..on.params };
        let mut memory = Memory::for_model(&model);
        let (tuned, mut state) = memory.start(&model, &params)?;

        let start_m = self.route.at_m.first().copied().unwrap_or(on.site.at_m);
        let mut device = Scripted::new(profile, on.site.at_m.cast(), start_m);
        let settings = Settings { limits: profile.limit_values(), ..Settings::safe(&device.limits) };
        let mut rig = Rig::build(&settings, &device.limits)?.over(on.shape.clone()).at_port(on.shape.clone(), &device.limits);
        // arming happens far from the tissue, where a patch at rest gives no force
        rig.arm(&mut device, &mut Nothing, &mut (), |_, _| ());
        let armed_tick = rig.last().map_or(0, |tick| tick.telemetry.tick);
        let mut outcome = PathOutcome { honest: true, ..PathOutcome::default() };
        let (mut ended, mut last_m, mut last_way_m, mut sharpest_m) = (None, start_m, Vector3::zeros(), 0.0_f64);
        for at_m in &self.route.at_m {
            let displacement_m = at_m - last_m;
            if ended.is_none() {
                outcome.honest &= displacement_m.norm() <= HONEST_M_PER_S * TICK_S * 1.0001;
                sharpest_m = sharpest_m.max((displacement_m - last_way_m).norm());
            }
            let truth = device.drive.carry(&last_m, at_m);
            rig.acted(&truth);
            (last_m, last_way_m) = (*at_m, displacement_m);
            device.at_m = *at_m;
            let telemetry =
                rig.tick(&mut device, &mut PatchRenderer { model: &model, tuned: &tuned, state: &mut state }, Command::HEARD);
            outcome.peak_n = outcome.peak_n.max(telemetry.applied_n.norm());
            outcome.ticks += 1;
            see(&Track { at_m: *at_m, telemetry, created_j: contact(&rig).created_j });
            if telemetry.mode == Mode::Fault {
                outcome.fault = outcome.fault.or(telemetry.fault);
                let since = ended.get_or_insert(0);
                *since += 1;
                if *since > AFTER_FAULT_TICKS {
                    break;
                }
            }
        }
        // no hand stops dead or jumps by several counts at once; an encoder that
        // sticks does
        let stuck = outcome.fault == Some(Fault::SensorFault) && sharpest_m > SHARPEST_M_PER_S2 * TICK_S * TICK_S;
        outcome.honest &= !stuck;
        outcome.by_hand = outcome.honest && sharpest_m <= SHARPEST_M_PER_S2 * TICK_S * TICK_S;
        outcome.seen = rig.watch().seen();
        outcome.created_j = contact(&rig).worst_j;
        outcome.broken = rig.broken().iter().map(|&(broken, tick)| (broken, tick.saturating_sub(armed_tick + 1))).collect();
        Ok(outcome)
    }
}

/// Energy of the contacts so far; none once the port is no longer checked.
fn contact(rig: &Rig) -> Contact {
    rig.port().map(|port| port.energy().contact()).unwrap_or_default()
}

/// Free space, which exerts no force.
struct Nothing;

impl Renderer for Nothing {
    fn render(&mut self, pose: ProbePose) -> Output {
        Output { point_m: pose.tip_m, ..Output::NONE }
    }

    fn reset(&mut self) {}
}

/// A device at the position of the path, with quantised readings.
struct Scripted {
    limits: DeviceSpec,
    at_m: Vector3<f64>,
    reading: Sensed,
    drive: Drive,
}

impl Scripted {
    fn new(profile: &DeviceProfile, site_m: Vector3<f32>, at_m: Vector3<f64>) -> Self {
        let reach_m = Vector3::repeat(REACH_M);
        let limits =
            DeviceSpec { workspace_low_m: site_m - reach_m, workspace_high_m: site_m + reach_m, ..profile.limits(site_m) };
        let reading = Sensed { position_m: at_m.cast(), sequence: 0, status: SensorStatus::Good };
        let drive = Drive::new(profile.delay_ticks, profile.amplifier_lag_s);
        Self { limits, at_m, reading, drive }
    }
}

impl HapticDevice for Scripted {
    fn limits(&self) -> DeviceSpec {
        self.limits
    }

    fn sense(&mut self) -> Sensed {
        let count_m = f64::from(self.limits.count_m);
        let counted = |x: f64| if count_m > 0.0 { (x / count_m).floor() * count_m } else { x };
        self.reading.position_m = self.at_m.map(counted).cast();
        self.reading.sequence = self.reading.sequence.wrapping_add(1);
        self.reading
    }

    fn actuate(&mut self, force_n: Vector3<f32>) {
        self.drive.send(force_n.cast());
    }

    fn release(&mut self) {
        self.drive.release();
    }
}
