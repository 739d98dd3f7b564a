//! Indentations with known constants: our finite elements on a finer mesh than `identify` uses, and
//! the integrals of Lee and Radok and of Ting, where `identify` steps Maxwell chains.

use palpate_fit::half_space::HalfSpace;
use palpate_fit::identify::elastic::{Elastic, Setup};
use palpate_fit::identify::model::Tissue;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

/// Size of the elements over the contact radius, and what `identify` uses is coarser.
const FINENESS: f64 = 0.09;

/// A test that is made up.
#[derive(Clone, Debug)]
pub struct Indentation {
    /// Tip and slab.
    pub setup: Setup,
    /// Constants that are to be found.
    pub tissue: Tissue,
    /// Deepest point below the surface [m].
    pub depth_m: f64,
    /// Durations of the way before contact, the press, the hold and the retreat [s].
    pub durations_s: [f64; 4],
    /// Rows per second.
    pub rate_hz: f64,
    /// Standard deviation of the force, as a share of its largest value (1).
    pub noise: f64,
    /// Seed of the noise.
    pub seed: u64,
}

fn uniform(random: &mut Xoshiro256PlusPlus) -> f64 {
    ((random.next_u64() >> 11) as f64 + 0.5) / 9_007_199_254_740_992.0
}

/// A number between two, evenly in its logarithm.
pub fn between(random: &mut Xoshiro256PlusPlus, low: f64, high: f64) -> f64 {
    low * (high / low).powf(uniform(random))
}

impl Indentation {
    /// Rows of time [s], depth [m] and force [N]. Depths are counted from where the tip starts.
    #[must_use]
    pub fn rows(&self) -> Vec<[f64; 3]> {
        let curve = Elastic::solve_at(&self.setup, self.depth_m, &[self.tissue.stiffening_b], FINENESS).unwrap();
        let curve = curve.at(self.tissue.stiffening_b);
        let [before_s, press_s, hold_s, retreat_s] = self.durations_s;
        let dt_s = 1.0 / self.rate_hz;
        let speed = self.depth_m / press_s;
        let depth = |t: f64| {
            let back = (t - before_s - press_s - hold_s).max(0.0) * speed;
            (speed * (t - before_s)).min(self.depth_m) - back
        };
        let count = ((before_s + press_s + hold_s + retreat_s) * self.rate_hz) as usize;
        let depths: Vec<f64> = (0..=count).map(|n| depth(n as f64 * dt_s)).collect();
        let elastic: Vec<f64> = depths.iter().map(|d| self.tissue.youngs_modulus_pa * curve.force_m2(*d)).collect();
        let half = HalfSpace { radius_m: self.setup.ball_m, plane_modulus_pa: 1.0, terms: self.tissue.terms.clone() };
        let held = ((before_s + press_s + hold_s) * self.rate_hz) as usize;
        let clean: Vec<f64> = (0..=count)
            .map(|n| match n <= held {
                true => half.loaded_n(&elastic[..=n], dt_s),
                false => half.retreating_n(&elastic[..=n], &depths[..=n], dt_s),
            })
            .collect();
        let most_n = clean.iter().copied().fold(0.0, f64::max);
        let mut random = Xoshiro256PlusPlus::seed_from_u64(self.seed);
        let row = |(n, force): (usize, f64)| {
            let normal = (-2.0 * uniform(&mut random).ln()).sqrt() * (std::f64::consts::TAU * uniform(&mut random)).cos();
            [n as f64 * dt_s, depths[n] + speed * before_s, force + self.noise * most_n * normal]
        };
        clean.into_iter().enumerate().map(row).collect()
    }

    /// The data set of the guide.
    #[must_use]
    pub fn phantom() -> Self {
        Self {
            setup: Setup { ball_m: 4e-3, block_m: [0.05, 0.05, 0.01], poisson_ratio: 0.45 },
            tissue: Tissue { youngs_modulus_pa: 12e3, stiffening_b: 0.3, terms: vec![(0.2, 2.0)] },
            depth_m: 4e-3,
            durations_s: [0.5, 2.0, 10.0, 2.0],
            rate_hz: 50.0,
            noise: 0.01,
            seed: 52,
        }
    }
}
