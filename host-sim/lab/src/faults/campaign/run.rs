//! One case from its first tick to its verdict.

use palpate::haptic::cycle::{Ask, Command, Settings};
use palpate::haptic::mode::Mode;
use palpate::stages::probe::ProbePose;
use palpate::{BuildError, ClampFlags, Fault};
use rand_xoshiro::SplitMix64;
use rand_xoshiro::rand_core::SeedableRng;

use super::case::{Case, Moment};
use super::inject::{begin, command};
use super::state::{Outcome, Scene};
use super::verdict::{reacted, verdict};
use crate::faults::faulty::{Expected, Faulty, FaultyTissue, Needs, Opening};
use palpate_loop::closed_loop::device::DeviceProfile;
use palpate_loop::closed_loop::hand::HANDS;
use palpate_loop::closed_loop::plant::Plant;
use palpate_loop::closed_loop::rig::Rig;
use palpate_loop::closed_loop::run::{Setup, trajectory_of};
use palpate_loop::closed_loop::stimulus::{CLEAR_M, Stimulus, Trajectory};
use palpate_loop::closed_loop::surface::Surface;

/// Longest wait for the moment of a fault [ticks].
const PATIENCE_TICKS: u32 = 1500;
/// Number of ticks that are checked after a fault begins, and after the loop has latched a fault.
const AFTER_TICKS: u32 = 260;
const AFTER_FAULT_TICKS: u32 = 80;
/// Smallest force [N] and speed [m/s] that satisfy [`Needs::Force`] and [`Needs::FastForce`].
const FORCE_N: f32 = 0.3;
const FAST_M_PER_S: f64 = 0.35;
/// Force to which a ramp must have fallen within [`RAMP_TICKS`] [N].
const RAMP_END_N: f32 = 0.05;
const RAMP_TICKS: u32 = 150;

/// A loop in free space, ready for runs.
pub struct Bed<'a> {
    device: &'a DeviceProfile,
    settings: Settings,
    static_n: f64,
    /// State after ramp-in, and state at the end of arming, before the gain rises.
    ready: Rig,
    fresh: Rig,
}

impl<'a> Bed<'a> {
    /// Arms a loop over this surface; `static_n` is the force of the surface at the depth where a
    /// press rests [N].
    pub fn arm(device: &'a DeviceProfile, surface: &mut impl Surface, static_n: f64) -> Result<Self, BuildError> {
        let site = surface.site();
        let limits = device.limits(site.at_m.cast());
        let settings = Settings { limits: device.limit_values(), ..Settings::safe(&limits) };
        let mut plant = Plant::new(device, HANDS[0], site.at_m.cast(), site.normal.cast(), site.point_m(-CLEAR_M, 0.0, 0.0));
        let mut ready = Rig::on(&settings, &limits, surface)?;
        let mut fresh = ready.clone();
        ready.arm(&mut plant, surface, &mut (), |rig, _| {
            if rig.mode() != Mode::Active {
                fresh = rig.clone();
            }
        });
        Ok(Self { device, settings, static_n, ready, fresh })
    }

    /// Runs one case.
    pub fn run<S: Surface>(&self, case: &Case, surface: &mut S) -> Result<Outcome, BuildError> {
        let site = surface.site();
        let limits = self.device.limits(site.at_m.cast());
        let rig = match case.kind().opening {
            Opening::Active => self.ready.clone(),
            Opening::RampingIn => self.fresh.clone(),
            Opening::Inside | Opening::Waving => Rig::on(&self.settings, &limits, surface)?,
        };
        let stimulus = case.motion.stimulus().unwrap_or(palpate_loop::closed_loop::stimulus::STIMULI[0]);
        let trajectory = self.trajectory(case, stimulus, surface);
        let from_s = case.motion.from_s();
        let begin = trajectory.aim(from_s);
        surface.reset();
        let mut plant = Plant::new(self.device, case.hand, site.at_m.cast(), site.normal.cast(), begin.at_m);
        plant.set_velocity_m_per_s(if trajectory.entry_m_per_s() > 0.0 {
            -site.normal * trajectory.entry_m_per_s()
        } else {
            begin.velocity_m_per_s
        });
        let mut device =
            Faulty::new(plant, site.at_m.cast(), site.normal.cast(), site.along.cast(), SplitMix64::seed_from_u64(case.noise));
        device.number_from(rig.last().map_or(0, |tick| tick.reading.sequence));
        let mut scene = Scene { rig, device, tissue: FaultyTissue::new(surface) };
        let mut outcome = match case.kind().opening {
            Opening::Active | Opening::RampingIn => {
                // the patch first receives a pose outside the tissue, as it did while the loop
                // armed
                palpate::haptic::cycle::Renderer::render(&mut scene.tissue, ProbePose { tip_m: begin.at_m.cast() });
                follow(case, &trajectory, from_s, &mut scene)
            }
            Opening::Inside | Opening::Waving => never_felt(case, &mut scene),
        };
        outcome.broken = scene.rig.broken().iter().map(|(broken, _)| *broken).collect();
        Ok(outcome)
    }

    fn trajectory(&self, case: &Case, stimulus: Stimulus, surface: &impl Surface) -> Trajectory {
        let (static_n, depth_m) = (self.static_n, super::DEPTH_M);
        trajectory_of(
            &Setup { device: self.device, hand: case.hand, stimulus, settings: self.settings, depth_m, static_n },
            surface,
        )
    }
}

/// Starts a loop in a state in which it must never produce a force, and checks that it does not.
fn never_felt<S: Surface>(case: &Case, scene: &mut Scene<'_, S>) -> Outcome {
    let site = scene.tissue.site();
    let inside = case.kind().opening == Opening::Inside;
    let mut outcome = Outcome { injected: true, ..Outcome::default() };
    for n in 0..400_u32 {
        let to_and_fro = f64::from(if n % 80 < 40 { n % 40 } else { 40 - n % 40 });
        let out_m = if inside { -(0.3e-3 + 4e-3 * case.share) } else { CLEAR_M + 0.8e-3 * to_and_fro };
        scene.plant().put(site.point_m(-out_m, 8e-3 * (case.share - 0.5), 0.0));
        let asked = [Ask::Booted, Ask::TestPassed, Ask::Arm].get(n as usize).copied();
        let telemetry = scene.cycle(Command { asked, ..Command::HEARD });
        outcome.peak_n = outcome.peak_n.max(telemetry.applied_n.norm());
        outcome.fault = outcome.fault.or(telemetry.fault);
        if telemetry.mode.allows_force() {
            outcome.wrong = Some("armed where no force may come");
        }
    }
    outcome
}

fn follow<S: Surface>(case: &Case, trajectory: &Trajectory, from_s: f64, scene: &mut Scene<'_, S>) -> Outcome {
    let kind = case.kind();
    let mut outcome = Outcome::default();
    let (mut begun, mut ended): (Option<u32>, Option<u32>) = (None, None);
    let (mut touched_ticks, mut waited, mut last_n) = (0_u32, 0_u32, 0.0_f32);
    let mut last_mode = scene.rig.mode();
    // first tick of the present contact's force: a force at its limit that ends for some ticks
    // begins anew
    let mut forced_from = 0;
    for n in 0.. {
        let aim = trajectory.aim(from_s + f64::from(n) * 1e-3);
        if begun.is_none() {
            let normal = scene.tissue.site().normal;
            let speed = scene.plant().velocity_m_per_s();
            let due = match case.moment {
                Moment::Free => n >= 2,
                Moment::Touch => touched_ticks > 0,
                Moment::Deep => touched_ticks > 40,
                Moment::Release => touched_ticks > 20 && (aim.let_go || speed.dot(&normal) > 5e-3 || touched_ticks > 400),
            };
            waited += u32::from(due);
            let met = match kind.needs {
                Needs::Nothing => true,
                Needs::Force | Needs::NobodysForce => last_n > FORCE_N,
                Needs::FastForce => last_n > FORCE_N && speed.norm() > FAST_M_PER_S,
            };
            if waited > case.after_ticks && met {
                begun = Some(n);
                outcome.injected = true;
                outcome.wrong = begin(kind.injection, scene);
                if !kind.injection.keeps_profile() {
                    scene.rig.leave_port();
                }
            } else if n >= PATIENCE_TICKS {
                break;
            }
        }
        let since = begun.map(|b| n - b);
        let on = since.is_some_and(|s| s < kind.ticks);
        if since == Some(kind.ticks) {
            scene.device.break_reading(None);
            scene.device.break_drive(None);
            scene.tissue.break_it(None);
        }
        let mut command = command(kind.injection, since.filter(|_| on));
        // a latched fault must survive an early request to clear it, and must keep its reason when
        // the board reports another fault
        let ago = ended.map(|e| n - e);
        if ago.is_some_and(|a| matches!(a, 3 | 20)) {
            command.asked = Some(Ask::Clear);
        } else if ago == Some(6) {
            command.found = Some(Fault::SelfTestFailed);
        }
        for _ in 0..command.late_ticks {
            scene.step(&aim, last_n > 0.0);
        }
        let telemetry = scene.cycle(command);
        last_n = telemetry.applied_n.norm();
        last_mode = telemetry.mode;
        if last_n == 0.0 {
            forced_from = n + 1;
        }
        let touches = telemetry.output.depth_m > 0.0;
        touched_ticks += u32::from(touches);
        scene.step(&aim, touches || last_n > 0.0);
        if let Some(since) = since {
            outcome.peak_n = outcome.peak_n.max(last_n);
            if outcome.reaction_ticks.is_none() && reacted(&kind.expected, &telemetry) {
                // the limit is for one contact; what the energy alarm scales down needs no time
                let at_limit = telemetry.limiters.contains(ClampFlags::FORCE) && !telemetry.limiters.contains(ClampFlags::ENERGY);
                let saturated = matches!(kind.expected, Expected::Degraded(_)) && at_limit;
                outcome.reaction_ticks = Some(if saturated { (since + 1).min(n + 1 - forced_from) } else { since + 1 });
            }
            if matches!(kind.expected, Expected::Ramp(_)) && since >= RAMP_TICKS && last_n > RAMP_END_N {
                outcome.wrong = Some("the force did not end in its ramp");
            }
        }
        if ended.is_none() && telemetry.mode == Mode::Fault {
            (ended, outcome.fault) = (Some(n), telemetry.fault);
        }
        if ended.is_some_and(|e| n - e > AFTER_FAULT_TICKS) || since.is_some_and(|s| s > AFTER_TICKS) {
            break;
        }
    }
    outcome.wrong = outcome.wrong.or_else(|| verdict(case, &outcome, last_mode));
    outcome
}
