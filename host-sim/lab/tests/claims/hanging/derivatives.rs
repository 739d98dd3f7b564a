//! Residual and tangent are the derivatives of the energy, including weight and ties.

use palpate::Vector3;
use palpate_fit::reference::quadratic::QuadraticMesh;
use palpate_lab::hanging::organs::join;
use palpate_lab::hanging::suspension::Suspension;
use palpate_lab::hanging::tie::layer;

use crate::hanging::{bar, body};

/// Step of the central differences [m].
const STEP_M: f64 = 1e-8;
/// Distance of the two surfaces at rest [m].
const GAP_M: f64 = 0.001;

#[test]
fn residual_and_tangent_are_the_slopes_of_energy_and_residual() {
    let mut lower = bar([0.018, 0.02, 0.02], 40);
    for node in &mut lower.nodes_m {
        node[2] -= 0.02 + GAP_M;
    }
    let (mesh, organs) = join(&[QuadraticMesh::new(&bar([0.02; 3], 50)), QuadraticMesh::new(&lower)]);
    let onto: Vec<usize> = organs[1].triangles.clone().collect();
    let from: Vec<usize> = organs[0].triangles.clone().collect();
    let ties = layer(&mesh, &from, &onto, 1.5 * GAP_M, |x| 50.0 + 1000.0 * x.y);
    assert!(ties.len() > 20 && ties.iter().all(|tie| tie.gap_m >= GAP_M * (1.0 - 1e-9)), "{}", ties.len());
    let nodes_m = mesh.nodes_m.clone();
    let densities = vec![1000.0; mesh.tets.len()];
    let suspension = Suspension::new(body(mesh, 0.45, |_| [false; 3]))
        .with_weight(&densities, Vector3::new(1.0, 2.0, -9.0), 3500.0)
        .expect("sound")
        .with_ties(ties)
        .expect("there");
    let wave = |x: &Vector3<f64>, k: f64| (k * (91.0 * x.x - 57.0 * x.y + 73.0 * x.z)).sin();
    let field = |size: f64, k: f64| -> Vec<Vector3<f64>> {
        nodes_m.iter().map(|x| Vector3::new(wave(x, k), wave(x, k + 0.7), wave(x, k + 1.9)) * size).collect()
    };
    let (bent, direction) = (field(2e-4, 1.0), field(1.0, 1.3));
    let moved = |by: f64| -> Vec<_> { bent.iter().zip(&direction).map(|(u, d)| u + d * by).collect() };
    let at = |by: f64| suspension.assemble(&moved(by), 0.7).expect("nothing is inside out");
    let (now, plus, minus) = (at(0.0), at(STEP_M), at(-STEP_M));
    let energy = suspension.energy_m3(&bent, 0.7).expect("sound");
    assert!((energy / now.energy_m3 - 1.0).abs() < 1e-12, "{energy:e}, {:e}", now.energy_m3);

    let slope: f64 = now.residual_m2.iter().zip(&direction).map(|(r, d)| r.dot(d)).sum();
    let measured = (plus.energy_m3 - minus.energy_m3) / (2.0 * STEP_M);
    assert!((slope / measured - 1.0).abs() < 1e-6, "{slope:e} for {measured:e}");

    let product = suspension.body().tangent_times(&now, &direction);
    let difference = |n: usize| (plus.residual_m2[n] - minus.residual_m2[n]) / (2.0 * STEP_M);
    let norm = product.iter().map(Vector3::norm_squared).sum::<f64>().sqrt();
    let off = (0..product.len()).map(|n| (product[n] - difference(n)).norm_squared()).sum::<f64>().sqrt();
    assert!(off < 1e-6 * norm, "the tangent is {:e} of itself off", off / norm);
}
