//! The chart as CSV and JSON.

use serde::Serialize;

use super::accuracy::{DEPTHS_M, SURFACE_DEPTHS_M};
use super::front::{front, front_of_three};
use super::moving::SPEEDS_MM_PER_S;
use super::run::{Measured, Run};
use crate::error::Error;
use palpate_tissue::output::OutputFolder;

/// Contents of `summary.json`.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// Name of the scene that was pressed.
    pub scene: &'static str,
    /// Processor on which ticks were timed; the file states it in its provenance.
    #[serde(skip)]
    pub machine: String,
    /// Version and build profile; the file states them in its provenance.
    #[serde(skip)]
    pub build: String,
    /// Conditions that all methods share, conditions in which they differ, and origin of the cycle
    /// estimates.
    pub terms: [&'static str; 3],
    /// Number of rows.
    pub rows: usize,
    /// Number of rows that survived the deepest press.
    pub survived: usize,
    /// Fronts, one for each combination of cost, error and stiffness.
    pub fronts: Vec<Front>,
    /// Fronts in tick time, held error and moving error together, one per stiffness; empty if
    /// moving errors were not measured.
    pub moving_fronts: Vec<MovingFront>,
}

/// A front in three quantities: the points that no other point matches or beats in cost, held error
/// and moving error at once.
#[derive(Clone, Debug, Serialize)]
pub struct MovingFront {
    /// Young's modulus [Pa].
    pub youngs_modulus_pa: f64,
    /// Points in order of rising cost.
    pub points: Vec<MovingPoint>,
}

/// A point of a front in three quantities.
#[derive(Clone, Debug, Serialize)]
pub struct MovingPoint {
    /// Name of the method.
    pub method: &'static str,
    /// Number of nodes.
    pub nodes: usize,
    /// Substeps per tick.
    pub substeps: u16,
    /// Time of a tick [us].
    pub tick_us: f64,
    /// Root mean square force error of held presses [%].
    pub held_rms_pct: f64,
    /// Root mean square force error while the probe moves, relative to the largest force [%].
    pub moving_rms_pct: f64,
}

/// A front of one cost against one error.
#[derive(Clone, Debug, Serialize)]
pub struct Front {
    /// Young's modulus [Pa].
    pub youngs_modulus_pa: f64,
    /// Name of the cost on the horizontal axis.
    pub cost: &'static str,
    /// Name of the error that the front minimises.
    pub error: &'static str,
    /// Points in order of rising cost.
    pub points: Vec<FrontPoint>,
}

/// A point of a front.
#[derive(Clone, Debug, Serialize)]
pub struct FrontPoint {
    /// Name of the method.
    pub method: &'static str,
    /// Number of nodes.
    pub nodes: usize,
    /// Substeps per tick.
    pub substeps: u16,
    /// Cost in the unit of the front.
    pub cost: f64,
    /// Error in the unit of the front.
    pub error: f64,
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

impl Summary {
    /// Computes the fronts of rows whose times were measured on `processor`.
    #[must_use]
    pub fn of(runs: &[Run], processor: &str) -> Self {
        let mut moduli: Vec<f64> = runs.iter().map(|r| r.task.youngs_modulus_pa).collect();
        moduli.dedup();
        let mut fronts = Vec::new();
        let mut moving_fronts = Vec::new();
        for youngs_modulus_pa in moduli {
            let points = moving_front_of(runs, youngs_modulus_pa);
            if !points.is_empty() {
                moving_fronts.push(MovingFront { youngs_modulus_pa, points });
            }
            for (cost, cost_of) in COSTS {
                for (error, error_of) in ERRORS {
                    let points = front_of(runs, youngs_modulus_pa, cost_of, error_of);
                    if !points.is_empty() {
                        fronts.push(Front { youngs_modulus_pa, cost, error, points });
                    }
                }
            }
        }
        Self {
            scene: "block 80 x 80 x 40 mm, nu 0.45, hemisphere R = 8 mm, pressed to 8 mm",
            machine: processor.to_owned(),
            build: palpate_tissue::machine::build(),
            terms: [
                "contact: the same foundation points and law for all but implicit and compliance, which have unilateral contact at the nodes",
                "mass floor and damping: the same for all but implicit (true masses) and compliance (no masses)",
                "m4f_cycles are estimates: of ours from instruction counts, of the others from counted floating-point operations",
            ],
            rows: runs.len(),
            survived: runs.iter().filter(|r| r.survived().is_some()).count(),
            fronts,
            moving_fronts,
        }
    }
}

fn front_of(runs: &[Run], youngs_modulus_pa: f64, cost: Quantity, error: Quantity) -> Vec<FrontPoint> {
    let rows: Vec<(&Run, f64, f64)> = runs
        .iter()
        .filter(|r| r.task.youngs_modulus_pa == youngs_modulus_pa)
        .filter_map(|r| r.survived().and_then(|m| Some((r, cost(m)?, error(m)?))))
        .collect();
    let points: Vec<(f64, f64)> = rows.iter().map(|(_, c, e)| (*c, *e)).collect();
    let named = |n: usize| {
        let (run, cost, error) = rows[n];
        let substeps = run.survived().map_or(0, |m| m.substeps);
        FrontPoint { method: run.task.method.name(), nodes: run.task.nodes, substeps, cost, error }
    };
    front(&points).into_iter().map(named).collect()
}

/// Points of the rows that survive and have a tick time, a held and a moving error.
fn moving_points(runs: &[Run], youngs_modulus_pa: f64) -> Vec<MovingPoint> {
    let of_run = |run: &Run| {
        let m = run.survived()?;
        Some(MovingPoint {
            method: run.task.method.name(),
            nodes: run.task.nodes,
            substeps: m.substeps,
            tick_us: m.time.min_us,
            held_rms_pct: m.accuracy.rms_pct()?,
            moving_rms_pct: m.moving_rms_pct()?,
        })
    };
    runs.iter().filter(|r| r.task.youngs_modulus_pa == youngs_modulus_pa).filter_map(of_run).collect()
}

fn moving_front_of(runs: &[Run], youngs_modulus_pa: f64) -> Vec<MovingPoint> {
    let points = moving_points(runs, youngs_modulus_pa);
    let three: Vec<[f64; 3]> = points.iter().map(|p| [p.tick_us, p.held_rms_pct, p.moving_rms_pct]).collect();
    front_of_three(&three).into_iter().map(|n| points[n].clone()).collect()
}

/// Writes `chart.csv` and `summary.json`.
///
/// # Errors
/// The folder cannot be written.
pub fn write(folder: &OutputFolder, runs: &[Run], summary: &Summary) -> Result<(), Error> {
    folder.write("chart.csv", csv(runs).as_bytes())?;
    Ok(folder.write_summary(summary)?)
}

fn csv(runs: &[Run]) -> String {
    let depths = DEPTHS_M.map(|d| format!("force_{0}mm_n,force_error_{0}mm_pct", d * 1e3)).join(",");
    let surfaces = SURFACE_DEPTHS_M.map(|d| format!("surface_error_{}mm_mm", d * 1e3)).join(",");
    let ramps = SPEEDS_MM_PER_S.map(|v| format!("ramp_{v}_mm_per_s_rms_pct,ramp_{v}_mm_per_s_peak_pct")).join(",");
    let mut text = format!(
        "method,nodes,edges,tets,youngs_modulus_pa,survives_8mm,substeps,min_j_8mm,tick_min_us,tick_median_us,times_springs,m4f_cycles_estimate,{depths},force_rms_pct,{surfaces},moving_rms_pct,{ramps}\n"
    );
    for run in runs {
        let (task, size) = (run.task, run.size);
        let head = format!(
            "{},{},{},{},{},\"{}\"",
            task.method.name(),
            size.nodes,
            size.edges,
            size.tets,
            task.youngs_modulus_pa,
            run.verdict()
        );
        let tail = match &run.outcome {
            Err(_) => ",".repeat(6 + 2 * DEPTHS_M.len() + 1 + SURFACE_DEPTHS_M.len() + 1 + 2 * SPEEDS_MM_PER_S.len()),
            Ok(m) => values(m),
        };
        text.push_str(&head);
        text.push_str(&tail);
        text.push('\n');
    }
    text
}

/// Formats the measured values as CSV cells, each preceded by a comma.
fn values(m: &Measured) -> String {
    let a = &m.accuracy;
    let mut cells = vec![
        m.substeps.to_string(),
        format!("{:.3}", m.trial.min_j),
        format!("{:.2}", m.time.min_us),
        format!("{:.2}", m.time.median_us),
        format!("{:.2}", m.time.times_springs),
        format!("{:.0}", m.m4f_cycles),
    ];
    let or_empty = |v: Option<f64>, digits: usize| v.map_or(String::new(), |v| format!("{v:.digits$}"));
    for (force, error) in a.force_n.iter().zip(a.force_error_pct) {
        cells.push(format!("{force:.5}"));
        cells.push(or_empty(error, 2));
    }
    cells.push(or_empty(a.rms_pct(), 2));
    cells.extend(a.surface_error_mm.map(|s| or_empty(s, 4)));
    cells.push(or_empty(m.moving_rms_pct(), 2));
    for n in 0..SPEEDS_MM_PER_S.len() {
        let ramp = m.moving.and_then(Result::ok).map(|moving| moving.0[n]);
        cells.push(or_empty(ramp.map(|r| r.rms_pct), 2));
        cells.push(or_empty(ramp.map(|r| r.peak_pct), 2));
    }
    cells.into_iter().map(|c| format!(",{c}")).collect()
}
