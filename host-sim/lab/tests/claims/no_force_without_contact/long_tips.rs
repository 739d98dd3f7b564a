//! A capsule, an ellipsoid and a flat end on random paths, upright and tilted.

use palpate::{Params, Probe, ProbeShape, Vector3};
use palpate_lab::faults::paths::{PathGround, PathPatch, paths};
use palpate_loop::closed_loop::watch::{RestShape, RestSolid};

use crate::no_force_without_contact::{GROUND, patch_named};

const PATHS: u64 = 120;

/// A capsule and an ellipsoid with this axis, whose long side is as near as possible to
/// perpendicular to `wish`.
fn tips(axis: Vector3<f32>, wish: Vector3<f32>) -> [Probe; 2] {
    let along = axis.cross(&wish).normalize();
    let shapes = [ProbeShape::Capsule { length_m: 0.010, along }, ProbeShape::Ellipsoid { semi_axes_m: [0.010, 0.005], along }];
    shapes.map(|shape| Probe { shape, radius_m: 0.006, axis })
}

#[test]
fn paths_break_no_invariant_under_a_capsule_and_an_ellipsoid() {
    // each patch once, with its tip replaced
    let shipped = GROUND.patches.iter().filter(|patch| patch.params.probe.shape == ProbeShape::Hemisphere);
    for (n, wish) in [Vector3::new(0.2, 0.9, 0.1), Vector3::new(-0.7, 0.4, 0.5)].into_iter().enumerate() {
        let patches =
            shipped.clone().map(|patch| patch.with_probe(tips(patch.params.probe.axis, wish)[n], Params::UPRIGHT).unwrap());
        let ground = PathGround { patches: patches.collect(), devices: GROUND.devices.clone() };
        let total = paths(&ground, 0..PATHS, 3, |_| ()).unwrap();
        let (examples, total) = (total.examples.clone(), total.total());
        println!("{total:?}");
        assert!(total.ticks_with_force > PATHS * 50, "{} ticks with a force", total.ticks_with_force);
        assert!(total.broken.is_empty(), "{:?}\n{}", total.broken, examples.join("\n"));
    }
}

#[test]
fn paths_break_no_invariant_under_tilted_tips() {
    for (n, degrees) in [(0, 20.0), (0, 45.0), (1, 20.0), (2, 10.0), (2, 30.0)] {
        let total = paths(&tilted(&GROUND, n, degrees), 0..PATHS, 5, |_| ()).unwrap();
        let (examples, total) = (total.examples.clone(), total.total());
        println!("tip {n}, {degrees} degrees: {total:?}");
        assert!(total.ticks_with_force > PATHS * 50, "{} ticks with a force", total.ticks_with_force);
        assert!(total.broken.is_empty(), "tip {n}, {degrees} degrees: {:?}\n{}", total.broken, examples.join("\n"));
    }
}

/// Each shipped patch once, under a capsule (0), an ellipsoid (1) or a flat end (2), tilted so that
/// one end of its long side dips.
pub fn tilted(ground: &PathGround, n: usize, degrees: f32) -> PathGround {
    let under = |patch: &PathPatch| {
        let axis = patch.params.probe.axis;
        let [capsule, ellipsoid] = tips(axis, Vector3::new(0.2, 0.9, 0.1));
        let flat = Probe { shape: ProbeShape::Flat, radius_m: 9e-3, ..capsule };
        let about = axis.cross(&axis.cross(&Vector3::new(0.2, 0.9, 0.1)).normalize());
        let (sin, cos) = (0.5 * degrees.to_radians()).sin_cos();
        patch.with_probe([capsule, ellipsoid, flat][n], [about.x * sin, about.y * sin, about.z * sin, cos]).unwrap()
    };
    let shipped = ground.patches.iter().filter(|patch| patch.params.probe.shape == ProbeShape::Hemisphere);
    PathGround { patches: shipped.map(under).collect(), devices: ground.devices.clone() }
}

/// Free distance between a probe and the block of 80 x 80 x 40 mm [m]: for a capsule by points
/// along its segment, for an ellipsoid by points all over its surface.
fn gap_by_points_m(probe: &Probe, tip_m: Vector3<f64>) -> f64 {
    let (axis, radius_m) = (probe.axis.cast::<f64>(), f64::from(probe.radius_m));
    let centre_m = tip_m + axis * radius_m;
    let out = |p: Vector3<f64>| {
        let beyond = |k: usize, low: f64, high: f64| (low - p[k]).max(p[k] - high).max(0.0);
        Vector3::new(beyond(0, -0.04, 0.04), beyond(1, -0.04, 0.04), beyond(2, -0.04, 0.0)).norm()
    };
    match probe.shape {
        ProbeShape::Capsule { length_m, along } => {
            let along = along.cast::<f64>() * f64::from(length_m);
            let points = (0..=400).map(|n| out(centre_m + along * (f64::from(n) / 400.0 - 0.5)));
            (points.fold(f64::INFINITY, f64::min) - radius_m).max(0.0)
        }
        ProbeShape::Ellipsoid { semi_axes_m: [a, b], along } => {
            let along: Vector3<f64> = along.cast();
            let circle = (0..90).flat_map(|n| (0..46).map(move |m| (f64::from(n) * 0.07, f64::from(m) * 0.07)));
            let points = circle.map(|(turn, lift)| {
                let unit = Vector3::new(turn.cos() * lift.sin(), turn.sin() * lift.sin(), lift.cos());
                let across = axis.cross(&along) * f64::from(b);
                out(centre_m + along * (f64::from(a) * unit.x) + across * unit.y + axis * (radius_m * unit.z))
            });
            points.fold(f64::INFINITY, f64::min)
        }
        _ => unreachable!("tips of this file"),
    }
}

/// The gap is zero where the probe touches the tissue; elsewhere it is at most the free distance,
/// and for the capsule it is equal to it.
#[test]
fn the_gap_of_a_long_tip_is_that_of_its_points() {
    let ground = &*GROUND;
    let block = &ground.patches[patch_named(ground, "block-130")];
    let (mut free, mut touching) = (0, 0);
    // tilted, so that an end enters the tissue before the tip does
    for probe in tips(Vector3::new(0.28, 0.0, 0.96), Vector3::new(0.3, 0.8, 0.0)) {
        let shape = RestSolid::of(&block.patch.model(), &probe);
        let capsule = matches!(probe.shape, ProbeShape::Capsule { .. });
        for x in -11..=11 {
            for y in -11..=11 {
                for z in 0..8 {
                    let tip_m = Vector3::new(f64::from(x) * 4.3e-3, f64::from(y) * 4.4e-3, f64::from(z) * 0.9e-3 + 1e-5);
                    let (found_m, by_points_m) = (shape.outside_m(&tip_m), gap_by_points_m(&probe, tip_m));
                    assert!(found_m <= by_points_m + 1e-7, "{probe:?} {tip_m}: {found_m} of {by_points_m}");
                    let least = if capsule { by_points_m - 1.5e-5 } else { 0.4 * by_points_m - 5e-5 };
                    assert!(found_m >= least, "{probe:?} {tip_m}: {found_m} of {by_points_m}");
                    free += u32::from(found_m > 1e-4);
                    touching += u32::from(by_points_m == 0.0);
                }
            }
        }
    }
    assert!(free > 2_000 && touching > 20, "{free} free, {touching} touching");
}
