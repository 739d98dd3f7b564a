//! Computes percentiles, bars and round numbers for a histogram with logarithmic axes.

use std::ops::Range;

/// Period of the device, and hence the longest time that a tick may take [us].
pub const BUDGET_US: f64 = 1000.0;

/// Number of bars across the axis, each about ten pixels wide.
pub const BARS: usize = 90;

/// The smallest value that is not exceeded by at least `share` (0 to 1) of `sorted`.
pub fn percentile(sorted: &[f64], share: f64) -> Option<f64> {
    let rank = (share * sorted.len() as f64).ceil() as usize;
    sorted.get(rank.saturating_sub(1)).copied()
}

/// Range of a logarithmic axis that contains all times, and the budget if the times come near it.
pub fn time_range(sorted_us: &[f64], max: f64) -> Range<f64> {
    // a clock that is too coarse for a tick reports 0, which a logarithmic axis cannot show: the
    // axis begins at the first time of a nanosecond or more, and the first bar counts all shorter
    // times
    let least = sorted_us.iter().copied().find(|t| *t >= 1e-3);
    let least = least.unwrap_or(1.0);
    let (least, most) = if max > 0.4 * BUDGET_US { (least.min(BUDGET_US), max.max(BUDGET_US)) } else { (least, max.max(least)) };
    let start = least / 1.3;
    // a sixth of the axis remains free for the label of the longest tick
    start..most * (most / start).powf(0.19).max(1.3)
}

/// Number of ticks in each of `BARS` bars of equal width on the logarithmic axis `x`.
pub fn count(sorted_us: &[f64], x: &Range<f64>) -> Vec<usize> {
    let mut bars = vec![0; BARS];
    let scale = BARS as f64 / (x.end / x.start).ln();
    for t in sorted_us {
        let bar = ((t.max(x.start) / x.start).ln() * scale) as usize;
        if let Some(bar) = bars.get_mut(bar.min(BARS - 1)) {
            *bar += 1;
        }
    }
    bars
}

/// Round numbers for a logarithmic axis over `range`, as fine as possible with at most `most` of
/// them.
pub fn round_points(range: &Range<f64>, most: usize) -> Vec<f64> {
    let steps: [&[f64]; 5] = [
        &[1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0],
        &[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0],
        &[1.0, 2.0, 5.0],
        &[1.0, 3.0],
        &[1.0],
    ];
    let within = |steps: &[f64]| -> Vec<f64> {
        let decades = range.start.log10().floor() as i32..=range.end.log10().ceil() as i32;
        decades.flat_map(|d| steps.iter().map(move |s| s * 10_f64.powi(d))).filter(|p| range.contains(p)).collect()
    };
    let mut finest_first = steps.iter().map(|s| within(s));
    finest_first.find(|p| p.len() <= most).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_tick_is_in_one_bar_and_every_mark_on_the_axis() {
        for times in [&[0.0, 0.0][..], &[21.5], &[0.3, 2.0, 900.0, 90_000.0], &[4000.0]] {
            let max = times.last().copied().unwrap_or_default();
            let x = time_range(times, max);
            assert_eq!(count(times, &x).iter().sum::<usize>(), times.len());
            assert!(x.contains(&max.max(x.start)));
            assert_eq!(x.contains(&BUDGET_US), max > 400.0);
            let points = round_points(&x, 12);
            assert!((2..=12).contains(&points.len()), "{points:?}");
            assert!(points.iter().all(|p| x.contains(p)));
        }
    }

    #[test]
    fn percentiles_are_nearest_rank() {
        let hundred: Vec<f64> = (1..=100).map(f64::from).collect();
        assert_eq!(percentile(&hundred, 0.50), Some(50.0));
        assert_eq!(percentile(&hundred, 0.99), Some(99.0));
        assert_eq!(percentile(&[7.0], 0.99), Some(7.0));
        assert_eq!(percentile(&[], 0.5), None);
    }
}
