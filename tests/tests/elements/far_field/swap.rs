//! Another organ around the same patch: only the far field is replaced.

use palpate_fit::far_field::springs;
use palpate_fit::statics::{Statics, Vector};

use super::{far_field, forces, free, graded, on_bottom, radius, rim, tissue};
use palpate::Params;
use palpate_tissue::patch::{Material, Patch};
use palpate_tissue::tissue::Tissue;

const DEPTHS_M: [f64; 3] = [0.001, 0.002, 0.004];

/// Forces of the patch with the far field of `whole`, and forces of `whole` itself.
fn pressed(whole: &Tissue) -> (Vec<f64>, Vec<f64>) {
    let far = far_field(whole, &radius(0.018));
    let patch = forces(&free(&far).with_rim(&rim(&far), &springs::dense(&far.springs)), Vector::zeros(), &DEPTHS_M);
    let all = Statics::of(&Patch::build(whole, &Material::default(), None).model(), &Params::default()).unwrap();
    (patch, forces(&all, Vector::zeros(), &DEPTHS_M))
}

/// Three organs are compared: a block fixed at its bottom; one fixed at its sides as well; and one
/// in which everything below 24 mm is bone, which leaves a thin layer. Replacing the far field
/// changes the force by the same ratio as changing the organ itself, within 2 %; without replacing
/// it the force is wrong. (The comparison is with the whole mesh of the same springs, whose own
/// error cancels in the ratio.)
#[test]
fn a_swapped_far_field_changes_the_force_as_the_other_organ_does() {
    let mesh = graded(300);
    let whole = |fixed: &dyn Fn(&[f64; 3]) -> bool| tissue(mesh.clone(), [0.0; 3], fixed);
    let (patch, own) = pressed(&whole(&on_bottom));
    let walls = |x: &[f64; 3]| on_bottom(x) || x[0].abs() > 0.0399 || x[1].abs() > 0.0399;
    let bone = |x: &[f64; 3]| x[2] < -0.024;
    for (name, fixed) in [("walls", &walls as &dyn Fn(&[f64; 3]) -> bool), ("thin layer", &bone)] {
        let (swapped, other) = pressed(&whole(fixed));
        for k in 0..DEPTHS_M.len() {
            let (found, wanted) = (swapped[k] / patch[k], other[k] / own[k]);
            let (off_pct, not_swapped_pct) = (100.0 * (found / wanted - 1.0), 100.0 * (1.0 / wanted - 1.0));
            println!("{name}, {} m: swapped {off_pct:+.2} %, not swapped {not_swapped_pct:+.2} %", DEPTHS_M[k]);
            assert!(off_pct.abs() < 2.0, "{name}, {} m: {off_pct} % off the other organ", DEPTHS_M[k]);
            // measured: an error at least five times as large
            let felt = not_swapped_pct.abs() > 2.0 && not_swapped_pct.abs() > 5.0 * off_pct.abs();
            assert!(felt, "{name}, {} m: swapped {off_pct} %, not swapped {not_swapped_pct} %", DEPTHS_M[k]);
        }
    }
}
