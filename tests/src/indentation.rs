//! Indentations with known constants: our finite elements on a finer mesh than `identify` uses, and
//! the integrals of Lee and Radok and of Ting, where `identify` steps Maxwell chains.

use std::fmt;

use palpate_fit::half_space::HalfSpace;
use palpate_fit::identify::elastic::{Elastic, Setup};
use palpate_fit::identify::model::Tissue;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

/// Size of the elements over the contact radius; those that `identify` uses are coarser.
const FINENESS: f64 = 0.1;

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

/// Number between two, drawn evenly in its logarithm.
fn between(random: &mut Xoshiro256PlusPlus, low: f64, high: f64) -> f64 {
    low * (high / low).powf(uniform(random))
}

/// Counts of cases.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tally {
    cases: f64,
    inside: f64,
    right: f64,
    told: f64,
    told_right: f64,
    possible: f64,
}

impl Tally {
    /// Adds a value that was made with `truth` and should be within `most` of it.
    pub fn add(&mut self, truth: f64, value: f64, [low, high]: [f64; 2], most: f64, told: bool) {
        let count = |so: bool| f64::from(u8::from(so));
        let right = (value - truth).abs() <= most;
        self.cases += 1.0;
        self.inside += count(low <= truth && truth <= high);
        self.right += count(right);
        self.told += count(told);
        self.told_right += count(told && right);
        // an unbiased value is spread at least as the interval says (the bound of Cramer and Rao)
        let deviation = (high - low) / (2.0 * 1.645);
        self.possible += libm::erf(most / (std::f64::consts::SQRT_2 * deviation));
    }

    /// Share of cases whose truth lies in the interval (1).
    pub fn inside(&self) -> f64 {
        self.inside / self.cases
    }

    /// Share of cases whose value is within the target (1).
    pub fn right(&self) -> f64 {
        self.right / self.cases
    }

    /// Share of the told values that are right (1).
    pub fn told_right(&self) -> f64 {
        self.told_right / self.told
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let share = |part: f64| part / self.cases;
        write!(
            f,
            "{} cases: truth inside the interval in {:.2}, within the target in {:.2} (by the intervals at most {:.2}); told in {:.2}, of which within in {:.2}",
            self.cases,
            self.inside(),
            share(self.right),
            share(self.possible),
            share(self.told),
            self.told_right()
        )
    }
}

impl Indentation {
    /// A case of the study: thickness 5 to 40 mm, tip 2 to 10 mm, noise 1 to 3 %, one term or two.
    pub fn drawn(case: u64) -> Self {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(case);
        let mut draw = |low: f64, high: f64| between(&mut random, low, high);
        let (thick_m, ball_m) = (draw(5e-3, 40e-3), draw(2e-3, 10e-3));
        // as the guide advises: half the radius or deeper, at most half the thickness
        let depth_m = (draw(0.5, 1.0) * ball_m).min(0.45 * thick_m);
        let (stiffening_b, press_s, hold_s) = (draw(0.3, 8.0), draw(0.7, 2.0), draw(8.0, 15.0));
        let shares = [draw(0.1, 0.35), draw(0.1, 0.35)];
        let slow = [(shares[0], draw(0.3, 1.0)), (shares[1], draw(3.0, 10.0))];
        let wide_m = 0.1_f64.max(4.0 * thick_m);
        Self {
            setup: Setup { ball_m, block_m: [wide_m, wide_m, thick_m], poisson_ratio: 0.45 },
            tissue: Tissue { youngs_modulus_pa: draw(2e3, 100e3), stiffening_b, terms: slow[(case % 2) as usize..].to_vec() },
            depth_m,
            durations_s: [0.3 * press_s, press_s, hold_s, 0.0],
            rate_hz: 60.0,
            noise: draw(0.01, 0.03),
            seed: case,
        }
    }

    /// Rows of time [s], depth [m] and force [N]. Depths are counted from where the tip starts.
    pub fn rows(&self) -> Vec<[f64; 3]> {
        self.repeated(1).remove(0)
    }

    /// Rows of several tests, which differ in their noise.
    pub fn repeated(&self, tests: u64) -> Vec<Vec<[f64; 3]>> {
        let curve = Elastic::solve_with(&self.setup, self.depth_m, &[self.tissue.stiffening_b], FINENESS).unwrap();
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
        let noisy = |test: u64| {
            let mut random = Xoshiro256PlusPlus::seed_from_u64(self.seed + (test << 32));
            let row = |(n, force): (usize, &f64)| {
                let normal = (-2.0 * uniform(&mut random).ln()).sqrt() * (std::f64::consts::TAU * uniform(&mut random)).cos();
                [n as f64 * dt_s, depths[n] + speed * before_s, force + self.noise * most_n * normal]
            };
            clean.iter().enumerate().map(row).collect()
        };
        (0..tests).map(noisy).collect()
    }

    /// The rows as the file of the guide.
    pub fn csv(&self) -> String {
        let head = "# Made up by a program (tests/src/indentation.rs), not measured: E = 12 kPa, b = 0.3, one relaxation term of\n\
                    # share 0.2 and 2 s, nu = 0.45, noise 1 %; a ball of radius 4 mm on a slab of 50 x 50 x 10 mm.\n\
                    time_s,depth_mm,force_mN\n";
        let rows = self.rows().into_iter().map(|[t, d, f]| format!("{t:.3},{:.4},{:.3}\n", d * 1e3, f * 1e3));
        rows.fold(head.to_owned(), |text, row| text + &row)
    }

    /// The data set of the guide.
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
