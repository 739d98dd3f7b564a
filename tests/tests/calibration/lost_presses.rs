//! A press without equilibrium on the uncalibrated patch is left out of a fit and does not end it.

use palpate_fit::calibrate::targets::PlaceTarget;
use palpate_fit::calibrate::{CalibrateError, Fit, ForceTarget, Settings, Targets, calibrate};
use palpate_fit::pressed_patch::PressedPatch;
use palpate_fit::scene_fit::prepare;
use palpate_fit::statics::Vector;
use palpate_tissue::scene::Scene;

const DEPTH_M: f64 = 0.006;
/// Presses with an equilibrium for each one without: more than the fifty that are required.
const SOUND: usize = 60;

/// Place at which the springs of this mesh buckle between two shapes, 6 mm deep.
fn buckles() -> Vector {
    let (radius_m, angle) = (0.0125 * (133.5_f64 / 250.0).sqrt(), 2.399_963 * 133.0_f64);
    Vector::new(radius_m * angle.cos(), radius_m * angle.sin(), 0.0)
}

fn place(place_m: Vector, depths_m: impl Iterator<Item = f64>) -> PlaceTarget {
    // any force will do: the question is whether the press is found
    let forces = depths_m.map(|depth_m| ForceTarget { depth_m, force: 0.01 * depth_m, tolerance: 1.0 }).collect();
    PlaceTarget { place_m, forces, dents: Vec::new() }
}

fn fitted(sound: usize) -> Result<usize, CalibrateError> {
    let scene = Scene::load("../host-sim/scenes/trials/nu25-130.toml").unwrap();
    let prepared = prepare(&scene).unwrap();
    let depths = (1..=sound).map(|n| 0.004 * n as f64 / sound as f64);
    let places = vec![place(Vector::zeros(), depths), place(buckles(), [0.004, DEPTH_M].into_iter())];
    let targets = Targets { places, glued: Vec::new(), centre_m: Vector::zeros(), radius_m: 0.008, disc_radii: 1.65 };
    let settings = Settings { places: 1, rounds: 0, least_gain: 0.03, fit: Fit::GaussNewton };
    calibrate(&prepared.tissue, &prepared.material, None, &prepared.params, &targets, &settings, &mut |_| ())
        .map(|fit| fit.lost_presses)
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
