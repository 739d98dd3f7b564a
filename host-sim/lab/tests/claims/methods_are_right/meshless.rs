//! The meshless method: its shape functions, the integration over its cells, and its stress.

use crate::bench::Noise;
use nalgebra::{Matrix3, Vector3};
use palpate_lab::chart::{Accuracy, Reference};
use palpate_lab::methods::{Block, Law, Meshless, Method, ShapeFunctions, integration_points_m};
use palpate_tissue::mesh::surface::surface;

/// Reach of a node's weight, as in the method.
const REACH: f64 = 1.05;
/// Lamé constants over E at nu = 0.45.
const LAMBDA: f64 = 0.45 / (1.45 * 0.1);
const MU: f64 = 0.5 / 1.45;

fn block() -> Block {
    Block::standard(130, 3500.0).expect("a block that can be meshed")
}

fn rest(block: &Block) -> Vec<Vector3<f64>> {
    block.tissue.mesh.nodes_m.iter().map(|x| Vector3::from(*x)).collect()
}

fn forces(block: &Block, x: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let position: Vec<_> = x.iter().map(|x| x.cast::<f32>()).collect();
    let mut force = vec![Vector3::zeros(); x.len()];
    Meshless::new(block).expect("sound tets").forces(&position, &mut force);
    force.into_iter().map(|f| f.cast()).collect()
}

#[test]
fn shape_functions_reproduce_linear_fields_and_nodal_values() {
    let block = block();
    let (nodes, shape) = (rest(&block), ShapeFunctions::new(&block.tissue.mesh, REACH));
    for triangle in surface(&block.tissue.mesh.tets) {
        let corners = triangle.map(|n| nodes[n as usize]);
        for at in integration_points_m(&corners) {
            let near = shape.at(&at).expect("nodes in reach");
            let one: f64 = near.iter().map(|(_, phi)| phi).sum();
            let there: Vector3<f64> = near.iter().map(|&(n, phi)| nodes[n as usize] * phi).sum();
            assert!((one - 1.0).abs() < 1e-9 && (there - at).norm() < 1e-11, "{one} and {there:?} at {at:?}");
        }
        // a micrometre from a node, a point that may be within reach of that corner only
        let inside = corners[0].lerp(&corners[1], 1e-4).lerp(&corners[2], 1e-4);
        if let Ok(near) = shape.at(&inside) {
            let own = near.iter().find(|(n, _)| *n == triangle[0]).map_or(0.0, |(_, phi)| *phi);
            assert!((own - 1.0).abs() < 1e-2, "{own} at its own node {inside:?}");
        }
    }
}

/// A uniform stress P must give exactly the boundary traction, `-P` times the integral of `phi_n
/// N`, summed here over the surface triangles.
#[test]
fn uniform_stress_leaves_its_boundary_traction_alone() {
    let block = block();
    let (nodes, shape) = (rest(&block), ShapeFunctions::new(&block.tissue.mesh, REACH));
    let mut flux = vec![Vector3::zeros(); nodes.len()];
    for triangle in surface(&block.tissue.mesh.tets) {
        let corners = triangle.map(|n| nodes[n as usize]);
        let area = (corners[1] - corners[0]).cross(&(corners[2] - corners[0])) / 2.0;
        for at in integration_points_m(&corners) {
            shape.at(&at).expect("nodes in reach").into_iter().for_each(|(n, phi)| flux[n as usize] += area * (phi / 3.0));
        }
    }
    let f = Matrix3::new(1.10, 0.05, -0.02, 0.03, 0.95, 0.04, 0.00, -0.06, 0.92);
    let p = piola(&f);
    let deformed: Vec<_> = nodes.iter().map(|x| f * x).collect();
    let wanted: Vec<_> = flux.iter().map(|a| -p * a).collect();
    let largest = wanted.iter().map(|w| w.norm()).fold(0.0, f64::max);
    let found = forces(&block, &deformed);
    for (n, (found, wanted)) in found.iter().zip(&wanted).enumerate() {
        // within single precision
        let off = (found - wanted).norm();
        assert!(off < 1e-4 * largest, "node {n}: {found:?} instead of {wanted:?}");
    }
}

/// First Piola-Kirchhoff stress over E, computed with the inverse instead of cofactors.
fn piola(f: &Matrix3<f64>) -> Matrix3<f64> {
    let j = f.determinant();
    f * MU + f.try_inverse().expect("a deformation").transpose() * (LAMBDA * j.ln() - MU)
}

/// Stress over E from the virtual work of nodal forces in uniform gradients: `V P = -sum f_n
/// X_n^T`.
fn mean_stress(block: &Block, f: &Matrix3<f64>) -> Matrix3<f64> {
    let nodes = rest(block);
    let deformed: Vec<_> = nodes.iter().map(|x| f * x).collect();
    let force = forces(block, &deformed);
    force.iter().zip(&nodes).map(|(f, x)| -f * x.transpose()).sum::<Matrix3<f64>>() / (0.08 * 0.08 * 0.04)
}

#[test]
fn stress_is_the_textbooks_when_pulled_sheared_and_hardly_strained() {
    let block = block();
    // uniaxial: the sides are free where mu (b - 1/b) + lambda ln(a b^2) / b = 0
    for a in [0.7, 1.3] {
        let (mut low, mut high) = (0.5, 1.5);
        for _ in 0..60 {
            let b = f64::midpoint(low, high);
            let side = MU * (b * b - 1.0) + LAMBDA * f64::ln(a * b * b);
            if side > 0.0 { high = b } else { low = b }
        }
        let wanted = MU * (a - low * low / a);
        let p = mean_stress(&block, &Matrix3::from_diagonal(&Vector3::new(low, low, a)));
        assert!((p[(2, 2)] / wanted - 1.0).abs() < 1e-3, "stretch {a}: {} instead of {wanted}", p[(2, 2)]);
        assert!(p[(0, 0)].abs() < 1e-3 * wanted.abs() && p[(1, 1)].abs() < 1e-3 * wanted.abs(), "stretch {a}: sides {p}");
    }
    // simple shear preserves volume: P = mu gamma, linear at any size
    let mut shear = Matrix3::identity();
    shear[(0, 2)] = 0.4;
    assert!((mean_stress(&block, &shear)[(0, 2)] / (0.4 * MU) - 1.0).abs() < 1e-3);
    // Hooke's law, from which strains of 1e-3 deviate by a few thousandths
    let strain = 1e-3;
    let p = mean_stress(&block, &Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 1.0 + strain)));
    assert!((p[(2, 2)] / ((LAMBDA + 2.0 * MU) * strain) - 1.0).abs() < 5e-3);
    assert!((p[(0, 0)] / (LAMBDA * strain) - 1.0).abs() < 5e-3);
}

#[test]
fn inner_forces_have_no_sum_and_no_torque() {
    let block = block();
    let mut noise = Noise::new(7);
    let x: Vec<_> = rest(&block).iter().map(|x| (x + noise.vector() * 1e-3).cast::<f32>().cast::<f64>()).collect();
    let force = forces(&block, &x);
    let size: f64 = force.iter().map(|f| f.norm()).sum();
    let sum: Vector3<f64> = force.iter().sum();
    let torque: Vector3<f64> = force.iter().zip(&x).map(|(f, x)| x.cross(f)).sum();
    assert!(sum.norm() < 1e-6 * size, "{sum:?} of {size}");
    assert!(torque.norm() < 1e-6 * 0.04 * size, "{torque:?} of {size} at 40 mm");
}

/// The difference from quadratic finite elements becomes smaller as nodes are added.
#[test]
fn it_nears_the_reference_as_nodes_are_added() {
    let rms = [57, 410].map(|nodes| {
        let block = Block::standard(nodes, 3500.0).expect("a block that can be meshed");
        let pressed = Method::Meshless.run(&block, 1, |running| Accuracy::measure(&block, running, &Reference::block()));
        pressed.expect("built").expect("to be had").expect("stable").rms_pct().expect("a reference")
    });
    assert!(rms[0] < 14.0 && rms[1] < 10.5 && rms[1] < rms[0], "{rms:?} %");
}
