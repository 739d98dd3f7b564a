//! A device with a hand on it, one axis, and what a run over it shows.
//!
//! The plant runs in double precision at 100 kHz: 45 g and 0.1 N s/m of device, Coulomb friction or none, counts of 55 um, force held for a tick and
//! up to two ticks late; the hand's mass, damper and spring ride on it.

use palpate::Vector3;
use palpate::haptic::cycle::{Ask, Command, Cycle, Renderer, Settings, Telemetry};
use palpate::haptic::device::{DeviceLimits, HapticDevice, Sensed, SensorStatus};
use palpate::haptic::mode::Mode;

pub const COUNT_M: f64 = 55e-6;
const TICK_S: f64 = 1e-3;
const PLANT_STEPS: u32 = 100;
const START_M: f64 = 5e-3;
const TARGET_M: f64 = -4e-3;
const TAP_M_PER_S: f64 = 0.2;
/// Friction of a desktop stylus [N].
pub const FRICTION_N: f64 = 0.03;

/// Mass [kg], damping [N s/m], stiffness [N/m] towards the hand's own target; constant push [N].
#[derive(Clone, Copy)]
pub struct Hand {
    pub mass_kg: f64,
    pub damping: f64,
    pub stiffness: f64,
    pub push_n: f64,
}

pub const RELEASED: Hand = Hand { mass_kg: 0.0, damping: 0.0, stiffness: 0.0, push_n: 0.5 };
pub const LIGHT_FINGER: Hand = Hand { mass_kg: 6e-3, damping: 1.0, stiffness: 200.0, push_n: 0.0 };
pub const FIRM_FINGER: Hand = Hand { mass_kg: 20e-3, damping: 4.0, stiffness: 800.0, push_n: 0.0 };
pub const ARM: Hand = Hand { mass_kg: 0.554, damping: 6.45, stiffness: 135.0, push_n: 0.0 };

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
pub struct Run {
    /// Peak to peak of the true position in the last half second [m].
    pub swing_m: f64,
    /// RMS above 20 Hz of the applied force in the last half second [N].
    pub shake_n: f64,
    /// The swing grew over each of the last three windows of 100 ms, beyond a count.
    pub grows: bool,
    /// True energy created at the port [J].
    pub created_j: f64,
    /// What the loop's observer says [J].
    pub counted_j: f64,
    pub last: Telemetry,
}

impl Run {
    pub fn limit_cycle(&self) -> bool {
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
pub fn tap(surface: &mut impl Renderer, delay: u8, friction_n: f64, settings: Settings, hand_at: impl Fn(f64) -> Hand) -> Run {
    let mut plant = Plant::new(delay, friction_n);
    let mut cycle = Cycle::build(&settings, &plant.limits()).unwrap();
    for asked in [Ask::Booted, Ask::TestPassed, Ask::Arm] {
        cycle.run(&mut plant, surface, Command { asked: Some(asked), ..Command::HEARD });
    }
    // the hand keeps still while the loop arms and ramps in
    let mut last = (0..700).map(|_| cycle.run(&mut plant, surface, Command::HEARD)).last().unwrap();
    assert_eq!((last.mode, last.applied_n), (Mode::Active, Vector3::zeros()));
    plant.v_m_per_s = -TAP_M_PER_S;

    let (mut z_m, mut force_n, mut counted_j) = (Vec::new(), Vec::new(), 0.0_f64);
    for n in 0..3000_u32 {
        let t = f64::from(n) * TICK_S;
        let way_m = START_M - TAP_M_PER_S * t;
        let (target_m, target_m_per_s) = if way_m > TARGET_M { (way_m, -TAP_M_PER_S) } else { (TARGET_M, 0.0) };
        last = cycle.run(&mut plant, surface, Command::HEARD);
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
