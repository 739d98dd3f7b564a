//! The preset block: known forces, the shipped reference, and invariances.

use palpate_fit::reference::shape::TetRule;
use palpate_tissue::answer::Answer;
use palpate_tissue::scene::Shape;

use crate::fem_reference::{RADIUS_M, above, assert_within, standard_block, tissue};
use crate::fingerprint::solved_before;

/// Depth [m] and force over E [m^2] of a converged hexahedral solution, accurate within 0.3 %.
const KNOWN: [(f64, f64); 3] = [(0.002, 14.065e-6), (0.004, 39.65e-6), (0.008, 107.0e-6)];
/// Allowed difference in surface displacement between the coarse and the shipped mesh: mean over
/// the grid points within 20 mm, relative to the depth.
const SURFACE_SHARE: f64 = 0.005;

#[test]
fn forces_and_surface_are_the_known_and_the_shipped_ones() {
    if solved_before() {
        return;
    }
    let block = standard_block(400, 0.006).build().expect("meshed");
    let mut press = above(&block, Shape::Hemisphere, RADIUS_M);
    let shipped = Answer::block();
    for (depth_m, known_m2) in KNOWN {
        press.go_to(depth_m, |_| {}).expect("the preset press converges");
        let force_m2 = press.force_over_e_m2();
        assert_within("known force", force_m2, known_m2, 0.005);
        assert!(press.touch().penetration_m < 5e-4 * depth_m, "{:e}", press.touch().penetration_m);
        let hold = shipped.hold([0.0; 3], depth_m).expect("shipped");
        assert_within("shipped force", force_m2, hold.force_over_e_m2, 0.005);
        assert_within("shipped against known", hold.force_over_e_m2, known_m2, 0.005);
        let grid = hold.surface.as_ref().expect("shipped");
        let (mut sum, mut count) = (0.0, 0.0);
        for n in 0..400 {
            let at = [f64::from(n % 20 * 2 - 19) * 1e-3, f64::from(n / 20 * 2 - 19) * 1e-3];
            let own = block.top_displacement_m(&press.displacement_m, at);
            let shipped = palpate::Vector3::from(grid.at_m(at).expect("within the grid"));
            sum += (own - shipped).norm();
            count += 1.0;
        }
        assert!(sum / count < SURFACE_SHARE * depth_m, "surface {:e} m off at {depth_m} m", sum / count);
    }
}

#[test]
fn neither_quadrature_nor_contact_stiffness_matters() {
    if solved_before() {
        return;
    }
    settings_do_not_matter(0.49);
}

#[test]
#[ignore = "long: minutes of finite elements"]
fn neither_quadrature_nor_contact_stiffness_matters_at_the_preset() {
    settings_do_not_matter(0.45);
}

fn settings_do_not_matter(poisson_ratio: f64) {
    let depth_m = 0.002;
    let touch = |rule: TetRule| {
        let mut case = standard_block(250, 0.005);
        case.material = tissue(poisson_ratio);
        case.rule = rule;
        let block = case.build().expect("meshed");
        let mut press = above(&block, Shape::Hemisphere, RADIUS_M);
        press.go_to(depth_m, |_| {}).expect("converges");
        press.touch()
    };
    let plain = touch(TetRule::Four);
    assert_within("eleven points", touch(TetRule::Eleven).force_m2.z, plain.force_m2.z, 0.002);
    // A rigid contact would correspond to at most this much more depth, and force rises more slowly
    // than with the square of the depth.
    let given = plain.penetration_m / depth_m;
    assert!(given > 0.0 && 2.0 * given < 0.001, "the surface enters the probe by {given:e} of the depth");
}

#[test]
fn every_shipped_place_is_there() {
    let shipped = Answer::block();
    for depth_mm in [0.25, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0] {
        assert!(shipped.hold([0.0; 3], depth_mm * 1e-3).is_some(), "{depth_mm} mm");
    }
    for place_mm in [[4.0, 0.0], [8.0, 0.0], [12.0, 0.0], [16.0, 0.0]] {
        for depth_mm in [0.5, 1.0, 2.0, 4.0, 6.0] {
            let hold = shipped.hold([place_mm[0] * 1e-3, place_mm[1] * 1e-3, 0.0], depth_mm * 1e-3);
            let centred = shipped.hold([0.0; 3], depth_mm * 1e-3).expect("shipped").force_over_e_m2;
            let force = hold.expect("shipped").force_over_e_m2;
            // the block is softer near its free sides, but these places are still far from them
            assert!((0.85..1.005).contains(&(force / centred)), "{place_mm:?}, {depth_mm} mm: {}", force / centred);
        }
    }
}

#[test]
fn the_other_shipped_answers_are_read_and_match_their_scenes() {
    let folder = palpate_tests::palpate_command::repository().join("host-sim/references");
    let read = |name: &str| Answer::load(&folder.join(name)).expect("shipped");
    let nodule = read("nodule.json");
    assert!(nodule.is_for(&palpate_tissue::scene::Scene::load("nodule").expect("a preset")));
    assert!(!nodule.is_for(&palpate_tissue::scene::Scene::load("block").expect("a preset")));
    // the nodule can be felt above its centre, but no longer at twice its radius
    let over_plain = |x_m: f64| {
        let at = |answer: &Answer| answer.hold([x_m, 0.0, 0.0], 0.002).expect("shipped").force_over_e_m2;
        at(&nodule) / at(&Answer::block())
    };
    assert!(over_plain(0.0) > 1.15 && (0.95..1.06).contains(&over_plain(0.012)), "{} {}", over_plain(0.0), over_plain(0.012));
    // compared with the linear law of a flat punch, and with Hertz's sqrt(R) for a smaller ball
    let flat = read("flat.json").hold([0.0; 3], 0.001).expect("shipped").force_over_e_m2;
    assert!((0.9..1.1).contains(&(flat / (1.213 * 2.0 * RADIUS_M / (1.0 - 0.45 * 0.45) * 0.001))), "{flat:e}");
    let small = read("sphere-5mm.json").hold([0.0; 3], 0.0005).expect("shipped").force_over_e_m2;
    let large = Answer::block().hold([0.0; 3], 0.0005).expect("shipped").force_over_e_m2;
    assert_within("ball of 5 mm", small, large * (5.0_f64 / 8.0).sqrt(), 0.05);
}
