//! Where the probe presses during a calibration.

/// Golden angle [rad].
const GOLDEN: f64 = 2.399_963_229_728_653;

/// `count` places spread evenly over a disc of radius `radius_m` (Vogel's sunflower), relative to its centre [m].
#[must_use]
pub fn sunflower(count: usize, radius_m: f64) -> Vec<[f64; 2]> {
    let place = |n: usize| {
        let r = radius_m * ((n as f64 + 0.5) / count as f64).sqrt();
        let (sin, cos) = (GOLDEN * n as f64).sin_cos();
        [r * cos, r * sin]
    };
    (0..count).map(place).collect()
}

/// `count` places at random over a disc, the same for the same seed: what a calibration is tested on.
#[must_use]
pub fn random(count: usize, radius_m: f64, seed: u64) -> Vec<[f64; 2]> {
    let mut state = seed;
    let mut next = || {
        // SplitMix64 (Steele, Lea, Flood 2014)
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    };
    (0..count)
        .map(|_| {
            let (r, angle) = (radius_m * next().sqrt(), std::f64::consts::TAU * next());
            [r * angle.cos(), r * angle.sin()]
        })
        .collect()
}
