//! A bar and a cantilever under their own weight.

use palpate::Vector3;
use palpate_fit::reference::body::{Body, Stiffness};
use palpate_fit::reference::quadratic::QuadraticMesh;
use palpate_fit::reference::shape::TetRule;
use palpate_lab::hanging::hang::Hanging;
use palpate_lab::hanging::locate::Locator;
use palpate_lab::hanging::organs::Organ;
use palpate_lab::hanging::suspension::Suspension;

use crate::hanging::{assert_within, bar, body, nodes_where};

const LENGTH_M: f64 = 0.06;
const SIDE_M: f64 = 0.02;
const TOP: [bool; 3] = [true; 3];

fn hung(load: f64, nodes: usize) -> Suspension {
    let mesh = QuadraticMesh::new(&bar([SIDE_M, SIDE_M, LENGTH_M], nodes));
    let tets = mesh.tets.len();
    let body = body(mesh, 0.0, |x| if x.z == 0.0 { TOP } else { [false; 3] });
    // gravity and modulus are chosen so that density x gravity x length is `load` times the modulus
    let gravity = Vector3::new(0.0, 0.0, -load / LENGTH_M);
    Suspension::new(body).with_weight(&vec![1000.0; tets], gravity, 1000.0).expect("sound")
}

/// Stretch of a neo-Hookean bar with nu = 0, given its tension over Young's modulus: the tension is
/// mu (s - 1/s), since the cross-section does not change.
fn stretch(tension: f64) -> f64 {
    tension + (tension * tension + 1.0).sqrt()
}

#[test]
fn a_bar_hangs_down_as_far_as_one_dimension_says() {
    for load in [0.005, 0.8] {
        let suspension = hung(load, 120);
        let mut hanging = Hanging::new(&suspension).expect("small");
        hanging.weigh(1.0).expect("a bar hangs");
        let mesh = &suspension.body().mesh;
        let locator = Locator::new(mesh, &Organ::whole(mesh), 0.001);
        // Simpson's rule over the stretch from the top down
        let sag = |depth_m: f64| -> f64 {
            let at = |k: f64| stretch(load * (1.0 - k * depth_m / LENGTH_M)) - 1.0;
            let steps = (0..50).map(|n| f64::from(n) / 50.0);
            steps.map(|k| (at(k) + 4.0 * at(k + 0.01) + at(k + 0.02)) * depth_m / 300.0).sum()
        };
        if load < 0.1 {
            assert_within("small strain", sag(LENGTH_M), 0.5 * load * LENGTH_M, 0.005);
        }
        for depth_m in [0.013, 0.031, LENGTH_M] {
            let at = Vector3::new(0.007, 0.012, -depth_m);
            let u = locator.displacement_at(&hanging.displacement_m, &at).expect("inside");
            assert_within("sag", -u.z, sag(depth_m), 0.0005);
            assert!(u.x.abs().max(u.y.abs()) < 1e-5 * sag(LENGTH_M), "a bar with nu = 0 stays as wide as it is: {u:?}");
        }
        let volume = Organ::whole(mesh).volume(mesh, &hanging.displacement_m);
        assert_within("rest volume", volume.rest_m3, SIDE_M * SIDE_M * LENGTH_M, 1e-12);
        assert_within("volume", volume.now_m3, SIDE_M * SIDE_M * (LENGTH_M + sag(LENGTH_M)), 0.0005);
        assert!((0.999..1.01).contains(&volume.least_j), "the lower end is free: {}", volume.least_j);
    }
}

#[test]
fn supports_and_grip_carry_the_weight_and_its_moment() {
    let mesh = QuadraticMesh::new(&bar([0.08, 0.02, 0.02], 120));
    let grip = nodes_where(&mesh, |x| x.x >= 0.08 - 1e-9);
    let held = nodes_where(&mesh, |x| x.x <= 1e-9);
    let tets = mesh.tets.clone();
    let heavy = |t: usize| if t.is_multiple_of(2) { 900.0 } else { 1300.0 };
    let corners = mesh.nodes_m.clone();
    let body = Body::with_stiffness(
        mesh,
        |_, x| Stiffness { ratio: if x.z > -0.01 { 1.0 } else { 4.0 }, poisson_ratio: 0.45, stiffening_b: 0.0 },
        corners.iter().map(|x| [x.x <= 1e-9; 3]).collect(),
        vec![],
        1.0,
        TetRule::Four,
    );
    let gravity = Vector3::new(1.0, -2.0, -9.0);
    let densities: Vec<f64> = (0..tets.len()).map(heavy).collect();
    let suspension =
        Suspension::new(body).with_weight(&densities, gravity, 3500.0).expect("sound").with_grip(&grip).expect("there");
    let mut hanging = Hanging::new(&suspension).expect("small");
    hanging.weigh(1.0).expect("hangs");
    hanging.go_to(1.0, &vec![Vector3::new(-0.005, 0.004, 0.02); grip.len()], |_| {}).expect("lifts");
    // mass and moment are computed from the corners and by quadrature of the deformed positions,
    // without the nodal weights
    let mut mass_kg = 0.0;
    let mut weight_moment = Vector3::zeros();
    let locator_mesh = &suspension.body().mesh;
    let locator = Locator::new(locator_mesh, &Organ::whole(locator_mesh), 0.0);
    for (t, tet) in tets.iter().enumerate() {
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| corners[tet[k] as usize]);
        let own_kg = heavy(t) * (b - a).cross(&(c - a)).dot(&(d - a)) / 6.0;
        mass_kg += own_kg;
        for (at, share) in TetRule::Eleven.points() {
            let x = a * at[0] + b * at[1] + c * at[2] + d * at[3];
            let now = x + locator.displacement_at(&hanging.displacement_m, &x).expect("inside");
            weight_moment += now.cross(&gravity) * (share * own_kg / 3500.0);
        }
    }
    let weight = gravity * (mass_kg / 3500.0);
    assert!((suspension.weight_m2() - weight).norm() < 1e-12 * weight.norm());
    let (wall, hand) = (hanging.support(held), hanging.support(grip));
    assert!((wall.force_m2 + hand.force_m2 + weight).norm() < 1e-6 * weight.norm(), "{wall:?} {hand:?} {weight:?}");
    let moments = wall.moment_m3 + hand.moment_m3 + weight_moment;
    assert!(moments.norm() < 1e-5 * weight_moment.norm(), "{moments:?} of {weight_moment:?}");
    assert!(hand.force_m2.z > 0.3 * weight.norm(), "the hand lifts: {hand:?}");
}

#[test]
#[ignore = "long: three meshes of a body that locks"]
fn a_nearly_incompressible_cantilever_converges_with_the_mesh() {
    cantilever_converges(0.499);
}

#[test]
#[ignore = "long: minutes of finite elements"]
fn a_cantilever_converges_with_the_mesh() {
    cantilever_converges(0.45);
}

fn cantilever_converges(poisson_ratio: f64) {
    let tip = |nodes: usize| {
        let mesh = QuadraticMesh::new(&bar([0.1, 0.03, 0.02], nodes));
        let tets = mesh.tets.len();
        let body = body(mesh, poisson_ratio, |x| [x.x <= 1e-9; 3]);
        let suspension =
            Suspension::new(body).with_weight(&vec![1060.0; tets], Vector3::new(0.0, 0.0, -9.81), 6000.0).expect("sound");
        let mut hanging = Hanging::new(&suspension).expect("small");
        hanging.weigh(1.0).expect("hangs");
        let mesh = &suspension.body().mesh;
        let locator = Locator::new(mesh, &Organ::whole(mesh), 0.001);
        locator.displacement_at(&hanging.displacement_m, &Vector3::new(0.1, 0.015, -0.01)).expect("on the end")
    };
    let tips = [80, 160, 400].map(tip);
    let off = [0, 1].map(|k| (tips[k] - tips[2]).norm() / tips[2].norm());
    assert!(tips[2].z < -0.03, "bends far: {:?}", tips[2]);
    assert!(off[0] < 0.05 && off[1] < 0.025 && off[1] < off[0], "nu {poisson_ratio}: {off:?}");
}
