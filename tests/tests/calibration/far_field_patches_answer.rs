//! A calibrated patch with a far field is accurate at places and depths that no fit used, also for
//! glued discs, and in another organ once its far field has been replaced.

use palpate_fit::statics::{Solver, Statics, Vector};
use palpate_tests::far_patch::FarPatch;
use palpate_tissue::answer::Answer;
use palpate_tissue::scene::Inclusion;

/// Patch radius and element size [m], which give 68 nodes.
const SIZE: (f64, f64) = (0.017, 0.0052);
const DEPTHS_M: [f64; 4] = [0.001, 0.002, 0.004, 0.006];
/// An inclusion ten times as stiff, outside the patch, below its rim.
const OUTSIDE: Inclusion = Inclusion { center_m: [0.0, 0.0, -0.026], radius_m: 0.008, stiffness_ratio: 10.0, stiffening_b: None };

/// Forces over E of centred presses [m^2], one per depth.
fn forces(statics: &Statics) -> Vec<f64> {
    let solver = Solver::of(statics).unwrap();
    let mut here = solver.rest(statics, Vector::zeros(), 1e-4).unwrap();
    let mut found = Vec::new();
    for depth_m in DEPTHS_M {
        here = solver.press(statics, &here, -statics.axis() * depth_m, depth_m).unwrap();
        found.push(here.force);
    }
    found
}

fn worst(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max)
}

#[test]
fn a_patch_is_right_where_it_was_not_fitted() {
    let patch = FarPatch::quick(SIZE.0, SIZE.1);
    let fitted = Statics::of(&patch.fitted.patch.model(), &patch.fitted.params).unwrap();
    for at in &patch.verdict.depths {
        println!("{at:?}");
    }
    let at = |mm: f64| *patch.verdict.depths.iter().find(|at| (at.depth_mm - mm).abs() < 1e-6).unwrap();
    let rms = |errors: [f64; 3]| (errors.iter().map(|e| e * e).sum::<f64>() / 3.0).sqrt();
    // the fit used neither the depths of 1.5, 3 and 6 mm nor any of the places
    assert!(rms([1.5, 3.0, 6.0].map(|mm| at(mm).centred_pct)) < 2.0);
    // a quick fit has forty places, too few for the shallowest presses, so those are not checked
    // here
    let disc = [2.0, 3.0, 4.0].map(at);
    assert!(rms(disc.map(|at| at.rms_pct)) < 2.0 && disc.iter().all(|at| at.worst_pct.abs() < 5.0), "{disc:?}");
    let solver = Solver::of(&fitted).unwrap();
    let answer = Answer::block();
    let centred: Vec<_> = answer.glued.iter().filter(|disc| disc.place_m == [0.0; 3]).collect();
    assert!(centred.len() >= 2);
    for disc in centred {
        let found_m = solver.glued(&fitted, Vector::zeros(), disc.radius_m, disc.direction.into()).unwrap().stiffness_m;
        let off = found_m / disc.stiffness_over_e_m - 1.0;
        assert!(off.abs() < 0.03, "{:?} {off}", disc.direction);
    }
    // before the fit it is not accurate
    let raw = Statics::of(&patch.prepared.patch().model(), &patch.prepared.params).unwrap();
    assert!(worst_of(&raw, &fitted) > 0.05);
}

fn worst_of(a: &Statics, b: &Statics) -> f64 {
    worst(&forces(a), &forces(b))
}

#[test]
fn a_fitted_patch_takes_the_far_field_of_another_organ() {
    let patch = FarPatch::quick(SIZE.0, SIZE.1);
    let (bench, other) = patch.with_balls(&[OUTSIDE], 0.008);
    let swapped = Statics::of(&bench.patch.model(), &bench.params).unwrap();
    let rim: Vec<usize> = other.far.cut.rim.iter().map(|n| *n as usize).collect();
    let exact = swapped.with_rim(&rim, &other.far.exact_m);
    assert!(worst_of(&swapped, &exact) < 0.005, "{}", worst_of(&swapped, &exact));
    let kept = Statics::of(&patch.fitted.patch.model(), &patch.fitted.params).unwrap();
    assert!(worst_of(&kept, &exact) > 0.02, "{}", worst_of(&kept, &exact));
}
