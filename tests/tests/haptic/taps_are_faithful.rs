//! With the substeps that a session derives, a patch responds to taps as with true masses, from 3.5
//! to 100 kPa; with one step and floored masses it does not.

use palpate::Params;
use palpate_loop::closed_loop::fidelity::{TAPS, derive};
use palpate_tests::bench::Bench;
use palpate_tissue::moving::with_substeps;

const DEPTH_M: f64 = 4e-3;

#[test]
fn derived_substeps_answer_taps_within_2_and_8_percent() {
    for nodes in [130, 410] {
        for youngs_modulus_pa in [3.5e3, 20e3, 100e3] {
            let mut bench = Bench::calibrated(nodes).with(|p| p.youngs_modulus_pa = youngs_modulus_pa);
            bench.patch.set_depth_limit_m(8e-3);
            let one = Params { substeps: 1, ..bench.params };
            let derived = derive(&bench.patch, &one, DEPTH_M).unwrap();
            println!("{nodes} nodes, {youngs_modulus_pa} Pa: {} substeps, {:?}", derived.params.substeps, derived.errors);
            assert!(derived.held && derived.errors.iter().zip(TAPS).all(|(e, (_, most))| *e <= most), "{derived:?}");
            assert!((1..=8).contains(&derived.params.substeps));
            assert_eq!(with_substeps(&one, derived.params.substeps), derived.params);
        }
    }
}

#[test]
fn one_step_is_not_faithful_on_stiff_tissue() {
    // these parameters allow one step per tick only because they limit the sinking speed to what
    // floored masses can follow
    let mut bench = Bench::calibrated(130).with(|p| p.youngs_modulus_pa = 100e3);
    bench.patch.set_depth_limit_m(8e-3);
    let derived = derive(&bench.patch, &Params { substeps: 1, ..bench.params }, DEPTH_M).unwrap();
    assert!(derived.params.substeps > 1, "{derived:?}");
}
