//! The pictures of the chart: one for each combination of stiffness, cost and error.

use super::report::{COSTS, ERRORS};
use super::run::{Measured, Run};
use crate::error::Error;
use crate::methods::Method;
use palpate_charts::{MethodPoint, MethodPoints, SpeedAccuracy, speed_accuracy};
use palpate_tissue::output::OutputFolder;

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

/// Draws the pictures for rows whose times were measured on `processor`; returns the names of the
/// written pictures without their extension. A quantity without a reference has no picture.
///
/// # Errors
/// Fails if a picture cannot be drawn or written.
pub fn draw(folder: &OutputFolder, runs: &[Run], processor: &str) -> Result<Vec<String>, Error> {
    let mut moduli: Vec<f64> = runs.iter().map(|r| r.task.youngs_modulus_pa).collect();
    moduli.dedup();
    let below = format!(
        "80 x 80 x 40 mm block, hemisphere R = 8 mm, substeps to survive 8 mm; {processor}; {}",
        palpate_tissue::machine::build()
    );
    let below = match runs.iter().any(|r| r.task.refinement > 1) {
        true => format!("{below}; lines: one split"),
        false => below,
    };
    let mut names = Vec::new();
    for &modulus_pa in &moduli {
        for ((cost_name, cost), (cost_axis, budget, budget_name)) in COSTS.into_iter().zip(COST_WORDS) {
            for ((error_name, error), (what, error_axis)) in ERRORS.into_iter().zip(ERROR_WORDS) {
                // cycles are drawn in thousands
                let scale = if cost_name == "m4f_cycles" { 1e-3 } else { 1.0 };
                let methods = methods(runs, modulus_pa, |m| Some((cost(m)? * scale, error(m)?)));
                if methods.iter().all(|m| m.points.is_empty()) {
                    continue;
                }
                let kpa = modulus_pa * 1e-3;
                let name = format!("{error_name}_over_{cost_name}_{kpa}kpa");
                let front = front_of(&methods);
                let chart = SpeedAccuracy {
                    title: &format!("Speed against accuracy of the {what}, {kpa} kPa"),
                    below: &below,
                    cost: cost_axis,
                    error: error_axis,
                    budget: Some((budget, budget_name)),
                    methods: &methods,
                    front: &front,
                };
                speed_accuracy(folder.draft(), &name, &chart)?;
                names.push(name);
            }
        }
    }
    names.extend(moving_pictures(folder, runs, &below)?);
    Ok(names)
}

/// Moving error over held error of every model whose tick takes at most a millisecond, one picture
/// per stiffness. The front consists of those that none of the others beats in both errors.
fn moving_pictures(folder: &OutputFolder, runs: &[Run], below: &str) -> Result<Vec<String>, Error> {
    let mut moduli: Vec<f64> = runs.iter().map(|r| r.task.youngs_modulus_pa).collect();
    moduli.dedup();
    let mut names = Vec::new();
    for modulus_pa in moduli {
        let errors = |m: &Measured| {
            let within = m.time.min_us <= COST_WORDS[0].1;
            within.then_some((m.accuracy.rms_pct()?, m.moving_rms_pct()?))
        };
        let methods = methods(runs, modulus_pa, errors);
        if methods.iter().all(|m| m.points.is_empty()) {
            continue;
        }
        let (kpa, front) = (modulus_pa * 1e-3, front_of(&methods));
        let name = format!("moving_over_held_{kpa}kpa");
        let chart = SpeedAccuracy {
            title: &format!("Error while moving against error when held, ticks under 1 ms, {kpa} kPa"),
            below,
            cost: "RMS force error of held presses at 1, 2, 4 and 8 mm [%]",
            error: ERROR_WORDS[2].1,
            budget: None,
            methods: &methods,
            front: &front,
        };
        speed_accuracy(folder.draft(), &name, &chart)?;
        names.push(name);
    }
    Ok(names)
}

fn methods(runs: &[Run], modulus_pa: f64, of: impl Fn(&Measured) -> Option<(f64, f64)>) -> Vec<MethodPoints<'static>> {
    let points = |method: Method| {
        let rows = runs.iter().filter(|r| r.task.method == method && r.task.youngs_modulus_pa == modulus_pa);
        let point = |run: &Run| {
            let (cost, error) = of(run.outcome.as_ref().ok()?)?;
            Some(MethodPoint {
                nodes: run.task.nodes,
                split: run.task.refinement,
                cost,
                error,
                survived: run.survived().is_some(),
            })
        };
        MethodPoints { name: method.name(), points: rows.filter_map(point).collect() }
    };
    Method::ALL.map(points).into()
}

pub(super) fn front_of(methods: &[MethodPoints]) -> Vec<(usize, usize)> {
    let places: Vec<(usize, usize)> =
        methods.iter().enumerate().flat_map(|(m, method)| (0..method.points.len()).map(move |p| (m, p))).collect();
    let at = |&(m, p): &(usize, usize)| {
        let point: &MethodPoint = &methods[m].points[p];
        if point.survived { (point.cost, point.error) } else { (f64::NAN, f64::NAN) }
    };
    let points: Vec<(f64, f64)> = places.iter().map(at).collect();
    super::front(&points).into_iter().map(|n| places[n]).collect()
}
