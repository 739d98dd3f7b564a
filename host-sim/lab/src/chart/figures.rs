//! The pictures of the chart: one for each combination of stiffness, cost and error.

use std::collections::BTreeSet;

use palpate_charts::{Dot, Figure, Level, Plot, ScaledAxis, Series, radius_px};

use super::report::{COSTS, ERRORS, moduli_pa};
use super::run::{Measured, Run};
use crate::methods::Method;

/// Each cost: label of its axis, budget in the unit of the axis, label of the budget.
pub(super) const COST_WORDS: [(&str, f64, &str); 2] = [
    ("time of a 1 ms tick on one desktop core [µs]", 1000.0, "1 ms"),
    ("cycles of a 1 ms tick on a Cortex-M4F [thousands, estimated]", 168.0, "1 ms at 168 MHz"),
];
/// Each error: its part of the title, label of its axis.
pub(super) const ERROR_WORDS: [(&str, &str); 3] = [
    ("force", "RMS force error at 1, 2, 4 and 8 mm [%]"),
    ("shape of the surface", "mean surface error, r < 20 mm, at 2 and 4 mm [mm]"),
    ("force while the probe moves", "RMS force error in ramps of 40, 100, 200 and a tap of 500 mm/s [% of the peak]"),
];

/// Point of a method, for one mesh and one split of its substeps.
#[derive(Clone, Debug)]
pub(super) struct Point {
    pub nodes: usize,
    /// Number of parts into which each substep is divided; the points of a split are joined.
    pub split: u16,
    /// Cost and error.
    pub at: (f64, f64),
    pub survived: bool,
}

/// Points of some runs, with cost and error as `of` reads them.
pub(super) fn points<'a>(runs: impl Iterator<Item = &'a Run>, of: impl Fn(&Measured) -> Option<(f64, f64)>) -> Vec<Point> {
    let point = |run: &Run| {
        let at = of(run.outcome.as_ref().ok()?)?;
        Some(Point { nodes: run.size.nodes, split: run.task.refinement, at, survived: run.survived().is_some() })
    };
    runs.filter_map(point).collect()
}

/// Cost against error of several methods, with the front of those that survived.
pub(super) fn scatter(x: &str, y: &str, budget: Option<(f64, &str)>, methods: &[(&str, Vec<Point>)]) -> Plot {
    let places: Vec<&Point> = methods.iter().flat_map(|(_, points)| points).collect();
    let survived: Vec<(f64, f64)> = places.iter().map(|p| if p.survived { p.at } else { (f64::NAN, f64::NAN) }).collect();
    let front: Vec<(f64, f64)> = super::front(&survived).into_iter().map(|n| survived[n]).collect();
    let mut series = Vec::new();
    for (name, points) in methods {
        let dot = |p: &Point| {
            let split = if p.split > 1 { format!(" x{}", p.split) } else { String::new() };
            let nodes = if p.nodes > 0 { format!(" {}", p.nodes) } else { String::new() };
            let label = if front.contains(&p.at) { format!("{name}{nodes}{split}") } else { String::new() };
            Dot { radius_px: radius_px(p.nodes), hollow: !p.survived, label, ..Dot::from(p.at) }
        };
        let mut splits: Vec<u16> = points.iter().map(|p| p.split).collect();
        splits.sort_unstable();
        splits.dedup();
        // a method without points keeps its place among the looks
        let splits = if splits.is_empty() { vec![1] } else { splits };
        series.extend(splits.into_iter().map(|split| {
            let dots = points.iter().filter(|p| p.split == split).map(dot).collect();
            Series { joined: true, ..Series::dots(*name, dots) }
        }));
    }
    let budget = budget.map(|(at, name)| Level::new(name, at));
    let nodes: BTreeSet<usize> = places.iter().map(|p| p.nodes).filter(|nodes| *nodes > 0).collect();
    let sizes = nodes.into_iter().map(|nodes| (radius_px(nodes), format!("{nodes} nodes"))).collect();
    Plot { budget, front, sizes, ..Plot::new(ScaledAxis::log(x), ScaledAxis::log(y), series) }
}

/// The pictures for rows whose times were measured on `processor`. A quantity without a reference
/// has no picture. The last compares, for each stiffness, the moving error with the held one of all
/// models whose tick takes at most a millisecond.
pub fn figures(runs: &[Run], processor: &str) -> Vec<Figure> {
    let below = format!("80 x 80 x 40 mm block, hemisphere R = 8 mm, substeps to survive 8 mm (hollow: did not); {processor}");
    let mut figures = Vec::new();
    for modulus_pa in moduli_pa(runs) {
        let kpa = modulus_pa * 1e-3;
        let methods = |of: &dyn Fn(&Measured) -> Option<(f64, f64)>| {
            let own = |m: Method| runs.iter().filter(move |r| r.task.method == m && r.task.youngs_modulus_pa == modulus_pa);
            Method::ALL.map(|method| (method.name(), points(own(method), of)))
        };
        let mut add = |name: String, title: String, plot: Plot| {
            if plot.series.iter().any(|s| !s.dots.is_empty()) {
                figures.push(Figure::plot(name, title, below.as_str(), plot));
            }
        };
        for ((cost_name, cost), (x, budget, budget_name)) in COSTS.into_iter().zip(COST_WORDS) {
            for ((error_name, error), (what, y)) in ERRORS.into_iter().zip(ERROR_WORDS) {
                // cycles are drawn in thousands
                let scale = if cost_name == "m4f_cycles" { 1e-3 } else { 1.0 };
                let methods = methods(&|m| Some((cost(m)? * scale, error(m)?)));
                add(
                    format!("{error_name}_over_{cost_name}_{kpa}kpa"),
                    format!("Speed against accuracy of the {what}, {kpa} kPa"),
                    scatter(x, y, Some((budget, budget_name)), &methods),
                );
            }
        }
        let methods = methods(&|m| {
            let within = m.time.min_us <= COST_WORDS[0].1;
            within.then_some((m.accuracy.rms_pct()?, m.moving_rms_pct()?))
        });
        let x = "RMS force error of held presses at 1, 2, 4 and 8 mm [%]";
        let title = format!("Error while moving against error when held, ticks under 1 ms, {kpa} kPa");
        add(format!("moving_over_held_{kpa}kpa"), title, scatter(x, ERROR_WORDS[2].1, None, &methods));
    }
    figures
}
