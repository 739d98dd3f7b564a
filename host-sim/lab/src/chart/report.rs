//! The chart as tables.

use serde::Serialize;

use super::front::{front, front_of_three};
use super::run::{Measured, Run};
use super::term_errors::TermErrors;

/// A row of the chart; what was not measured is left out.
#[derive(Clone, Debug, Default, Serialize)]
pub struct ChartRow {
    method: &'static str,
    nodes: usize,
    edges: usize,
    tets: usize,
    youngs_modulus_pa: f64,
    survives_8mm: String,
    substeps: Option<u16>,
    min_j_8mm: Option<f64>,
    tick_min_us: Option<f64>,
    tick_median_us: Option<f64>,
    times_springs: Option<f64>,
    m4f_cycles_estimate: Option<f64>,
    force_1mm_n: Option<f64>,
    force_error_1mm_pct: Option<f64>,
    force_2mm_n: Option<f64>,
    force_error_2mm_pct: Option<f64>,
    force_4mm_n: Option<f64>,
    force_error_4mm_pct: Option<f64>,
    force_8mm_n: Option<f64>,
    force_error_8mm_pct: Option<f64>,
    force_rms_pct: Option<f64>,
    surface_error_2mm_mm: Option<f64>,
    surface_error_4mm_mm: Option<f64>,
    moving_rms_pct: Option<f64>,
    ramp_40_mm_per_s_rms_pct: Option<f64>,
    ramp_40_mm_per_s_peak_pct: Option<f64>,
    ramp_100_mm_per_s_rms_pct: Option<f64>,
    ramp_100_mm_per_s_peak_pct: Option<f64>,
    ramp_200_mm_per_s_rms_pct: Option<f64>,
    ramp_200_mm_per_s_peak_pct: Option<f64>,
    ramp_500_mm_per_s_rms_pct: Option<f64>,
    ramp_500_mm_per_s_peak_pct: Option<f64>,
}

impl ChartRow {
    /// The row of a run.
    #[must_use]
    pub fn of(run: &Run) -> Self {
        let head = Self {
            method: run.task.method.name(),
            nodes: run.size.nodes,
            edges: run.size.edges,
            tets: run.size.tets,
            youngs_modulus_pa: run.task.youngs_modulus_pa,
            survives_8mm: run.verdict(),
            ..Self::default()
        };
        let Ok(m) = &run.outcome else { return head };
        let [f1, f2, f4, f8] = m.accuracy.force_n.map(Some);
        let [e1, e2, e4, e8] = m.accuracy.force_error_pct;
        let [s2, s4] = m.accuracy.surface_error_mm;
        let ramps = m.moving.and_then(Result::ok).map(|moving| moving.0);
        let [r40, r100, r200, r500] = [0, 1, 2, 3].map(|n| ramps.map(|ramps| ramps[n]));
        Self {
            substeps: Some(m.substeps),
            min_j_8mm: Some(m.trial.min_j),
            tick_min_us: Some(m.time.min_us),
            tick_median_us: Some(m.time.median_us),
            times_springs: Some(m.time.times_springs),
            m4f_cycles_estimate: Some(m.m4f_cycles),
            force_1mm_n: f1,
            force_error_1mm_pct: e1,
            force_2mm_n: f2,
            force_error_2mm_pct: e2,
            force_4mm_n: f4,
            force_error_4mm_pct: e4,
            force_8mm_n: f8,
            force_error_8mm_pct: e8,
            force_rms_pct: m.accuracy.rms_pct(),
            surface_error_2mm_mm: s2,
            surface_error_4mm_mm: s4,
            moving_rms_pct: m.moving_rms_pct(),
            ramp_40_mm_per_s_rms_pct: r40.map(|r| r.rms_pct),
            ramp_40_mm_per_s_peak_pct: r40.map(|r| r.peak_pct),
            ramp_100_mm_per_s_rms_pct: r100.map(|r| r.rms_pct),
            ramp_100_mm_per_s_peak_pct: r100.map(|r| r.peak_pct),
            ramp_200_mm_per_s_rms_pct: r200.map(|r| r.rms_pct),
            ramp_200_mm_per_s_peak_pct: r200.map(|r| r.peak_pct),
            ramp_500_mm_per_s_rms_pct: r500.map(|r| r.rms_pct),
            ramp_500_mm_per_s_peak_pct: r500.map(|r| r.peak_pct),
            ..head
        }
    }
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

/// Errors of a method that lacks the terms of the tissue.
#[derive(Clone, Debug, Serialize)]
pub struct TermRow {
    method: &'static str,
    nodes: usize,
    has_terms: bool,
    substeps: u16,
    substeps_stiffening: u16,
    held_1s_error_pct: Option<f64>,
    held_10s_error_pct: Option<f64>,
    stiffening_error_pct: Option<f64>,
    sideways_error_pct: Option<f64>,
}

impl TermRow {
    /// The row of these errors.
    #[must_use]
    pub fn of(errors: &TermErrors) -> Self {
        let ([substeps, substeps_stiffening], [one, ten]) = (errors.substeps, errors.held_pct);
        Self {
            method: errors.method.name(),
            nodes: errors.nodes,
            has_terms: errors.has_terms,
            substeps,
            substeps_stiffening,
            held_1s_error_pct: one,
            held_10s_error_pct: ten,
            stiffening_error_pct: errors.stiffening_pct,
            sideways_error_pct: errors.sideways_pct,
        }
    }
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
#[must_use]
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
#[must_use]
pub fn fronts(runs: &[Run]) -> Vec<FrontRow> {
    let mut fronts = Vec::new();
    for youngs_modulus_pa in moduli_pa(runs) {
        for (cost, cost_of) in COSTS {
            for (error, error_of) in ERRORS {
                let rows = survivors(runs, youngs_modulus_pa, |m| Some((cost_of(m)?, error_of(m)?)));
                let points: Vec<(f64, f64)> = rows.iter().map(|row| row.2).collect();
                fronts.extend(front(&points).into_iter().map(|n| {
                    let (run, substeps, (cost_value, error_value)) = rows[n];
                    let (method, nodes) = (run.task.method.name(), run.task.nodes);
                    FrontRow { youngs_modulus_pa, cost, error, method, nodes, substeps, cost_value, error_value }
                }));
            }
        }
    }
    fronts
}

/// Every front in tick time, held error and moving error at once, by stiffness; empty if moving
/// errors were not measured.
#[must_use]
pub fn moving_fronts(runs: &[Run]) -> Vec<MovingFrontRow> {
    let mut fronts = Vec::new();
    for youngs_modulus_pa in moduli_pa(runs) {
        let of = |m: &Measured| Some([m.time.min_us, m.accuracy.rms_pct()?, m.moving_rms_pct()?]);
        let rows = survivors(runs, youngs_modulus_pa, of);
        let points: Vec<[f64; 3]> = rows.iter().map(|row| row.2).collect();
        fronts.extend(front_of_three(&points).into_iter().map(|n| {
            let (run, substeps, [tick_us, held_rms_pct, moving_rms_pct]) = rows[n];
            let (method, nodes) = (run.task.method.name(), run.task.nodes);
            MovingFrontRow { youngs_modulus_pa, method, nodes, substeps, tick_us, held_rms_pct, moving_rms_pct }
        }));
    }
    fronts
}
