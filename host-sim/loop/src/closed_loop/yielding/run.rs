//! One run, judged from the true position and the force that acted.

use palpate::haptic::cycle::{Ask, Command, Cycle, PatchRenderer, Settings, Telemetry};
use palpate::{BuildError, ClampFlags, Fault, Model, Vector3};
use palpate_tissue::patch::Memory;
use palpate_tissue::scene::TICK_S;

use super::case::YieldingCase;
use crate::closed_loop::hand::{Aim, Grip, Hand};
use crate::closed_loop::paths::PathGround;
use crate::closed_loop::plant::Plant;
use crate::closed_loop::run::ARMING_TICKS;
use crate::closed_loop::stimulus::CLEAR_M;
use crate::closed_loop::watch::{Broken, PortWatch};

/// Force of the patch from which a loss counts [N].
const FELT_N: f32 = 0.1;
/// Ticks in a row with less than half of the force that are a loss.
const LOST_TICKS: u32 = 20;
/// Time that a swing after the press may take to die out [s].
const SETTLED_S: f64 = 1.0;
/// Window of the vibration [s].
const WINDOW_TICKS: usize = 2000;

/// Result of a run.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// Energy created in each contact [J].
    pub contacts_j: Vec<f64>,
    /// Largest energy given since any instant without contact [J].
    pub most_j: f64,
    /// Energy given in all [J].
    pub given_j: f64,
    /// Ticks in which the patch asked for a force that is felt.
    pub asked_ticks: u32,
    /// Ticks in which more than half of it was lost for more than 20 ticks.
    pub lost_ticks: u32,
    /// Those among them that the account did not flag.
    pub silent_ticks: u32,
    /// Impulse of the patch's push up to the limit, and of the push that was applied [N s].
    pub asked_n_s: f64,
    /// See `asked_n_s`.
    pub felt_n_s: f64,
    /// Force above 15 Hz in the worst window of two seconds [N].
    pub shake_n: f64,
    /// Fault that ended the run.
    pub fault: Option<Fault>,
    /// Largest force [N].
    pub peak_n: f32,
    /// Invariants of the port that were broken, each once.
    pub broken: Vec<Broken>,
}

impl Outcome {
    fn note(&mut self, answer: Result<(), Broken>) {
        if let Err(broken) = answer
            && !self.broken.contains(&broken)
        {
            self.broken.push(broken);
        }
    }
}

/// One tick of a run, for closer inspection.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// Time [s].
    pub t_s: f64,
    /// Position of the tip [m].
    pub at_m: Vector3<f64>,
    /// Force that acts at the end of the tick [N].
    pub acting_n: Vector3<f64>,
    /// Energy given so far [J].
    pub given_j: f64,
    /// The loop's record.
    pub telemetry: Telemetry,
}

struct Scaled<R> {
    inner: R,
    gain: f32,
}

impl<R: palpate::haptic::cycle::Renderer> palpate::haptic::cycle::Renderer for Scaled<R> {
    fn render(&mut self, pose: palpate::ProbePose) -> palpate::Output {
        let o = self.inner.render(pose);
        palpate::Output { force_n: o.force_n * self.gain, grip_n: o.grip_n * self.gain, ..o }
    }
    fn reset(&mut self) {
        self.inner.reset();
    }
}

impl YieldingCase {
    /// Runs the case for `seconds`; `see` is called for every tick.
    ///
    /// # Errors
    /// The loop or the patch refuses its settings.
    pub fn follow(
        &self,
        ground: &PathGround,
        seconds: f64,
        change: impl Fn(&mut Settings),
        mut see: impl FnMut(&Seen),
    ) -> Result<Outcome, BuildError> {
        let on = &ground.patches[self.patch];
        let e = f64::from(self.params.youngs_modulus_pa);
        let model = on.patch.wide_model();
        let guard_m = on.guard_depth_m(e, self.device.force_limit_n) as f32;
        let model = Model { depth_limit_m: guard_m.min(model.depth_limit_m), ..model };
        let mut memory = Memory::for_model(&model);
        let (tuned, mut state) = memory.start(&model, &self.params)?;
        let slope = |d: f64| (on.force_n(e, d) - on.force_n(e, d - 0.25e-3)) / 0.25e-3;
        let stiffness = (1..100).map(|n| slope(f64::from(guard_m) * f64::from(n) * 0.01)).fold(1.0, f64::max);
        let ceiling = self.device.stiffness_ceiling_n_per_m.min(0.06 / self.device.count_m.max(1e-9));
        let gain = (ceiling / stiffness).min(1.0) as f32;
        let mut renderer = Scaled { inner: PatchRenderer { model: &model, tuned: &tuned, state: &mut state }, gain };

        let site = on.site;
        let start_m = self.motion.target_m(&site, 0.0, seconds);
        let hand = Hand { id: "HY", name: "yielding", grip: Grip::Firm(self.hand) };
        let mut plant = Plant::new(&self.device, hand, site.at_m.cast(), site.normal.cast(), start_m);
        let limits = palpate::haptic::device::HapticDevice::limits(&plant);
        let mut port = PortWatch::over(on.shape.clone(), &limits);
        let mut settings = Settings { limits: self.device.limit_values(), ..Settings::safe(&limits) };
        change(&mut settings);
        let mut cycle = Cycle::build(&settings, &limits)?;
        for n in 0..ARMING_TICKS {
            let asked = [Ask::Booted, Ask::TestPassed, Ask::Arm].get(n as usize).copied();
            cycle.tick(&mut plant, &mut renderer, Command { asked, ..Command::HEARD });
            plant.rest();
        }

        let mut outcome = Outcome::default();
        let ticks = (seconds / TICK_S) as usize;
        let mut force_n = Vec::with_capacity(ticks);
        let (mut last_m, mut low_j, mut given_j) = (start_m, 0.0_f64, 0.0_f64);
        let (mut contact_from_j, mut contact_j, mut free, mut lost) = (0.0_f64, 0.0_f64, u32::MAX, 0_u32);
        for n in 0..ticks {
            let t_s = n as f64 * TICK_S;
            let telemetry = cycle.tick(&mut plant, &mut renderer, Command::HEARD);
            let (from_m, to_m) = (self.motion.target_m(&site, t_s, seconds), self.motion.target_m(&site, t_s + TICK_S, seconds));
            let aim = Aim {
                at_m: from_m,
                velocity_m_per_s: (to_m - from_m) / TICK_S,
                push_n: Vector3::zeros(),
                let_go: false,
                steady: false,
            };
            plant.step(&aim, true);
            outcome.note(port.check(&plant.truth()));
            given_j = plant.energy().given_j;
            let acting_n = plant.acting_n();
            see(&Seen { t_s, at_m: plant.at_m(), acting_n, given_j, telemetry });
            // contact as the geometry has it, or a force
            let touches = on.shape_touches(&plant.at_m()) || acting_n.norm() > 1e-4 || telemetry.applied_n.norm() > 0.0;
            if touches {
                if free >= 20 {
                    (contact_from_j, contact_j) = (given_j, 0.0);
                }
                free = 0;
                contact_j = contact_j.max(given_j - contact_from_j);
                outcome.most_j = outcome.most_j.max(given_j - low_j);
            } else {
                free = free.saturating_add(1);
                low_j = low_j.min(given_j);
                if free == 20 {
                    outcome.contacts_j.push(contact_j);
                }
            }
            let patch_n = telemetry.output.force_n;
            let normal = telemetry.output.normal;
            let limit_n = cycle.limits().max_force_n;
            let push_n = patch_n.dot(&normal).min(limit_n);
            let wanted_n = telemetry.wanted_n.dot(&normal).min(limit_n);
            let felt_n = telemetry.applied_n.dot(&normal);
            outcome.peak_n = outcome.peak_n.max(telemetry.applied_n.norm());
            if push_n > 0.0 {
                outcome.asked_n_s += f64::from(push_n) * TICK_S;
                outcome.felt_n_s += f64::from(felt_n) * TICK_S;
            }
            if push_n > FELT_N {
                outcome.asked_ticks += 1;
                if felt_n < 0.5 * wanted_n {
                    lost += 1;
                    if lost > LOST_TICKS {
                        outcome.lost_ticks += 1;
                        outcome.silent_ticks += u32::from(!telemetry.limiters.contains(ClampFlags::ENERGY));
                    }
                } else {
                    lost = 0;
                }
            }
            force_n.push(acting_n);
            last_m = plant.at_m();
            if telemetry.fault.is_some() {
                outcome.fault = telemetry.fault;
                break;
            }
        }
        let _ = (last_m, CLEAR_M);
        outcome.contacts_j.push(contact_j);
        outcome.given_j = given_j;
        if self.motion.kind.is_slow() {
            let from = ((self.motion.press_s + SETTLED_S) / TICK_S) as usize;
            let to = force_n.len().saturating_sub(700);
            if to > from + 500 {
                let window = WINDOW_TICKS.min(to - from);
                outcome.shake_n = (from..=to - window)
                    .step_by(250)
                    .map(|start| crate::closed_loop::verdict::rms_above(&force_n[..start + window], 15.0, start))
                    .fold(0.0, f64::max);
            }
        }
        Ok(outcome)
    }
}
