//! How long the ticks took: a histogram with median, 99th percentile and worst tick marked.

use std::ops::Range;
use std::path::Path;

use plotters::coord::combinators::{BindKeyPoints, IntoLogRange};
use plotters::element::{PathElement, Rectangle};
use plotters::prelude::DrawingBackend;
use plotters::style::text_anchor::{HPos, VPos};
use plotters::style::{Color, RGBColor};

use super::layout::{Area, Labels, axes, builder, title, width};
use super::picture::{Drawn, Picture, save};
use super::style::{BAR, DEPTH, LABEL_PX, WARN, line, px, text};
use super::{ChartError, check};

/// Tick times of a run.
#[derive(Clone, Copy, Debug)]
pub struct TickTimes<'a> {
    /// Scene name, first words of the title.
    pub scene: &'a str,
    /// Size of the patch that was pressed.
    pub node_count: usize,
    /// Processor and build on which the times hold, one line.
    pub machine: &'a str,
    /// Wall time of every tick [us], in any order.
    pub tick_us: &'a [f32],
}

/// The device's period, hence the longest a tick may take [us].
const BUDGET_US: f64 = 1000.0;

/// Bars across the axis; about ten pixels each.
const BARS: usize = 90;

/// Writes `NAME.svg` and `NAME.png` into `folder`.
///
/// # Errors
/// No ticks, a time that is negative or cannot be drawn, or a folder that cannot be written.
pub fn tick_time(folder: &Path, name: &str, times: &TickTimes) -> Result<(), ChartError> {
    let mut sorted_us: Vec<f64> = times.tick_us.iter().map(|t| f64::from(*t)).collect();
    check("tick_us", sorted_us.iter().copied())?;
    if let Some(index) = sorted_us.iter().position(|t| *t < 0.0) {
        let value = sorted_us.get(index).copied().unwrap_or_default();
        let what = "tick_us";
        return Err(ChartError::NotDrawable { what, index, value });
    }
    sorted_us.sort_unstable_by(f64::total_cmp);
    let (Some(p50), Some(p99), Some(max)) = (
        percentile(&sorted_us, 0.50),
        percentile(&sorted_us, 0.99),
        sorted_us.last().copied(),
    ) else {
        return Err(ChartError::Empty { what: "tick_us" });
    };
    let x = time_range(&sorted_us, max);
    let chart = TickTime {
        times,
        bars: count(&sorted_us, &x),
        over: sorted_us.iter().filter(|t| **t > BUDGET_US).count(),
        x,
        marks: [("p50", p50), ("p99", p99), ("max", max)],
    };
    save(folder, name, &chart)
}

/// The smallest value that at least `share` of `sorted` do not exceed.
fn percentile(sorted: &[f64], share: f64) -> Option<f64> {
    let rank = (share * sorted.len() as f64).ceil() as usize;
    sorted.get(rank.saturating_sub(1)).copied()
}

/// A range for a log axis that holds all times, and the budget where that is near.
fn time_range(sorted_us: &[f64], max: f64) -> Range<f64> {
    // a clock too coarse for a tick reports 0, which a log axis has no place for
    let least = sorted_us.iter().copied().find(|t| *t > 0.0).unwrap_or(1.0);
    let most = max.max(least);
    let most = if most > 0.4 * BUDGET_US {
        most.max(BUDGET_US)
    } else {
        most
    };
    least / 1.3..most * 1.3
}

/// Ticks in each of `BARS` bars of equal width on the log axis `x`.
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

struct TickTime<'a> {
    times: &'a TickTimes<'a>,
    x: Range<f64>,
    bars: Vec<usize>,
    /// Ticks that took longer than the budget.
    over: usize,
    marks: [(&'static str, f64); 3],
}

/// Round numbers for a log axis over `range`: as fine as leaves at most `most`.
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
        decades
            .flat_map(|d| steps.iter().map(move |s| s * 10_f64.powi(d)))
            .filter(|p| range.contains(p))
            .collect()
    };
    let points = steps.iter().map(|s| within(s));
    points
        .clone()
        .find(|p| p.len() <= most)
        .or(points.last())
        .unwrap_or_default()
}

/// A number without trailing zeros.
fn plain(value: f64) -> String {
    let digits = format!("{value:.6}");
    digits
        .trim_end_matches('0')
        .trim_end_matches('.')
        .to_owned()
}

/// A time to three digits [us].
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
            if self.over == 0 {
                "none".to_owned()
            } else {
                self.over.to_string()
            },
            self.times.machine,
        )
    }
}

impl Picture for TickTime<'_> {
    fn draw<DB: DrawingBackend>(&self, area: &Area<DB>) -> Drawn<DB> {
        let top = format!("{}: time of a tick", self.times.scene);
        title(area, &top, &self.budget_line())?;

        // the labels of the marks hang above the highest bar, one row each
        let highest = self.bars.iter().max().map_or(1.0, |n| *n as f64);
        let floor = 0.7;
        let ceiling = floor * (highest / floor).max(3.0).powf(1.25);
        let (x_points, y_points) = (
            round_points(&self.x, 12),
            round_points(&(floor..ceiling), 9),
        );
        let mut chart = builder(area).build_cartesian_2d(
            self.x.clone().log_scale().with_key_points(x_points),
            (floor..ceiling).log_scale().with_key_points(y_points),
        )?;
        axes(
            &mut chart,
            Labels {
                title: "time of a tick [µs]",
                ticks: 12,
                of: &|t| plain(*t),
            },
            Labels {
                title: "ticks (log scale)",
                ticks: 9,
                of: &|n| plain(*n),
            },
        )?;

        let edge =
            |bar: usize| self.x.start * (self.x.end / self.x.start).powf(bar as f64 / BARS as f64);
        chart.draw_series(self.bars.iter().enumerate().filter(|(_, n)| **n > 0).map(
            |(bar, n)| {
                Rectangle::new(
                    [(edge(bar), *n as f64), (edge(bar + 1), floor)],
                    BAR.filled(),
                )
            },
        ))?;

        let budget = self
            .x
            .contains(&BUDGET_US)
            .then_some(("budget", BUDGET_US, WARN));
        let marks = self
            .marks
            .iter()
            .map(|(name, t)| (*name, *t, DEPTH))
            .chain(budget);
        let rows = chart.plotting_area().get_base_pixel().1;
        for (row, (name, t, color)) in marks.enumerate() {
            let foot = chart.backend_coord(&(t, floor));
            let top = (foot.0, rows + px(14.0 + 21.0 * row as f64));
            // each line ends at its own label, so that none runs through the label above
            let up = (top.0, top.1 - px(8.0));
            area.draw(&PathElement::new([foot, up], line(color, 1.6)))?;
            self.beside(area, top, &format!("{name} {}", micros(t)), color)?;
        }
        Ok(())
    }
}

impl TickTime<'_> {
    /// Writes `label` right of `at`, or left of it where the picture ends.
    fn beside<DB: DrawingBackend>(
        &self,
        area: &Area<DB>,
        (x, y): (i32, i32),
        label: &str,
        color: RGBColor,
    ) -> Drawn<DB> {
        let style = |h| text(LABEL_PX, color, (h, VPos::Center));
        let wide = width(area, label, &style(HPos::Left))?;
        let right = area.dim_in_pixel().0.cast_signed() - px(24.0);
        if x + px(7.0) + wide < right {
            area.draw_text(label, &style(HPos::Left), (x + px(7.0), y))
        } else {
            area.draw_text(label, &style(HPos::Right), (x - px(7.0), y))
        }
    }
}
