//! Chooses the places at which a calibration presses.

use rand_xoshiro::SplitMix64;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

/// Golden angle [rad].
const GOLDEN: f64 = 2.399_963_229_728_653;

/// `count` places spread evenly over a disc of radius `radius_m` (Vogel's sunflower), relative to
/// its centre [m].
#[must_use]
pub fn sunflower(count: usize, radius_m: f64) -> Vec<[f64; 2]> {
    let place = |n: usize| {
        let r = radius_m * ((n as f64 + 0.5) / count as f64).sqrt();
        let (sin, cos) = (GOLDEN * n as f64).sin_cos();
        [r * cos, r * sin]
    };
    (0..count).map(place).collect()
}

/// `count` random places over a disc, relative to its centre [m], for testing a calibration. Equal
/// seeds give equal places.
#[must_use]
pub fn random(count: usize, radius_m: f64, seed: u64) -> Vec<[f64; 2]> {
    let mut random = SplitMix64::seed_from_u64(seed);
    let mut next = || (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    (0..count)
        .map(|_| {
            let (r, angle) = (radius_m * next().sqrt(), std::f64::consts::TAU * next());
            [r * angle.cos(), r * angle.sin()]
        })
        .collect()
}
