//! Patches of stiffening tissue compared with finite elements of the same law, at exponents as
//! found in tissue. Nothing is fitted to these forces.

use palpate::Params;
use palpate_fit::reference::body::Material;
use palpate_fit::reference::domain::BlockCase;
use palpate_fit::reference::newton::Press;
use palpate_fit::reference::probe::RigidProbe;
use palpate_fit::reference::shape::TetRule;
use palpate_fit::statics::{Solver, Statics, Vector};
use palpate_tests::bench::Bench;
use palpate_tests::share::Share;
use palpate_tissue::scene::Shape;
use serde_json::Value;

use crate::fingerprint::solved_before;

struct Pressed {
    b: f64,
    x_m: f64,
    depth_m: Vec<f64>,
    force_m2: Vec<f64>,
}

fn stored() -> Vec<Pressed> {
    let file: Value = serde_json::from_str(include_str!("../../data/stiffening_reference.json")).unwrap();
    let number = |value: &Value| value.as_f64().unwrap();
    let list = |value: &Value| value.as_array().unwrap().iter().map(number).collect();
    let press = |p: &Value| Pressed {
        b: number(&p["b"]),
        x_m: number(&p["x_m"]),
        depth_m: list(&p["depth_m"]),
        force_m2: list(&p["force_m2"]),
    };
    file["press"].as_array().unwrap().iter().map(press).collect()
}

/// Relative errors of a patch's force (1), with the exponent `b` in its parameters, at the depths
/// of a press from `least_m` on.
fn errors(bench: &Bench, b: f64, press: &Pressed, least_m: f64) -> Vec<f64> {
    let params = Params { stiffening_b: b as f32, ..bench.params };
    let statics = Statics::of(&bench.patch.model(), &params).unwrap();
    let solver = Solver::of(&statics).unwrap();
    let tip_m = |depth_m: f64| Vector::new(press.x_m, 0.0, -depth_m);
    let mut here = solver.rest(&statics, tip_m(0.0), 1e-6).unwrap();
    let mut errors = Vec::new();
    for (depth_m, force_m2) in press.depth_m.iter().zip(&press.force_m2) {
        here = solver.press(&statics, &here, tip_m(*depth_m), *depth_m).unwrap();
        if *depth_m >= least_m {
            errors.push(here.force / force_m2 - 1.0);
        }
    }
    errors
}

fn rms(errors: &[f64]) -> f64 {
    (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt()
}

/// Largest accepted rms error at the centre and at places that no fit used [%], by number of nodes
/// and exponent.
const ACCEPTED: [(usize, f64, [f64; 2]); 15] = [
    (410, 0.0, [1.5, 3.0]),
    (410, 0.3, [1.5, 3.0]),
    (410, 3.0, [1.5, 3.0]),
    (410, 10.0, [1.5, 3.0]),
    (410, 20.0, [2.2, 3.0]),
    (1020, 0.0, [1.5, 3.0]),
    (1020, 0.3, [1.5, 3.0]),
    (1020, 3.0, [1.5, 3.0]),
    (1020, 10.0, [1.5, 3.0]),
    (1020, 20.0, [3.0, 3.0]),
    // elements of half a probe radius, where the mean strain of a node is a poor measure of its
    // energy
    (130, 0.0, [1.5, 3.0]),
    (130, 0.3, [2.0, 3.0]),
    (130, 3.0, [3.0, 4.5]),
    (130, 10.0, [5.0, 10.0]),
    (130, 20.0, [10.0, 16.0]),
];

#[test]
fn forces_agree_with_finite_elements_of_the_same_law() {
    forces_agree(|nodes| nodes <= 410);
}

#[test]
#[ignore = "long: minutes of finite elements"]
fn forces_of_the_finest_patch_agree_too() {
    forces_agree(|nodes| nodes > 410);
}

fn forces_agree(chosen: fn(usize) -> bool) {
    let mut share = Share::one_in(3);
    for (nodes, b, accepted_pct) in ACCEPTED.into_iter().filter(|(nodes, ..)| chosen(*nodes) && share.takes()) {
        let bench = Bench::calibrated(nodes);
        let of = |centred: bool| -> Vec<f64> {
            let presses = stored().into_iter().filter(|p| p.b == b && (p.x_m == 0.0) == centred);
            presses.flat_map(|press| errors(&bench, b, &press, 0.0)).collect()
        };
        let found = [true, false].map(|centred| {
            let errors = of(centred);
            assert!(errors.len() >= 8);
            100.0 * rms(&errors)
        });
        println!("{nodes} nodes, b = {b}: {:.2} % at the centre, {:.2} % elsewhere, rms", found[0], found[1]);
        for (found, accepted) in found.iter().zip(accepted_pct) {
            assert!(*found <= accepted, "{nodes} nodes, b = {b}: {found} %");
        }
        let press = stored().into_iter().find(|p| p.b == b && p.x_m == 0.0).unwrap();
        if b >= 3.0 {
            let without = 100.0 * rms(&errors(&bench, 0.0, &press, 2e-3));
            assert!(without > 10.0, "{nodes} nodes, b = {b}: {without} % without the term");
        }
    }
}

#[test]
fn the_stored_forces_are_those_of_finite_elements() {
    if solved_before() {
        return;
    }
    for press in stored().into_iter().filter(|p| p.x_m == 0.0 && [3.0, 20.0].contains(&p.b)) {
        let case = BlockCase {
            size_m: [0.08, 0.08, 0.04],
            place_m: [0.0; 2],
            material: Material { poisson_ratio: 0.45, stiffening_b: press.b, inclusions: vec![] },
            nodes: 350,
            fine_radius_m: 0.006,
            rule: TetRule::Four,
            may_cut: [true; 2],
        };
        let block = case.build().unwrap();
        let probe = RigidProbe::new(Shape::Hemisphere, 0.008, block.place_m, Vector::z());
        let mut solving = Press::new(&block.body, probe, block.place_m).unwrap();
        for depth_m in [2e-3, 4e-3] {
            solving.go_to(depth_m, |_| ()).unwrap();
            let at = press.depth_m.iter().position(|d| (d - depth_m).abs() < 1e-9).unwrap();
            let off = solving.force_over_e_m2() / press.force_m2[at] - 1.0;
            println!("b = {}, {depth_m} m: {:+.2} %", press.b, 100.0 * off);
            assert!(off.abs() < 0.015, "b = {}, {depth_m} m: {off}", press.b);
        }
    }
}
