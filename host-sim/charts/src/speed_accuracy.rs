//! Draws speed against accuracy: cost per tick and error of every method, with the Pareto front.

mod key;
pub(super) mod marker;

use std::ops::Range;
use std::path::Path;

use plotters::coord::combinators::{BindKeyPoints, IntoLogRange};
use plotters::element::{PathElement, Polygon};
use plotters::prelude::DrawingBackend;
use plotters::style::text_anchor::{HPos, VPos};
use plotters::style::{Color, WHITE};

use super::canvas::Area;
use super::canvas::Drawn;
use super::layout::{Labels, axes, builder, title, width};
use super::picture::{Picture, save};
use super::place::{Frame, Page};
use super::style::{INK, MUTED, TICK_PX, WARN, line, px, text};
use super::tick_time::histogram::round_points;
use super::tick_time::plain;
use super::{ChartError, check};
use marker::{Look, look, outline, radius_px};

/// Colour of the Pareto front.
const FRONT: plotters::style::RGBColor = plotters::style::RGBColor(0xb9, 0xc0, 0xc7);

/// Data and labels of a speed-accuracy chart.
#[derive(Clone, Copy, Debug)]
pub struct SpeedAccuracy<'a> {
    /// First line above the chart.
    pub title: &'a str,
    /// Second line above the chart: machine and build.
    pub below: &'a str,
    /// Quantity and unit along x.
    pub cost: &'a str,
    /// Quantity and unit along y.
    pub error: &'a str,
    /// Largest cost that a tick may have, with its name; `None` where x is not a cost.
    pub budget: Option<(f64, &'a str)>,
    /// Methods in the order of the legend; a method without points is left out.
    pub methods: &'a [MethodPoints<'a>],
    /// Pareto front in the order of increasing cost, as (index of the method, index of its point).
    pub front: &'a [(usize, usize)],
}

/// Results of one method for several mesh sizes.
#[derive(Clone, Debug)]
pub struct MethodPoints<'a> {
    /// Name of the method in the legend.
    pub name: &'a str,
    /// Points in the order of increasing size.
    pub points: Vec<MethodPoint>,
}

/// Result of one method for one mesh size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MethodPoint {
    /// Number of nodes of the mesh.
    pub nodes: usize,
    /// Number of parts into which each substep of the method is divided; drawn as `x2` and so on.
    pub split: u16,
    /// Cost per tick, above 0.
    pub cost: f64,
    /// Error, above 0.
    pub error: f64,
    /// Whether the method survived the press; otherwise it is drawn hollow.
    pub survived: bool,
}

/// Writes `NAME.svg` and `NAME.png` into `folder`.
///
/// # Errors
/// Fails if there are no points, if a cost or an error is not above zero, or if the folder cannot
/// be written.
pub fn speed_accuracy(folder: &Path, name: &str, chart: &SpeedAccuracy) -> Result<(), ChartError> {
    let points = || chart.methods.iter().flat_map(|m| &m.points);
    for (what, of) in [("cost", (|p| p.cost) as fn(&MethodPoint) -> f64), ("error", |p| p.error)] {
        check(what, points().map(of))?;
        if let Some((index, value)) = points().map(of).enumerate().find(|(_, v)| *v <= 0.0) {
            return Err(ChartError::NotDrawable { what, index, value });
        }
    }
    if points().next().is_none() {
        return Err(ChartError::Empty { what: "methods" });
    }
    let with_budget = points().map(|p| p.cost).chain(chart.budget.map(|b| b.0));
    let picture = Drawing { chart, x: wide(with_budget), y: wide(points().map(|p| p.error)) };
    save(folder, name, &picture)
}

/// A logarithmic range with some margin at both ends.
fn wide(values: impl Iterator<Item = f64>) -> Range<f64> {
    let (low, high) = values.fold((f64::INFINITY, 0.0_f64), |(low, high), v| (low.min(v), high.max(v)));
    let room = (high / low).max(4.0).powf(0.06);
    low / room..high * room
}

struct Drawing<'a> {
    chart: &'a SpeedAccuracy<'a>,
    x: Range<f64>,
    y: Range<f64>,
}

impl Picture for Drawing<'_> {
    fn draw<DB: DrawingBackend>(&self, area: &Area<DB>) -> Drawn<DB> {
        let data = self.chart;
        title(area, data.title, data.below)?;
        let x_points = round_points(&self.x, 10);
        let y_points = round_points(&self.y, 10);
        let mut chart = builder(area).margin_right(key::room(area, data)?).build_cartesian_2d(
            self.x.clone().log_scale().with_key_points(x_points),
            self.y.clone().log_scale().with_key_points(y_points),
        )?;
        axes(
            &mut chart,
            Labels { title: data.cost, ticks: 10, of: &|v| plain(*v) },
            Labels { title: data.error, ticks: 10, of: &|v| plain(*v) },
        )?;
        let at = |p: &MethodPoint| chart.backend_coord(&(p.cost, p.error));
        let (xs, ys) = chart.plotting_area().get_pixel_range();
        let mut page = Page::new(Frame { low: (xs.start, ys.start), high: (xs.end, ys.end) });

        if let Some((budget, name)) = data.budget {
            let x = chart.backend_coord(&(budget, self.y.start)).0;
            area.draw(&PathElement::new([(x, ys.start), (x, ys.end)], line(WARN, 1.4)))?;
            let style = text(TICK_PX, WARN, (HPos::Right, VPos::Center));
            area.draw_text(name, &style, (x - px(6.0), ys.start + px(12.0)))?;
            let taken = width(area, name, &style)?;
            page.add_box(Frame { low: (x - px(10.0) - taken, ys.start), high: (x + px(4.0), ys.start + px(22.0)) });
            page.add_curve([(x, ys.start), (x, ys.end)], px(3.0));
        }

        let stairs = self.stairs(&at, xs.end, ys.start);
        area.draw(&PathElement::new(stairs.clone(), line(FRONT, 6.0)))?;
        page.add_curve(stairs, px(3.0));

        for (index, method) in data.methods.iter().enumerate() {
            let Look { color, shape } = look(index);
            // points with the same split are joined by one line
            let mut splits: Vec<u16> = method.points.iter().map(|p| p.split).collect();
            splits.sort_unstable();
            splits.dedup();
            for split in splits {
                let path: Vec<_> = method.points.iter().filter(|p| p.split == split).map(at).collect();
                area.draw(&PathElement::new(path.clone(), line(color, 1.2)))?;
                page.add_curve(path, px(3.0));
            }
            for point in &method.points {
                let (center, r) = (at(point), px(radius_px(point.nodes)));
                area.draw(&Polygon::new(outline(shape, center, r + px(1.2)), WHITE.filled()))?;
                area.draw(&Polygon::new(outline(shape, center, r), color.filled()))?;
                if !point.survived {
                    area.draw(&Polygon::new(outline(shape, center, r - px(1.8)), WHITE.filled()))?;
                }
                page.add_dot(center, r + px(1.0));
            }
        }
        self.name_front(area, &at, &mut page)?;
        key::draw(area, data, xs.end + px(14.0), ys.start)
    }
}

impl Drawing<'_> {
    /// The Pareto front as stairs: the smallest error that is reached at each cost.
    fn stairs(&self, at: &impl Fn(&MethodPoint) -> (i32, i32), right: i32, top: i32) -> Vec<(i32, i32)> {
        let corners: Vec<_> = self.front().map(|(_, p)| at(p)).collect();
        let mut stairs = Vec::new();
        if let Some(first) = corners.first() {
            stairs.push((first.0, top));
        }
        for pair in corners.windows(2) {
            stairs.extend([pair[0], (pair[1].0, pair[0].1)]);
        }
        if let Some(last) = corners.last() {
            stairs.extend([*last, (right, last.1)]);
        }
        stairs
    }

    /// Methods and points of the Pareto front.
    fn front(&self) -> impl Iterator<Item = (&MethodPoints<'_>, &MethodPoint)> {
        self.chart.front.iter().filter_map(|&(m, p)| {
            let method = self.chart.methods.get(m)?;
            Some((method, method.points.get(p)?))
        })
    }

    /// Writes the number of nodes beside each point of the front, where there is room.
    fn name_front<DB: DrawingBackend>(
        &self,
        area: &Area<DB>,
        at: &impl Fn(&MethodPoint) -> (i32, i32),
        page: &mut Page,
    ) -> Drawn<DB> {
        let plain = text(TICK_PX, INK, (HPos::Left, VPos::Center));
        for (method, point) in self.front() {
            let short = label(point);
            for label in [format!("{} {short}", method.name), short] {
                let size = (width(area, &label, &plain)?, px(TICK_PX * 1.1));
                if let Some((corner, anchor)) = page.place(at(point), size, px(9.0)) {
                    area.draw_text(&label, &text(TICK_PX, MUTED, anchor), corner)?;
                    break;
                }
            }
        }
        Ok(())
    }
}

/// Label of a point: number of nodes, and the split of the substeps if there is one.
fn label(point: &MethodPoint) -> String {
    match point.split {
        0 | 1 => point.nodes.to_string(),
        split => format!("{} x{split}", point.nodes),
    }
}
