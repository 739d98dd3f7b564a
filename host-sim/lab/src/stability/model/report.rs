//! The matrix as tables.

use palpate::ClampFlags;
use palpate_sim::error::Error;
use serde::Serialize;

use super::load_case::{CaseTissue, Stimulus};
use super::matrix::{Cell, MarginCell, Matrix};
use super::promise::{LEAST_J, is_promised, promises};
use super::verdict::Verdict;
use crate::study::{Claim, Findings, Table};

/// Definitions of the terms of the tables.
const TERMS: [&str; 5] = [
    "substeps: the product's as a session derives them, the others' the fewest with which they survive the chart's press to 8 mm on the same tissue",
    "jitter: the pose that a tick is given was sensed up to half a tick before or after it; the step of the model stays what it is, as on a device",
    "held: the product's guard let the tip no deeper than 10 mm; the other methods have no depth limit, and no more than 1 m/s is shown to any but implicit and compliance",
    "force is cut at 12 N, the most the core lets out: above that a fall of it is not seen; it is judged in slow presses only",
    "margins: one quantity grows while the others stay at the press to 8 mm and the tap of 0.5 m/s, found within 5 %; the tick up to 2 ms, which is what the foundation's damping and slope allow",
];

/// A row of the matrix: its substeps at each stiffness, on the block without the inclusion, and how
/// many cells ended in which verdict.
#[derive(Serialize)]
struct MethodRow {
    method: String,
    substeps: String,
    ended_in: String,
}

#[derive(Serialize)]
struct CellRow {
    row: String,
    method: &'static str,
    substeps: u16,
    youngs_modulus_pa: f64,
    case: &'static str,
    depth_m: f64,
    in_m_per_s: f64,
    out_m_per_s: f64,
    jitter: f64,
    tissue: &'static str,
    promised: bool,
    verdict: Verdict,
    lowest_j: Option<f64>,
    held_j: Option<f64>,
    residual_mm: Option<f64>,
    force_drop_pct: Option<f64>,
    moved_mm: Option<f64>,
    force_change_pct: Option<f64>,
    held_n: Option<f64>,
    peak_n: Option<f64>,
    diverged_at_mm: Option<f64>,
    depth_held: bool,
    speed_limited: bool,
    force_cut: bool,
}

impl CellRow {
    fn of(cell: &Cell) -> Self {
        let (f, s) = (&cell.figures, cell.case.stimulus);
        // a value that was not measured is left out
        let some = |value: f64| Some(value).filter(|v| v.is_finite());
        Self {
            row: cell.row.name(),
            method: cell.row.method.name(),
            substeps: cell.substeps,
            youngs_modulus_pa: cell.youngs_modulus_pa,
            case: cell.case.name,
            depth_m: s.depth_m,
            in_m_per_s: s.in_m_per_s,
            out_m_per_s: s.out_m_per_s,
            jitter: s.jitter,
            tissue: cell.case.tissue.name(),
            promised: is_promised(cell),
            verdict: f.verdict,
            lowest_j: some(f.lowest_j),
            held_j: some(f.held_j),
            residual_mm: some(f.residual_mm),
            force_drop_pct: some(f.drop_pct),
            moved_mm: some(f.moved_mm),
            force_change_pct: some(f.force_change_pct),
            held_n: some(f.held_n),
            peak_n: some(f.peak_n),
            diverged_at_mm: f.diverged_at_mm,
            depth_held: f.limiters.contains(ClampFlags::DEPTH),
            speed_limited: f.limiters.contains(ClampFlags::SPEED),
            force_cut: f.limiters.contains(ClampFlags::FORCE),
        }
    }
}

#[derive(Serialize)]
struct MarginRow {
    row: String,
    method: &'static str,
    substeps: u16,
    youngs_modulus_pa: f64,
    quantity: &'static str,
    standard: f64,
    passes_up_to: Option<f64>,
    largest_tried: f64,
    beyond: Option<Verdict>,
}

impl MarginRow {
    fn of(cell: &MarginCell) -> Self {
        Self {
            row: cell.row.name(),
            method: cell.row.method.name(),
            substeps: cell.substeps,
            youngs_modulus_pa: cell.youngs_modulus_pa,
            quantity: cell.axis.name(),
            standard: cell.axis.standard(cell.youngs_modulus_pa),
            passes_up_to: cell.margin.passes,
            largest_tried: cell.axis.range()[1],
            beyond: cell.margin.beyond,
        }
    }
}

/// Adds the tables, the pictures and the claim of the matrix.
///
/// # Errors
/// A table cannot be formatted.
pub fn report(matrix: &Matrix, findings: &mut Findings) -> Result<(), Error> {
    let moduli: Vec<String> = matrix.scope.moduli_pa.iter().map(|pa| (pa * 1e-3).to_string()).collect();
    let rows = matrix.scope.rows.iter().filter_map(|row| {
        let own: Vec<&Cell> = matrix.cells.iter().filter(|c| c.row == *row).collect();
        let plain = |pa: &f64| {
            let of = |c: &&&Cell| c.youngs_modulus_pa == *pa && c.case.tissue == CaseTissue::Plain;
            own.iter().find(of).map(|c| c.substeps.to_string())
        };
        let count = |v: Verdict| (own.iter().filter(|c| c.figures.verdict == v).count(), v.name());
        let ended = Verdict::ALL.map(count).into_iter().filter(|(n, _)| *n > 0).map(|(n, name)| format!("{n} {name}"));
        let substeps = matrix.scope.moduli_pa.iter().filter_map(plain).collect::<Vec<_>>().join("/");
        let ended_in = ended.collect::<Vec<_>>().join(", ");
        (!own.is_empty()).then(|| (row.is_promised(), MethodRow { method: row.name(), substeps, ended_in }))
    });
    let (ours, rows): (Vec<bool>, Vec<MethodRow>) = rows.unzip();
    let cells: Vec<CellRow> = matrix.cells.iter().map(CellRow::of).collect();
    let margins: Vec<MarginRow> = matrix.margins.iter().map(MarginRow::of).collect();
    let about = format!(
        "block 80 x 80 x 40 mm of {} nodes, nu 0.45, hemisphere R = 8 mm; substeps at {} kPa; {} presses and taps per row",
        matrix.scope.nodes,
        moduli.join("/"),
        matrix.scope.moduli_pa.len() * matrix.scope.cases.len()
    );
    let broken = promises(matrix);
    let fails = cells.iter().map(|row| broken.iter().any(|line| line.starts_with(&row.row) && line.contains(row.case)));
    let fails: Vec<bool> = fails.collect();
    let promised = matrix.margins.iter().map(|cell| cell.row.is_promised()).collect::<Vec<_>>();
    findings.tables.extend([
        Table::of("stability_methods", &rows)?.about(about).only(ours),
        Table::of("stability_model", &cells)?.only(fails).columns(&[
            "row",
            "youngs_modulus_pa",
            "case",
            "promised",
            "verdict",
            "lowest_j",
            "held_j",
            "residual_mm",
            "force_drop_pct",
        ]),
        Table::of("stability_margins", &margins)?
            .about("how far a quantity can go before a press to 8 mm or a tap of 0.5 m/s fails, and in which way")
            .only(promised)
            .columns(&["row", "youngs_modulus_pa", "quantity", "standard", "passes_up_to", "largest_tried", "beyond"]),
    ]);
    worst(matrix, findings);
    let promised = matrix.cells.iter().filter(|cell| is_promised(cell)).count();
    let found = match broken.as_slice() {
        [] => format!("all {promised}"),
        [first, ..] => format!("{} of {promised} do not hold, the first: {first}", broken.len()),
    };
    findings.claims.push(Claim::promise(
        "presses that our patches promise to survive",
        format!("all, and every tet keeps {LEAST_J} of its volume"),
        found,
        broken.is_empty(),
    ));
    findings.notes.extend(broken.iter().map(|line| format!("does not hold: {line}")));
    findings.notes.extend(TERMS.map(str::to_owned));
    findings.figures.extend(super::figures::figures(matrix));
    Ok(())
}

/// Adds the worst figures over the cells for which the product makes promises.
fn worst(matrix: &Matrix, findings: &mut Findings) {
    let cells = || matrix.cells.iter().filter(|cell| is_promised(cell));
    let slow = |cell: &&Cell| cell.case.stimulus.is_slow();
    let jittered = |cell: &&Cell| Stimulus { jitter: 0.0, ..cell.case.stimulus }.is_slow();
    findings.fact("worst_lowest_j", cells().map(|c| c.figures.lowest_j).fold(f64::INFINITY, f64::min));
    findings.fact("worst_held_j", cells().map(|c| c.figures.held_j).fold(f64::INFINITY, f64::min));
    findings.fact("worst_residual_mm", cells().map(|c| c.figures.residual_mm).fold(0.0, f64::max));
    findings.fact("worst_drop_pct", cells().filter(slow).map(|c| c.figures.drop_pct).fold(0.0, f64::max));
    findings.fact("worst_jitter_drop_pct", cells().filter(jittered).map(|c| c.figures.drop_pct).fold(0.0, f64::max));
    findings.fact("worst_force_change_pct", cells().map(|c| c.figures.force_change_pct).fold(0.0, f64::max));
}
