//! A body whose held nodes are all rotated about an axis is rotated as a whole.

use palpate::Vector3;
use palpate_fit::reference::quadratic::QuadraticMesh;
use palpate_lab::hanging::hang::Hanging;
use palpate_lab::hanging::organs::{Organ, join};
use palpate_lab::hanging::suspension::Suspension;
use palpate_lab::hanging::tie::layer;

use crate::hanging::{bar, body, nodes_where};

/// Number and angle of the steps of a rotation by 129 degrees about y.
const STEPS: usize = 9;
const STEP_RAD: f64 = 0.25;

#[test]
fn tied_blocks_follow_a_turn_of_their_end_without_energy() {
    let mut lower = bar([0.03, 0.02, 0.02], 40);
    for node in &mut lower.nodes_m {
        node[2] -= 0.02;
    }
    let (mesh, organs) = join(&[QuadraticMesh::new(&bar([0.03, 0.02, 0.02], 50)), QuadraticMesh::new(&lower)]);
    let grip = nodes_where(&mesh, |x| x.z == 0.0);
    let faces = |organ: &Organ| -> Vec<usize> {
        let seam = |t: &usize| mesh.triangles[*t].iter().all(|n| (mesh.nodes_m[*n as usize].z + 0.02).abs() < 1e-9);
        organ.triangles.clone().filter(seam).collect()
    };
    let ties = layer(&mesh, &faces(&organs[0]), &faces(&organs[1]), 1e-6, |_| 100.0);
    let suspension =
        Suspension::new(body(mesh, 0.45, |_| [false; 3])).with_ties(ties).expect("there").with_grip(&grip).expect("there");
    let mut hanging = Hanging::new(&suspension).expect("small");
    let nodes_m = &suspension.body().mesh.nodes_m;
    let turned = |x: &Vector3<f64>, angle: f64| {
        let (sin, cos) = angle.sin_cos();
        Vector3::new(cos * x.x + sin * x.z, x.y, cos * x.z - sin * x.x) - x
    };
    for step in 1..=STEPS {
        let place: Vec<_> = grip.iter().map(|n| turned(&nodes_m[*n as usize], step as f64 * STEP_RAD)).collect();
        hanging.go_to(0.0, &place, |_| {}).expect("follows");
    }
    for (x, u) in nodes_m.iter().zip(&hanging.displacement_m) {
        let off = (u - turned(x, STEPS as f64 * STEP_RAD)).norm();
        assert!(off < 1e-6 * 0.04, "{x:?} is {off:e} m off");
    }
    let volume = 2.0 * 0.03 * 0.02 * 0.02;
    let energy = suspension.energy_m3(&hanging.displacement_m, 0.0).expect("sound");
    assert!(energy.abs() < 1e-10 * volume, "{energy:e}");
}
