//! A press without equilibrium on the uncalibrated patch is excluded from a fit and does not end
//! it.

use palpate_fit::calibrate::targets::PlaceTarget;
use palpate_fit::calibrate::{CalibrateError, ForceTarget, Objective, Settings, Targets, Unknowns, calibrate};
use palpate_fit::pressed_patch::PressedPatch;
use palpate_fit::scene_fit::prepare;
use palpate_fit::settled::SettledPatch;
use palpate_fit::statics::{Statics, Vector};
use palpate_tissue::budget::MACHINES;
use palpate_tissue::scene::Scene;
use palpate_tissue::session::{Session, calibrated};

const DEPTH_M: f64 = 0.006;
/// Number of presses with an equilibrium for each one without; at least fifty are required.
const SOUND: usize = 60;

/// A place at which, at 6 mm depth, the springs of this mesh buckle and alternate between two
/// shapes.
fn buckles() -> Vector {
    let (radius_m, angle) = (0.0125 * (133.5_f64 / 250.0).sqrt(), 2.399_963 * 133.0_f64);
    Vector::new(radius_m * angle.cos(), radius_m * angle.sin(), 0.0)
}

fn place(place_m: Vector, depths_m: impl Iterator<Item = f64>) -> PlaceTarget {
    // the value of the force does not matter: the question is whether the press has an equilibrium
    let forces = depths_m.map(|depth_m| ForceTarget { depth_m, force: 0.01 * depth_m, tolerance: 1.0 }).collect();
    PlaceTarget { place_m, forces, dents: Vec::new() }
}

/// Targets of `sound` presses at the centre, and of two presses at a place where the deeper one has
/// no equilibrium.
fn targets(sound: usize) -> Targets {
    let depths = (1..=sound).map(|n| 0.004 * n as f64 / sound as f64);
    let places = vec![place(Vector::zeros(), depths), place(buckles(), [0.004, DEPTH_M].into_iter())];
    Targets { places, glued: Vec::new(), centre_m: Vector::zeros(), radius_m: 0.008, disc_radii: 1.65 }
}

fn fitted(sound: usize) -> Result<usize, CalibrateError> {
    let scene = Scene::load("../host-sim/scenes/trials/nu25-130.toml").unwrap();
    let prepared = prepare(&scene).unwrap();
    let settings = Settings { places: 1, rounds: 0, least_gain: 0.03 };
    calibrate(&prepared.tissue, &prepared.material, None, &prepared.params, &targets(sound), &settings, &mut |_| ())
        .map(|fit| fit.lost_presses)
}

/// Otherwise a fit would end when a step loses one press of hundreds, or count the loss as a gain.
#[test]
fn a_lost_press_counts_in_neither_of_two_costs() {
    let scene = Scene::load("../host-sim/scenes/trials/nu25-130.toml").unwrap();
    let prepared = prepare(&scene).unwrap();
    let statics = Statics::of(&prepared.uncalibrated().model(), &prepared.params).unwrap();
    let targets = targets(SOUND);
    let unknowns = Unknowns::of(&statics, &prepared.tissue, targets.reach_m());
    let mut objective = Objective::new(statics, unknowns, &targets).unwrap();
    let start = objective.place().to_vec();
    let (lost, _) = objective.evaluate(&start, true).unwrap();
    let last = SOUND + 1;
    assert_eq!((lost.lost.as_slice(), lost.residuals.len(), lost.residuals[last]), ([last].as_slice(), SOUND + 2, 0.0));
    assert!(lost.rows[last].iter().all(|slope| *slope == 0.0) && lost.rows[last].len() == lost.rows[0].len());
    let mut found = lost.clone();
    found.lost.clear();
    found.residuals[last] = 3.0;
    assert_eq!((found.known_here_alone(&lost), lost.known_here_alone(&found)), (9.0, 0.0));
}

#[test]
fn one_press_without_balance_ends_no_fit() {
    let scene = Scene::load("../host-sim/scenes/trials/nu25-130.toml").unwrap();
    let prepared = prepare(&scene).unwrap();
    let pressed = PressedPatch::of(&prepared.uncalibrated(), &prepared.params).unwrap();
    let found = pressed.press(buckles(), [DEPTH_M], |_, balance| balance.force);
    assert!(found.is_err(), "this place serves no longer: {found:?}");
    assert_eq!(fitted(SOUND).unwrap(), 1);
}

#[test]
fn many_presses_without_balance_end_it() {
    let refused = fitted(10).unwrap_err();
    assert!(matches!(refused, CalibrateError::Press(_)), "{refused}");
}

/// Otherwise a verdict leaves out the places where the patch is worst.
#[test]
fn a_press_without_balance_is_judged_by_the_running_patch() {
    let scene = Scene::load("../host-sim/scenes/trials/nu25-130.toml").unwrap();
    let prepared = prepare(&scene).unwrap();
    let session = Session::of_fitted(&MACHINES[0], prepared.uncalibrated(), prepared.params).unwrap();
    let settled = SettledPatch::of(&session);
    let force_m2 = |place: Vector| settled.press(place, &[0.004, DEPTH_M]).unwrap()[1].unwrap().force_m2;
    let [here, before, after] = [0.0, -3e-4, 3e-4].map(|aside_m| force_m2(buckles() + Vector::new(0.0, aside_m, 0.0)));
    let ratio = here / (0.5 * (before + after));
    assert!((ratio - 1.0).abs() < 0.02, "{ratio}: {here} between {before} and {after}");
}

/// The two ways to the same force, below the depth limit; the second place lies below the rest
/// surface, as the rim of a flat tip does where tissue is curved.
#[test]
fn the_running_patch_settles_at_the_force_of_the_equilibrium() {
    for (scene, depth_m) in [("nu25-130", 0.004), ("flat8-410", 0.001)] {
        let scene = Scene::load(&format!("../host-sim/scenes/trials/{scene}.toml")).unwrap();
        let prepared = prepare(&scene).unwrap();
        let session = Session::of_fitted(&MACHINES[0], prepared.uncalibrated(), prepared.params).unwrap();
        let pressed = PressedPatch::of(&session.patch, &session.params).unwrap();
        for place in [Vector::new(0.003, -0.002, 0.0), Vector::new(-0.001, 0.004, -0.0005)] {
            let balanced_m2 = pressed.press(place, [depth_m], |_, balance| balance.force).unwrap()[0];
            let settled = SettledPatch::of(&session).press(place, &[depth_m]).unwrap()[0].unwrap();
            let ratio = settled.force_m2 / balanced_m2;
            assert!(!settled.limited && (ratio - 1.0).abs() < 2e-3, "{}: {place:?} {settled:?} {balanced_m2}", scene.name);
        }
    }
}

/// The guard holds the tip at the limit, and the verdict is of what the hand feels: the static
/// solver would press on as if there were no limit.
#[test]
fn a_press_beyond_the_depth_limit_is_judged_by_its_continuation() {
    let (mut patch, params) = calibrated::sized(130).unwrap();
    let pressed = PressedPatch::of(&patch, &params).unwrap();
    let free_m2 = pressed.press(Vector::zeros(), [0.002, DEPTH_M], |_, balance| balance.force).unwrap();
    patch.set_depth_limit_m(0.003);
    let session = Session::of_fitted(&MACHINES[0], patch, params).unwrap();
    let found = SettledPatch::of(&session).press(Vector::zeros(), &[0.002, DEPTH_M]).unwrap();
    let [shallow, deep] = [found[0].unwrap(), found[1].unwrap()];
    assert!(!shallow.limited && (shallow.force_m2 / free_m2[0] - 1.0).abs() < 2e-3, "{shallow:?} {free_m2:?}");
    let ratio = deep.force_m2 / free_m2[1];
    assert!(deep.limited && (0.75..0.95).contains(&ratio), "{ratio}: {deep:?} {free_m2:?}");
}
