//! A device with a hand on it, in double precision and small steps: the plant of the loop, with the
//! quantities that the loop cannot measure.
//!
//! The handle is one mass along three axes (or one), with viscous and Coulomb friction, a hard stop
//! at the workspace, forces held for a tick, delayed by whole ticks and smoothed by the amplifier;
//! readings are quantised. Energy is the work of the true force along the true displacement.

use palpate::Vector3;
use palpate::haptic::device::{DeviceSpec, HapticDevice, Sensed, SensorStatus};

use super::device::DeviceProfile;
use super::hand::{Aim, Hand, HandState};
use super::watch::Truth;
use palpate_tissue::scene::TICK_S;

/// Number of steps of the plant per tick: it runs at 50 kHz.
const STEPS: u32 = 50;

/// Energy at the port between device and hand, contact by contact.
#[derive(Clone, Copy, Debug, Default)]
pub struct PortEnergy {
    /// Given to the hand since the touch [J]; negative while the tissue stores energy.
    pub given_j: f64,
    /// Largest value of `given_j` so far in this contact, at least zero: the energy created [J].
    pub created_j: f64,
    /// Energy created by the worst contact [J].
    pub worst_j: f64,
    /// Largest energy that the tissue absorbed in any contact [J].
    pub taken_j: f64,
}

impl PortEnergy {
    fn add(&mut self, work_j: f64) {
        self.given_j += work_j;
        self.created_j = self.created_j.max(self.given_j);
        self.worst_j = self.worst_j.max(self.created_j);
        self.taken_j = self.taken_j.max(-self.given_j);
    }

    fn leave(&mut self) {
        (self.given_j, self.created_j) = (0.0, 0.0);
    }
}

/// A device and the hand that holds it.
#[derive(Clone, Debug)]
pub struct Plant {
    device: DeviceProfile,
    limits: DeviceSpec,
    hand: HandState,
    normal: Vector3<f64>,
    /// Position [m] and velocity [m/s] of the handle.
    at_m: Vector3<f64>,
    velocity_m_per_s: Vector3<f64>,
    /// Forces not yet at the amplifier [N], the oldest first.
    line_n: Vec<Vector3<f64>>,
    /// Force of the motors [N].
    acting_n: Vector3<f64>,
    sequence: u32,
    t_s: f64,
    energy: PortEnergy,
    /// Work of the motors' force in the last tick [J], and this force summed over its steps [N].
    work_j: f64,
    sum_n: Vector3<f64>,
}

impl Plant {
    /// Creates a plant with the handle at rest at `start_m`, outside the tissue whose outward
    /// normal at `site_m` is `normal`.
    #[must_use]
    pub fn new(device: &DeviceProfile, hand: Hand, site_m: Vector3<f32>, normal: Vector3<f32>, start_m: Vector3<f64>) -> Self {
        Self {
            limits: device.limits(site_m),
            device: device.clone(),
            hand: HandState::new(hand, normal.cast()),
            normal: normal.cast(),
            at_m: start_m,
            velocity_m_per_s: Vector3::zeros(),
            line_n: vec![Vector3::zeros(); usize::from(device.delay_ticks) + 1],
            acting_n: Vector3::zeros(),
            sequence: 0,
            t_s: 0.0,
            energy: PortEnergy::default(),
            work_j: 0.0,
            sum_n: Vector3::zeros(),
        }
    }

    /// Position of the handle [m].
    #[must_use]
    pub fn at_m(&self) -> Vector3<f64> {
        self.at_m
    }

    /// Velocity of the handle [m/s].
    #[must_use]
    pub fn velocity_m_per_s(&self) -> Vector3<f64> {
        self.velocity_m_per_s
    }

    /// Sets the velocity [m/s], for a hand that approaches at a speed.
    pub fn set_velocity_m_per_s(&mut self, velocity_m_per_s: Vector3<f64>) {
        self.velocity_m_per_s = velocity_m_per_s;
    }

    /// Moves the handle to a position [m], at rest.
    pub fn put(&mut self, at_m: Vector3<f64>) {
        (self.at_m, self.velocity_m_per_s) = (at_m, Vector3::zeros());
    }

    /// Returns the device profile, mutable: friction and lag may change during a run.
    pub fn device_mut(&mut self) -> &mut DeviceProfile {
        &mut self.device
    }

    /// Force of the motors at the end of the last tick [N].
    #[must_use]
    pub fn acting_n(&self) -> Vector3<f64> {
        self.acting_n
    }

    /// Energy at the port between device and hand.
    #[must_use]
    pub fn energy(&self) -> PortEnergy {
        self.energy
    }

    /// Motion and force at the port in the last tick.
    #[must_use]
    pub fn truth(&self) -> Truth {
        Truth { at_m: self.at_m, mean_n: self.sum_n / f64::from(STEPS), work_j: self.work_j }
    }

    /// Sets the velocity of the handle to zero, for ticks in which it is held still.
    pub fn rest(&mut self) {
        self.velocity_m_per_s = Vector3::zeros();
    }

    /// Runs one tick. `touched` says whether the loop is in contact. When it is not, and no
    /// delayed force is left, the contact is over.
    pub fn step(&mut self, aim: &Aim, touched: bool) {
        if !touched && self.line_n.iter().all(|f| *f == Vector3::zeros()) && self.acting_n.norm() < 1e-4 {
            self.energy.leave();
        }
        (self.work_j, self.sum_n) = (0.0, Vector3::zeros());
        let dt_s = TICK_S / f64::from(STEPS);
        let lag = match self.device.amplifier_lag_s {
            lag_s if lag_s > 0.0 => 1.0 - (-dt_s / lag_s).exp(),
            _ => 1.0,
        };
        let asked_n = self.line_n.first().copied().unwrap_or_default();
        let workspace_m = [self.limits.workspace_low_m, self.limits.workspace_high_m].map(|corner_m| corner_m.cast());
        // values that depend on the mass are recomputed only when the mass of the hand changes
        let (mut moved_kg, mut per_force, mut friction_m_per_s) = (f64::NAN, 0.0, 0.0);
        for step in 0..STEPS {
            self.acting_n += (asked_n - self.acting_n) * lag;
            self.sum_n += self.acting_n;
            let t_s = self.t_s + f64::from(step) * dt_s;
            let hand_n = self.hand.force_n(aim, &self.at_m, &self.velocity_m_per_s, t_s, dt_s);
            let mass_kg = self.device.mass_kg + self.hand.mass_kg(aim, t_s);
            let viscous_n = self.velocity_m_per_s * self.device.damping_n_s_per_m;
            if mass_kg != moved_kg {
                (moved_kg, per_force, friction_m_per_s) = (mass_kg, dt_s / mass_kg, self.device.friction_n * dt_s / mass_kg);
            }
            let mut velocity = self.velocity_m_per_s + (self.acting_n + hand_n - viscous_n) * per_force;
            // friction reduces the speed, at most to zero
            let speed = velocity.norm();
            let slower = (speed - friction_m_per_s).max(0.0);
            velocity = if speed > 0.0 { velocity * (slower / speed) } else { velocity };
            if self.device.axes == 1 {
                velocity = self.normal * velocity.dot(&self.normal);
            }
            let displacement_m = self.stopped(&workspace_m, &mut velocity, dt_s);
            self.velocity_m_per_s = velocity;
            self.at_m += displacement_m;
            let work_j = self.acting_n.dot(&displacement_m);
            self.work_j += work_j;
            self.energy.add(work_j);
        }
        self.t_s += TICK_S;
    }

    /// Displacement of a step, limited by the hard stop at the lower and upper corners of the
    /// workspace.
    fn stopped(&self, [low_m, high_m]: &[Vector3<f64>; 2], velocity: &mut Vector3<f64>, dt_s: f64) -> Vector3<f64> {
        let mut displacement_m = *velocity * dt_s;
        for axis in 0..3 {
            let (low, high) = (low_m[axis], high_m[axis]);
            let next = self.at_m[axis] + displacement_m[axis];
            if next < low || next > high {
                displacement_m[axis] = next.clamp(low, high) - self.at_m[axis];
                velocity[axis] = 0.0;
            }
        }
        displacement_m
    }
}

impl HapticDevice for Plant {
    fn limits(&self) -> DeviceSpec {
        self.limits
    }

    fn sense(&mut self) -> Sensed {
        self.sequence = self.sequence.wrapping_add(1);
        let count_m = self.device.count_m;
        let counted = |x: f64| if count_m > 0.0 { (x / count_m).floor() * count_m } else { x };
        Sensed { position_m: self.at_m.map(counted).cast(), sequence: self.sequence, status: SensorStatus::Good }
    }

    fn actuate(&mut self, force_n: Vector3<f32>) {
        self.line_n.rotate_left(1);
        if let Some(newest) = self.line_n.last_mut() {
            *newest = force_n.cast();
        }
    }

    /// Cuts the motors' power: delayed forces do not arrive, and the amplifier's lag sustains no
    /// force.
    fn release(&mut self) {
        self.line_n.fill(Vector3::zeros());
        self.acting_n = Vector3::zeros();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed_loop::hand::HANDS;

    fn plant(friction_n: f64, lag_s: f64) -> Plant {
        let device = DeviceProfile { friction_n, amplifier_lag_s: lag_s, ..DeviceProfile::load("touch").unwrap() };
        Plant::new(&device, HANDS[0], Vector3::zeros(), Vector3::z(), Vector3::zeros())
    }

    fn aim(push_n: Vector3<f64>) -> Aim {
        Aim { at_m: Vector3::zeros(), velocity_m_per_s: Vector3::zeros(), push_n, let_go: false, steady: true }
    }

    #[test]
    fn a_free_handle_follows_newton_and_its_friction_and_gets_its_work() {
        let mut plant = plant(0.03, 0.0);
        let push = Vector3::new(0.06, 0.0, 0.08);
        for _ in 0..100 {
            plant.step(&aim(push), true);
        }
        // m v' = F - Fc - b v, closed form
        let (m, b, f) = (0.045, 0.1, 0.1 - 0.03);
        let speed = f / b * (1.0 - (-b / m * 0.1_f64).exp());
        assert!((plant.velocity_m_per_s().norm() / speed - 1.0).abs() < 1e-3);
        assert!(plant.velocity_m_per_s().cross(&push).norm() < 1e-12, "friction acts against the velocity, not per axis");
        let still = {
            let mut p = self::plant(0.03, 0.0);
            p.step(&aim(Vector3::x() * 0.029), true);
            p
        };
        assert_eq!(still.velocity_m_per_s(), Vector3::zeros(), "less than friction moves nothing");
    }

    #[test]
    fn a_force_arrives_late_by_its_ticks_and_its_lag_and_its_work_is_counted() {
        let mut plant = plant(0.0, 2e-3);
        plant.set_velocity_m_per_s(Vector3::z() * 0.1);
        let mut work_j = 0.0;
        for tick in 0..20 {
            plant.actuate(Vector3::z());
            let before = plant.at_m();
            plant.step(&aim(Vector3::zeros()), true);
            let acting = plant.acting_n().z;
            // one tick of delay, then held: the amplifier receives it from the second tick on
            let seen_s = (f64::from(tick) - 0.0) * 1e-3;
            assert!((acting - (1.0 - (-seen_s / 2e-3_f64).exp())).abs() < 1e-9, "tick {tick}: {acting} N");
            work_j += (plant.at_m() - before).z * acting;
        }
        assert!((plant.energy().given_j / work_j - 1.0).abs() < 0.1);
        plant.release();
        assert_eq!(plant.acting_n(), Vector3::zeros());
    }

    #[test]
    fn readings_are_counts_and_the_stop_is_hard() {
        let mut plant = plant(0.0, 0.0);
        for _ in 0..2000 {
            plant.step(&aim(Vector3::new(0.3, -0.2, 0.1)), false);
        }
        assert!((plant.at_m() - Vector3::new(0.08, -0.06, 0.06)).norm() < 1e-8, "{}", plant.at_m());
        let counts = plant.sense().position_m / 55e-6;
        assert!(counts.iter().all(|c| (c - c.round()).abs() < 1e-3));
    }
}
