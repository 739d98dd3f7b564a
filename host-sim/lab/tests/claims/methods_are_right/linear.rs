//! The stiffness matrix, its factorisation, and the solutions computed from them.

use nalgebra::Vector3;
use palpate_lab::methods::{Block, Compliance, Factor, LinearElastic, Method, RunningMethod};

/// `K u`, given the lower triangle of K [m times the unit of u], shape \[rows\].
fn times(linear: &LinearElastic, u: &[f64]) -> Vec<f64> {
    let mut product = vec![0.0; linear.rows];
    for &(r, c, v) in &linear.lower {
        product[r] += v * u[c];
        if r != c {
            product[c] += v * u[r];
        }
    }
    product
}

fn block() -> Block {
    Block::standard(57, 3500.0).expect("a block that can be meshed")
}

#[test]
fn the_matrix_passes_the_patch_test() {
    let mut free = block();
    free.tissue.anchors.clear();
    let linear = LinearElastic::of(&free);
    let strain = 1e-3;
    let stretch = [-0.45 * strain, -0.45 * strain, strain];
    let nodes = &free.tissue.mesh.nodes_m;
    let u: Vec<f64> = nodes.iter().flat_map(|x| [0, 1, 2].map(|k| x[k] * stretch[k])).collect();
    let force = times(&linear, &u);
    let wanted = 0.08 * 0.08 * strain;
    let pull: f64 = nodes.iter().enumerate().filter(|(_, x)| x[2] > -1e-9).map(|(n, _)| force[3 * n + 2]).sum();
    assert!((pull / wanted - 1.0).abs() < 1e-5, "{pull:e} is not {wanted:e}");
    // uniaxial stress gives no force on inner nodes and sides
    for (n, x) in nodes.iter().enumerate().filter(|(_, x)| x[2] < -1e-9 && x[2] > -0.04 + 1e-9) {
        let left = Vector3::new(force[3 * n], force[3 * n + 1], force[3 * n + 2]).norm();
        assert!(left < 1e-5 * wanted, "{left:e} at {x:?}");
    }
}

#[test]
fn a_factor_solves_in_both_precisions() {
    let linear = LinearElastic::of(&block());
    let wanted: Vec<f64> = (0..linear.rows).map(|r| (0.37 * r as f64).sin()).collect();
    let right = times(&linear, &wanted);

    let mut solution = right.clone();
    Factor::<f64>::new(linear.rows, &linear.lower).expect("positive definite").solve(&mut solution);
    let worst = solution.iter().zip(&wanted).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(worst < 1e-9, "{worst:e}");

    // the condition number is about the square of the block's size over that of its elements, times
    // the ratio of the moduli: 1e4
    let single: Vec<_> = linear.lower.iter().map(|&(r, c, v)| (r, c, v as f32)).collect();
    let mut solution: Vec<f32> = right.iter().map(|v| *v as f32).collect();
    Factor::<f32>::new(linear.rows, &single).expect("positive definite").solve(&mut solution);
    let worst = solution.iter().zip(&wanted).map(|(a, b)| (f64::from(*a) - b).abs()).fold(0.0, f64::max);
    assert!(worst < 1e-3, "{worst:e}");
}

#[test]
fn compliance_is_the_linear_answer_under_signorini_contact() {
    let block = block();
    let linear = LinearElastic::of(&block);
    let mut compliance = Compliance::new(&block).expect("a matrix that can be factored");
    let e = 3500.0;
    for depth_m in [0.0005, 0.002, 0.004] {
        // repeated, because the contact normals are updated with a delay
        let force_n = (0..20).map(|_| compliance.tick(block.tip_m(depth_m)).expect("finite")).last().expect("ticks");
        let rest = block.tissue.mesh.nodes_m.iter().map(|x| Vector3::from(*x));
        let moved: Vec<Vector3<f64>> = (0..rest.len()).map(|n| compliance.position_m(n).cast()).collect();
        let mut u = vec![0.0; linear.rows];
        for ((row, rest), now) in linear.row.iter().zip(rest).zip(&moved) {
            if let Some(r) = *row {
                u[r..r + 3].copy_from_slice((now - rest).as_slice());
            }
        }
        let force = times(&linear, &u);
        let centre = Vector3::new(0.0, 0.0, 8e-3 - depth_m);
        let mut sum = Vector3::zeros();
        let mut touched = 0;
        for (n, row) in linear.row.iter().enumerate() {
            let Some(r) = *row else { continue };
            let f = Vector3::new(force[r], force[r + 1], force[r + 2]);
            let gap = (moved[n] - centre).norm() - 8e-3;
            sum += f;
            // single-precision displacements of millimetres times stiffnesses of centimetres: 1e-9
            // N/Pa is a thousandth of a node's load
            if f.norm() > 2e-8 {
                touched += 1;
                let outward = (moved[n] - centre).normalize();
                assert!(gap.abs() < 2e-6, "node {n} is pushed from {gap:e} m away");
                assert!((f.normalize() - outward).norm() < 0.03, "node {n} is not pushed along the normal: {f:?}");
            } else if block.tissue.mesh.nodes_m[n][2] > -1e-9 {
                assert!(gap > -2e-6, "node {n} is {:e} m inside", -gap);
            }
        }
        assert!(touched > 0, "nothing touched at {depth_m} m");
        let felt = f64::from(force_n.z) / e;
        assert!((sum.z / -felt - 1.0).abs() < 2e-3, "K u = {:e}, force/E = {felt:e}", sum.z);
    }
}

#[test]
fn implicit_rests_where_compliance_does_while_strains_are_small() {
    let block = Block::standard(130, 3500.0).expect("a block that can be meshed");
    let press = |method: Method| {
        let force = method.run(&block, 1, |running| {
            running.tick(block.tip_m(-1e-4)).expect("finite");
            (0..400).map(|_| running.tick(block.tip_m(2e-4)).expect("finite").z).last()
        });
        force.expect("built").flatten().expect("ticks")
    };
    let (moving, still) = (press(Method::Implicit), press(Method::Compliance));
    assert!((moving / still - 1.0).abs() < 0.02, "implicit {moving} N, compliance {still} N");
}
