//! Two blocks with a stiff tie behave as one; a soft tie stretches according to its stiffness; a
//! body without support is refused.

use palpate::Vector3;
use palpate_fit::reference::quadratic::QuadraticMesh;
use palpate_lab::hanging::hang::Hanging;
use palpate_lab::hanging::locate::Locator;
use palpate_lab::hanging::organs::{Organ, join};
use palpate_lab::hanging::suspension::{HangError, Suspension};
use palpate_lab::hanging::tie::layer;

use crate::hanging::{assert_within, bar, body, nodes_where};

const SIDE_M: f64 = 0.02;
/// Thickness of the upper block, and of both blocks together [m].
const SEAM_M: f64 = 0.02;
const BOTH_M: f64 = 0.04;

/// Two blocks on top of each other, with meshes that do not match and a layer between them. The
/// upper one is fixed at its top, the lower one is gripped at its bottom, and both have weight.
fn two(poisson_ratio: f64, nodes: [usize; 2], stiffness_per_m: f64) -> (Suspension, Vec<u32>) {
    let mut lower = bar([SIDE_M, SIDE_M, BOTH_M - SEAM_M], nodes[1]);
    for node in &mut lower.nodes_m {
        node[2] -= SEAM_M;
    }
    let (mesh, organs) = join(&[QuadraticMesh::new(&bar([SIDE_M, SIDE_M, SEAM_M], nodes[0])), QuadraticMesh::new(&lower)]);
    let faces = |organ: &Organ| -> Vec<usize> {
        let seam = |t: &usize| mesh.triangles[*t].iter().all(|n| (mesh.nodes_m[*n as usize].z + SEAM_M).abs() < 1e-9);
        organ.triangles.clone().filter(seam).collect()
    };
    let ties = layer(&mesh, &faces(&organs[0]), &faces(&organs[1]), 1e-6, |_| stiffness_per_m);
    let tied_m2: f64 = ties.iter().map(|tie| tie.stiffness_m / stiffness_per_m).sum();
    assert_within("tied area", tied_m2, SIDE_M * SIDE_M, 1e-9);
    let grip = nodes_where(&mesh, |x| x.z <= -BOTH_M + 1e-9);
    let tets = mesh.tets.len();
    let body = body(mesh, poisson_ratio, |x| [x.z == 0.0; 3]);
    let suspension =
        Suspension::new(body).with_weight(&vec![1000.0; tets], Vector3::new(0.0, 0.0, -9.81), 5000.0).expect("sound");
    (suspension.with_ties(ties).expect("there").with_grip(&grip).expect("there"), grip)
}

fn pulled(suspension: &Suspension, grip: &[u32]) -> (Vec<Vector3<f64>>, Vector3<f64>) {
    let mut hanging = Hanging::new(suspension).expect("small");
    hanging.go_to(1.0, &vec![Vector3::new(0.006, -0.003, -0.008); grip.len()], |_| {}).expect("can be pulled");
    let force = hanging.support(grip.iter().copied()).force_m2;
    (hanging.displacement_m, force)
}

#[test]
fn two_blocks_tied_stiffly_are_one_block() {
    let (tied, grip) = two(0.45, [160, 230], 1e5);
    let (apart, force) = pulled(&tied, &grip);
    let mesh = QuadraticMesh::new(&bar([SIDE_M, SIDE_M, BOTH_M], 500));
    let bottom = nodes_where(&mesh, |x| x.z <= -BOTH_M + 1e-9);
    let tets = mesh.tets.len();
    let whole = Suspension::new(body(mesh, 0.45, |x| [x.z == 0.0; 3]))
        .with_weight(&vec![1000.0; tets], Vector3::new(0.0, 0.0, -9.81), 5000.0)
        .expect("sound")
        .with_grip(&bottom)
        .expect("there");
    let (one, one_force) = pulled(&whole, &bottom);
    assert!((force - one_force).norm() < 0.005 * one_force.norm(), "{force:?} for {one_force:?}");
    let meshes = [&tied.body().mesh, &whole.body().mesh];
    let locators = meshes.map(|mesh| Locator::new(mesh, &Organ::whole(mesh), 1e-6));
    for at in [[0.0, 0.0, -0.01], [0.02, 0.01, -0.0199], [0.01, 0.01, -0.0201], [0.003, 0.017, -0.03]].map(Vector3::from) {
        let u = locators[0].displacement_at(&apart, &at).expect("inside");
        let known = locators[1].displacement_at(&one, &at).expect("inside");
        assert!((u - known).norm() < 0.005 * known.norm(), "at {at:?}: {u:?} for {known:?}");
    }
    let widest = tied.ties().iter().map(|tie| tie.stretch_m(&apart).norm()).fold(0.0, f64::max);
    assert!(widest < 1e-5 && widest > 0.0, "{widest:e}");
}

#[test]
fn a_soft_layer_and_two_bars_are_springs_in_series() {
    // with nu = 0 and a small pull, both bars are springs of stiffness A/l, and the layer is a
    // spring of stiffness k A
    let stiffness_per_m = 70.0;
    let (tied, grip) = two(0.0, [60, 80], stiffness_per_m);
    let mut hanging = Hanging::new(&tied).expect("small");
    let pull_m = 1e-5;
    hanging.go_to(0.0, &vec![Vector3::new(0.0, 0.0, -pull_m); grip.len()], |_| {}).expect("can be pulled");
    let force = -hanging.support(grip).force_m2.z;
    assert_within("force", force, pull_m * SIDE_M * SIDE_M / (BOTH_M + 1.0 / stiffness_per_m), 0.001);
    // the quadrature of one surface does not resolve the triangle edges of the other, so the
    // pressure is uniform only within a few parts per thousand
    for tie in tied.ties() {
        let stretch = tie.stretch_m(&hanging.displacement_m);
        assert_within("stretch", stretch.z, force / (SIDE_M * SIDE_M * stiffness_per_m), 0.02);
    }
}

#[test]
fn what_cannot_hang_is_refused() {
    let make = || Suspension::new(body(QuadraticMesh::new(&bar([SIDE_M; 3], 40)), 0.45, |_| [false; 3]));
    let tets = make().body().mesh.tets.len();
    assert_eq!(Hanging::new(&make()).err(), Some(HangError::Loose));
    let down = Vector3::new(0.0, 0.0, -9.81);
    assert_eq!(make().with_weight(&[1.0], down, 1.0).err(), Some(HangError::Densities { given: 1, tets }));
    assert_eq!(make().with_weight(&vec![-1.0; tets], down, 1.0).err(), Some(HangError::Density { tet: 0, value: -1.0 }));
    assert_eq!(make().with_weight(&vec![1.0; tets], down, 0.0).err(), Some(HangError::Modulus { value: 0.0 }));
    assert!(matches!(make().with_grip(&[99_999]).err(), Some(HangError::Grip { node: 99_999, .. })));
    let held = make().with_grip(&[0, 1, 2]).expect("there");
    let mut hanging = Hanging::new(&held).expect("small");
    assert_eq!(hanging.go_to(0.0, &[down], |_| {}).err(), Some(HangError::Moves { given: 1, nodes: 3 }));
    assert_eq!(hanging.go_to(0.0, &[down * f64::NAN; 3], |_| {}).err(), Some(HangError::Moves { given: 3, nodes: 3 }));
    // on the way to its mirror image, a block is inverted from the midpoint on
    let all: Vec<u32> = (0..make().body().mesh.nodes_m.len() as u32).collect();
    let whole = make().with_grip(&all).expect("there");
    let mirrored: Vec<_> = whole.body().mesh.nodes_m.iter().map(|x| Vector3::new(SIDE_M - 2.0 * x.x, 0.0, 0.0)).collect();
    let stalled = Hanging::new(&whole).expect("small").go_to(0.0, &mirrored, |_| {}).expect_err("cannot be");
    assert!(matches!(stalled, HangError::Stalled { share, .. } if (0.49..0.5).contains(&share)), "{stalled}");
}
