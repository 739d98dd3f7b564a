//! Draws how long the ticks took: a histogram with median, 99th percentile and longest tick.

use std::ops::Range;
use std::path::Path;

use super::figure::Figure;
use super::plot::{Level, Plot, ScaledAxis, Series};
use super::{ChartError, check};

/// Times of the ticks of a run.
#[derive(Clone, Copy, Debug)]
pub struct TickTimes<'a> {
    /// Name of the scene, with which the title begins.
    pub scene: &'a str,
    /// Number of nodes of the patch that was pressed.
    pub node_count: usize,
    /// Processor and build on which the times were measured, in one line.
    pub machine: &'a str,
    /// Wall-clock time of every tick [us], in any order.
    pub tick_us: &'a [f32],
}

/// Height of an empty bar on the logarithmic axis [ticks].
const FLOOR: f64 = 0.7;

/// Writes `NAME.svg` and `NAME.png` into `folder`.
pub fn tick_time(folder: &Path, name: &str, times: &TickTimes) -> Result<(), ChartError> {
    let what = "tick_us";
    let mut sorted_us: Vec<f64> = times.tick_us.iter().map(|t| f64::from(*t)).collect();
    check(what, sorted_us.iter().copied())?;
    if let Some((index, value)) = sorted_us.iter().copied().enumerate().find(|(_, t)| *t < 0.0) {
        return Err(ChartError::NotDrawable { what, index, value });
    }
    sorted_us.sort_unstable_by(f64::total_cmp);
    let (Some(p50), Some(p99), Some(max)) =
        (percentile(&sorted_us, 0.50), percentile(&sorted_us, 0.99), sorted_us.last().copied())
    else {
        return Err(ChartError::Empty { what });
    };
    let range = time_range(&sorted_us, max);
    let bars = count(&sorted_us, &range);
    let edge = |bar: usize| range.start * (range.end / range.start).powf(bar as f64 / BARS as f64);
    let heights = bars.iter().map(|n| (*n as f64).max(FLOOR));
    let stairs = heights.clone().enumerate().flat_map(|(bar, height)| [(edge(bar), height), (edge(bar + 1), height)]);
    let top = heights.fold(FLOOR, f64::max);
    let mark = |(words, t): (&str, f64)| {
        let at = t.max(range.start);
        Series { dashed: true, ..Series::curve(format!("{words} {}", micros(t)), [(at, FLOOR), (at, top)]) }
    };
    let mut series = vec![Series::curve("ticks", stairs)];
    series.extend([("median", p50), ("99 % below", p99), ("longest", max)].map(mark));
    let budget = range.contains(&BUDGET_US).then(|| Level::new(format!("budget {}", micros(BUDGET_US)), BUDGET_US));
    let over = sorted_us.iter().filter(|t| **t > BUDGET_US).count();
    let below = format!(
        "{} nodes, {} ticks, {} over the budget of 1000 µs; {}",
        times.node_count,
        sorted_us.len(),
        if over == 0 { "none".to_owned() } else { over.to_string() },
        times.machine,
    );
    let plot = Plot::new(ScaledAxis::log("time of a tick [µs]"), ScaledAxis::log("ticks (log scale)"), series);
    Figure::plot(name, format!("{}: time of a tick", times.scene), below, Plot { budget, ..plot }).draw(folder)
}

/// Formats a time [us] to about three significant digits.
fn micros(t: f64) -> String {
    let decimals = usize::from(t < 99.95) + usize::from(t < 9.995);
    format!("{t:.decimals$} µs")
}

/// Period of the device, and hence the longest time that a tick may take [us].
const BUDGET_US: f64 = 1000.0;

/// Number of bars across the axis, each about ten pixels wide.
const BARS: usize = 90;

/// The smallest value that is not exceeded by at least `share` (0 to 1) of `sorted`.
fn percentile(sorted: &[f64], share: f64) -> Option<f64> {
    let rank = (share * sorted.len() as f64).ceil() as usize;
    sorted.get(rank.saturating_sub(1)).copied()
}

/// Range of a logarithmic axis that contains all times, and the budget if the times come near it.
fn time_range(sorted_us: &[f64], max: f64) -> Range<f64> {
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
fn count(sorted_us: &[f64], x: &Range<f64>) -> Vec<usize> {
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
