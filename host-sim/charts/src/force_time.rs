//! Draws depth and force over time, one above the other, as an overview of press, holds and
//! release.

use std::path::Path;

use plotters::prelude::{DrawingBackend, LineSeries};
use plotters::style::RGBColor;

use super::axis::{Axis, Unit};
use super::canvas::Area;
use super::canvas::Drawn;
use super::decimate::decimate;
use super::holds::{self, Mark};
use super::layout::{Labels, TITLE_HEIGHT_PX, axes, builder, title};
use super::picture::{Picture, save};
use super::style::{DEPTH, PRESS, line, px};
use super::{ChartError, Press, Sample};

/// Writes `NAME.svg` and `NAME.png` into `folder`.
///
/// # Errors
/// Fails if the trace is empty, if a value cannot be drawn, or if the folder cannot be written.
pub fn force_time(folder: &Path, name: &str, press: &Press) -> Result<(), ChartError> {
    press.check()?;
    let trace = decimate(press.trace);
    let length = Unit::of_length(trace.iter().map(|s| s.depth_m));
    let force = Unit::of_force(trace.iter().map(|s| s.force_n));
    let chart = ForceTime {
        press,
        trace: &trace,
        time: time_axis(&trace),
        depth: Panel::new("depth", length, DEPTH, &trace, |s| s.depth_m),
        force: Panel::new("force", force, PRESS, &trace, |s| s.force_n),
    };
    save(folder, name, &chart)
}

struct ForceTime<'a> {
    press: &'a Press<'a>,
    trace: &'a [Sample],
    time: Axis,
    depth: Panel,
    force: Panel,
}

/// Plot of one quantity over time.
struct Panel {
    title: String,
    unit: Unit,
    color: RGBColor,
    axis: Axis,
    of: fn(&Sample) -> f64,
}

impl Panel {
    fn new(quantity: &str, unit: Unit, color: RGBColor, trace: &[Sample], of: fn(&Sample) -> f64) -> Self {
        Self {
            title: format!("{quantity} [{}]", unit.symbol),
            unit,
            color,
            axis: Axis::from_zero(trace.iter().map(|s| of(s) * unit.per_si), 0.22, 8),
            of,
        }
    }

    fn at(&self, sample: &Sample) -> (f64, f64) {
        (sample.t_s, (self.of)(sample) * self.unit.per_si)
    }
}

fn time_axis(trace: &[Sample]) -> Axis {
    let (first, last) =
        trace.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(first, last), s| (first.min(s.t_s), last.max(s.t_s)));
    // a run of one tick also needs an axis of non-zero length
    let length = if last > first { last - first } else { 1.0 };
    let first = if first.abs() < 0.01 * length { 0.0 } else { first };
    Axis::over(first..first + 1.02 * length, 10)
}

impl Picture for ForceTime<'_> {
    fn draw<DB: DrawingBackend>(&self, area: &Area<DB>) -> Drawn<DB> {
        let press = self.press;
        let top = format!("{}: depth and force over time", press.scene);
        title(area, &top, &press.summary(self.depth.unit, self.force.unit))?;
        let labels = 54.0; // height of the time labels, which only the lower panel has [px]
        let plots = f64::from(area.dim_in_pixel().1) - f64::from(px(TITLE_HEIGHT_PX + labels));
        let (upper, lower) = area.split_vertically(px(TITLE_HEIGHT_PX) + (plots / 2.0) as i32);
        self.panel(&upper, &self.depth, TITLE_HEIGHT_PX, 0.0)?;
        self.panel(&lower, &self.force, 14.0, labels)
    }
}

impl ForceTime<'_> {
    fn panel<DB: DrawingBackend>(&self, area: &Area<DB>, panel: &Panel, top_px: f64, labels_px: f64) -> Drawn<DB> {
        let mut chart = builder(area)
            .margin_top(px(top_px))
            .x_label_area_size(px(labels_px))
            .build_cartesian_2d(self.time.range.clone(), panel.axis.range.clone())?;
        axes(
            &mut chart,
            Labels { title: "time [s]", ticks: self.time.ticks, of: &|t| self.time.label(*t) },
            Labels { title: &panel.title, ticks: panel.axis.ticks, of: &|v| panel.axis.label(*v) },
        )?;
        let curve: Vec<_> = self.trace.iter().map(|s| panel.at(s)).collect();
        chart.draw_series(LineSeries::new(curve.clone(), line(panel.color, 2.4)))?;
        let mark = |hold| Mark { at: panel.at(hold), label: panel.unit.say((panel.of)(hold)) };
        let marks: Vec<_> = self.press.holds.iter().map(mark).collect();
        holds::draw(area, &mut chart, &marks, &curve, None)
    }
}
