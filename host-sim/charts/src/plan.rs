//! Draws the models that `plan` searched: cost per tick against the tolerance that a model meets,
//! with the budget and the requested tolerance.

use std::ops::Range;
use std::path::Path;

use plotters::coord::combinators::{BindKeyPoints, IntoLogRange};
use plotters::element::{Circle, DashedPathElement, PathElement, Polygon};
use plotters::prelude::DrawingBackend;
use plotters::style::text_anchor::{HPos, VPos};
use plotters::style::{Color, WHITE};

use super::canvas::Area;
use super::canvas::Drawn;
use super::key_column::{self, Sign};
use super::layout::{Labels, TITLE_HEIGHT_PX, axes, builder, title, width};
use super::picture::{Picture, save};
use super::place::{Frame, Page};
use super::speed_accuracy::marker::{Look, distinct, outline};
use super::style::{INK, MUTED, TICK_PX, WARN, line, px, text};
use super::tick_time::histogram::round_points;
use super::tick_time::plain;
use super::{ChartError, check};

/// Ratio of the budget to the largest cost above which the budget is not drawn (1).
const FAR_BUDGET: f64 = 6.0;

/// Data and labels of a plan chart.
#[derive(Clone, Copy, Debug)]
pub struct PlanChart<'a> {
    /// First line above the chart.
    pub title: &'a str,
    /// Second line above the chart.
    pub below: &'a str,
    /// Quantity and unit along x.
    pub cost: &'a str,
    /// Quantity and unit along y.
    pub error: &'a str,
    /// Largest cost that a tick may have, in the unit of `cost`.
    pub budget: f64,
    /// Requested tolerance [%].
    pub tolerance: f64,
    /// Names of the kinds of models, in the order of the legend.
    pub kinds: &'a [&'a str],
    /// All models that were searched.
    pub dots: &'a [PlanDot],
}

/// A model of the search, drawn as a dot.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanDot {
    /// Index of the model's kind in `kinds`.
    pub kind: usize,
    /// Cost per tick, above 0.
    pub cost: f64,
    /// Error [%], above 0.
    pub error: f64,
    /// Whether the model was fitted completely; otherwise it is drawn hollow.
    pub full: bool,
    /// Whether this is the chosen model, which is drawn with a ring around it.
    pub chosen: bool,
    /// Text beside the dot; may be empty.
    pub label: String,
}

/// Writes `NAME.svg` and `NAME.png` into `folder`.
///
/// # Errors
/// Fails if there are no dots, if a cost or an error is not above zero, or if the folder cannot be
/// written.
pub fn plan(folder: &Path, name: &str, chart: &PlanChart) -> Result<(), ChartError> {
    if chart.dots.is_empty() {
        return Err(ChartError::Empty { what: "dots" });
    }
    for (what, of) in [("cost", (|d| d.cost) as fn(&PlanDot) -> f64), ("error", |d| d.error)] {
        check(what, chart.dots.iter().map(of))?;
        if let Some((index, value)) = chart.dots.iter().map(of).enumerate().find(|(_, v)| *v <= 0.0) {
            return Err(ChartError::NotDrawable { what, index, value });
        }
    }
    let dearest = chart.dots.iter().map(|d| d.cost).fold(0.0, f64::max);
    let drawn = (chart.budget <= FAR_BUDGET * dearest).then_some(chart.budget);
    let picture = Drawing {
        chart,
        budget: drawn,
        x: wide(chart.dots.iter().map(|d| d.cost).chain(drawn)),
        y: wide(chart.dots.iter().map(|d| d.error).chain([chart.tolerance])),
    };
    save(folder, name, &picture)
}

fn wide(values: impl Iterator<Item = f64>) -> Range<f64> {
    let (low, high) = values.fold((f64::INFINITY, 0.0_f64), |(low, high), v| (low.min(v), high.max(v)));
    let room = (high / low).max(4.0).powf(0.08);
    low / room..high * room
}

struct Drawing<'a> {
    chart: &'a PlanChart<'a>,
    budget: Option<f64>,
    x: Range<f64>,
    y: Range<f64>,
}

impl Picture for Drawing<'_> {
    fn draw<DB: DrawingBackend>(&self, area: &Area<DB>) -> Drawn<DB> {
        let data = self.chart;
        title(area, data.title, data.below)?;
        let look = |kind: usize| Sign::Line { look: distinct(kind), joined: false, marked: true };
        let entries: Vec<_> = data.kinds.iter().enumerate().map(|(n, name)| (look(n), *name)).collect();
        let taken = key_column::room(area, &entries)?;
        let mut chart = builder(area).margin_right(taken).build_cartesian_2d(
            self.x.clone().log_scale().with_key_points(round_points(&self.x, 10)),
            self.y.clone().log_scale().with_key_points(round_points(&self.y, 10)),
        )?;
        axes(
            &mut chart,
            Labels { title: data.cost, ticks: 10, of: &|v| plain(*v) },
            Labels { title: data.error, ticks: 10, of: &|v| plain(*v) },
        )?;
        let (xs, ys) = chart.plotting_area().get_pixel_range();
        let mut page = Page::new(Frame { low: (xs.start, ys.start), high: (xs.end, ys.end) });
        if let Some(budget) = self.budget {
            let x = chart.backend_coord(&(budget, self.y.start)).0;
            area.draw(&PathElement::new([(x, ys.start), (x, ys.end)], line(WARN, 1.4)))?;
            let words = "budget of the board";
            let style = text(TICK_PX, WARN, (HPos::Right, VPos::Center));
            area.draw_text(words, &style, (x - px(6.0), ys.start + px(12.0)))?;
            let wide = width(area, words, &style)?;
            page.add_box(Frame { low: (x - px(10.0) - wide, ys.start), high: (x + px(4.0), ys.start + px(24.0)) });
            page.add_curve([(x, ys.start), (x, ys.end)], px(3.0));
        }
        let y = chart.backend_coord(&(self.x.start, data.tolerance)).1;
        area.draw(&DashedPathElement::new([(xs.start, y), (xs.end, y)], px(7.0), px(5.0), line(MUTED, 1.6)))?;
        let words = format!("{} % asked for", plain(data.tolerance));
        let style = text(TICK_PX, MUTED, (HPos::Left, VPos::Bottom));
        area.draw_text(&words, &style, (xs.start + px(6.0), y - px(3.0)))?;
        let wide = width(area, &words, &style)?;
        page.add_box(Frame { low: (xs.start, y - px(22.0)), high: (xs.start + wide + px(10.0), y) });
        page.add_curve([(xs.start, y), (xs.end, y)], px(3.0));

        let at = |dot: &PlanDot| chart.backend_coord(&(dot.cost, dot.error));
        // hollow dots are drawn first, so that a filled dot at the same place stays visible
        for full in [false, true] {
            for dot in data.dots.iter().filter(|d| d.full == full) {
                let Look { color, shape } = distinct(dot.kind);
                let center = at(dot);
                area.draw(&Polygon::new(outline(shape, center, px(6.6)), WHITE.filled()))?;
                area.draw(&Polygon::new(outline(shape, center, px(5.6)), color.filled()))?;
                if !full {
                    area.draw(&Polygon::new(outline(shape, center, px(3.8)), WHITE.filled()))?;
                }
                if dot.chosen {
                    area.draw(&Circle::new(center, px(11.0), line(INK, 2.2)))?;
                }
                page.add_dot(center, px(if dot.chosen { 13.0 } else { 7.0 }));
            }
        }
        for dot in data.dots.iter().filter(|d| !d.label.is_empty()) {
            let style = text(TICK_PX, INK, (HPos::Left, VPos::Center));
            let size = (width(area, &dot.label, &style)?, px(TICK_PX * 1.1));
            let gap = px(if dot.chosen { 16.0 } else { 10.0 });
            if let Some((corner, anchor)) = page.place(at(dot), size, gap) {
                area.draw_text(&dot.label, &text(TICK_PX, if dot.chosen { INK } else { MUTED }, anchor), corner)?;
                page.add_box(label_frame(corner, size, anchor));
            }
        }
        key_column::draw(area, &entries, taken, px(TITLE_HEIGHT_PX))
    }
}

/// Returns the frame that a label occupies, so that the next label avoids it.
fn label_frame((x, y): (i32, i32), (wide, high): (i32, i32), (h, v): (HPos, VPos)) -> Frame {
    let left = match h {
        HPos::Left => x,
        HPos::Center => x - wide / 2,
        HPos::Right => x - wide,
    };
    let top = match v {
        VPos::Top => y,
        VPos::Center => y - high / 2,
        VPos::Bottom => y - high,
    };
    Frame { low: (left, top), high: (left + wide, top + high) }
}
