//! Hours of normal use: every hand in turn, one motion after the other, on one loop that is never
//! restarted. No fault may occur, and the tissue must return to its rest shape.

use palpate::haptic::cycle::{Ask, Command, Settings};
use palpate::haptic::mode::Mode;
use palpate::{BuildError, Fault, Node, Vector3};
use rand_xoshiro::SplitMix64;
use rand_xoshiro::rand_core::SeedableRng;

use super::campaign::{DEPTH_M, Ground, WALL_N_PER_M};
use super::faulty::Faulty;
use palpate_loop::closed_loop::hand::{Aim, HANDS};
use palpate_loop::closed_loop::plant::Plant;
use palpate_loop::closed_loop::rig::{ARMING_TICKS, Rig};
use palpate_loop::closed_loop::run::{Setup, trajectory_of};
use palpate_loop::closed_loop::stimulus::{CLEAR_M, Stimulus};
use palpate_loop::closed_loop::surface::{Surface, Wall, with_tissue};
use palpate_loop::closed_loop::watch::Broken;

/// Stimuli of normal use, by id, and the longest duration of each [s].
const USES: [(&str, f64); 9] = [
    ("S1-0.2", 2.0),
    ("S1-0.5", 2.0),
    ("S4", 4.0),
    ("S5", 7.0),
    ("S6", 4.0),
    ("S7", 3.0),
    ("S9", 7.0),
    ("S10", 4.0),
    ("S2", 4.0),
];
/// Duration of the retreat after each stimulus, and of the rest outside the tissue [s].
const OUT_S: f64 = 0.8;
const REST_S: f64 = 1.0;
/// Speed of the retreat [m/s].
const OUT_M_PER_S: f64 = 0.05;

/// Result of a soak run.
#[derive(Clone, Debug, Default)]
pub struct Soak {
    /// Number of ticks.
    pub ticks: u64,
    /// Number of stimuli, each with one hand.
    pub uses: u64,
    /// Faults that occurred: hand, stimulus, fault.
    pub trips: Vec<(&'static str, &'static str, Fault)>,
    /// Invariants that were broken, each once.
    pub broken: Vec<Broken>,
    /// Largest distance of a node at rest from its initial position [m].
    pub drift_m: f32,
    /// Largest number of denormal values in the tissue's state after any rest.
    pub denormals: usize,
    /// Largest force [N].
    pub peak_n: f32,
}

impl Soak {
    fn add(mut self, other: Self) -> Self {
        self.ticks += other.ticks;
        self.uses += other.uses;
        self.trips.extend(other.trips);
        self.broken.extend(other.broken);
        self.drift_m = self.drift_m.max(other.drift_m);
        self.denormals = self.denormals.max(other.denormals);
        self.peak_n = self.peak_n.max(other.peak_n);
        self
    }
}

/// Runs on a wall and on the patch, each for half of the time [s].
pub fn soak(ground: &Ground, seconds: f64, done: impl Fn(u64) + Sync) -> Result<Soak, BuildError> {
    let half_s = 0.5 * seconds;
    let wall = || {
        let mut wall = Wall::new(WALL_N_PER_M, ground.device.force_limit_n, super::campaign::Case::WALL_NORMAL);
        on(ground, &mut wall, WALL_N_PER_M * DEPTH_M, half_s, &done, |_| &[])
    };
    let patch =
        || with_tissue(ground.patch, ground.params, |tissue| on(ground, tissue, ground.patch_n, half_s, &done, |t| t.nodes()))?;
    let (wall, patch) = rayon::join(wall, patch);
    Ok(wall?.add(patch?))
}

/// A loop on a surface, with its checks.
struct Loop<'s, S> {
    rig: Rig,
    surface: &'s mut S,
    seen: Soak,
}

impl<S: Surface> Loop<'_, S> {
    fn tick(&mut self, device: &mut Faulty<Plant>, asked: Option<Ask>) -> bool {
        let telemetry = self.rig.tick_on(device, self.surface, Command { asked, ..Command::HEARD });
        self.seen.ticks += 1;
        self.seen.peak_n = self.seen.peak_n.max(telemetry.applied_n.norm());
        telemetry.output.depth_m > 0.0 || telemetry.applied_n != Vector3::zeros()
    }

    /// Puts the device into another hand; its sequence numbers continue.
    fn held(&self, plant: Plant) -> Faulty<Plant> {
        let site = self.surface.site();
        let random = SplitMix64::seed_from_u64(0);
        let mut device = Faulty::new(plant, site.at_m.cast(), site.normal.cast(), site.along.cast(), random);
        device.number_from(self.rig.last().map_or(0, |tick| tick.reading.sequence));
        device
    }
}

fn on<S: Surface>(
    ground: &Ground,
    surface: &mut S,
    static_n: f64,
    seconds: f64,
    done: &(impl Fn(u64) + Sync),
    nodes: impl Fn(&S) -> &[Node],
) -> Result<Soak, BuildError> {
    let site = surface.site();
    let limits = ground.device.limits(site.at_m.cast());
    let settings = Settings { limits: ground.device.limit_values(), ..Settings::safe(&limits) };
    let mut held = Loop { rig: Rig::on(&settings, &limits, surface)?, surface, seen: Soak::default() };
    let plant = |hand, at_m| Plant::new(ground.device, hand, site.at_m.cast(), site.normal.cast(), at_m);
    arm(&mut held, plant(HANDS[0], site.point_m(-CLEAR_M, 0.0, 0.0)));
    let first: Vec<Vector3<f32>> = nodes(held.surface).iter().map(Node::position_m).collect();
    let uses = HANDS.iter().cycle().flat_map(|hand| USES.map(|(id, s)| (*hand, id, s)));
    for (hand, id, longest_s) in uses {
        if held.seen.ticks as f64 * 1e-3 >= seconds {
            break;
        }
        let before = held.seen.ticks;
        let Some(stimulus) = Stimulus::named(id) else { continue };
        let setup = Setup { device: ground.device, hand, stimulus, settings, depth_m: DEPTH_M, static_n };
        let trajectory = trajectory_of(&setup, held.surface);
        let mut device = held.held(plant(hand, site.point_m(-CLEAR_M, 0.0, 0.0)));
        device.device().set_velocity_m_per_s(-site.normal * trajectory.entry_m_per_s());
        let ticks = (1e3 * trajectory.seconds().min(longest_s)) as u32;
        for n in 0..ticks {
            let touched = held.tick(&mut device, None);
            device.device().step(&trajectory.aim(f64::from(n) * 1e-3), touched);
            held.rig.acted(&device.device().truth());
        }
        // a light fingertip lifts the probe out and keeps it there
        let from_m = device.device().at_m();
        let mut device = held.held(plant(HANDS[1], from_m));
        // a released device may be further out already: it then stays there
        let out_m = (CLEAR_M - (from_m - site.at_m).dot(&site.normal)).max(0.0);
        for n in 0..(1e3 * (OUT_S + REST_S)) as u32 {
            let touched = held.tick(&mut device, None);
            let moved_m = (OUT_M_PER_S * 1e-3 * f64::from(n)).min(out_m);
            let at_m = from_m + site.normal * moved_m;
            let aim = Aim { at_m, velocity_m_per_s: Vector3::zeros(), push_n: Vector3::zeros(), let_go: false, steady: true };
            device.device().step(&aim, touched);
            held.rig.acted(&device.device().truth());
        }
        held.seen.uses += 1;
        if let Mode::Fault = held.rig.mode() {
            // the fault is recorded once, then the loop is armed again
            let fault = held.trip(&mut device);
            held.seen.trips.extend(fault.map(|f| (hand.id, id, f)));
            let at_m = device.device().at_m();
            arm(&mut held, plant(HANDS[0], at_m));
        }
        let now = nodes(held.surface);
        let far = now.iter().zip(&first).map(|(n, x)| (n.position_m() - x).norm()).fold(0.0, f32::max);
        held.seen.drift_m = held.seen.drift_m.max(far);
        let denormal = |n: &Node| n.velocity_m_per_s().iter().chain(n.position_m().iter()).filter(|c| c.is_subnormal()).count();
        held.seen.denormals = held.seen.denormals.max(now.iter().map(denormal).sum());
        done(held.seen.ticks - before);
    }
    held.seen.broken = held.rig.broken().iter().map(|(broken, _)| *broken).collect();
    Ok(held.seen)
}

impl<S: Surface> Loop<'_, S> {
    /// Returns the latched fault, and clears it.
    fn trip(&mut self, device: &mut Faulty<Plant>) -> Option<Fault> {
        let telemetry = self.rig.tick_on(device, self.surface, Command::HEARD);
        for _ in 0..150 {
            self.tick(device, None);
        }
        self.tick(device, Some(Ask::Clear));
        telemetry.fault
    }
}

/// Arms the loop with the probe outside, from any state.
fn arm<S: Surface>(held: &mut Loop<'_, S>, plant: Plant) {
    let mut device = held.held(plant);
    for n in 0..ARMING_TICKS as usize {
        let asked = [Ask::Booted, Ask::TestPassed, Ask::Arm].get(n).copied();
        held.tick(&mut device, asked);
    }
}
