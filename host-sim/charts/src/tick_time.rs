//! Draws how long the ticks took: a histogram in which median, 99th percentile and longest tick are
//! marked.

pub(super) mod histogram;

use std::ops::Range;
use std::path::Path;

use plotters::coord::combinators::{BindKeyPoints, IntoLogRange};
use plotters::element::{PathElement, Rectangle};
use plotters::prelude::DrawingBackend;
use plotters::style::Color;
use plotters::style::text_anchor::{HPos, VPos};

use super::canvas::Area;
use super::canvas::Drawn;
use super::layout::{Labels, axes, builder, title};
use super::picture::{Picture, save};
use super::style::{BAR, DEPTH, LABEL_PX, WARN, line, px, text};
use super::{ChartError, check};
use histogram::{BARS, BUDGET_US, count, percentile, round_points, time_range};

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

/// Writes `NAME.svg` and `NAME.png` into `folder`.
///
/// # Errors
/// Fails if there are no ticks, if a time is negative or cannot be drawn, or if the folder cannot
/// be written.
pub fn tick_time(folder: &Path, name: &str, times: &TickTimes) -> Result<(), ChartError> {
    let mut sorted_us: Vec<f64> = times.tick_us.iter().map(|t| f64::from(*t)).collect();
    check("tick_us", sorted_us.iter().copied())?;
    if let Some(index) = sorted_us.iter().position(|t| *t < 0.0) {
        let value = sorted_us.get(index).copied().unwrap_or_default();
        let what = "tick_us";
        return Err(ChartError::NotDrawable { what, index, value });
    }
    sorted_us.sort_unstable_by(f64::total_cmp);
    let (Some(p50), Some(p99), Some(max)) =
        (percentile(&sorted_us, 0.50), percentile(&sorted_us, 0.99), sorted_us.last().copied())
    else {
        return Err(ChartError::Empty { what: "tick_us" });
    };
    let x = time_range(&sorted_us, max);
    let chart = TickTime {
        times,
        bars: count(&sorted_us, &x),
        over: sorted_us.iter().filter(|t| **t > BUDGET_US).count(),
        x,
        marks: [("median", p50), ("99 % below", p99), ("longest", max)],
    };
    save(folder, name, &chart)
}

struct TickTime<'a> {
    times: &'a TickTimes<'a>,
    x: Range<f64>,
    bars: Vec<usize>,
    /// Number of ticks that took longer than the budget.
    over: usize,
    marks: [(&'static str, f64); 3],
}

/// Formats a number without trailing zeros.
pub(super) fn plain(value: f64) -> String {
    let digits = format!("{value:.6}");
    digits.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// Formats a time [us] to about three significant digits.
fn micros(t: f64) -> String {
    let decimals = usize::from(t < 99.95) + usize::from(t < 9.995);
    format!("{t:.decimals$} µs")
}

impl TickTime<'_> {
    fn budget_line(&self) -> String {
        let ticks = self.times.tick_us.len();
        format!(
            "{} nodes, {ticks} ticks, {} over the budget of 1000 µs; {}",
            self.times.node_count,
            if self.over == 0 { "none".to_owned() } else { self.over.to_string() },
            self.times.machine,
        )
    }
}

impl Picture for TickTime<'_> {
    fn draw<DB: DrawingBackend>(&self, area: &Area<DB>) -> Drawn<DB> {
        let top = format!("{}: time of a tick", self.times.scene);
        title(area, &top, &self.budget_line())?;

        // the labels of the marks are above the highest bar, one in each row
        let highest = self.bars.iter().max().map_or(1.0, |n| *n as f64);
        let floor = 0.7;
        let ceiling = floor * (highest / floor).max(3.0).powf(1.25);
        let x_points = round_points(&self.x, 12);
        let mut y_points = round_points(&(floor..ceiling), 9);
        y_points.retain(|count| count.fract() == 0.0);
        let mut chart = builder(area).build_cartesian_2d(
            self.x.clone().log_scale().with_key_points(x_points),
            (floor..ceiling).log_scale().with_key_points(y_points),
        )?;
        axes(
            &mut chart,
            Labels { title: "time of a tick [µs]", ticks: 12, of: &|t| plain(*t) },
            Labels { title: "ticks (log scale)", ticks: 9, of: &|n| plain(*n) },
        )?;

        let edge = |bar: usize| self.x.start * (self.x.end / self.x.start).powf(bar as f64 / BARS as f64);
        chart.draw_series(
            self.bars
                .iter()
                .enumerate()
                .filter(|(_, n)| **n > 0)
                .map(|(bar, n)| Rectangle::new([(edge(bar), *n as f64), (edge(bar + 1), floor)], BAR.filled())),
        )?;

        let budget = self.x.contains(&BUDGET_US);
        let budget = budget.then_some(("budget", BUDGET_US, WARN));
        let marks = self.marks.iter().map(|(name, t)| (*name, *t, DEPTH));
        let mut marks: Vec<_> = marks.chain(budget).collect();
        marks.sort_by(|a, b| a.1.total_cmp(&b.1));
        let rows = chart.plotting_area().get_base_pixel().1;
        for (row, (name, t, color)) in marks.into_iter().enumerate() {
            let foot = chart.backend_coord(&(t, floor));
            let y = rows + px(14.0 + 21.0 * row as f64);
            // each line ends at its own label, so that it does not cross the labels below it
            let top = (foot.0, y - px(8.0));
            area.draw(&PathElement::new([foot, top], line(color, 1.6)))?;
            let style = text(LABEL_PX, color, (HPos::Left, VPos::Center));
            area.draw_text(&format!("{name} {}", micros(t)), &style, (foot.0 + px(7.0), y))?;
        }
        Ok(())
    }
}
