//! Draws force against depth: the press with its holds, and a reference.

use std::path::Path;

use plotters::element::{Circle, Cross, DashedPathElement, PathElement};
use plotters::prelude::{DashedLineSeries, DrawingBackend, LineSeries};

use super::axis::{Axis, Unit};
use super::canvas::Area;
use super::canvas::Drawn;
use super::decimate::decimate;
use super::holds::{self, Mark};
use super::layout::{Labels, axes, builder, legend, legend_frame, title};
use super::picture::{Picture, save};
use super::style::{DEPTH, INK, PRESS, REFERENCE, RELEASE, line, px};
use super::{ChartError, Press, Sample};

/// Writes `NAME.svg` and `NAME.png` into `folder`.
///
/// # Errors
/// Fails if the trace is empty, if a value cannot be drawn, or if the folder cannot be written.
pub fn force_depth(folder: &Path, name: &str, press: &Press) -> Result<(), ChartError> {
    press.check()?;
    let trace = decimate(press.trace);
    let depths_m = || trace.iter().map(|s| s.depth_m);
    let all_depths_m = depths_m().chain(press.reference.iter().map(|r| r.0));
    let forces_n = trace.iter().map(|s| s.force_n);
    let all_forces_n = forces_n.chain(press.reference.iter().map(|r| r.1));
    let length = Unit::of_length(all_depths_m.clone());
    let force = Unit::of_force(all_forces_n.clone());
    let chart = ForceDepth {
        press,
        turn: turning_point(&trace),
        x: Axis::from_zero(all_depths_m.map(|d| d * length.per_si), 0.06, 10),
        y: Axis::from_zero(all_forces_n.map(|f| f * force.per_si), 0.10, 9),
        trace: &trace,
        length,
        force,
    };
    save(folder, name, &chart)
}

/// Change of depth between two samples up to which the probe counts as held [m].
const STILL_M: f64 = 1e-9;

struct ForceDepth<'a> {
    press: &'a Press<'a>,
    trace: &'a [Sample],
    /// Index of the last sample of the press, which is also the first one of the release.
    turn: usize,
    length: Unit,
    force: Unit,
    x: Axis,
    y: Axis,
}

/// Index of the last sample whose depth is within a thousandth of the depth range from the deepest
/// one, so that a final hold belongs to the press.
fn turning_point(trace: &[Sample]) -> usize {
    let (least, most) =
        trace.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), s| (least.min(s.depth_m), most.max(s.depth_m)));
    let deep = most - 1e-3 * (most - least);
    trace.iter().rposition(|s| s.depth_m >= deep).unwrap_or(0)
}

/// Splits a trace into runs of samples in which the probe moves, or in which it is held; adjacent
/// runs share a sample.
fn runs(trace: &[Sample], moving: bool) -> Vec<&[Sample]> {
    let moves = |k: usize| (trace[k].depth_m - trace[k - 1].depth_m).abs() > STILL_M;
    let (mut runs, mut begun) = (Vec::new(), None);
    for k in 1..=trace.len() {
        let wanted = k < trace.len() && moves(k) == moving;
        match (wanted, begun) {
            (true, None) => begun = Some(k - 1),
            (false, Some(begin)) => {
                runs.push(&trace[begin..k]);
                begun = None;
            }
            _ => {}
        }
    }
    runs
}

impl ForceDepth<'_> {
    fn at(&self, depth_m: f64, force_n: f64) -> (f64, f64) {
        (depth_m * self.length.per_si, force_n * self.force.per_si)
    }

    fn mark(&self, hold: &Sample) -> Mark {
        let (depth, force) = (self.length.say(hold.depth_m), self.force.say(hold.force_n));
        Mark { at: self.at(hold.depth_m, hold.force_n), label: format!("{depth}, {force}") }
    }
}

impl Picture for ForceDepth<'_> {
    fn draw<DB: DrawingBackend>(&self, area: &Area<DB>) -> Drawn<DB> {
        let press = self.press;
        let top = format!("{}: force against depth", press.scene);
        let below = press.summary(self.length, self.force);
        title(area, &top, &format!("{below}; a probe that moves also feels inertia and damping"))?;
        let mut chart = builder(area).build_cartesian_2d(self.x.range.clone(), self.y.range.clone())?;
        axes(
            &mut chart,
            Labels { title: &format!("depth [{}]", self.length.symbol), ticks: self.x.ticks, of: &|v| self.x.label(*v) },
            Labels { title: &format!("force [{}]", self.force.symbol), ticks: self.y.ticks, of: &|v| self.y.label(*v) },
        )?;

        // the sample at the turning point belongs to press and release, so that the two curves meet
        let curve: Vec<_> = (self.trace.iter().map(|s| self.at(s.depth_m, s.force_n))).collect();
        let loading = &self.trace[..=self.turn];
        let mut entries = 1;
        for (n, run) in runs(loading, true).into_iter().enumerate() {
            let moving = run.iter().map(|s| self.at(s.depth_m, s.force_n));
            let drawn = chart.draw_series(LineSeries::new(moving, line(PRESS, 2.6)))?;
            if n == 0 {
                drawn.label("going in").legend(|at| PathElement::new(key(at), line(PRESS, 2.6)));
            }
        }
        for (n, run) in runs(loading, false).into_iter().enumerate() {
            let held = run.iter().map(|s| self.at(s.depth_m, s.force_n));
            let drawn = chart.draw_series(LineSeries::new(held, line(DEPTH, 1.4)))?;
            if n == 0 {
                drawn.label("held: the force settles").legend(|at| PathElement::new(key(at), line(DEPTH, 1.4)));
                entries += 1;
            }
        }
        let release: Vec<_> = curve.iter().copied().skip(self.turn).collect();
        if release.len() > 1 {
            // dashed, because without hysteresis it coincides with the press
            let (dash, gap, thin) = (px(7.0), px(5.0), line(RELEASE, 1.8));
            chart
                .draw_series(DashedLineSeries::new(release, dash, gap, thin))?
                .label("coming out")
                .legend(move |at| DashedPathElement::new(key(at), dash, gap, thin));
            entries += 1;
        }
        if !press.holds.is_empty() {
            // the holds themselves are drawn further down, with their values
            let ring = |(x, y): (i32, i32)| Circle::new((x + px(13.0), y), px(4.8), line(INK, 1.6));
            chart.draw_series(std::iter::empty::<Circle<(f64, f64), i32>>())?.label("end of a hold, at rest").legend(ring);
            entries += 1;
        }
        entries += u32::from(!press.reference.is_empty());
        let marks: Vec<_> = press.holds.iter().map(|hold| self.mark(hold)).collect();
        let taken = legend_frame(&chart, entries);
        holds::draw(area, &mut chart, &marks, &curve, Some(taken))?;
        if !press.reference.is_empty() {
            let cross = |at| Cross::new(at, px(4.2), line(REFERENCE, 2.0));
            chart
                .draw_series(press.reference.iter().map(|r| cross(self.at(r.0, r.1))))?
                .label("finite elements, at rest")
                .legend(|(x, y)| Cross::new((x + px(13.0), y), px(4.2), line(REFERENCE, 2.0)));
        }
        legend(&mut chart)
    }
}

/// Line segment of a legend entry that begins at a point [canvas units].
fn key((x, y): (i32, i32)) -> [(i32, i32); 2] {
    [(x, y), (x + px(26.0), y)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hold_between_two_ramps_is_one_run() {
        let depths = [0.0, 1.0, 2.0, 2.0, 2.0, 3.0];
        let trace: Vec<_> = depths.iter().map(|mm| Sample { t_s: 0.0, depth_m: mm * 1e-3, force_n: 0.0 }).collect();
        let lengths = |moving| runs(&trace, moving).iter().map(|run| run.len()).collect::<Vec<_>>();
        assert_eq!(lengths(true), [3, 2]);
        assert_eq!(lengths(false), [3]);
        assert!(runs(&trace[..1], true).is_empty() && runs(&[], false).is_empty());
    }
}
