//! Forces and torques of tilted tips compared with finite elements under the same tip.

use palpate::{ContactMap, Params, Probe, ProbePose, Vector3, tick};
use palpate_fit::reference::domain::BlockCase;
use palpate_fit::reference::newton::Press;
use palpate_fit::reference::probe::RigidProbe;
use palpate_fit::reference::touch::Pressed;
use palpate_tests::bench::Bench;
use palpate_tissue::scene::Shape;

use crate::contact_map::{OffTheMiddle, capsule, ellipsoid, flat_end};
use crate::fem_reference::{assert_within, standard_block};

/// Depths of the deepest point of the tip [m].
const DEPTHS_M: [f64; 3] = [1e-3, 2e-3, 3e-3];

fn tilted(case: &OffTheMiddle, degrees: f64) -> Params {
    let probe = Probe {
        shape: (case.shape)([1.0, 0.0, 0.0]).of_core([0.0, 0.0, 1.0]),
        radius_m: case.radius_m as f32,
        axis: Vector3::z(),
    };
    let (sin, cos) = (0.5 * degrees.to_radians()).sin_cos();
    Params { probe, orientation: [0.0, sin as f32, 0.0, cos as f32], ..Params::default() }
}

/// Forces along the press over E [m^2] and torques around y about the tip over E [m^3] of finite
/// elements under a tip that is tilted about y, with elements of `least_m` where the pressure is
/// steep.
fn solved(case: &OffTheMiddle, degrees: f64, least_m: f64) -> Vec<[f64; 2]> {
    let block = BlockCase { may_cut: [false, true], ..standard_block(0, 0.0) };
    let body = block.support(&case.mesh(true, least_m), [false, true]);
    let (sin, cos) = degrees.to_radians().sin_cos();
    let (axis, along, up) = (Vector3::new(sin, 0.0, cos), Vector3::new(cos, 0.0, -sin), Vector3::z());
    let tip = RigidProbe::new((case.shape)(along.into()), case.radius_m, Vector3::zeros(), axis);
    // with the middle of the tip above the site, and its lowest point level with it
    let place_m = body.place_m
        + match tip.shape {
            Shape::Capsule { length_m, .. } => up * (tip.radius_m + 0.5 * length_m * sin) - axis * tip.radius_m,
            Shape::Ellipsoid { semi_axes_m: [a_m, _], .. } => up * (a_m * sin).hypot(tip.radius_m * cos) - axis * tip.radius_m,
            // the lowest point is on the rounded edge
            _ => up * ((tip.radius_m - tip.edge_m) * sin + tip.edge_m * (1.0 - cos)),
        };
    let mut press = Press::new(&body.body, tip, place_m).unwrap().against(up);
    let mut at = |depth_m: f64| {
        press.go_to(depth_m, |_| {}).unwrap();
        let contact = press.contact(depth_m);
        let torque_m3 = |p: &Pressed| {
            let push = contact.probe.gap(&p.at_m).normal * (-p.area_m2 * p.pressure_over_e);
            (p.at_m - contact.probe.tip_m).cross(&push).y
        };
        let torque_m3 = body.body.pressed(&press.displacement_m, &contact).iter().map(torque_m3).sum();
        [press.force_over_e_m2(), torque_m3]
    };
    DEPTHS_M.map(&mut at).to_vec()
}

fn turned(bench: &Bench, tilted: &Params) -> Bench {
    bench.clone().with(|p| (p.probe, p.orientation) = (tilted.probe, tilted.orientation))
}

/// Forces of a patch, held, over E [m^2], and its torques, as of [`solved`].
fn pressed(bench: &Bench, tilted: &Params) -> Vec<[f64; 2]> {
    let bench = turned(bench, tilted);
    let model = bench.patch.wide_model();
    let mut memory = bench.memory();
    let (tuned, mut state) = memory.start(&model, &bench.params).unwrap();
    let touch_m = bench.patch.touch_m(&bench.params);
    let mut depth_m = -3e-3_f32;
    let mut hold = |to_m: f32| {
        let mut force_n = 0.0;
        for _ in 0..500 {
            depth_m = (depth_m + 2e-5).min(to_m);
            let output = tick(&model, &tuned, &mut state, ProbePose { tip_m: touch_m - Vector3::z() * depth_m });
            assert_eq!(output.fault, None);
            force_n = output.force_n.z;
        }
        let torque_nm = ContactMap::read(&model, &tuned, &mut state, &mut []).torque_nm.y;
        [force_n, torque_nm].map(|x| f64::from(x / bench.params.youngs_modulus_pa))
    };
    DEPTHS_M.iter().map(|depth_m| hold(*depth_m as f32)).collect()
}

fn assert_forces(
    case: &OffTheMiddle,
    degrees: f64,
    least_m: f64,
    from_m: f64,
    benches: impl IntoIterator<Item = Bench>,
    [force, torque]: [f64; 2],
) {
    let (right, params) = (solved(case, degrees, least_m), tilted(case, degrees));
    for bench in benches {
        for ((own, right), depth_m) in pressed(&bench, &params).into_iter().zip(&right).zip(DEPTHS_M) {
            let label = format!("{degrees} degrees, {depth_m} m, {} nodes", bench.patch.wide_model().nodes.len());
            let off = [0, 1].map(|k| 100.0 * (own[k] / right[k] - 1.0));
            println!("{label}: force {:+.2} %, torque {:+.2} % of {:.3e}", off[0], off[1], right[1]);
            if depth_m >= from_m {
                assert_within(&format!("force at {label}"), own[0], right[0], force);
                // an upright tip has none
                if degrees > 0.0 {
                    assert_within(&format!("torque at {label}"), own[1], right[1], torque);
                }
            }
        }
    }
}

/// Force and torque of a tilted capsule are those of finite elements, on patches that were fitted
/// to an upright hemisphere.
#[test]
fn a_tilted_capsules_force_is_that_of_finite_elements() {
    assert_forces(&capsule(0.0, [0.0; 2]), 20.0, 2.2e-3, 0.0, [410, 1020].map(Bench::calibrated), [0.03; 2]);
}

#[test]
#[ignore = "long: finite elements of half a block, three times"]
fn a_capsules_force_is_that_of_finite_elements_at_every_tilt() {
    for degrees in [0.0, 10.0, 30.0] {
        assert_forces(&capsule(0.0, [0.0; 2]), degrees, 2.2e-3, 0.0, [410, 1020].map(Bench::calibrated), [0.03; 2]);
    }
}

#[test]
#[ignore = "long: finite elements of half a block, four times"]
fn an_ellipsoids_force_is_that_of_finite_elements_at_every_tilt() {
    for degrees in [0.0, 10.0, 20.0, 30.0] {
        assert_forces(&ellipsoid(0.0, [0.0; 2]), degrees, 2.2e-3, 0.0, [410, 1020].map(Bench::calibrated), [0.03, 0.04]);
    }
}

/// A flat end misses 3 %, as it does upright: patches by formulas are that far off (upright 4.7 %),
/// and one that was fitted to a hemisphere loses up to two fifths of the force of a shallow edge.
#[test]
#[ignore = "long: finite elements of half a block, and patches of thousands of nodes"]
fn a_flat_ends_force_is_near_that_of_finite_elements_once_its_edge_is_deep() {
    let case = flat_end(0.0, [0.0; 2]);
    for degrees in [10.0, 20.0, 30.0] {
        assert_forces(&case, degrees, 2.2e-3, 2e-3, [case.by_formulas(0.9e-3)], [0.055, 0.045]);
        assert_forces(&case, degrees, 2.2e-3, 0.0, [410, 1020].map(Bench::calibrated), [0.38, 0.45]);
    }
}

/// Work that a patch does on the tip that is led around a rectangle of 6 mm along the surface and
/// 2 mm of depth, in both senses [J], and its largest forces across and along the press [N].
fn around(bench: &Bench, tilted: &Params) -> ([f32; 2], [f32; 2]) {
    let bench = turned(bench, tilted);
    let model = bench.patch.wide_model();
    let mut memory = bench.memory();
    let (tuned, mut state) = memory.start(&model, &bench.params).unwrap();
    let touch_m = bench.patch.touch_m(&bench.params);
    let corners = [[-3e-3, 1e-3], [3e-3, 1e-3], [3e-3, 3e-3], [-3e-3, 3e-3]];
    let corners = corners.map(|[x, depth]: [f32; 2]| Vector3::new(x, 0.0, -depth));
    let mut at = corners[0] + Vector3::z() * 2e-3;
    let mut largest_n = [0.0_f32; 2];
    let mut go = |to: Vector3<f32>| {
        let from = at;
        let steps = ((to - from).norm() / 4e-6).ceil() as u16;
        let mut work_j = 0.0;
        for step in 1..=steps {
            let next = from + (to - from) * (f32::from(step) / f32::from(steps));
            let output = tick(&model, &tuned, &mut state, ProbePose { tip_m: touch_m + next });
            assert_eq!(output.fault, None);
            work_j += output.force_n.dot(&(next - at));
            largest_n = [largest_n[0].max(output.force_n.x.abs()), largest_n[1].max(output.force_n.z)];
            at = next;
        }
        work_j
    };
    go(corners[0]);
    let work_j = [[1, 2, 3, 0], [3, 2, 1, 0]].map(|order| order.iter().map(|n| go(corners[*n])).sum());
    (work_j, largest_n)
}

/// Over level tissue the stored energy does not depend on the place, so a slow way around returns
/// what it took and no force acts along the surface, apart from what the block's sides and the mesh
/// give. A flat end that pushed along its own axis gave 0.16 mJ here, and leaned by a third.
#[test]
fn a_slow_way_around_under_a_tilted_tip_creates_no_energy() {
    let flat = [5.0, 20.0, 30.0].map(|degrees| (flat_end(0.0, [0.0; 2]), degrees));
    let long = [(capsule(0.0, [0.0; 2]), 20.0), (ellipsoid(0.0, [0.0; 2]), 20.0)];
    let tips = || flat.iter().chain(&long);
    for (nodes, (case, degrees)) in [130, 410, 1020].into_iter().flat_map(|nodes| tips().map(move |tip| (nodes, tip))) {
        let (work_j, [across_n, up_n]) = around(&Bench::calibrated(nodes), &tilted(case, *degrees));
        println!("{nodes} nodes, {degrees} degrees: {work_j:?} J, {across_n} N across, {up_n} N up");
        assert!(work_j.iter().all(|work_j| work_j.abs() < 2e-5), "{nodes} nodes, {degrees} degrees: {work_j:?} J");
        assert!(across_n < 0.1 * up_n, "{nodes} nodes, {degrees} degrees: {across_n} N across, {up_n} N up");
    }
}
