//! Presses of the block: invariances, the static limit, and independently computed forces.

use palpate::Vector3;
use palpate_fit::reference::newton::Press;
use palpate_fit::reference::probe::RigidProbe;
use palpate_lab::dynamic::compute;
use palpate_lab::dynamic::error::DynamicError;
use palpate_lab::dynamic::motion::{Motion, Pose};
use palpate_lab::dynamic::piece::Piece;
use palpate_lab::dynamic::settings::Settings;

use crate::dynamic_truth::{block, coarse};
use crate::hanging::assert_within;

/// Depth [mm] and force over E [mm^2]: first by other quadratic elements with Newmark's average
/// acceleration, then by this project's finest mesh and shortest step. The contact of the former
/// chatters at 200 mm/s; at 40 mm/s its mesh was coarser.
const AT_200_MM_PER_S: [[f64; 3]; 4] = [[1.0, 8.46, 8.62], [2.0, 20.6, 20.20], [3.0, 33.9, 33.74], [4.0, 49.3, 48.54]];
const AT_40_MM_PER_S: [[f64; 3]; 4] = [[1.0, 5.61, 5.45], [2.0, 14.97, 14.76], [3.0, 27.09, 26.70], [4.0, 41.26, 40.65]];

#[test]
fn forces_on_the_way_are_those_of_independent_elements_and_of_a_fine_mesh() {
    for (speed_m_per_s, known) in [(0.2, AT_200_MM_PER_S), (0.04, AT_40_MM_PER_S)] {
        let settings = Settings { step_s: 8e-5 / speed_m_per_s, ..coarse() };
        let history = compute(&block(), &Motion::ramp(speed_m_per_s, 0.004, 1e-3), &settings).expect("converges");
        assert!(history.samples.iter().all(|sample| sample.at_planned_step));
        for [depth_mm, elsewhere_mm2, fine_mm2] in known {
            let force_mm2 = history.force_over_e_m2(depth_mm * 1e-3 / speed_m_per_s)[2] * 1e6;
            let place = format!("{depth_mm} mm at {speed_m_per_s} m/s");
            assert_within(&format!("{place}, elsewhere"), force_mm2, elsewhere_mm2, 0.035);
            assert_within(&format!("{place}, fine"), force_mm2, fine_mm2, 0.02);
        }
    }
}

#[test]
fn a_held_ramp_ends_at_the_static_reference() {
    let mut scene = block();
    // the wave caused by the stop decays sooner
    scene.tissue.node_damping_per_s = 150.0;
    let motion = Motion::ramp(0.1, 0.002, 0.25);
    let settings = Settings { step_s: 2e-3, ..coarse() };
    let history = compute(&scene, &motion, &settings).expect("converges");
    let piece = Piece::of(&scene, &motion, &settings).expect("meshed");
    let probe = RigidProbe::new(scene.probe.shape, scene.probe.radius_m, piece.place_m, Vector3::z());
    let mut press = Press::new(&piece.body, probe, piece.place_m).expect("a small factor fits into memory");
    press.go_to(0.002, |_| {}).expect("converges");
    let end_m2 = history.force_over_e_m2(f64::MAX)[2];
    assert_within("held force", end_m2, press.force_over_e_m2(), 0.002);
    assert_within("held force against the converged one", end_m2, 14.065e-6, 0.01);
}

#[test]
fn neither_step_nor_contact_stiffness_nor_numerical_damping_matters() {
    let motion = Motion::ramp(0.2, 0.002, 0.005);
    let force = |settings: Settings| compute(&block(), &motion, &settings).expect("converges");
    let plain = force(coarse());
    let others = [
        ("half the step", Settings { step_s: 5e-4, ..coarse() }),
        ("five times stiffer contact", Settings { softness: 1e-4, ..coarse() }),
        ("stronger numerical damping", Settings { spectral_radius: 0.2, ..coarse() }),
    ];
    for (name, settings) in others {
        let other = force(settings);
        for t_s in [0.005, 0.01, 0.015] {
            assert_within(name, other.force_over_e_m2(t_s)[2], plain.force_over_e_m2(t_s)[2], 0.01);
        }
    }
}

#[test]
fn tissue_resists_a_drag_in_either_direction_alike() {
    let at_rest = Pose { depth_m: 0.002, across_m: [0.0; 2] };
    let drag = |x_m: f64| {
        let slide = Pose { across_m: [x_m, 0.0], ..at_rest };
        let motion = Motion::at_touch().go(at_rest, 0.2).hold(0.005).go(slide, 0.4);
        let settings = Settings { corner_nodes: 160, step_s: 2e-3, first_step_share: 0.5, ..coarse() };
        let history = compute(&block(), &motion, &settings).expect("converges");
        history.force_over_e_m2(f64::MAX).map(|f| f * 1e6)
    };
    let (there, back) = (drag(0.006), drag(-0.006));
    // the two meshes are not mirror images of each other
    assert!(there[0] < -0.1 && back[0] > 0.1, "{there:?} {back:?}");
    assert!((there[0] + back[0]).abs() < 0.15 * there[0].abs(), "{there:?} {back:?}");
    assert!(there[1] == 0.0, "a plane of symmetry leaves no force across: {there:?}");
    assert_within("normal force", there[2], back[2], 0.02);
}

#[test]
fn a_tap_that_comes_back_leaves_no_force() {
    let settings = Settings { step_s: 2e-3, ..coarse() };
    let history = compute(&block(), &Motion::tap(0.5, 0.002, 0.01), &settings).expect("converges");
    let at = |t_s: f64| history.force_over_e_m2(t_s)[2] * 1e6;
    let inside = history.samples.iter().map(|sample| sample.normal_n).fold(f64::INFINITY, f64::min);
    assert!(inside >= 0.0, "contact never pulls: {inside} N");
    assert!(at(0.004) > 20.0, "a tap is harder than a press: {}", at(0.004));
    assert!(at(f64::MAX) < 1.0, "{}", at(f64::MAX));
}

#[test]
fn bad_input_is_refused_with_its_name() {
    let refused = compute(&block(), &Motion::ramp(-0.1, 0.004, 0.1), &coarse());
    assert!(matches!(refused, Err(DynamicError::Motion { key: "speed_m_per_s", .. })), "{refused:?}");
    let refused = compute(&block(), &Motion::ramp(0.1, 0.05, 0.1), &coarse());
    assert!(matches!(refused, Err(DynamicError::Motion { key: "depth_m", .. })), "{refused:?}");
    let refused = compute(&block(), &Motion::ramp(0.1, 0.004, 0.1), &Settings { step_s: 0.0, ..coarse() });
    assert!(matches!(refused, Err(DynamicError::Setting { key: "step_s", .. })), "{refused:?}");
    let mut scene = block();
    scene.tissue.poisson_ratio = 0.4999;
    let refused = compute(&scene, &Motion::ramp(0.1, 0.004, 0.1), &coarse());
    assert!(matches!(refused, Err(DynamicError::Scene(_))), "{refused:?}");
}
