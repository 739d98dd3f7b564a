//! Paths on which a force once remained, and similar ones with other patches, stiffnesses, speeds
//! and devices.

use crate::share::Share;
use palpate::{Fault, Vector3};
use palpate_lab::faults::paths::{Leg, PathCase, PathGround, PathOutcome, Route};

use crate::no_force_without_contact::{GROUND, patch_named};

/// Number of ticks at rest at the end of every path.
const REST_TICKS: usize = 2000;

/// A path through these corners [mm], beginning at the first, at a constant speed.
fn path(corners_mm: &[[f64; 3]], m_per_s: f64) -> Route {
    let corner = |mm: &[f64; 3]| Vector3::from(*mm) * 1e-3;
    let legs: Vec<Leg> = corners_mm[1..].iter().map(|mm| Leg { to_m: corner(mm), m_per_s, stop_ticks: 0 }).collect();
    let mut last_m = corner(&corners_mm[0]);
    let ticks: f64 = legs.iter().map(|leg| (leg.to_m - std::mem::replace(&mut last_m, leg.to_m)).norm() / (m_per_s * 1e-3)).sum();
    Route::along(corner(&corners_mm[0]), &legs, ticks as usize + legs.len() + 1, REST_TICKS, 0)
}

fn follow(ground: &PathGround, patch: &str, kpa: f64, device: &str, route: Route) -> (PathOutcome, f32) {
    let case = PathCase {
        number: 0,
        seed: 0,
        kind: 0,
        patch: patch_named(ground, patch),
        device: ground.devices.iter().position(|d| d.count_m == count_m(device)).expect("a device"),
        youngs_modulus_pa: kpa * 1e3,
        guarded: false,
        route,
    };
    let ticks = case.route.at_m.len();
    let (mut n, mut rest_n) = (0, 0.0_f32);
    let outcome = case.follow(ground, |track| {
        n += 1;
        if n > ticks - 1000 {
            rest_n = rest_n.max(track.telemetry.applied_n.norm());
        }
    });
    (outcome.unwrap(), rest_n)
}

/// Count size by which a device is identified [m].
fn count_m(device: &str) -> f64 {
    match device {
        "touch" => 55e-6,
        "falcon" => 60e-6,
        "inverse3" => 10e-6,
        other => panic!("{other}"),
    }
}

/// Asserts that no invariant was violated, no fault occurred, and no force acts at rest outside.
#[track_caller]
fn expect_quiet(what: &str, (outcome, rest_n): &(PathOutcome, f32)) {
    assert!(
        outcome.broken.is_empty() && outcome.fault.is_none() && *rest_n == 0.0,
        "{what}: {rest_n} N at rest outside, {outcome:?}"
    );
}

/// In through the top, out through the side of the block to 30 mm from it, stop. A force once
/// alternated there without end, of 0.5 N at 3.5 kPa and of 3 N at 25 kPa.
#[test]
fn out_through_the_side_leaves_no_force() {
    let ground = &*GROUND;
    let corners = [[-31.8, 2.8, 15.0], [25.6, -0.7, -1.8], [-70.0, 23.2, -25.8]];
    for kpa in [3.5, 25.0] {
        expect_quiet(&format!("{kpa} kPa"), &follow(ground, "block-m7-480", kpa, "inverse3", path(&corners, 0.064)));
    }
}

#[test]
fn out_through_the_side_leaves_no_force_at_other_speeds_places_patches_and_devices() {
    let ground = &*GROUND;
    let (mut bad, mut share) = (Vec::new(), Share::one_in(3));
    for patch in ["block-m4f-168", "block-m7-480", "nodule-m7-480", "liver-m4f-168", "block-130"] {
        for (kpa, device) in [(1.0, "touch"), (3.5, "inverse3"), (25.0, "falcon"), (100.0, "inverse3")] {
            for m_per_s in [0.02, 0.064, 0.3, 1.0] {
                for side in [[-70.0, 23.2, -25.8], [8.0, 70.0, -4.0], [3.0, -52.0, -12.0], [55.0, 55.0, -2.0]] {
                    if !share.takes() {
                        continue;
                    }
                    let on = &ground.patches[patch_named(ground, patch)];
                    let mut route = path(&[[0.0, 1.0, 4.0], [6.0, -0.7, -3.8], side], m_per_s);
                    route.at_m.iter_mut().for_each(|x| *x = on.point_m(&(*x).into()));
                    let (outcome, rest_n) = follow(ground, patch, kpa, device, route);
                    // a sudden stop from 0.2 m/s or more may trip the check for a frozen encoder
                    let tripped = outcome.fault.is_some_and(|f| f != Fault::SensorFault || m_per_s < 0.2);
                    if !outcome.broken.is_empty() || tripped || rest_n > 0.0 {
                        bad.push(format!(
                            "{patch} {kpa} kPa {device} {m_per_s} m/s {side:?}: {rest_n} N, {:?} {:?}",
                            outcome.broken, outcome.fault
                        ));
                    }
                }
            }
        }
    }
    assert!(bad.is_empty(), "{} cases:\n{}", bad.len(), bad.join("\n"));
}

/// Around the block in free space with sharp corners. Half a newton once acted 17 mm from the
/// tissue, for 45 to 82 ticks.
#[test]
fn fast_and_sharp_round_the_tissue_is_free_space() {
    let ground = &*GROUND;
    let mut bad = Vec::new();
    for patch in ["block-m4f-168", "block-m7-480", "nodule-m7-480", "liver-m4f-168", "block-130", "block-410"] {
        let on = &ground.patches[patch_named(ground, patch)];
        let [low, high] = on.extent_m.map(|corner| corner.map(|c| 1e3 * c));
        for out_mm in [12.0, 25.0] {
            for axis in [0, 1] {
                for m_per_s in [1.0, 2.0, 2.5, 3.0] {
                    let at = |along: f64, z: f64| if axis == 0 { [along, 0.0, z] } else { [0.0, along, z] };
                    let (left, right) = (low[axis] - out_mm, high[axis] + out_mm);
                    let (below, above) = (low[2] + 15.0, high[2] + 12.0);
                    let corners = [at(left, above + 30.0), at(left, below), at(left, above), at(right, above), at(right, below)];
                    let mut route = path(&corners, m_per_s);
                    route.at_m.iter_mut().for_each(|x| *x = on.point_m(&(*x).into()));
                    let (outcome, rest_n) = follow(ground, patch, 3.5, "touch", route);
                    if outcome.peak_n > 0.0 || outcome.fault.is_some() || !outcome.broken.is_empty() {
                        bad.push(format!(
                            "{patch} {out_mm} mm, axis {axis}, {m_per_s} m/s: {} N, {rest_n} N at rest, {} ticks, {:?} {:?}",
                            outcome.peak_n, outcome.seen.ticks_with_force, outcome.broken, outcome.fault
                        ));
                    }
                }
            }
        }
    }
    assert!(bad.is_empty(), "{} of 96:\n{}", bad.len(), bad.join("\n"));
}
