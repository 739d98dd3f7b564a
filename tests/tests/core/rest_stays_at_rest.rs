//! Untouched tissue does not move and exerts no force, whatever its mesh, stiffness and size.
//!
//! Rest lengths are rounded independently of the rest positions. Half an ulp of the block's
//! half-width, divided by the shortest edge, is a strain, and so is the rounding of a force divided
//! by the corresponding stiffness. If all these strains had the same direction over the whole
//! block, its far side would move by strain times side length. This is the bound; a real pre-strain
//! of 1e-5 is far above it.

use palpate::stages::probe::ProbePose;
use palpate::{Output, Vector3, tick};
use palpate_tests::bench::Bench;
use palpate_tests::rounding::UNIT;
use palpate_tissue::measure;

const TICKS: usize = 2000;
/// Number of roundings of a force, relative to stiffness times length: as many as a node has
/// springs and tets.
const OPERATIONS: f64 = 40.0;

fn stays(bench: &Bench, side_m: f64, label: &str) {
    let model = bench.patch.wide_model();
    let mut memory = bench.memory();
    let (tuned, mut state) = memory.start(&model, &bench.params).unwrap();
    let tip_m = Vector3::new(0.0, 0.0, side_m as f32);
    for n in 0..TICKS {
        let output = tick(&model, &tuned, &mut state, ProbePose { tip_m });
        let free = (model.nodes.len() - model.anchors.len()) as u16;
        assert_eq!(output, Output { point_m: tip_m, active_nodes: free, outside: true, ..Output::NONE }, "{label}, tick {n}");
    }
    let shortest_m = model.springs.iter().map(|s| f64::from(s.k_rest / s.k)).fold(f64::INFINITY, f64::min);
    let strain = UNIT * (side_m / 2.0 / shortest_m + OPERATIONS);
    let moved_m = measure::largest_displacement_m(&model, &state);
    println!("{label}: moved {:.2e} of the side, allowed {strain:.2e}", moved_m / side_m);
    assert!(moved_m <= strain * side_m, "{label}: moved {moved_m} m, rounding explains {} m", strain * side_m);
}

#[test]
fn rest_stays_at_rest() {
    for nodes in [60, 129, 410, 1023] {
        stays(&Bench::block(nodes), 0.08, &format!("{nodes} nodes"));
    }
    for youngs_modulus_pa in [500.0, 20e3, 100e3] {
        let bench = Bench::block(129).with(|p| p.youngs_modulus_pa = youngs_modulus_pa);
        stays(&bench, 0.08, &format!("{youngs_modulus_pa} Pa"));
    }
    let undamped = Bench::block(129).with(|p| p.node_damping_per_s = 0.0);
    stays(&undamped, 0.08, "no damping");
    for scale in [0.01, 0.1, 10.0] {
        let bench = Bench::scaled(129, scale).with(|p| p.youngs_modulus_pa = 20e3);
        stays(&bench, 0.08 * scale, &format!("{} mm block of 20 kPa", 80.0 * scale));
    }
}
