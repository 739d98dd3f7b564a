//! Noise, segments and thinning of the rows of a test.

use std::ops::Range;

/// Fewest readings of a motion: fewer are the steps of a hand on a screw.
const FEWEST_READINGS: usize = 20;
/// Noise of a depth over the deepest one that is left (1), and the largest number of neighbours on
/// either side by which it is lowered, as a part of the rows of the press.
const MOST_NOISE: f64 = 0.001;
const MOST_ASIDE: usize = 10;
/// Fewest means whose variation is known.
const FEWEST_MEANS: usize = 8;
/// Number of neighbours among which a value may stand out.
const AROUND: usize = 9;
/// Distance from its neighbours at which a value is a disturbance, in deviations of the noise, as a
/// share of the whole range (1), and in steps between rows, which a coarse converter has.
const SPIKE_NOISES: f64 = 10.0;
const SPIKE_SHARE: f64 = 0.02;
const SPIKE_STEPS: f64 = 4.0;
/// Share of the deepest depth by which it must fall to count as a retreat (1): control loops
/// overshoot and sag by less.
const FALL: f64 = 0.15;
/// Share of the deepest depth from which a fall is looked for (1).
const DEEP: f64 = 0.5;
/// Share of the deepest depth from which rows may be those of a hold, and of the hold's level that
/// a press reaches at its end (1).
const NEARLY: f64 = 0.93;
const REACHED: f64 = 0.991;
/// Share of the rows near the deepest depth that are below the level of a hold (1).
const LEVEL: f64 = 0.8;
/// Way over the deepest depth that shows how fast the tip falls (1).
const SHORT_WAY: f64 = 0.025;
/// Share of the depth by which a tip comes in again, after which the rows are another cycle (1).
const AGAIN: f64 = 0.1;

/// Rows of the segments of a test.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Segments {
    /// The tip moves in, from the first row on.
    pub press: Range<usize>,
    /// The depth is held.
    pub hold: Range<usize>,
    /// The tip moves out; may be empty.
    pub retreat: Range<usize>,
}

/// Mean of some values.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Value that a share (1) of some values is below; zero without any.
pub fn quantile(values: &[f64], share: f64) -> f64 {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    values.get((share * values.len() as f64) as usize).copied().unwrap_or(0.0)
}

/// Whether each value lies far outside those around it: disturbances of the
/// electronics, of which one would decide on contact, peak and depth.
pub fn spikes(values: &[f64]) -> Vec<bool> {
    let all = [0.05, 0.95].map(|share| quantile(values, share));
    let steps: Vec<f64> = values.windows(2).map(|w| (w[1] - w[0]).abs()).filter(|step| *step > 0.0).collect();
    let least = (SPIKE_NOISES * noise(values)).max(SPIKE_SHARE * (all[1] - all[0])).max(SPIKE_STEPS * quantile(&steps, 0.5));
    let first = |n: usize| n.saturating_sub(AROUND / 2).min(values.len().saturating_sub(AROUND));
    let outside = |n: usize| {
        let around = &values[first(n)..(first(n) + AROUND).min(values.len())];
        let [low, high] = [0.2, 0.8].map(|share| quantile(around, share));
        let far = 3.0 * (high - low) + least;
        values[n] > high + far || values[n] < low - far
    };
    (0..values.len()).map(outside).collect()
}

/// Standard deviation of the noise from second differences, which a smooth signal hardly has.
pub fn noise(values: &[f64]) -> f64 {
    let second: Vec<f64> = values.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).abs()).collect();
    // median of a normal variable's size is 0.6745 deviations; the variance of the difference is 6
    quantile(&second, 0.5) / 0.6745 / 6_f64.sqrt()
}

/// Factor by which means of so many values vary more than if the noise of each were its own (1), as
/// behind a filter; smooth values hardly have any such variation.
pub fn lasting(values: &[f64], count: usize) -> f64 {
    let means: Vec<f64> = values.chunks_exact(count.max(1)).map(mean).collect();
    let alone = noise(values);
    if means.len() < FEWEST_MEANS || alone == 0.0 { 1.0 } else { (noise(&means) * (count as f64).sqrt() / alone).max(1.0) }
}

/// Factor by which neighbouring deviations repeat each other (1), from their correlation.
pub fn repeats(off: &[f64]) -> f64 {
    let own: f64 = off.iter().map(|off| off * off).sum();
    let next: f64 = off.windows(2).map(|w| w[0] * w[1]).sum();
    let rho = if own > 0.0 { (next / own).clamp(0.0, 0.95) } else { 0.0 };
    (1.0 + rho) / (1.0 - rho)
}

impl Segments {
    /// Segments of a motion from the row of contact on, at the surface's depth; rows from the end
    /// of the retreat on are another cycle.
    pub fn of(depth_m: &[f64], touch: usize, surface_m: f64) -> Self {
        let deepest_m = depth_m[touch..].iter().copied().fold(f64::MIN, f64::max);
        let (span_m, wanders_m) = (deepest_m - surface_m, 4.0 * noise(depth_m));
        let first = |from: usize, end: usize, share: f64, of_m: f64| {
            (from..end).find(|n| depth_m[*n] - surface_m >= share * (of_m - surface_m)).unwrap_or(end)
        };
        let (fall_m, mut highest_m) = (FALL * span_m + wanders_m, f64::MIN);
        let fallen = (first(touch, depth_m.len(), DEEP, deepest_m)..depth_m.len()).find(|n| {
            highest_m = highest_m.max(depth_m[*n]);
            depth_m[*n] < highest_m - fall_m
        });
        // the retreat begins where the tip comes to fall as fast as in the second half of that
        // fall; an overshoot or a sag is slower, or over before
        let retreat = fallen.map_or(depth_m.len(), |fallen| {
            let half = |n: &usize| depth_m[*n] >= depth_m[fallen] + 0.5 * fall_m;
            let middle = (touch..fallen).rev().find(half).unwrap_or(touch);
            let per_row_m = (depth_m[middle] - depth_m[fallen]) / (fallen - middle) as f64;
            let rows = (((SHORT_WAY * span_m).max(2.0 * wanders_m) / per_row_m) as usize).max(1);
            let falls = |n: usize| n >= touch + rows && depth_m[n - rows] - depth_m[n] > 0.5 * per_row_m * rows as f64;
            let last = (touch..=middle).rev().find(|n| !falls(*n)).unwrap_or(touch);
            last.saturating_sub(rows / 2).max(touch)
        });
        // a single row, as of a noisy sensor, is no level, and neither is a short overshoot
        let level = &depth_m[first(touch, retreat, NEARLY, highest_m)..retreat];
        let level_m = if level.is_empty() { highest_m } else { quantile(level, LEVEL) };
        let reached = first(touch, retreat, REACHED, level_m);
        let mut lowest_m = f64::MAX;
        let again = (retreat..depth_m.len()).find(|n| {
            lowest_m = lowest_m.min(depth_m[*n]);
            depth_m[*n] > lowest_m + AGAIN * span_m + wanders_m
        });
        let end = again.map_or(depth_m.len(), |again| {
            let low = |n: &usize| depth_m[*n] <= lowest_m + wanders_m;
            (retreat..again).rev().find(low).unwrap_or(again)
        });
        Self { press: 0..reached, hold: reached..retreat, retreat: retreat..end }
    }
}

/// Depths [m] on lines between readings, where they are read less often than the forces; a depth
/// that stays for longer is at rest.
pub fn between_readings(depth_m: &mut [f64]) {
    let read: Vec<usize> = (0..depth_m.len()).filter(|n| *n == 0 || depth_m[*n] != depth_m[n - 1]).collect();
    if read.len() < FEWEST_READINGS {
        return;
    }
    let rare = 2.0 * quantile(&read.windows(2).map(|w| (w[1] - w[0]) as f64).collect::<Vec<f64>>(), 0.5);
    for w in read.windows(2).filter(|w| (w[1] - w[0]) as f64 <= rare) {
        let per_row_m = (depth_m[w[1]] - depth_m[w[0]]) / (w[1] - w[0]) as f64;
        (w[0] + 1..w[1]).for_each(|n| depth_m[n] = depth_m[n - 1] + per_row_m);
    }
}

/// Depths [m] of a driven motion without the noise of their sensor, which would act as a motion: a
/// line through neighbours of the same segment, as many as bring the noise below a share of the
/// deepest depth [m].
pub fn driven(depth_m: &mut [f64], segments: &Segments, span_m: f64) {
    let wanted = (noise(depth_m) / (MOST_NOISE * span_m)).powi(2) / 2.0;
    let aside = (wanted as usize).min(segments.press.len() / MOST_ASIDE);
    for part in [&segments.press, &segments.hold, &segments.retreat] {
        let read = depth_m[part.clone()].to_vec();
        for (n, depth_m) in depth_m[part.clone()].iter_mut().enumerate() {
            let first = n.saturating_sub(aside);
            let near = &read[first..(n + aside + 1).min(read.len())];
            let (middle, mean_m) = (0.5 * (near.len() - 1) as f64, mean(near));
            let off = |k: usize| k as f64 - middle;
            let spread: f64 = (0..near.len()).map(|k| off(k).powi(2)).sum();
            let slope_m = near.iter().enumerate().map(|(k, d)| off(k) * d).sum::<f64>() / spread.max(1.0);
            *depth_m = mean_m + slope_m * off(n - first);
        }
    }
}

/// Ranges of `step` rows, at most `most` of them. Where there are more, the distance between two
/// grows with the time since the first row, as what relaxes changes ever more slowly. Each point
/// averages as many rows, so that all have the same noise.
pub fn thinned(rows: Range<usize>, step: usize, most: usize) -> Vec<Range<usize>> {
    let count = rows.len().div_ceil(step);
    let chosen = |growth: f64| -> Vec<usize> {
        let next = |at: &usize| Some(at + 1.max((*at as f64 * growth) as usize)).filter(|at| *at < count);
        std::iter::successors((count > 0).then_some(0), next).collect()
    };
    let growths = std::iter::successors(Some(0.0), |growth: &f64| Some((2.0 * growth).max(1.0 / 512.0)));
    let places = growths.take(16).map(chosen).find(|places| places.len() <= most).unwrap_or_default();
    let start = |at: usize| (rows.start + at * step).min(rows.end);
    places.into_iter().map(|at| start(at)..start(at + 1)).collect()
}

/// Rows of which several have the same time [s], as where it is written in coarse steps: one row of
/// their means for each time.
pub fn merged(rows: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let same = rows.chunk_by(|a, b| a[0] == b[0]);
    same.map(|same| std::array::from_fn(|k| mean(&same.iter().map(|row| row[k]).collect::<Vec<f64>>()))).collect()
}
