//! The loop closed over a device, a hand and a spring: raw it shakes the hand, damped by the tangent it does not.
//!
//! One axis. The plant runs in double precision at 100 kHz: 45 g and 0.1 N s/m of device, Coulomb friction or none, counts of 55 um, force held for
//! a tick and up to two ticks late; the hand's mass, damper and spring ride on it. The loop runs whole, armed and ramped in like a user's.

use palpate::haptic::cycle::{Ask, Command, Cycle, Renderer, Settings, Telemetry};
use palpate::haptic::damping::DampingSettings;
use palpate::haptic::device::{DeviceLimits, HapticDevice, Sensed, SensorStatus};
use palpate::haptic::mode::Mode;
use palpate::haptic::passivity::PassivitySettings;
use palpate::path::probe::ProbePose;
use palpate::{Fault, Output, Vector3};

const COUNT_M: f64 = 55e-6;
const TICK_S: f64 = 1e-3;
const PLANT_STEPS: u32 = 100;
const START_M: f64 = 5e-3;
const TARGET_M: f64 = -4e-3;
const TAP_M_PER_S: f64 = 0.2;
/// Friction of a desktop stylus [N].
const FRICTION_N: f64 = 0.03;

/// Mass [kg], damping [N s/m], stiffness [N/m] towards the hand's own target; constant push [N].
#[derive(Clone, Copy)]
struct Hand {
    mass_kg: f64,
    damping: f64,
    stiffness: f64,
    push_n: f64,
}

const RELEASED: Hand = Hand { mass_kg: 0.0, damping: 0.0, stiffness: 0.0, push_n: 0.5 };
const LIGHT_FINGER: Hand = Hand { mass_kg: 6e-3, damping: 1.0, stiffness: 200.0, push_n: 0.0 };
const FIRM_FINGER: Hand = Hand { mass_kg: 20e-3, damping: 4.0, stiffness: 800.0, push_n: 0.0 };
const ARM: Hand = Hand { mass_kg: 0.554, damping: 6.45, stiffness: 135.0, push_n: 0.0 };

/// A spring of known stiffness below z = 0.
struct Spring {
    n_per_m: f32,
}

impl Renderer for Spring {
    fn render(&mut self, pose: ProbePose) -> Output {
        let depth_m = -pose.tip_m.z;
        if depth_m <= 0.0 {
            return Output { point_m: pose.tip_m, ..Output::NONE };
        }
        Output { force_n: Vector3::z() * (self.n_per_m * depth_m), depth_m, normal: Vector3::z(), ..Output::NONE }
    }

    fn reset(&mut self) {}

    fn tangent_n_per_m(&self, output: &Output) -> f32 {
        if output.depth_m > 0.0 { self.n_per_m } else { 0.0 }
    }
}

/// Device and hand, one axis.
struct Plant {
    z_m: f64,
    v_m_per_s: f64,
    friction_n: f64,
    /// Forces on their way; the first acts.
    line_n: Vec<f64>,
    sequence: u32,
    /// Energy given to the hand since the touch, and the most of it [J].
    given_j: f64,
    created_j: f64,
}

impl Plant {
    fn new(delay: u8, friction_n: f64) -> Self {
        let line_n = vec![0.0; usize::from(delay) + 1];
        Self { z_m: START_M, v_m_per_s: 0.0, friction_n, line_n, sequence: 0, given_j: 0.0, created_j: 0.0 }
    }

    /// One tick under the force that acts in it.
    fn step(&mut self, hand: Hand, target_m: f64, target_m_per_s: f64) {
        let force_n = self.line_n[0];
        let mass_kg = 0.045 + hand.mass_kg;
        let dt = TICK_S / f64::from(PLANT_STEPS);
        let from_m = self.z_m;
        for _ in 0..PLANT_STEPS {
            let pull_n = hand.stiffness * (target_m - self.z_m) + hand.damping * (target_m_per_s - self.v_m_per_s) - hand.push_n;
            let free = self.v_m_per_s + dt / mass_kg * (force_n + pull_n - 0.1 * self.v_m_per_s);
            // friction takes speed away and ends at rest
            self.v_m_per_s = free.signum() * (free.abs() - dt / mass_kg * self.friction_n).max(0.0);
            self.z_m += dt * self.v_m_per_s;
        }
        self.given_j += force_n * (self.z_m - from_m);
        self.created_j = self.created_j.max(self.given_j);
    }
}

impl HapticDevice for Plant {
    fn limits(&self) -> DeviceLimits {
        DeviceLimits {
            max_force_n: 3.3,
            workspace_low_m: Vector3::repeat(-0.08),
            workspace_high_m: Vector3::repeat(0.08),
            count_m: COUNT_M as f32,
            delay_ticks: self.line_n.len() as u8 - 1,
        }
    }

    fn sense(&mut self) -> Sensed {
        self.sequence += 1;
        let counted_m = (self.z_m / COUNT_M).floor() * COUNT_M;
        Sensed { position_m: Vector3::new(0.0, 0.0, counted_m as f32), sequence: self.sequence, status: SensorStatus::Good }
    }

    fn actuate(&mut self, force_n: Vector3<f32>) {
        self.line_n.rotate_left(1);
        *self.line_n.last_mut().unwrap() = f64::from(force_n.z);
    }

    fn release(&mut self) {
        self.line_n.fill(0.0);
    }
}

/// What a run of three seconds showed.
#[derive(Debug)]
struct Run {
    /// Peak to peak of the true position in the last half second [m].
    swing_m: f64,
    /// RMS above 20 Hz of the applied force in the last half second [N].
    shake_n: f64,
    /// The swing grew over each of the last three windows of 100 ms, beyond a count.
    grows: bool,
    /// True energy created at the port [J].
    created_j: f64,
    /// What the loop's observer says [J].
    counted_j: f64,
    last: Telemetry,
}

impl Run {
    fn limit_cycle(&self) -> bool {
        assert_eq!(self.last.fault, None, "a loop that was stopped says nothing: {self:?}");
        self.swing_m > 2.0 * COUNT_M || self.shake_n > 0.02 || self.grows
    }
}

/// Second-order Butterworth high-pass at 20 Hz, sampled at 1 kHz.
fn high_pass(force_n: &[f64]) -> Vec<f64> {
    let w = (std::f64::consts::PI * 20.0 * TICK_S).tan();
    let norm = 1.0 / (1.0 + std::f64::consts::SQRT_2 * w + w * w);
    let (a1, a2) = (2.0 * (w * w - 1.0) * norm, (1.0 - std::f64::consts::SQRT_2 * w + w * w) * norm);
    let (mut x1, mut x2, mut y1, mut y2) = (force_n[0], force_n[0], 0.0, 0.0);
    let filter = |&x: &f64| {
        let y = norm * (x - 2.0 * x1 + x2) - a1 * y1 - a2 * y2;
        (x2, x1, y2, y1) = (x1, x, y1, y);
        y
    };
    force_n.iter().map(filter).collect()
}

/// Arms outside, then taps at 0.2 m/s and holds, `hand_at` the hand at a time.
fn tap(n_per_m: f32, delay: u8, friction_n: f64, settings: Settings, hand_at: impl Fn(f64) -> Hand) -> Run {
    let mut plant = Plant::new(delay, friction_n);
    let mut spring = Spring { n_per_m };
    let mut cycle = Cycle::build(&settings, &plant.limits()).unwrap();
    for asked in [Ask::Booted, Ask::TestPassed, Ask::Arm] {
        cycle.run(&mut plant, &mut spring, Command { asked: Some(asked), ..Command::HEARD });
    }
    // the hand keeps still while the loop arms and ramps in
    let mut last = (0..700).map(|_| cycle.run(&mut plant, &mut spring, Command::HEARD)).last().unwrap();
    assert_eq!((last.mode, last.applied_n), (Mode::Active, Vector3::zeros()));
    plant.v_m_per_s = -TAP_M_PER_S;

    let (mut z_m, mut force_n, mut counted_j) = (Vec::new(), Vec::new(), 0.0_f64);
    for n in 0..3000_u32 {
        let t = f64::from(n) * TICK_S;
        let way_m = START_M - TAP_M_PER_S * t;
        let (target_m, target_m_per_s) = if way_m > TARGET_M { (way_m, -TAP_M_PER_S) } else { (TARGET_M, 0.0) };
        last = cycle.run(&mut plant, &mut spring, Command::HEARD);
        if last.output.depth_m == 0.0 && last.applied_n == Vector3::zeros() && plant.line_n.iter().all(|f| *f == 0.0) {
            plant.given_j = 0.0; // the touch is yet to come
        }
        plant.step(hand_at(t), target_m, target_m_per_s);
        counted_j = counted_j.max(last.energy.created_j.into());
        z_m.push(plant.z_m);
        force_n.push(f64::from(last.applied_n.z));
    }
    let swing_m = |from: usize, to: usize| {
        let (low, high) = z_m[from..to].iter().fold((f64::MAX, f64::MIN), |(l, h), &z| (l.min(z), h.max(z)));
        high - low
    };
    let shaken = high_pass(&force_n);
    let windows = [2600, 2700, 2800, 2900].map(|from| swing_m(from, from + 100));
    Run {
        swing_m: swing_m(2500, 3000),
        shake_n: (shaken[2500..].iter().map(|f| f * f).sum::<f64>() / 500.0).sqrt(),
        grows: windows.windows(2).all(|w| w[1] > 1.01 * w[0]) && windows[3] > COUNT_M,
        created_j: plant.created_j,
        counted_j,
        last,
    }
}

/// The model's force as it is, and the last resort as late as it may be set.
fn raw(delay: u8) -> Settings {
    Settings { damping: DampingSettings::NONE, passivity: PassivitySettings::HIGHEST, ..Settings::safe(delay) }
}

#[test]
fn a_raw_spring_shakes_a_released_hand_far_below_400() {
    for (delay, n_per_m) in [(0, 850.0), (1, 160.0), (2, 80.0)] {
        let run = tap(n_per_m, delay, FRICTION_N, raw(delay), |_| RELEASED);
        assert!(run.limit_cycle(), "delay {delay}, {n_per_m} N/m: {run:?}");
        assert!(run.created_j > 0.5e-3, "delay {delay}: {run:?}");
    }
    let run = tap(400.0, 1, 0.0, raw(1), |_| LIGHT_FINGER);
    assert!(run.created_j > 0.5e-3, "stable and yet not passive: {run:?}");
}

#[test]
fn damped_by_the_tangent_400_n_per_m_is_quiet_in_every_hand() {
    for delay in [0, 1, 2] {
        for friction_n in [FRICTION_N, 0.0] {
            for (name, hand) in [("released", RELEASED), ("light", LIGHT_FINGER), ("firm", FIRM_FINGER), ("arm", ARM)] {
                let run = tap(400.0, delay, friction_n, Settings::safe(delay), |_| hand);
                assert!(!run.limit_cycle(), "{name}, delay {delay}, friction {friction_n} N: {run:?}");
                assert!(run.created_j <= 0.01e-3, "{name}, delay {delay}, friction {friction_n} N: {run:?}");
            }
            let grips = |t: f64| if t > 2.25 || (t * 4.0).fract() < 0.5 { LIGHT_FINGER } else { FIRM_FINGER };
            let run = tap(400.0, delay, friction_n, Settings::safe(delay), grips);
            assert!(!run.limit_cycle(), "changing grip, delay {delay}, friction {friction_n} N: {run:?}");
            assert!(run.created_j <= 0.01e-3, "changing grip, delay {delay}, friction {friction_n} N: {run:?}");
        }
    }
}

#[test]
fn damping_leaves_the_static_force_alone() {
    for hand in [RELEASED, LIGHT_FINGER, FIRM_FINGER] {
        let last = tap(400.0, 1, FRICTION_N, Settings::safe(1), |_| hand).last;
        assert!(last.output.force_n.z > 0.1, "{last:?}");
        assert_eq!(last.applied_n, last.output.force_n);
    }
}

#[test]
fn the_observer_sees_the_energy_that_the_plant_gets() {
    // counting fakes up to the longest force times one count
    for (n_per_m, delay) in [(100.0, 1), (160.0, 1), (80.0, 2)] {
        let run = tap(n_per_m, delay, FRICTION_N, raw(delay), |_| RELEASED);
        assert!(run.created_j > 0.3e-3, "{run:?}");
        assert!((run.created_j - run.counted_j).abs() < 3.0 * COUNT_M, "{n_per_m} N/m: {run:?}");
    }
}

#[test]
fn the_last_resort_ends_what_the_raw_spring_does() {
    for delay in [1, 2] {
        let settings = Settings { damping: DampingSettings::NONE, ..Settings::safe(delay) };
        let free = tap(400.0, delay, 0.0, raw(delay), |_| RELEASED);
        let watched = tap(400.0, delay, 0.0, settings, |_| RELEASED);
        assert!(free.created_j > 2e-3 && free.last.fault.is_none(), "{free:?}");
        assert!(watched.created_j < 0.5 * free.created_j, "{} J instead of {} J", watched.created_j, free.created_j);
        // contact after contact, or sunk through a spring that has faded: then it is a fault, and the hand is let go
        assert!(matches!(watched.last.fault, None | Some(Fault::EnergyCreated | Fault::ForceImplausible)), "{watched:?}");
        assert!(watched.last.fault.is_none() || watched.last.applied_n == Vector3::zeros());
    }
}
