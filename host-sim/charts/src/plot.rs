//! Draws curves and points over one pair of axes, each of which is linear or logarithmic.

use std::ops::Range;
use std::path::Path;

use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint, Ranged};
use plotters::coord::types::RangedCoordf64;
use plotters::element::{Circle, DashedPathElement, PathElement, Polygon};
use plotters::prelude::DrawingBackend;
use plotters::style::text_anchor::{HPos, VPos};
use plotters::style::{Color, RGBColor, WHITE};

use super::axis::Axis;
use super::canvas::Area;
use super::canvas::Drawn;
use super::key_column::{self, Sign};
use super::layout::{Labels, TITLE_HEIGHT_PX, axes, builder, title, width};
use super::marker::{self, DISTINCT, Look, look, outline};
use super::picture::{Picture, save};
use super::place::{Frame, Page};
use super::style::{INK, MUTED, TICK_PX, WARN, line, px, text};
use super::{ChartError, check_series};

/// Colour of the front.
const FRONT: RGBColor = RGBColor(0xb9, 0xc0, 0xc7);

/// Spacing of values along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Even spacing; the axis begins at zero if the data come near it.
    Linear,
    /// Logarithmic spacing; all values are above zero.
    Log,
}

/// Title and scale of one axis.
#[derive(Clone, Debug)]
pub struct ScaledAxis {
    /// Quantity and unit, such as `depth [mm]`.
    pub title: String,
    /// Scale along the axis.
    pub scale: Scale,
}

impl ScaledAxis {
    /// An evenly spaced axis.
    pub fn linear(title: impl Into<String>) -> Self {
        Self { title: title.into(), scale: Scale::Linear }
    }

    /// A logarithmic axis.
    pub fn log(title: impl Into<String>) -> Self {
        Self { title: title.into(), scale: Scale::Log }
    }
}

/// One point, in the units of the axes.
#[derive(Clone, Debug)]
pub struct Dot {
    /// Position along x and along y.
    pub at: (f64, f64),
    /// Radius of the marker in pixels.
    pub radius_px: f64,
    /// Whether the marker is an outline, through which other markers are seen.
    pub hollow: bool,
    /// Whether a ring is drawn around the marker.
    pub ringed: bool,
    /// Text beside the marker, left out where there is no room; may be empty.
    pub label: String,
}

impl From<(f64, f64)> for Dot {
    fn from(at: (f64, f64)) -> Self {
        Self { at, radius_px: 4.6, hollow: false, ringed: false, label: String::new() }
    }
}

/// One curve, or the points of one kind. Series of the same name have the same look.
#[derive(Clone, Debug)]
pub struct Series {
    /// Name in the legend.
    pub name: String,
    /// Points in drawing order; a series without points only keeps its place among the looks.
    pub dots: Vec<Dot>,
    /// Whether the points are joined by a line.
    pub joined: bool,
    /// Whether a marker is drawn at every point.
    pub marked: bool,
    /// Whether the line is dashed, because it may lie on another.
    pub dashed: bool,
}

impl Series {
    /// A curve without markers.
    pub fn curve(name: impl Into<String>, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        Self { name: name.into(), dots: points.into_iter().map(Dot::from).collect(), joined: true, marked: false, dashed: false }
    }

    /// Adds a marker at every point.
    pub fn marked(self) -> Self {
        Self { marked: true, ..self }
    }

    /// Points that are not joined.
    pub fn dots(name: impl Into<String>, dots: Vec<Dot>) -> Self {
        Self { name: name.into(), dots, joined: false, marked: true, dashed: false }
    }
}

/// A reference line across the whole plot.
#[derive(Clone, Debug)]
pub struct Level {
    /// Name in the legend.
    pub name: String,
    /// Position of the line, in the unit of its axis.
    pub at: f64,
}

impl Level {
    /// A line with this name at this position.
    pub fn new(name: impl Into<String>, at: f64) -> Self {
        Self { name: name.into(), at }
    }
}

/// Curves and points over one pair of axes.
#[derive(Clone, Debug)]
pub struct Plot {
    /// Axis along the bottom.
    pub x: ScaledAxis,
    /// Axis along the left side.
    pub y: ScaledAxis,
    /// Curves and kinds of points, in the order of the legend.
    pub series: Vec<Series>,
    /// Dashed horizontal lines; may be empty.
    pub levels: Vec<Level>,
    /// Vertical line at the largest x that is allowed, labelled with its name.
    pub budget: Option<Level>,
    /// Points that no other beats in both axes, in the order of increasing x; may be empty.
    pub front: Vec<(f64, f64)>,
    /// Radii of markers in pixels with their meaning; may be empty.
    pub sizes: Vec<(f64, String)>,
}

impl Plot {
    /// Curves over these axes.
    pub fn new(x: ScaledAxis, y: ScaledAxis, series: Vec<Series>) -> Self {
        Self { x, y, series, levels: Vec::new(), budget: None, front: Vec::new(), sizes: Vec::new() }
    }

    /// Adds dashed horizontal lines.
    pub fn levels(self, levels: impl IntoIterator<Item = Level>) -> Self {
        Self { levels: levels.into_iter().collect(), ..self }
    }

    /// Checks the values and determines the axes.
    fn drawing(&self) -> Result<Drawing<'_>, ChartError> {
        let log = |axis: &ScaledAxis| axis.scale == Scale::Log;
        let dots = || self.series.iter().flat_map(|s| s.dots.iter());
        if dots().next().is_none() {
            return Err(ChartError::Empty { what: "series" });
        }
        for series in &self.series {
            check_series(&series.name, "x", series.dots.iter().map(|d| d.at.0), log(&self.x))?;
            check_series(&series.name, "y", series.dots.iter().map(|d| d.at.1), log(&self.y))?;
        }
        for level in &self.levels {
            check_series(&level.name, "level", [level.at], log(&self.y))?;
        }
        let mut names: Vec<&str> = Vec::new();
        for series in &self.series {
            if !names.contains(&series.name.as_str()) {
                names.push(&series.name);
            }
        }
        let x = Ruler::new(self.x.scale, dots().map(|d| d.at.0).chain(self.budget.iter().map(|b| b.at)));
        let y = Ruler::new(self.y.scale, dots().map(|d| d.at.1).chain(self.levels.iter().map(|l| l.at)));
        Ok(Drawing { plot: self, names, x, y })
    }
}

/// Writes plots one above the other; only the lowest has labels below its axis.
pub(super) fn save_plots(plots: &[Plot], folder: &Path, name: &str, title: [&str; 2]) -> Result<(), ChartError> {
    let drawings = plots.iter().map(Plot::drawing).collect::<Result<Vec<_>, _>>()?;
    save(folder, name, &Panels { title, drawings })
}

/// Maps values to plotted quantities, which are evenly spaced in the picture.
pub(super) struct Ruler {
    scale: Scale,
    /// Range of the plotted quantities: values, or their decimal logarithms.
    pub range: Range<f64>,
    /// Ticks of the axis, as plotted quantities.
    pub ticks: Vec<f64>,
    axis: Axis,
}

impl Ruler {
    pub fn new(scale: Scale, values: impl Iterator<Item = f64>) -> Self {
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

    pub fn at(&self, value: f64) -> f64 {
        if self.scale == Scale::Log { value.log10() } else { value }
    }

    pub fn label(&self, place: f64) -> String {
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

/// Formats a number without trailing zeros.
fn plain(value: f64) -> String {
    let digits = format!("{value:.6}");
    digits.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// Round numbers for a logarithmic axis over `range`, as fine as possible with at most `most` of
/// them.
fn round_points(range: &Range<f64>, most: usize) -> Vec<f64> {
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

/// Formats a round number; uses a power of ten where the reader would have to count zeros.
fn round_label(value: f64) -> String {
    if (1e-4..1e6).contains(&value) {
        // conversion from the logarithm leaves rounding errors after the last digit
        return plain((value * 1e6).round() / 1e6);
    }
    format!("{value:.1e}").replace(".0e", "e").replace('-', "\u{2212}")
}

struct Panels<'a> {
    title: [&'a str; 2],
    drawings: Vec<Drawing<'a>>,
}

/// Height of the labels below an axis, and distance between two plots [px].
const LABELS_PX: f64 = 54.0;
const BETWEEN_PX: f64 = 14.0;

impl Picture for Panels<'_> {
    fn draw<DB: DrawingBackend>(&self, area: &Area<DB>) -> Drawn<DB> {
        title(area, self.title[0], self.title[1])?;
        let plots = area.dim_in_pixel().1.cast_signed() - px(TITLE_HEIGHT_PX + LABELS_PX);
        // every plot leaves room for the widest legend, so that all are equally wide
        let mut taken = 0;
        for drawing in &self.drawings {
            taken = taken.max(key_column::room(area, &drawing.entries())?);
        }
        let (mut rest, mut top_px) = (area.clone(), TITLE_HEIGHT_PX);
        for (n, drawing) in self.drawings.iter().enumerate() {
            let last = n + 1 == self.drawings.len();
            let height = px(top_px) + plots / self.drawings.len() as i32;
            let (panel, below) = if last { (rest.clone(), rest) } else { rest.split_vertically(height) };
            drawing.draw(&panel, taken, top_px, if last { LABELS_PX } else { 0.0 })?;
            (rest, top_px) = (below, BETWEEN_PX);
        }
        Ok(())
    }
}

impl Drawing<'_> {
    /// Entries of the legend.
    fn entries(&self) -> Vec<(Sign, &str)> {
        let plot = self.plot;
        let drawn = |name: &&str| plot.series.iter().find(|s| s.name == *name && !s.dots.is_empty());
        let hollow = |s: &Series| s.dots.iter().all(|d| d.hollow);
        let sign = |s: &Series| Sign::Line { look: self.look(&s.name), joined: s.joined, marked: s.marked, hollow: hollow(s) };
        let mut entries: Vec<_> = self.names.iter().filter_map(|name| Some((sign(drawn(name)?), *name))).collect();
        entries.extend(plot.levels.iter().map(|level| (Sign::Dashes(MUTED), level.name.as_str())));
        if !plot.front.is_empty() {
            entries.push((Sign::Wire(FRONT), "unbeaten in both"));
        }
        entries.extend(plot.sizes.iter().map(|(radius_px, meaning)| (Sign::Disc(*radius_px), meaning.as_str())));
        entries
    }

    fn draw<DB: DrawingBackend>(&self, area: &Area<DB>, taken: i32, top_px: f64, labels_px: f64) -> Drawn<DB> {
        let plot = self.plot;
        let mut chart = builder(area)
            .margin_top(px(top_px))
            .margin_right(taken)
            .x_label_area_size(px(labels_px))
            .build_cartesian_2d(self.x.coordinate(), self.y.coordinate())?;
        axes(
            &mut chart,
            Labels { title: &plot.x.title, ticks: 12, of: &|v| self.x.label(*v) },
            Labels { title: &plot.y.title, ticks: 12, of: &|v| self.y.label(*v) },
        )?;
        // the chart's coordinates are those of the canvas, the area's begin at its own corner
        let (left, top) = area.get_base_pixel();
        let at = |(x, y): (f64, f64)| {
            let (x, y) = chart.backend_coord(&(self.x.at(x), self.y.at(y)));
            (x - left, y - top)
        };
        let (xs, ys) = chart.plotting_area().get_pixel_range();
        let (xs, ys) = (xs.start - left..xs.end - left, ys.start - top..ys.end - top);
        let corner = (self.x.range.start, self.y.range.start);
        let across = |level: f64| chart.backend_coord(&(corner.0, self.y.at(level))).1 - top;
        let mut page = Page::new(Frame { low: (xs.start, ys.start), high: (xs.end, ys.end) });
        for level in &plot.levels {
            let y = across(level.at);
            area.draw(&DashedPathElement::new([(xs.start, y), (xs.end, y)], px(7.0), px(5.0), line(MUTED, 1.6)))?;
        }
        if let Some(budget) = &plot.budget {
            let x = chart.backend_coord(&(self.x.at(budget.at), corner.1)).0 - left;
            area.draw(&PathElement::new([(x, ys.start), (x, ys.end)], line(WARN, 1.4)))?;
            let style = text(TICK_PX, WARN, (HPos::Right, VPos::Center));
            area.draw_text(&budget.name, &style, (x - px(6.0), ys.start + px(12.0)))?;
            let left = x - px(10.0) - width(area, &budget.name, &style)?;
            page.add_box(Frame { low: (left, ys.start), high: (x + px(4.0), ys.start + px(22.0)) });
            page.add_curve([(x, ys.start), (x, ys.end)], px(3.0));
        }
        let corners: Vec<_> = plot.front.iter().copied().map(at).collect();
        let stairs = stairs(&corners, xs.end, ys.start);
        area.draw(&PathElement::new(stairs.clone(), line(FRONT, 6.0)))?;
        page.add_curve(stairs, px(3.0));
        for series in &plot.series {
            let look = self.look(&series.name);
            let path: Vec<_> = series.dots.iter().map(|d| at(d.at)).collect();
            if series.joined {
                let style = line(look.color, if series.marked || series.dashed { 1.6 } else { 2.2 });
                match series.dashed {
                    true => area.draw(&DashedPathElement::new(path.clone(), px(7.0), px(5.0), style))?,
                    false => area.draw(&PathElement::new(path.clone(), style))?,
                }
                page.add_curve(path.clone(), px(3.0));
            }
            for (dot, center) in series.dots.iter().zip(path).filter(|_| series.marked) {
                let radius = px(dot.radius_px);
                if dot.ringed {
                    area.draw(&Circle::new(center, radius + px(5.0), line(INK, 1.6)))?;
                }
                if !dot.hollow {
                    area.draw(&Polygon::new(outline(look.shape, center, radius + px(1.2)), WHITE.filled()))?;
                }
                marker::draw(area, look, center, radius, dot.hollow)?;
                page.add_dot(center, radius + px(1.0));
            }
        }
        let plain = text(TICK_PX, INK, (HPos::Left, VPos::Center));
        for dot in plot.series.iter().flat_map(|s| &s.dots).filter(|d| !d.label.is_empty()) {
            let size = (width(area, &dot.label, &plain)?, px(TICK_PX * 1.1));
            if let Some((corner, anchor)) = page.place(at(dot.at), size, px(9.0)) {
                area.draw_text(&dot.label, &text(TICK_PX, MUTED, anchor), corner)?;
            }
        }
        key_column::draw(area, &self.entries(), taken, px(top_px))
    }
}

/// The front as stairs: the smallest y that is reached at each x.
fn stairs(corners: &[(i32, i32)], right: i32, top: i32) -> Vec<(i32, i32)> {
    let (Some(first), Some(last)) = (corners.first(), corners.last()) else { return Vec::new() };
    let steps = corners.windows(2).flat_map(|pair| [pair[0], (pair[1].0, pair[0].1)]);
    std::iter::once((first.0, top)).chain(steps).chain([*last, (right, last.1)]).collect()
}

struct Drawing<'a> {
    plot: &'a Plot,
    /// Distinct names of the series, which determine their looks.
    names: Vec<&'a str>,
    x: Ruler,
    y: Ruler,
}

impl Drawing<'_> {
    fn look(&self, name: &str) -> Look {
        let index = self.names.iter().position(|n| *n == name).unwrap_or(0);
        // the looks of many series are less distinct than those of a few
        if self.names.len() > DISTINCT.len() { look(index) } else { DISTINCT[index] }
    }
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
