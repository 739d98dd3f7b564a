//! Determines units, ranges and tick labels of the axes.

use std::ops::Range;

use plotters::coord::ranged1d::Ranged;
use plotters::coord::types::RangedCoordf64;

/// Unit in which an axis is labelled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// Symbol of the unit, written after the number, or in brackets after the quantity.
    pub symbol: &'static str,
    /// Number of display units per SI unit.
    pub per_si: f64,
    /// Whether running text drops trailing zeros.
    trims: bool,
}

impl Unit {
    /// Returns N, or mN or µN if the largest of `forces_n` would have hardly any digits in N.
    pub fn of_force(forces_n: impl IntoIterator<Item = f64>) -> Self {
        let (symbol, per_si) = match largest(forces_n) {
            0.0 => ("N", 1.0),
            f if f < 2e-4 => ("µN", 1e6),
            f if f < 1e-2 => ("mN", 1e3),
            _ => ("N", 1.0),
        };
        // a measured value: a final zero is a significant digit
        Self { symbol, per_si, trims: false }
    }

    /// Returns mm, or µm if the largest of `lengths_m` would have hardly any digits in mm.
    pub fn of_length(lengths_m: impl IntoIterator<Item = f64>) -> Self {
        let (symbol, per_si) = match largest(lengths_m) {
            0.0 => ("mm", 1e3),
            l if l < 2e-5 => ("µm", 1e6),
            _ => ("mm", 1e3),
        };
        // lengths are mostly chosen values and therefore round, so trailing zeros carry no
        // information
        Self { symbol, per_si, trims: true }
    }

    /// Returns kPa, or Pa if the largest of `pressures_pa` would have hardly any digits in kPa.
    pub fn of_pressure(pressures_pa: impl IntoIterator<Item = f64>) -> Self {
        let (symbol, per_si) = if largest(pressures_pa) < 10.0 { ("Pa", 1.0) } else { ("kPa", 1e-3) };
        Self { symbol, per_si, trims: false }
    }

    /// Formats the SI value `si` with its unit for running text, to about three significant digits.
    pub fn say(&self, si: f64) -> String {
        let value = si * self.per_si;
        let decimals = match value.abs() {
            v if v >= 99.95 => 0,
            v if v >= 9.995 => 1,
            v if v >= 0.9995 => 2,
            _ => 3,
        };
        let mut number = format!("{value:.decimals$}");
        while self.trims && number.ends_with('0') && !number.ends_with(".0") && number.contains('.') {
            number.pop();
        }
        format!("{} {}", minus(&number), self.symbol)
    }
}

fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, |most, v| most.max(v.abs()))
}

/// A linear axis whose tick labels all have the same number of decimals.
#[derive(Clone, Debug)]
pub struct Axis {
    /// Both ends of the axis [display unit].
    pub range: Range<f64>,
    /// Largest number of ticks.
    pub ticks: usize,
    decimals: usize,
}

/// Span below which the plotting library treats an axis as a single value; no span in µm or µN is
/// that small.
const SMALLEST_SPAN: f64 = 1e-9;

impl Axis {
    /// Makes an axis that contains zero and all `values` [display unit] and leaves `headroom` of
    /// their span free at the top.
    pub fn from_zero(values: impl IntoIterator<Item = f64>, headroom: f64, ticks: usize) -> Self {
        let (low, high) = values.into_iter().fold((0.0_f64, 0.0_f64), |(low, high), v| (low.min(v), high.max(v)));
        let span = high - low;
        if span < SMALLEST_SPAN {
            return Self::over(0.0..1.0, ticks);
        }
        let low = if low < 0.0 { low - 0.05 * span } else { 0.0 };
        Self::over(low..high + headroom * span, ticks)
    }

    /// Makes an axis from zero to the first tick at or above `most` [display unit].
    pub fn to_a_tick(most: f64, ticks: usize) -> Self {
        let short = Self::from_zero([most], 0.0, ticks);
        let points = RangedCoordf64::from(short.range.clone()).key_points(ticks);
        let step = match points.as_slice() {
            [first, second, ..] => second - first,
            _ => short.range.end,
        };
        // a remainder of a millionth of a step is rounding error and needs no further tick
        let steps = (short.range.end / step - 1e-6).ceil().max(1.0);
        Self::over(0.0..steps * step, ticks + 1)
    }

    /// Makes an axis over exactly `range` [display unit].
    pub fn over(range: Range<f64>, ticks: usize) -> Self {
        let points = RangedCoordf64::from(range.clone()).key_points(ticks);
        let step = match points.as_slice() {
            [first, second, ..] => second - first,
            _ => range.end - range.start,
        };
        let shows_all = |decimals: i32| {
            let shift = 10_f64.powi(decimals);
            let error = |p: &f64| ((p * shift).round() / shift - p).abs();
            points.iter().all(|p| error(p) < 1e-3 * step)
        };
        let decimals = (0..9).position(shows_all).unwrap_or(9);
        Self { range, ticks, decimals }
    }

    /// Returns the label of the tick at `value` [display unit].
    pub fn label(&self, value: f64) -> String {
        minus(&format!("{value:.*}", self.decimals))
    }
}

/// Replaces the hyphen by a true minus sign, and removes it from a number that rounds to zero.
fn minus(number: &str) -> String {
    match number.strip_prefix('-') {
        Some(rest) if rest.bytes().all(|b| matches!(b, b'0' | b'.')) => rest.to_owned(),
        Some(rest) => format!("\u{2212}{rest}"),
        None => number.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tick_labels_differ_and_share_decimals() {
        for span in [3.3e-4, 0.0042, 0.15, 1.0, 7.0, 48.0, 1.3e4] {
            let axis = Axis::from_zero([span], 0.08, 8);
            let labels: Vec<_> =
                RangedCoordf64::from(axis.range.clone()).key_points(axis.ticks).into_iter().map(|p| axis.label(p)).collect();
            assert!(labels.len() >= 3, "{labels:?}");
            for pair in labels.windows(2) {
                assert_ne!(pair[0], pair[1]);
            }
        }
    }

    #[test]
    fn running_text_has_three_digits_and_a_unit() {
        let newton = Unit::of_force([0.139]);
        assert_eq!(newton.say(0.049_04), "0.049 N");
        assert_eq!(Unit::of_length([0.004]).say(0.002), "2.0 mm");
        assert_eq!(Unit::of_force([1.2e-4]).say(1.2e-4), "120 µN");
        assert_eq!(Unit::of_force([50.0]).say(50.0), "50.0 N");
        assert_eq!(newton.say(-0.000_01), "0.000 N");
        assert_eq!(newton.say(-0.02), "\u{2212}0.020 N");
    }
}
