//! A run, and what its genes mean.

use palpate::haptic::account::{AccountSettings, EnergyAccount, EnergyBound};
use palpate::{Params, PronyTerm, Vector3};
use palpate_tissue::finger::Impedance;
use palpate_tissue::scene::TICK_S;

use super::genes::{Genes, Reader};
use super::motion::{Motion, MotionKind};
use crate::faults::paths::{PathGround, PathPatch};
use palpate_loop::closed_loop::device::DeviceProfile;

/// Time constant of the relaxation that is drawn [s].
const RELAXES_S: f32 = 0.05;
/// Actuators give this multiple of the force limit (1).
const MOTOR_SHARE: f64 = 1.1;
/// Largest acceleration of shaking on purpose [m/s^2], and its slowest and fastest frequency [Hz].
const SHAKE_M_PER_S2: f64 = 200.0;
const SHAKE_HZ: [f64; 2] = [2.0, 200.0];
/// Largest factor on the stiffness of a hand that shakes on purpose (1): it moves the handle almost
/// as it likes.
const STIFFER: f64 = 50.0;

/// Fewest and most ticks from one reading that is missing to the next, and from one press of the
/// stop button to the next: one reading in 21 is no fault, and arming takes 0.6 s.
const MISSING_TICKS: [f64; 2] = [21.0, 60.0];
const STOP_TICKS: [f64; 2] = [700.0, 2000.0];

/// Behaviour that a hand may show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bounds {
    /// Behaviour of a person.
    Person,
    /// Also shaking with up to 200 m/s^2, by a hand that is stiffer than any, with readings that
    /// are missing and a stop that is pressed in step with it.
    Hand,
}

/// One run: device, hand, tissue and motion.
#[derive(Clone, Debug)]
pub struct YieldingCase {
    /// Name of the device, if it is a shipped one.
    pub shipped: Option<&'static str>,
    /// Whether the loop renders the patch as stiff as it is, whatever the device's ceiling.
    pub uncapped: bool,
    /// Index into the ground's patches.
    pub patch: usize,
    /// Tissue.
    pub params: Params,
    /// Device.
    pub device: DeviceProfile,
    /// Hand.
    pub hand: Impedance,
    /// Behaviour of the hand.
    pub motion: Motion,
    /// Ticks from one missing reading to the next, and from one press of the stop button to the
    /// next; zero for none.
    pub missing_ticks: usize,
    /// See `missing_ticks`.
    pub stop_ticks: usize,
}

impl YieldingCase {
    /// The run that these genes describe, on a device that they describe too. What they do not
    /// describe is taken from `base`.
    pub fn of(ground: &PathGround, genes: &Genes, base: &DeviceProfile, bounds: Bounds) -> Self {
        let mut genes = genes.reader();
        let device = device(&mut genes, base);
        Self::on(ground, &mut genes, device, bounds)
    }

    /// The run that these genes describe, on this device.
    pub fn on_device(ground: &PathGround, genes: &Genes, profile: &DeviceProfile, name: &'static str) -> Self {
        let mut genes = genes.reader();
        device(&mut genes, profile);
        Self { shipped: Some(name), ..Self::on(ground, &mut genes, profile.clone(), Bounds::Person) }
    }

    fn on(ground: &PathGround, genes: &mut Reader, device: DeviceProfile, bounds: Bounds) -> Self {
        let shares: u32 = ground.patches.iter().map(|p| p.share).sum();
        let mut left = genes.share() * f64::from(shares);
        let drawn = |p: &PathPatch| {
            left -= f64::from(p.share);
            left <= 0.0
        };
        let patch = ground.patches.iter().position(drawn).unwrap_or_default();
        let on = &ground.patches[patch];
        let youngs_modulus_pa = genes.by_factor(1e3, 100e3);
        let (relaxing, friction) = (genes.or_zero(0.6, 0.1, 0.6) as f32, genes.or_zero(0.6, 0.05, 0.5) as f32);
        let relaxation = match relaxing > 0.0 {
            true => [PronyTerm { share: relaxing, time_s: RELAXES_S }, PronyTerm::NONE, PronyTerm::NONE],
            false => on.params.relaxation,
        };
        let params = Params { youngs_modulus_pa: youngs_modulus_pa as f32, relaxation, friction, ..on.params };
        let mut hand = hand(genes, &device);
        let mut motion = motion(genes, on, youngs_modulus_pa, device.force_limit_n, &hand);
        let (mut missing_ticks, mut stop_ticks) = (0, 0);
        if bounds == Bounds::Hand {
            motion.shake_m_per_s2 = genes.or_zero(0.3, 1.0, SHAKE_M_PER_S2);
            motion.shake_hz = genes.by_factor(SHAKE_HZ[0], SHAKE_HZ[1]);
            let stiffer = genes.by_factor(1.0, STIFFER);
            hand.stiffness_n_per_m *= stiffer;
            hand.damping_n_s_per_m *= stiffer.sqrt();
            missing_ticks = genes.or_zero(0.5, MISSING_TICKS[0], MISSING_TICKS[1]) as usize;
            stop_ticks = genes.or_zero(0.7, STOP_TICKS[0], STOP_TICKS[1]) as usize;
        }
        Self { shipped: None, uncapped: false, patch, params, device, hand, motion, missing_ticks, stop_ticks }
    }

    /// The printed bound for the case's device.
    pub fn bound(&self, account: &AccountSettings) -> EnergyBound {
        EnergyAccount::bound(account, &self.device.limits(Vector3::zeros()), TICK_S as f32, 0)
    }

    /// The case in one line.
    pub fn in_words(&self, ground: &PathGround) -> String {
        let Self { device, hand, motion, params, .. } = self;
        format!(
            "{} of {:.1} mm deep in {:.2} s, {}, {:.1} kPa, friction {:.2}; {}: count {:.0} um, delay {}, lag {:.1} ms, {:.1} N, handle {:.0} g, ceiling {:.0} N/m; hand {:.0} g, {:.0} N/m, {:.2} N s/m, tremor {:.0} um, shaken {:.0} m/s^2 at {:.0} Hz, a reading missing every {} ticks, stopped every {} (0: never)",
            motion.kind.name(),
            motion.depth_m * 1e3,
            motion.press_s,
            ground.patches[self.patch].label(),
            params.youngs_modulus_pa * 1e-3,
            params.friction,
            self.shipped.unwrap_or("device"),
            device.count_m * 1e6,
            device.delay_ticks,
            device.amplifier_lag_s * 1e3,
            device.force_limit_n,
            device.mass_kg * 1e3,
            device.stiffness_ceiling_n_per_m,
            hand.mass_kg * 1e3,
            hand.stiffness_n_per_m,
            hand.damping_n_s_per_m,
            motion.tremor_m * 1e6,
            motion.shake_m_per_s2,
            motion.shake_hz,
            self.missing_ticks,
            self.stop_ticks
        )
    }
}

fn device(genes: &mut Reader, base: &DeviceProfile) -> DeviceProfile {
    let count_m = genes.or_zero(0.15, 1e-6, 100e-6);
    let delay_ticks = genes.below(8) as u8;
    let amplifier_lag_s = genes.or_zero(0.4, 0.1e-3, 10e-3);
    let force_limit_n = genes.by_factor(1.0, 12.0);
    let mass_kg = genes.by_factor(0.03, 0.3);
    let damping_n_s_per_m = genes.between(0.0, 0.5);
    let friction_n = genes.or_zero(0.5, 0.0, 0.1);
    let stiffness_ceiling_n_per_m = genes.by_factor(400.0, 2000.0);
    DeviceProfile {
        count_m,
        delay_ticks,
        amplifier_lag_s,
        force_limit_n,
        max_force_n: MOTOR_SHARE * force_limit_n,
        mass_kg,
        damping_n_s_per_m,
        friction_n,
        stiffness_ceiling_n_per_m,
        ..base.clone()
    }
}

fn hand(genes: &mut Reader, device: &DeviceProfile) -> Impedance {
    let mass_kg = genes.by_factor(0.01, 0.4);
    let stiffness_n_per_m = genes.by_factor(20.0, 2000.0);
    let ratio = genes.by_factor(0.02, 1.0);
    let damping_n_s_per_m = 2.0 * ratio * (stiffness_n_per_m * (mass_kg + device.mass_kg)).sqrt();
    Impedance { mass_kg, damping_n_s_per_m, stiffness_n_per_m }
}

fn motion(genes: &mut Reader, on: &PathPatch, youngs_modulus_pa: f64, force_limit_n: f64, hand: &Impedance) -> Motion {
    let kind = MotionKind::ALL[genes.below(MotionKind::ALL.len())];
    // not deeper than the device's force reaches
    let depth_m = on.guard_depth_m(youngs_modulus_pa, force_limit_n) * genes.between(0.05, 1.0);
    let force_n = on.force_n(youngs_modulus_pa, depth_m).min(force_limit_n);
    Motion {
        kind,
        reach_m: depth_m + force_n / hand.stiffness_n_per_m,
        depth_m,
        press_s: genes.by_factor(0.03, 1.0),
        share: genes.between(0.1, 1.0),
        hz: genes.by_factor(0.5, 4.0),
        tremor_m: genes.or_zero(0.2, 0.0, 0.1e-3),
        tremor_hz: genes.between(4.0, 12.0),
        aside_m_per_s: genes.by_factor(3e-3, 0.2),
        place_m: [genes.between(-4e-3, 4e-3), genes.between(-4e-3, 4e-3)],
        phase: genes.share(),
        shake_m_per_s2: 0.0,
        shake_hz: 1.0,
    }
}
