//! The chart as tables.

use serde::Serialize;

use super::accuracy::{DEPTHS_M, SURFACE_DEPTHS_M};
use super::front::{front, front_of_three};
use super::moving::SPEEDS_MM_PER_S;
use super::run::{Measured, Run};
use crate::study::{Columns, Table};

/// The rows of the chart, printed on request; what was not measured is left out.
pub fn rows(name: &str, runs: &[Run]) -> Columns<Run> {
    let measured = |run: &Run, of: fn(&Measured) -> Option<f64>| run.outcome.as_ref().ok().and_then(of);
    let mut table = Table::rows(name, runs.to_vec())
        .col("method", |run| run.task.method.name())
        .col("nodes", |run| run.size.nodes)
        .csv("edges", |run| run.size.edges)
        .csv("tets", |run| run.size.tets)
        .col("youngs_modulus_pa", |run| run.task.youngs_modulus_pa)
        .col("survives_8mm", Run::verdict)
        .col("substeps", |run| run.outcome.as_ref().ok().map(|m| m.substeps))
        .col("min_j_8mm", |run| measured(run, |m| Some(m.trial.min_j)))
        .col("tick_min_us", |run| measured(run, |m| Some(m.time.min_us)))
        .csv("tick_median_us", |run| measured(run, |m| Some(m.time.median_us)))
        .col("times_springs", |run| measured(run, |m| Some(m.time.times_springs)))
        .csv("m4f_cycles_estimate", |run| measured(run, |m| Some(m.m4f_cycles)));
    let accuracy = |run: &Run| run.outcome.as_ref().ok().map(|m| m.accuracy);
    for (n, depth_m) in DEPTHS_M.into_iter().enumerate() {
        let mm = depth_m * 1e3;
        table = table
            .csv(&format!("force_{mm}mm_n"), |run| accuracy(run).map(|a| a.force_n[n]))
            .col(&format!("force_error_{mm}mm_pct"), |run| accuracy(run).and_then(|a| a.force_error_pct[n]));
    }
    table = table.col("force_rms_pct", |run| measured(run, |m| m.accuracy.rms_pct()));
    for (n, depth_m) in SURFACE_DEPTHS_M.into_iter().enumerate() {
        let name = format!("surface_error_{}mm_mm", depth_m * 1e3);
        table = table.col(&name, |run| accuracy(run).and_then(|a| a.surface_error_mm[n]));
    }
    table = table.col("moving_rms_pct", |run| measured(run, Measured::moving_rms_pct));
    let ramp = |run: &Run, n: usize| run.outcome.as_ref().ok()?.moving.map(|moving| moving.0[n]);
    for (n, speed) in SPEEDS_MM_PER_S.into_iter().enumerate() {
        table = table
            .csv(&format!("ramp_{speed}_mm_per_s_rms_pct"), |run| ramp(run, n).map(|r| r.rms_pct))
            .csv(&format!("ramp_{speed}_mm_per_s_peak_pct"), |run| ramp(run, n).map(|r| r.peak_pct));
    }
    table
}

/// Point of a front of one cost against one error.
#[derive(Clone, Debug, Serialize)]
pub struct FrontRow {
    /// Young's modulus [Pa].
    pub youngs_modulus_pa: f64,
    /// Name of the cost, one of [`COSTS`].
    pub cost: &'static str,
    /// Name of the error, one of [`ERRORS`].
    pub error: &'static str,
    /// Name of the method.
    pub method: &'static str,
    /// Number of nodes.
    pub nodes: usize,
    /// Substeps per tick.
    pub substeps: u16,
    /// Cost of the point, in the unit of its name.
    pub cost_value: f64,
    /// Error of the point, in the unit of its name.
    pub error_value: f64,
}

/// Point of a front in tick time, held error and moving error at once.
#[derive(Clone, Debug, Serialize)]
pub struct MovingFrontRow {
    youngs_modulus_pa: f64,
    method: &'static str,
    nodes: usize,
    substeps: u16,
    tick_us: f64,
    held_rms_pct: f64,
    moving_rms_pct: f64,
}

/// Reads a cost or an error from a row.
pub type Quantity = fn(&Measured) -> Option<f64>;

/// Costs and their names in the files.
pub const COSTS: [(&str, Quantity); 2] = [("tick_us", |m| Some(m.time.min_us)), ("m4f_cycles", |m| Some(m.m4f_cycles))];
/// Errors and their names in the files.
pub const ERRORS: [(&str, Quantity); 3] = [
    ("force_rms_pct", |m| m.accuracy.rms_pct()),
    ("surface_mm", |m| m.accuracy.surface_mm()),
    ("moving_rms_pct", Measured::moving_rms_pct),
];

/// Young's moduli of the rows [Pa].
pub fn moduli_pa(runs: &[Run]) -> Vec<f64> {
    let mut moduli: Vec<f64> = runs.iter().map(|r| r.task.youngs_modulus_pa).collect();
    moduli.dedup();
    moduli
}

/// Rows of a stiffness that survived the deepest press, with values that `of` reads.
fn survivors<T>(runs: &[Run], modulus_pa: f64, of: impl Fn(&Measured) -> Option<T>) -> Vec<(&Run, u16, T)> {
    let rows = runs.iter().filter(|r| r.task.youngs_modulus_pa == modulus_pa);
    rows.filter_map(|r| r.survived().and_then(|m| Some((r, m.substeps, of(m)?)))).collect()
}

/// Every front of a cost against an error, by stiffness.
pub fn fronts(runs: &[Run]) -> Vec<FrontRow> {
    let mut fronts = Vec::new();
    for youngs_modulus_pa in moduli_pa(runs) {
        for (cost, cost_of) in COSTS {
            for (error, error_of) in ERRORS {
                let rows = survivors(runs, youngs_modulus_pa, |m| Some((cost_of(m)?, error_of(m)?)));
                let points: Vec<(f64, f64)> = rows.iter().map(|row| row.2).collect();
                fronts.extend(front(&points).into_iter().map(|n| {
                    let (run, substeps, (cost_value, error_value)) = rows[n];
                    let (method, nodes) = (run.task.method.name(), run.size.nodes);
                    FrontRow { youngs_modulus_pa, cost, error, method, nodes, substeps, cost_value, error_value }
                }));
            }
        }
    }
    fronts
}

/// Every front in tick time, held error and moving error at once, by stiffness; empty if moving
/// errors were not measured.
pub fn moving_fronts(runs: &[Run]) -> Vec<MovingFrontRow> {
    let mut fronts = Vec::new();
    for youngs_modulus_pa in moduli_pa(runs) {
        let of = |m: &Measured| Some([m.time.min_us, m.accuracy.rms_pct()?, m.moving_rms_pct()?]);
        let rows = survivors(runs, youngs_modulus_pa, of);
        let points: Vec<[f64; 3]> = rows.iter().map(|row| row.2).collect();
        fronts.extend(front_of_three(&points).into_iter().map(|n| {
            let (run, substeps, [tick_us, held_rms_pct, moving_rms_pct]) = rows[n];
            let (method, nodes) = (run.task.method.name(), run.size.nodes);
            MovingFrontRow { youngs_modulus_pa, method, nodes, substeps, tick_us, held_rms_pct, moving_rms_pct }
        }));
    }
    fronts
}
