//! Tissue that is translated and rotated as a whole is not deformed: its internal forces are
//! rounding errors only. (Rim and foundation do not move with it and are left out.)
//!
//! Rounding of the positions is itself a deformation: half an ulp of the farthest coordinate at
//! both ends of every edge, times the stiffness at the node. The rounding of the forces is added.

use palpate::stages::force;
use palpate::{State, Tuned, Vector3};
use palpate_tests::bench::{Bench, Noise, at_depth};
use palpate_tests::rounding::{self, UNIT};

/// Rotates a vector by a random unit quaternion.
fn rotated(noise: &mut Noise, x: Vector3<f64>) -> Vector3<f64> {
    let (axis, w) = (noise.vector(), noise.uniform());
    let length = (axis.norm_squared() + w * w).sqrt();
    let (axis, w) = (axis / length, w / length);
    x + axis.cross(&x) * (2.0 * w) + axis.cross(&axis.cross(&x)) * 2.0
}

/// Largest ratio of a force to its rounding bound (1).
fn worst(bench: &Bench, seed: u64, away_m: f64, state: &mut State, tuned: &Tuned) -> f64 {
    let model = bench.patch.wide_model();
    let carry = Noise::new(seed).vector() * away_m;
    let x: Vec<Vector3<f32>> =
        (model.nodes.iter()).map(|n| (rotated(&mut Noise::new(!seed), Vector3::from(n.rest_m).cast()) + carry).cast()).collect();
    for (n, x) in x.iter().enumerate() {
        state.place(n, *x, Vector3::zeros());
    }
    force::accumulate(&model, tuned, state, at_depth(-100.0), Vector3::zeros());
    let x: Vec<Vector3<f64>> = x.iter().map(|x| x.cast()).collect();
    let mut bound = rounding::of_forces_n(&model, &bench.params, &x);
    let e = f64::from(bench.params.youngs_modulus_pa);
    let farthest_m = x.iter().map(|x| x.amax()).fold(0.08, f64::max);
    for s in model.springs {
        // three coordinates, two ends, in the deformed and the rest position; the trace of the
        // node's stiffness is at most that of its springs and volumes
        let place = 4.0 * 3.0_f64.sqrt() * UNIT * farthest_m * f64::from(s.k) * e;
        [s.i, s.j].into_iter().for_each(|n| bound[usize::from(n)] += place);
    }
    for (b, n) in bound.iter_mut().zip(model.nodes) {
        // the volume's part: no node's row of the stiffness matrix is larger than a few diagonals
        *b += 4.0 * 3.0 * f64::from(n.stiffness_m) * e * UNIT * farthest_m * 3.0_f64.sqrt();
    }
    let forces = state.nodes().iter().map(|n| f64::from(n.force_over_modulus().norm()) * e);
    forces.zip(bound).map(|(f, b)| f / b).fold(0.0, f64::max)
}

#[test]
fn rigid_motion_gives_no_force() {
    let mut largest = 0.0_f64;
    for nodes in [60, 129, 410] {
        let bench = Bench::block(nodes);
        let model = bench.patch.wide_model();
        let mut memory = bench.memory();
        let (tuned, mut state) = memory.start(&model, &bench.params).unwrap();
        for seed in 0..20 {
            for away_m in [0.0, 0.05, 1.0] {
                let off = worst(&bench, seed, away_m, &mut state, &tuned);
                assert!(off <= 1.0, "{nodes} nodes, seed {seed}, {away_m} m away: {off} of what rounding explains");
                largest = largest.max(off);
            }
        }
    }
    println!("largest force: {largest:.3} of what rounding explains");
}
