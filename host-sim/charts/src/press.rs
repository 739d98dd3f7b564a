//! Draws a press: force against depth, and depth and force over time.

use std::path::Path;

use super::axis::Unit;
use super::decimate::decimate;
use super::figure::{Figure, Form};
use super::plot::{Dot, Plot, ScaledAxis, Series};
use super::{ChartError, Press, Sample};

/// Change of depth between two samples up to which the probe counts as held [m].
const STILL_M: f64 = 1e-9;
/// Radius of the mark of a hold [px].
const HOLD_PX: f64 = 7.5;

/// Writes force against depth, with the holds and a reference, as `NAME.svg` and `NAME.png` into
/// `folder`.
pub fn force_depth(folder: &Path, name: &str, press: &Press) -> Result<(), ChartError> {
    press.check()?;
    let trace = decimate(press.trace);
    let all = || trace.iter().map(|s| (s.depth_m, s.force_n)).chain(press.reference.iter().copied());
    let (length, force) = (Unit::of_length(all().map(|p| p.0)), Unit::of_force(all().map(|p| p.1)));
    let at = |depth_m: f64, force_n: f64| (depth_m * length.per_si, force_n * force.per_si);
    let curve = |name: &str, run: &[Sample]| Series::curve(name, run.iter().map(|s| at(s.depth_m, s.force_n)));
    // the sample at the turning point belongs to press and release, so that the two curves meet
    let turn = turning_point(&trace);
    let (loading, release) = (&trace[..=turn], &trace[turn..]);
    let mut series: Vec<Series> = runs(loading, true).into_iter().map(|run| curve("going in", run)).collect();
    if release.len() > 1 {
        // dashed, because without hysteresis it coincides with the press
        series.push(Series { dashed: true, ..curve("coming out", release) });
    }
    series.extend(runs(loading, false).into_iter().map(|run| curve("held: the force settles", run)));
    let holds = press.holds.iter().map(|hold| {
        let label = format!("{}, {}", length.say(hold.depth_m), force.say(hold.force_n));
        Dot { radius_px: HOLD_PX, hollow: true, label, ..Dot::from(at(hold.depth_m, hold.force_n)) }
    });
    let reference = press.reference.iter().map(|(depth_m, force_n)| Dot::from(at(*depth_m, *force_n)));
    series.push(Series::dots("finite elements, at rest", reference.collect()));
    // around the markers of finite elements, on which they nearly lie
    series.push(Series::dots("end of a hold, at rest", holds.collect()));
    if series.iter().all(|s| s.dots.is_empty()) {
        // a run of one sample has no curve
        series.push(Series::dots("going in", trace.iter().map(|s| at(s.depth_m, s.force_n).into()).collect()));
    }
    let [x, y] =
        [("depth", length), ("force", force)].map(|(what, unit)| ScaledAxis::linear(format!("{what} [{}]", unit.symbol)));
    let below = format!("{}; a probe that moves also feels inertia and damping", press.summary(length, force));
    Figure::plot(name, format!("{}: force against depth", press.scene), below, Plot::new(x, y, series)).draw(folder)
}

/// Writes depth and force over time, one above the other, as `NAME.svg` and `NAME.png` into
/// `folder`.
pub fn force_time(folder: &Path, name: &str, press: &Press) -> Result<(), ChartError> {
    press.check()?;
    let trace = decimate(press.trace);
    let length = Unit::of_length(trace.iter().map(|s| s.depth_m));
    let force = Unit::of_force(trace.iter().map(|s| s.force_n));
    let panel = |what: &str, unit: Unit, of: fn(&Sample) -> f64| {
        let at = |s: &Sample| (s.t_s, of(s) * unit.per_si);
        let hold = |s: &Sample| Dot { radius_px: HOLD_PX, hollow: true, label: unit.say(of(s)), ..Dot::from(at(s)) };
        let curve = Series::curve(what, trace.iter().map(at));
        let holds = Series::dots("end of a hold", press.holds.iter().map(hold).collect());
        Plot::new(ScaledAxis::linear("time [s]"), ScaledAxis::linear(format!("{what} [{}]", unit.symbol)), vec![curve, holds])
    };
    let form = Form::Panels(vec![panel("depth", length, |s| s.depth_m), panel("force", force, |s| s.force_n)]);
    let title = format!("{}: depth and force over time", press.scene);
    Figure { name: name.into(), title, below: press.summary(length, force), form }.draw(folder)
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
    let moves = |pair: &[Sample]| (pair[1].depth_m - pair[0].depth_m).abs() > STILL_M;
    let mut runs = Vec::new();
    let mut begin = 0;
    for end in 1..trace.len() {
        let ends = end + 1 == trace.len() || moves(&trace[end - 1..=end]) != moves(&trace[end..=end + 1]);
        if ends {
            if moves(&trace[end - 1..=end]) == moving {
                runs.push(&trace[begin..=end]);
            }
            begin = end;
        }
    }
    runs
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
