//! A run as numbers between 0 and 1, and what they mean.

use palpate::{Params, PronyTerm};
use palpate_tissue::finger::Impedance;
use rand_xoshiro::SplitMix64;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

use super::motion::{Motion, MotionKind};
use crate::closed_loop::device::DeviceProfile;
use crate::closed_loop::paths::{PathGround, PathPatch};

/// Number of numbers that describe a run.
pub const GENES: usize = 26;

/// One run: device, hand, tissue and motion.
#[derive(Clone, Debug)]
pub struct YieldingCase {
    /// Index into the ground's patches.
    pub patch: usize,
    /// Tissue.
    pub params: Params,
    /// Device.
    pub device: DeviceProfile,
    /// Hand.
    pub hand: Impedance,
    /// What the hand does.
    pub motion: Motion,
}

/// Reads the numbers of a run one after the other.
struct Genes<'a>(std::slice::Iter<'a, f64>);

impl Genes<'_> {
    fn share(&mut self) -> f64 {
        self.0.next().copied().unwrap_or(0.5)
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.share()
    }

    /// A number between `low` and `high` whose logarithm is linear in the gene.
    fn by_factor(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.share())
    }

    /// Zero for the genes below `share`, and a number between `low` and `high` for the others.
    fn or_zero(&mut self, share: f64, low: f64, high: f64) -> f64 {
        let at = self.share();
        if at < share { 0.0 } else { low + (high - low) * (at - share) / (1.0 - share) }
    }
}

impl YieldingCase {
    /// Draws the numbers of a run.
    #[must_use]
    pub fn draw(number: u64, seed: u64) -> [f64; GENES] {
        let mut random = SplitMix64::seed_from_u64(seed ^ number.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        std::array::from_fn(|_| (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64)
    }

    /// The run that these numbers describe.
    #[must_use]
    pub fn of(ground: &PathGround, genes: &[f64; GENES], base: &DeviceProfile) -> Self {
        let mut genes = Genes(genes.iter());
        let shares: f64 = ground.patches.iter().map(|p| f64::from(p.share)).sum();
        let mut left = genes.share() * shares;
        let patch = ground.patches.iter().position(|p| {
            left -= f64::from(p.share);
            left < 0.0
        });
        let patch = patch.unwrap_or_default();
        let on = &ground.patches[patch];
        let youngs_modulus_pa = genes.by_factor(1e3, 100e3);
        let count_m = genes.or_zero(0.15, 1e-6, 100e-6);
        let delay_ticks = (genes.share() * 8.0).min(7.0) as u8;
        let amplifier_lag_s = genes.or_zero(0.4, 0.1e-3, 10e-3);
        let force_limit_n = genes.by_factor(1.0, 12.0);
        let mass_kg = genes.by_factor(0.03, 0.3);
        let damping_n_s_per_m = genes.between(0.0, 0.5);
        let friction_n = genes.or_zero(0.5, 0.0, 0.1);
        let ceiling = genes.by_factor(400.0, 2000.0);
        let device = DeviceProfile {
            count_m,
            delay_ticks,
            amplifier_lag_s,
            force_limit_n,
            max_force_n: 1.1 * force_limit_n,
            mass_kg,
            damping_n_s_per_m,
            friction_n,
            stiffness_ceiling_n_per_m: ceiling,
            ..base.clone()
        };
        let hand_kg = genes.by_factor(0.01, 0.4);
        let stiffness_n_per_m = genes.by_factor(20.0, 2000.0);
        let ratio = genes.by_factor(0.02, 1.0);
        let damping_n_s_per_m = 2.0 * ratio * (stiffness_n_per_m * (hand_kg + mass_kg)).sqrt();
        let hand = Impedance { mass_kg: hand_kg, damping_n_s_per_m, stiffness_n_per_m };
        let (relaxing, friction) = (genes.or_zero(0.6, 0.1, 0.6), genes.or_zero(0.6, 0.05, 0.5));
        let params = Params {
            youngs_modulus_pa: youngs_modulus_pa as f32,
            relaxation: if relaxing > 0.0 {
                [PronyTerm { share: relaxing as f32, time_s: 0.05 }, PronyTerm::NONE, PronyTerm::NONE]
            } else {
                on.params.relaxation
            },
            friction: friction as f32,
            ..on.params
        };
        let motion = Self::motion(&mut genes, on, youngs_modulus_pa, force_limit_n, &hand);
        Self { patch, params, device, hand, motion }
    }

    fn motion(genes: &mut Genes, on: &PathPatch, youngs_modulus_pa: f64, force_limit_n: f64, hand: &Impedance) -> Motion {
        let kind = MotionKind::ALL[((genes.share() * MotionKind::ALL.len() as f64) as usize).min(MotionKind::ALL.len() - 1)];
        // not deeper than the device's force reaches
        let deepest_m = on.guard_depth_m(youngs_modulus_pa, force_limit_n);
        let depth_m = deepest_m * genes.between(0.05, 1.0);
        let reach_m = depth_m + on.force_n(youngs_modulus_pa, depth_m).min(force_limit_n) / hand.stiffness_n_per_m;
        Motion {
            kind,
            reach_m,
            depth_m,
            press_s: genes.by_factor(0.03, 1.0),
            share: genes.between(0.1, 1.0),
            hz: genes.by_factor(0.5, 4.0),
            tremor_m: genes.or_zero(0.2, 0.0, 0.1e-3),
            tremor_hz: genes.between(4.0, 12.0),
            aside_m_per_s: genes.by_factor(3e-3, 0.2),
            place_m: [genes.between(-4e-3, 4e-3), genes.between(-4e-3, 4e-3)],
            phase: genes.share(),
        }
    }
}
