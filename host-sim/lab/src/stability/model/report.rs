//! The matrix as tables.

use super::built_method::Row;
use super::load_case::{CaseTissue, Stimulus};
use super::matrix::{Cell, Matrix};
use super::promise::{LEAST_J, broken, is_promised, promises};
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

/// The cells of the matrix; those that break a promise are printed.
fn cells(matrix: &Matrix) -> Table {
    Table::rows("stability_model", &matrix.cells)
        .col("row", |c| c.row.name())
        .csv("method", |c| c.row.method.name())
        .csv("substeps", |c| c.substeps)
        .col("youngs_modulus_pa", |c| c.youngs_modulus_pa)
        .col("case", |c| c.case.name)
        .csv("depth_m", |c| c.case.stimulus.depth_m)
        .csv("in_m_per_s", |c| c.case.stimulus.in_m_per_s)
        .csv("out_m_per_s", |c| c.case.stimulus.out_m_per_s)
        .csv("jitter", |c| c.case.stimulus.jitter)
        .csv("tissue", |c| c.case.tissue.name())
        .col("promised", |c| is_promised(c))
        .col("verdict", |c| c.figures.verdict.name())
        .col("lowest_j", |c| c.figures.lowest_j)
        .col("held_j", |c| c.figures.held_j)
        .col("residual_mm", |c| c.figures.residual_mm)
        .col("force_drop_pct", |c| c.figures.drop_pct)
        .csv("moved_mm", |c| c.figures.moved_mm)
        .csv("force_change_pct", |c| c.figures.force_change_pct)
        .csv("held_n", |c| c.figures.held_n)
        .csv("peak_n", |c| c.figures.peak_n)
        .csv("diverged_at_mm", |c| c.figures.diverged_at_mm)
        .csv("depth_held", |c| c.figures.depth_held)
        .csv("speed_limited", |c| c.figures.speed_limited)
        .csv("force_cut", |c| c.figures.force_cut)
        .only(|c| is_promised(c) && broken(c).is_some())
}

fn margins(matrix: &Matrix) -> Table {
    Table::rows("stability_margins", &matrix.margins)
        .col("row", |c| c.row.name())
        .csv("method", |c| c.row.method.name())
        .csv("substeps", |c| c.substeps)
        .col("youngs_modulus_pa", |c| c.youngs_modulus_pa)
        .col("quantity", |c| c.axis.name())
        .col("standard", |c| c.axis.standard(c.youngs_modulus_pa))
        .col("passes_up_to", |c| c.margin.passes)
        .col("largest_tried", |c| c.axis.range()[1])
        .col("beyond", |c| c.margin.beyond.map(Verdict::name))
        .only(|c| c.row.is_promised())
}

/// The rows of the matrix: substeps at each stiffness, on the block without the inclusion, and the
/// number of cells that ended in each verdict.
fn methods(matrix: &Matrix) -> Table {
    let own = |row: &Row| matrix.cells.iter().filter(move |c| c.row == *row).collect::<Vec<_>>();
    let rows = matrix.scope.rows.iter().map(|row| (row, own(row))).filter(|(_, own)| !own.is_empty());
    let substeps = |own: &[&Cell]| {
        let plain = |pa: &f64| own.iter().find(|c| c.youngs_modulus_pa == *pa && c.case.tissue == CaseTissue::Plain);
        let at = matrix.scope.moduli_pa.iter().filter_map(plain).map(|c| c.substeps.to_string());
        at.collect::<Vec<_>>().join("/")
    };
    let ended = |own: &[&Cell]| {
        let count = |v: Verdict| (own.iter().filter(|c| c.figures.verdict == v).count(), v.name());
        let counts = Verdict::ALL.map(count).into_iter().filter(|(n, _)| *n > 0);
        counts.map(|(n, name)| format!("{n} {name}")).collect::<Vec<_>>().join(", ")
    };
    Table::rows("stability_methods", rows)
        .col("method", |(row, _)| row.name())
        .col("substeps", |(_, own)| substeps(own))
        .col("ended_in", |(_, own)| ended(own))
        .only(|(row, _)| row.is_promised())
}

/// Adds the tables, the pictures and the claim of the matrix.
pub fn report(matrix: &Matrix, findings: &mut Findings) {
    let moduli: Vec<String> = matrix.scope.moduli_pa.iter().map(|pa| (pa * 1e-3).to_string()).collect();
    let about = format!(
        "block 80 x 80 x 40 mm of {} nodes, nu 0.45, hemisphere R = 8 mm; substeps at {} kPa; {} presses and taps per row",
        matrix.scope.nodes,
        moduli.join("/"),
        matrix.scope.moduli_pa.len() * matrix.scope.cases.len()
    );
    let broken = promises(matrix);
    findings.tables.extend([
        methods(matrix).about(about),
        cells(matrix),
        margins(matrix).about("how far a quantity can go before a press to 8 mm or a tap of 0.5 m/s fails, and in which way"),
    ]);
    worst(matrix, findings);
    let cells = || matrix.cells.iter().filter(|cell| is_promised(cell));
    let (promised, lowest_j) = (cells().count(), cells().map(|c| c.figures.lowest_j).fold(f64::INFINITY, f64::min));
    let found = match broken.as_slice() {
        [] => format!("all {promised}; the tet squeezed most keeps {lowest_j:.3}"),
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
