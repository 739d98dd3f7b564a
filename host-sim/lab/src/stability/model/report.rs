//! The matrix as CSV and JSON.

use palpate::ClampFlags;
use serde::Serialize;

use super::load_case::{CaseTissue, Stimulus};
use super::matrix::{Cell, Matrix};
use super::promise::{is_promised, promises};
use super::verdict::Verdict;
use crate::error::Error;
use palpate_tissue::output::OutputFolder;

/// Contents of `summary.json`.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// Name of the scene that was pressed.
    pub scene: String,
    /// Definitions of the terms that the report uses.
    pub terms: [&'static str; 5],
    /// Number of cells of every row by verdict.
    pub rows: Vec<Counts>,
    /// Worst figures of the product in the cells for which it makes promises.
    pub product: Worst,
    /// Promises that did not hold, one sentence each.
    pub broken: Vec<String>,
}

/// Number of cells of a row by verdict.
#[derive(Clone, Debug, Serialize)]
pub struct Counts {
    /// Name of the row.
    pub row: String,
    /// Substeps per tick at each stiffness, on the block without the inclusion.
    pub substeps: Vec<u16>,
    /// Verdicts and the number of cells that have them.
    pub verdicts: Vec<(Verdict, usize)>,
}

/// Worst figures over the cells for which the product makes promises.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Worst {
    /// Number of cells to which a promise applies.
    pub cells: usize,
    /// Smallest volume ratio J of a tet in any tick (1).
    pub lowest_j: f64,
    /// Smallest volume ratio J of a tet at the end of a hold (1).
    pub held_j: f64,
    /// Largest distance of a node from its rest position half a second after a release [mm].
    pub residual_mm: f64,
    /// Largest fall of the force in a slow press, relative to the largest force [%].
    pub drop_pct: f64,
    /// Largest fall of the force in a slow press with jittered poses, relative to the largest force
    /// [%]. The speed of the tip jumps from tick to tick, and the force jumps with it.
    pub jitter_drop_pct: f64,
    /// Largest change of the force in the last 20 ms of a hold [%].
    pub force_change_pct: f64,
}

impl Summary {
    /// Counts verdicts, promises and margins of a matrix.
    #[must_use]
    pub fn of(matrix: &Matrix) -> Self {
        let rows = matrix.scope.rows.iter().filter_map(|row| {
            let own: Vec<&Cell> = matrix.cells.iter().filter(|c| c.row == *row).collect();
            let of = |pa: &f64| {
                own.iter().find(|c| c.youngs_modulus_pa == *pa && c.case.tissue == CaseTissue::Plain).map(|c| c.substeps)
            };
            let substeps = matrix.scope.moduli_pa.iter().filter_map(of).collect();
            let count = |verdict: Verdict| own.iter().filter(|c| c.figures.verdict == verdict).count();
            let verdicts = Verdict::ALL.map(|v| (v, count(v))).into_iter().filter(|(_, n)| *n > 0).collect();
            (!own.is_empty()).then(|| Counts { row: row.name(), substeps, verdicts })
        });
        Self {
            scene: format!("block 80 x 80 x 40 mm of {} nodes, nu 0.45, hemisphere R = 8 mm", matrix.scope.nodes),
            terms: [
                "substeps: the product's as a session derives them, the others' the fewest with which they survive the chart's press to 8 mm on the same tissue",
                "jitter: the pose that a tick is given was sensed up to half a tick before or after it; the step of the model stays what it is, as on a device",
                "held: the product's guard let the tip no deeper than 10 mm; the other methods have no depth limit, and no more than 1 m/s is shown to any but implicit and compliance",
                "force is cut at 12 N, the most the core lets out: above that a fall of it is not seen; it is judged in slow presses only",
                "margins: one quantity grows while the others stay at the press to 8 mm and the tap of 0.5 m/s, found within 5 %; the tick up to 2 ms, which is what the foundation's damping and slope allow",
            ],
            rows: rows.collect(),
            product: Worst::of(matrix),
            broken: promises(matrix),
        }
    }
}

impl Worst {
    fn of(matrix: &Matrix) -> Self {
        let none = Self {
            cells: 0,
            lowest_j: f64::INFINITY,
            held_j: f64::INFINITY,
            residual_mm: 0.0,
            drop_pct: 0.0,
            jitter_drop_pct: 0.0,
            force_change_pct: 0.0,
        };
        matrix.cells.iter().filter(|c| is_promised(c)).fold(none, |worst, cell| {
            let f = &cell.figures;
            let stimulus = cell.case.stimulus;
            let even = Stimulus { jitter: 0.0, ..stimulus };
            let drop_pct = if stimulus.is_slow() { f.drop_pct } else { 0.0 };
            let jitter_drop_pct = if even.is_slow() { f.drop_pct } else { 0.0 };
            Self {
                cells: worst.cells + 1,
                lowest_j: worst.lowest_j.min(f.lowest_j),
                held_j: worst.held_j.min(f.held_j),
                residual_mm: worst.residual_mm.max(f.residual_mm),
                drop_pct: worst.drop_pct.max(drop_pct),
                jitter_drop_pct: worst.jitter_drop_pct.max(jitter_drop_pct),
                force_change_pct: worst.force_change_pct.max(f.force_change_pct),
            }
        })
    }
}

/// Writes `stability_model.csv` and `stability_margins.csv`.
///
/// # Errors
/// The folder cannot be written.
pub fn write(folder: &OutputFolder, matrix: &Matrix) -> Result<(), Error> {
    folder.write("stability_model.csv", cells(matrix).as_bytes())?;
    Ok(folder.write("stability_margins.csv", margins(matrix).as_bytes())?)
}

fn cells(matrix: &Matrix) -> String {
    let mut text = String::from(
        "row,method,substeps,youngs_modulus_pa,case,depth_m,in_m_per_s,out_m_per_s,jitter,tissue,promised,verdict,lowest_j,held_j,residual_mm,force_drop_pct,moved_mm,force_change_pct,held_n,peak_n,diverged_at_mm,depth_held,speed_limited,force_cut\n",
    );
    for cell in &matrix.cells {
        let (f, s) = (&cell.figures, cell.case.stimulus);
        let clamped = |limiter: ClampFlags| f.limiters.contains(limiter).to_string();
        let row = [
            cell.row.name(),
            cell.row.method.name().into(),
            cell.substeps.to_string(),
            cell.youngs_modulus_pa.to_string(),
            cell.case.name.into(),
            s.depth_m.to_string(),
            s.in_m_per_s.to_string(),
            s.out_m_per_s.to_string(),
            s.jitter.to_string(),
            cell.case.tissue.name().into(),
            is_promised(cell).to_string(),
            f.verdict.name().into(),
            number(f.lowest_j, 4),
            number(f.held_j, 4),
            number(f.residual_mm, 5),
            number(f.drop_pct, 3),
            number(f.moved_mm, 5),
            number(f.force_change_pct, 3),
            number(f.held_n, 5),
            number(f.peak_n, 5),
            f.diverged_at_mm.map_or(String::new(), |d| number(d, 2)),
            clamped(ClampFlags::DEPTH),
            clamped(ClampFlags::SPEED),
            clamped(ClampFlags::FORCE),
        ];
        text.push_str(&row.join(","));
        text.push('\n');
    }
    text
}

fn margins(matrix: &Matrix) -> String {
    let mut text = String::from("row,method,substeps,youngs_modulus_pa,quantity,standard,passes_up_to,largest_tried,beyond\n");
    for cell in &matrix.margins {
        let row = [
            cell.row.name(),
            cell.row.method.name().into(),
            cell.substeps.to_string(),
            cell.youngs_modulus_pa.to_string(),
            cell.axis.name().into(),
            cell.axis.standard(cell.youngs_modulus_pa).to_string(),
            cell.margin.passes.map_or(String::new(), |v| format!("{v:.4e}")),
            cell.axis.range()[1].to_string(),
            cell.margin.beyond.map_or("", Verdict::name).into(),
        ];
        text.push_str(&row.join(","));
        text.push('\n');
    }
    text
}

/// Formats a value; the text is empty if nothing was measured.
fn number(value: f64, digits: usize) -> String {
    if value.is_finite() { format!("{value:.digits$}") } else { String::new() }
}
