//! One run, judged from the true position and the force that acted.

use palpate::haptic::cycle::{Ask, Command, PatchRenderer, Settings, Telemetry};
use palpate::haptic::device::{DeviceSpec, HapticDevice, Sensed};
use palpate::haptic::mode::Mode;
use palpate::{BuildError, Fault, Model, Vector3};
use palpate_tissue::patch::Memory;
use palpate_tissue::scene::TICK_S;

use super::case::YieldingCase;
use super::ceiling::{Measured, stiffest_n_per_m};
use super::energy::{GivenEnergy, Ledger};
use super::felt::Felt;
use super::target::{HAND_M_PER_S, Target, WITHDRAW_M_PER_S};
use super::truth::{hand_m_per_s2, shake_n};
use crate::faults::paths::PathGround;
use palpate_loop::closed_loop::hand::{Grip, Hand};
use palpate_loop::closed_loop::plant::Plant;
use palpate_loop::closed_loop::rig::Rig;
use palpate_loop::closed_loop::watch::Broken;

/// Least force of the motors that counts as contact [N].
const ACTS_N: f64 = 1e-4;
/// Energy above which a hand owes what it was given [J]: the most that a contact may create.
const OWES_J: f64 = 0.1e-3;
/// Speed limit of a hand that shakes on purpose [m/s]: none but its acceleration.
const ANY_M_PER_S: f64 = 100.0;

/// Durations of a run [s].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunLength {
    /// Duration of the motion.
    pub motion_s: f64,
    /// After a fault: time for which the fault is cleared, the loop armed and the motion repeated.
    pub again_s: f64,
}

impl RunLength {
    /// The length of campaigns.
    pub const FULL: Self = Self { motion_s: 6.0, again_s: 10.0 };
    /// A short form, for tests and `--quick`.
    pub const QUICK: Self = Self { motion_s: 3.0, again_s: 3.0 };
    /// A minute.
    pub const LONG: Self = Self { motion_s: 60.0, again_s: 10.0 };
}

/// Result of a run.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// Energy that the hand was given.
    pub given: GivenEnergy,
    /// Force that it felt.
    pub felt: Felt,
    /// Force above 15 Hz in the worst window of two seconds, in slow motions, after the press [N].
    pub shake_n: f64,
    /// First fault.
    pub fault: Option<Fault>,
    /// Number of faults: each was cleared, and the loop armed again.
    pub faults: u32,
    /// Largest acceleration of the tip that the forces of the motors do not explain [m/s^2].
    pub hand_m_per_s2: f64,
    /// Invariants of loop and port that were broken, each once.
    pub broken: Vec<Broken>,
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

impl YieldingCase {
    /// Runs the case; `change` may change the loop's settings.
    pub fn run(&self, ground: &PathGround, length: RunLength, change: impl Fn(&mut Settings)) -> Result<Outcome, BuildError> {
        self.follow(ground, length, change, |_| ())
    }

    /// Runs the case like [`Self::run`]; `see` is called for every tick.
    pub fn follow(
        &self,
        ground: &PathGround,
        length: RunLength,
        change: impl Fn(&mut Settings),
        mut see: impl FnMut(&Seen),
    ) -> Result<Outcome, BuildError> {
        let on = &ground.patches[self.patch];
        let model = on.patch.wide_model();
        let guard_m = on.guard_depth_m(f64::from(self.params.youngs_modulus_pa), self.device.force_limit_n) as f32;
        let model = Model { depth_limit_m: guard_m.min(model.depth_limit_m), ..model };
        let mut memory = Memory::for_model(&model);
        let (tuned, mut state) = memory.start(&model, &self.params)?;
        let patch = PatchRenderer { model: &model, tuned: &tuned, state: &mut state };
        let stiffness_n_per_m = if self.uncapped { 0.0 } else { stiffest_n_per_m(on, &self.params, f64::from(guard_m)) };
        let mut renderer = Measured { patch, stiffness_n_per_m };

        let start_m = self.motion.target_m(&on.site, 0.0, length.motion_s);
        let hand = Hand { id: "HY", name: "yielding", grip: Grip::Firm(self.hand) };
        let mut plant = Plant::new(&self.device, hand, on.site.at_m.cast(), on.site.normal.cast(), start_m);
        let limits = plant.limits();
        let mut settings = Settings { limits: self.device.limit_values(), ..Settings::safe(&limits) };
        // what is printed, whatever the settings are changed to
        let mut ledger = Ledger::new(self.bound(&settings.account));
        change(&mut settings);
        let mut rig = Rig::build(&settings, &limits)?.at_port(on.shape.clone(), &limits);
        rig.arm(&mut plant, &mut renderer, &mut (), |_, plant| plant.rest());

        let mut outcome = Outcome::default();
        let (mut target, mut motion_ticks, mut mode) = (Target { at_m: start_m }, 0, Mode::Active);
        let most_m_per_s = if self.motion.shake_m_per_s2 > 0.0 { ANY_M_PER_S } else { HAND_M_PER_S };
        let length_ticks = ticks(length.motion_s);
        let mut force_n = Vec::with_capacity(length_ticks);
        let (mut tick, mut end, mut reading) = (0, length_ticks, None);
        while tick < end {
            let asked = match mode {
                Mode::Fault => Some(Ask::Clear),
                Mode::Idle => Some(Ask::Arm),
                _ => None,
            };
            let found = falls_on(tick, self.stop_ticks).then_some(Fault::EmergencyStop);
            let repeats = falls_on(tick, self.missing_ticks);
            let mut port = Port { plant: &mut plant, last: &mut reading, repeats };
            let telemetry = rig.tick(&mut port, &mut renderer, Command { asked, found, ..Command::HEARD });
            let from_m_per_s = plant.velocity_m_per_s();
            let aim = if matches!(mode, Mode::Active | Mode::Degraded | Mode::SafeRamp) {
                motion_ticks = (motion_ticks + 1) % length_ticks;
                target.follow(
                    &self.motion.target_m(&on.site, f64::from(motion_ticks as u32) * TICK_S, length.motion_s),
                    most_m_per_s,
                )
            } else {
                motion_ticks = 0;
                target.follow(&start_m, WITHDRAW_M_PER_S)
            };
            plant.step(&aim, true);
            outcome.hand_m_per_s2 = outcome.hand_m_per_s2.max(hand_m_per_s2(&from_m_per_s, &plant, self));
            rig.acted(&plant.truth());
            let acting_n = plant.acting_n();
            // contact is what the geometry at rest tells, or any force
            let acts = acting_n.norm() > ACTS_N || telemetry.applied_n != Vector3::zeros();
            ledger.tick(plant.energy().given_j, acts || on.shape_touches(&plant.at_m()));
            outcome.felt.tick(&telemetry, rig.cycle().limits(), ledger.owed_j() > OWES_J);
            see(&Seen { t_s: f64::from(tick as u32) * TICK_S, at_m: plant.at_m(), acting_n, given_j: ledger.now_j(), telemetry });
            if telemetry.mode == Mode::Fault && mode != Mode::Fault {
                if outcome.fault.is_none() {
                    end = tick + ticks(length.again_s);
                }
                outcome.fault = outcome.fault.or(telemetry.fault);
                outcome.faults += 1;
            }
            if outcome.fault.is_none() {
                force_n.push(acting_n);
            }
            mode = telemetry.mode;
            tick += 1;
        }
        outcome.given = ledger.close();
        outcome.broken = rig.broken().iter().map(|(broken, _)| *broken).collect();
        if self.motion.kind.is_slow() {
            outcome.shake_n = shake_n(&force_n, ticks(self.motion.press_s));
        }
        Ok(outcome)
    }
}

/// A device whose reading may be the last one again.
struct Port<'a> {
    plant: &'a mut Plant,
    last: &'a mut Option<Sensed>,
    repeats: bool,
}

impl HapticDevice for Port<'_> {
    fn limits(&self) -> DeviceSpec {
        self.plant.limits()
    }

    fn sense(&mut self) -> Sensed {
        match *self.last {
            Some(last) if self.repeats => last,
            _ => *self.last.insert(self.plant.sense()),
        }
    }

    fn actuate(&mut self, force_n: Vector3<f32>) {
        self.plant.actuate(force_n);
    }

    fn release(&mut self) {
        self.plant.release();
    }
}

/// Whether something that happens every so many ticks, if ever, happens in this one.
fn falls_on(tick: usize, every: usize) -> bool {
    every > 0 && tick % every == every - 1
}

fn ticks(seconds: f64) -> usize {
    (seconds / TICK_S).round() as usize
}
