//! Promises of the product, compared with the results.

use super::load_case::Promise;
use super::matrix::{Cell, Matrix};
use super::verdict::Verdict;

/// Smallest and largest Young's modulus for which the product makes promises [Pa].
const PROMISED_PA: [f64; 2] = [3.5e3, 100e3];
/// Smallest ratio of a tet's volume to its rest volume that the product promises (1).
pub const LEAST_J: f64 = 0.2;

/// One sentence for each promise that did not hold.
pub fn promises(matrix: &Matrix) -> Vec<String> {
    matrix.cells.iter().filter(|c| is_promised(c)).filter_map(broken).collect()
}

/// Whether the product makes a promise for this cell.
pub fn is_promised(cell: &Cell) -> bool {
    let [softest_pa, stiffest_pa] = PROMISED_PA;
    let stiffness = (softest_pa..=stiffest_pa).contains(&cell.youngs_modulus_pa);
    cell.row.is_promised() && stiffness && cell.case.promise != Promise::None
}

/// The promise of a cell that did not hold, in one sentence.
pub(super) fn broken(cell: &Cell) -> Option<String> {
    let figures = &cell.figures;
    let wanted = match cell.case.promise {
        Promise::Hold => Verdict::Held,
        Promise::LetThrough => Verdict::Pierced,
        Promise::Pass | Promise::None => Verdict::Pass,
    };
    let kept = figures.verdict == wanted && figures.lowest_j > LEAST_J;
    let message = || {
        format!(
            "{} at {} kPa, {}: {} where {} is promised, smallest J {:.3} (promised above {LEAST_J}), {:.3} mm left",
            cell.row.name(),
            cell.youngs_modulus_pa * 1e-3,
            cell.case.name,
            figures.verdict.name(),
            wanted.name(),
            figures.lowest_j,
            figures.residual_mm,
        )
    };
    (!kept).then(message)
}
