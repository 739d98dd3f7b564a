//! Draws the progress of a calibration over its rounds: force error above, dent error below.

use std::path::Path;

use plotters::element::Circle;
use plotters::prelude::{DrawingBackend, LineSeries};
use plotters::style::{Color, RGBColor};

use super::axis::Axis;
use super::canvas::Area;
use super::canvas::Drawn;
use super::layout::{Labels, TITLE_HEIGHT_PX, axes, builder, title};
use super::picture::{Picture, save};
use super::style::{DEPTH, PRESS, line, px};
use super::{ChartError, check};

/// State of a calibration after a round.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConvergencePoint {
    /// Number of evaluations of all presses so far.
    pub evaluations: usize,
    /// Rms force error over the fitted places [%].
    pub force_rms_pct: f64,
    /// Mean dent error over the fitted places [mm].
    pub dent_mean_mm: f64,
    /// Time since the fit began [s].
    pub elapsed_s: f64,
}

/// Writes `NAME.svg` and `NAME.png` into `folder`.
///
/// # Errors
/// Fails if there is no round, if a value cannot be drawn, or if the folder cannot be written.
pub fn convergence(folder: &Path, name: &str, scene: &str, rounds: &[ConvergencePoint]) -> Result<(), ChartError> {
    if rounds.is_empty() {
        return Err(ChartError::Empty { what: "rounds" });
    }
    check("force error", rounds.iter().map(|r| r.force_rms_pct))?;
    check("dent error", rounds.iter().map(|r| r.dent_mean_mm))?;
    let chart = Convergence {
        scene,
        rounds,
        evaluations: Axis::from_zero(rounds.iter().map(|r| r.evaluations as f64), 0.05, 10),
        force: Panel::new("force error, rms [%]", PRESS, rounds, |r| r.force_rms_pct),
        dent: Panel::new("dent error, mean [mm]", DEPTH, rounds, |r| r.dent_mean_mm),
    };
    save(folder, name, &chart)
}

struct Convergence<'a> {
    scene: &'a str,
    rounds: &'a [ConvergencePoint],
    evaluations: Axis,
    force: Panel,
    dent: Panel,
}

struct Panel {
    title: &'static str,
    color: RGBColor,
    axis: Axis,
    of: fn(&ConvergencePoint) -> f64,
}

impl Panel {
    fn new(title: &'static str, color: RGBColor, rounds: &[ConvergencePoint], of: fn(&ConvergencePoint) -> f64) -> Self {
        Self { title, color, axis: Axis::from_zero(rounds.iter().map(of), 0.12, 7), of }
    }
}

impl Picture for Convergence<'_> {
    fn draw<DB: DrawingBackend>(&self, area: &Area<DB>) -> Drawn<DB> {
        let last = self.rounds.last().map_or(0.0, |r| r.elapsed_s);
        let caption = format!("over the fitted places; {last:.0} s in all");
        title(area, &format!("{}: calibration, errors against evaluations", self.scene), &caption)?;
        let labels = 54.0; // height of the labels below, which only the lower panel has [px]
        let plots = f64::from(area.dim_in_pixel().1) - f64::from(px(TITLE_HEIGHT_PX + labels));
        let (upper, lower) = area.split_vertically(px(TITLE_HEIGHT_PX) + (plots / 2.0) as i32);
        self.panel(&upper, &self.force, TITLE_HEIGHT_PX, 0.0)?;
        self.panel(&lower, &self.dent, 14.0, labels)
    }
}

impl Convergence<'_> {
    fn panel<DB: DrawingBackend>(&self, area: &Area<DB>, panel: &Panel, top_px: f64, labels_px: f64) -> Drawn<DB> {
        let mut chart = builder(area)
            .margin_top(px(top_px))
            .x_label_area_size(px(labels_px))
            .build_cartesian_2d(self.evaluations.range.clone(), panel.axis.range.clone())?;
        axes(
            &mut chart,
            Labels { title: "evaluations of all presses", ticks: self.evaluations.ticks, of: &|t| self.evaluations.label(*t) },
            Labels { title: panel.title, ticks: panel.axis.ticks, of: &|v| panel.axis.label(*v) },
        )?;
        let points: Vec<_> = self.rounds.iter().map(|r| (r.evaluations as f64, (panel.of)(r))).collect();
        chart.draw_series(LineSeries::new(points.clone(), line(panel.color, 2.0)))?;
        chart.draw_series(points.into_iter().map(|p| Circle::new(p, px(4.0), panel.color.filled())))?;
        Ok(())
    }
}
