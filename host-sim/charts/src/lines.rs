//! Draws any number of named curves over one pair of axes, each of which is linear or logarithmic.

use std::ops::Range;
use std::path::Path;

use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint, Ranged};
use plotters::coord::types::RangedCoordf64;
use plotters::element::{DashedPathElement, PathElement, Polygon};
use plotters::prelude::DrawingBackend;
use plotters::style::Color;

use super::axis::Axis;
use super::canvas::Area;
use super::canvas::Drawn;
use super::key_column::{self, Sign};
use super::layout::{Labels, TITLE_HEIGHT_PX, axes, builder, title};
use super::picture::{Picture, save};
use super::speed_accuracy::marker::{distinct, outline};
use super::style::{MUTED, line, px};
use super::tick_time::histogram::round_points;
use super::tick_time::plain;
use super::{ChartError, check_series};

/// Spacing of values along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Even spacing; the axis begins at zero if the data come near it.
    Linear,
    /// Logarithmic spacing; all values are above zero.
    Log,
}

/// Title and scale of one axis.
#[derive(Clone, Copy, Debug)]
pub struct ScaledAxis<'a> {
    /// Quantity and unit, such as `depth [mm]`.
    pub title: &'a str,
    /// Scale along the axis.
    pub scale: Scale,
}

/// One curve of a line chart.
#[derive(Clone, Debug)]
pub struct LineSeries<'a> {
    /// Name in the legend.
    pub name: &'a str,
    /// (x, y) in drawing order, in the units of the axes.
    pub points: Vec<(f64, f64)>,
    /// Whether the points are joined by a line.
    pub joined: bool,
    /// Whether a marker is drawn at every point.
    pub marked: bool,
}

/// A dashed horizontal reference line.
#[derive(Clone, Copy, Debug)]
pub struct Level<'a> {
    /// Name in the legend.
    pub name: &'a str,
    /// Height of the line, in the unit of the y axis.
    pub y: f64,
}

/// Data and labels of a line chart.
#[derive(Clone, Copy, Debug)]
pub struct Lines<'a> {
    /// First line above the chart.
    pub title: &'a str,
    /// Second line above the chart.
    pub below: &'a str,
    /// Axis along the bottom.
    pub x: ScaledAxis<'a>,
    /// Axis along the left side.
    pub y: ScaledAxis<'a>,
    /// Curves, in the order of the legend.
    pub series: &'a [LineSeries<'a>],
    /// Reference lines; may be empty.
    pub levels: &'a [Level<'a>],
}

/// Writes `NAME.svg` and `NAME.png` into `folder`.
///
/// # Errors
/// Fails if there is no series, if a series has no points, if a value cannot be drawn or is not
/// above zero on a logarithmic axis, or if the folder cannot be written.
pub fn lines(folder: &Path, name: &str, lines: &Lines) -> Result<(), ChartError> {
    if lines.series.is_empty() {
        return Err(ChartError::Empty { what: "series" });
    }
    for series in lines.series {
        if series.points.is_empty() {
            return Err(ChartError::EmptySeries { series: series.name.to_owned() });
        }
        check_series(series.name, "x", series.points.iter().map(|p| p.0), lines.x.scale == Scale::Log)?;
        check_series(series.name, "y", series.points.iter().map(|p| p.1), lines.y.scale == Scale::Log)?;
    }
    for level in lines.levels {
        check_series(level.name, "level", [level.y], lines.y.scale == Scale::Log)?;
    }
    let points = || lines.series.iter().flat_map(|s| s.points.iter());
    let heights = points().map(|p| p.1).chain(lines.levels.iter().map(|l| l.y));
    let picture = Drawing { lines, x: Ruler::new(lines.x.scale, points().map(|p| p.0)), y: Ruler::new(lines.y.scale, heights) };
    save(folder, name, &picture)
}

/// Maps values to plotted quantities, which are evenly spaced in the picture.
struct Ruler {
    scale: Scale,
    /// Range of the plotted quantities: values, or their decimal logarithms.
    range: Range<f64>,
    /// Ticks of the axis, as plotted quantities.
    ticks: Vec<f64>,
    axis: Axis,
}

impl Ruler {
    fn new(scale: Scale, values: impl Iterator<Item = f64>) -> Self {
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        match scale {
            Scale::Linear => {
                // a single value, or several indistinguishable ones, also need an axis of non-zero
                // length
                let span = (high - low).max(1e-6 * high.abs().max(low.abs())).max(1e-9);
                let near_zero = 0.5 * span;
                let start = if (0.0..=near_zero).contains(&low) { 0.0 } else { low - 0.05 * span };
                let end = if (-near_zero..=0.0).contains(&high) { 0.0 } else { high + 0.06 * span };
                let axis = Axis::over(start..end, 9);
                let ticks = RangedCoordf64::from(axis.range.clone()).key_points(axis.ticks);
                Self { scale, range: axis.range.clone(), ticks, axis }
            }
            Scale::Log => {
                // the ends differ by at least a factor of 4, or the axis would not contain a second
                // round number
                let room = (high / low).powf(0.05).max((4.0 * low / high).sqrt());
                let range = low / room..high * room;
                let ticks = round_points(&range, 9).into_iter().map(f64::log10).collect();
                let range = range.start.log10()..range.end.log10();
                Self { scale, axis: Axis::over(range.clone(), 9), range, ticks }
            }
        }
    }

    fn coordinate(&self) -> Ticked {
        Ticked { even: self.range.clone().into(), ticks: self.ticks.clone() }
    }

    fn at(&self, value: f64) -> f64 {
        if self.scale == Scale::Log { value.log10() } else { value }
    }

    fn label(&self, place: f64) -> String {
        match self.scale {
            Scale::Linear => self.axis.label(place),
            Scale::Log => round_label(10_f64.powf(place)),
        }
    }
}

/// An evenly spaced axis with ticks of our choice.
struct Ticked {
    even: RangedCoordf64,
    ticks: Vec<f64>,
}

impl Ranged for Ticked {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        self.even.map(value, limit)
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        self.ticks.clone()
    }

    fn range(&self) -> Range<f64> {
        self.even.range()
    }
}

/// Formats a round number; uses a power of ten where the reader would have to count zeros.
fn round_label(value: f64) -> String {
    if (1e-4..1e6).contains(&value) {
        // conversion from the logarithm leaves rounding errors after the last digit
        return plain((value * 1e6).round() / 1e6);
    }
    format!("{value:.1e}").replace(".0e", "e").replace('-', "\u{2212}")
}

impl Picture for Drawing<'_> {
    fn draw<DB: DrawingBackend>(&self, area: &Area<DB>) -> Drawn<DB> {
        let data = self.lines;
        title(area, data.title, data.below)?;
        let signs = data.series.iter().enumerate().map(|(n, s)| {
            let sign = Sign::Line { look: distinct(n), joined: s.joined, marked: s.marked };
            (sign, s.name)
        });
        let entries: Vec<_> = signs.chain(data.levels.iter().map(|l| (Sign::Dashes(MUTED), l.name))).collect();
        let taken = key_column::room(area, &entries)?;
        let mut chart = builder(area).margin_right(taken).build_cartesian_2d(self.x.coordinate(), self.y.coordinate())?;
        axes(
            &mut chart,
            Labels { title: data.x.title, ticks: 12, of: &|v| self.x.label(*v) },
            Labels { title: data.y.title, ticks: 12, of: &|v| self.y.label(*v) },
        )?;
        let (xs, _) = chart.plotting_area().get_pixel_range();
        for level in data.levels {
            let y = chart.backend_coord(&(self.x.range.start, self.y.at(level.y))).1;
            area.draw(&DashedPathElement::new([(xs.start, y), (xs.end, y)], px(7.0), px(5.0), line(MUTED, 1.6)))?;
        }
        for (n, series) in data.series.iter().enumerate() {
            let look = distinct(n);
            let path: Vec<_> = series.points.iter().map(|p| chart.backend_coord(&(self.x.at(p.0), self.y.at(p.1)))).collect();
            if series.joined {
                area.draw(&PathElement::new(path.clone(), line(look.color, 2.2)))?;
            }
            for at in path.into_iter().filter(|_| series.marked) {
                area.draw(&Polygon::new(outline(look.shape, at, px(4.6)), look.color.filled()))?;
            }
        }
        key_column::draw(area, &entries, taken, px(TITLE_HEIGHT_PX))
    }
}

struct Drawing<'a> {
    lines: &'a Lines<'a>,
    x: Ruler,
    y: Ruler,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rulers_hold_their_values_and_have_ticks() {
        for values in [vec![0.3], vec![1.0, 5.0], vec![1e-4, 1e4], vec![99.9, 100.1], vec![1e9, 1e9]] {
            for scale in [Scale::Linear, Scale::Log] {
                let ruler = Ruler::new(scale, values.iter().copied());
                assert!(values.iter().all(|v| ruler.range.contains(&ruler.at(*v))), "{values:?} {scale:?}");
                let labels: Vec<_> = ruler.ticks.iter().map(|t| ruler.label(*t)).collect();
                assert!((2..=12).contains(&labels.len()), "{values:?} {scale:?} {labels:?}");
                assert!(labels.windows(2).all(|p| p[0] != p[1]), "{labels:?}");
            }
        }
    }
}
