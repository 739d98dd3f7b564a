//! Residual and tangent are the derivatives of the energy, contact included.

use palpate::Vector3;
use palpate_fit::reference::body::Contact;
use palpate_fit::reference::probe::RigidProbe;
use palpate_tissue::scene::Shape;

use crate::fem_reference::{RADIUS_M, standard_block};

/// Step of the central differences [m]: the truncation error of order step^2 and the rounding of
/// order 1e-16/step are both below the tolerance.
const STEP_M: f64 = 1e-8;

#[test]
fn residual_and_tangent_are_the_slopes_of_energy_and_residual() {
    let block = standard_block(60, 0.006).build().expect("meshed");
    let body = &block.body;
    let wave = |x: &Vector3<f64>, k: f64| (k * (91.0 * x.x - 57.0 * x.y + 73.0 * x.z)).sin();
    let field = |size: f64, k: f64| -> Vec<Vector3<f64>> {
        let at = |x: &Vector3<f64>| Vector3::new(wave(x, k), wave(x, k + 0.7), wave(x, k + 1.9)) * size;
        body.mesh.nodes_m.iter().map(at).collect()
    };
    let bent = field(2e-4, 1.0);
    let direction = field(1.0, 1.3);
    let moved = |by: f64| -> Vec<_> { bent.iter().zip(&direction).map(|(u, d)| u + d * by).collect() };
    for (shape, depth_m) in [(Shape::Hemisphere, 0.002), (Shape::Sphere, 0.002), (Shape::Flat, 0.0004)] {
        let mut probe = RigidProbe::new(shape, RADIUS_M, Vector3::new(0.0, 0.0, -depth_m), Vector3::z());
        // an edge wide enough to include quadrature points of this mesh
        probe.edge_m = 0.003;
        // a penalty so low that the probe's curvature enters the tangent without being limited
        let contact = Contact { probe, penalty_per_m: 1000.0 };
        let at = |by: f64| body.assemble(&moved(by), Some(&contact)).expect("nothing is inside out");
        let (now, plus, minus) = (at(0.0), at(STEP_M), at(-STEP_M));
        assert!(body.touch(&bent, &contact).area_m2 > 1e-5, "{shape:?} touches");

        let slope: f64 = now.residual_m2.iter().zip(&direction).map(|(r, d)| r.dot(d)).sum();
        let measured = (plus.energy_m3 - minus.energy_m3) / (2.0 * STEP_M);
        assert!((slope / measured - 1.0).abs() < 1e-6, "{shape:?}: {slope:e} for {measured:e}");

        let product = body.tangent_times(&now, &direction);
        let difference = |n: usize| (plus.residual_m2[n] - minus.residual_m2[n]) / (2.0 * STEP_M);
        let norm = product.iter().map(Vector3::norm_squared).sum::<f64>().sqrt();
        let off = (0..product.len()).map(|n| (product[n] - difference(n)).norm_squared()).sum::<f64>().sqrt();
        assert!(off < 1e-6 * norm, "{shape:?}: the tangent is {:e} of itself off", off / norm);
    }
}
