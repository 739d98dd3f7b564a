//! The force on the probe that results from a load on the tissue: finite, within the limit, along
//! its own direction.

use palpate::stages::force::foundation::Load;
use palpate::stages::{output, probe};
use palpate::{ClampFlags, Fault, Output, ProbePose, ProbeShape, Vector3};

use crate::guard::Tissue;

/// Points of contact relative to the site, at rest and deformed [m].
const REST_M: Vector3<f32> = Vector3::new(1e-3, 0.0, 0.5e-3);
const POINT_M: Vector3<f32> = Vector3::new(2e-3, -1e-3, -0.5e-3);

/// Output of the stage for a load on the tissue [N] with the weight `push`, 2 mm below the rest
/// surface.
fn read(force_n: Vector3<f32>, push: f32) -> Result<Output, Fault> {
    read_under(ProbeShape::Hemisphere, Load { force: force_n, push, ..Load::NONE })
}

/// Output of the stage under this tip, for a load whose force is in newtons.
fn read_under(shape: ProbeShape, load: Load) -> Result<Output, Fault> {
    let mut tissue = Tissue::with(|params| {
        params.substeps = 2;
        params.limits.max_force_n = 3.0;
        params.probe.shape = shape;
    });
    let pascal = tissue.tuned.youngs_modulus_pa() / 2.0;
    let at_m = tissue.file.site_m - Vector3::new(0.0, 0.0, 2e-3);
    let motion = probe::admit(&tissue.file.model, &tissue.tuned, &mut tissue.state, ProbePose { tip_m: at_m })?;
    let rest = (tissue.file.site_m + REST_M) * load.push;
    let point = (tissue.file.site_m + POINT_M) * load.push;
    let load = Load { force: load.force / pascal, point, rest, ..load };
    output::read(&tissue.file.model, &tissue.tuned, &mut tissue.state, &motion, &load, 7)
}

/// Elements as wide as a small sphere let it slip through; a force of up to 0.15 N then pointed
/// into the tissue.
#[test]
fn a_sphere_below_the_surface_feels_nothing() {
    let sinks = Load { force: Vector3::new(0.3, 0.0, 0.01), push: 1.0, ..Load::NONE };
    let holds = Load { force: Vector3::new(0.3, 0.0, -0.01), ..sinks };
    for (shape, load, feels) in [
        (ProbeShape::Sphere, sinks, false),
        (ProbeShape::Sphere, holds, true),
        (ProbeShape::Sphere, Load { covered: true, ..holds }, false),
        (ProbeShape::Hemisphere, sinks, true),
    ] {
        let out = read_under(shape, load).unwrap();
        assert_eq!(out.force_n != Vector3::zeros(), feels, "{shape:?} {out:?}");
        assert_eq!(out.limiters.contains(ClampFlags::BURIED), !feels);
        assert!(feels || out.depth_m == 0.0, "{out:?}");
    }
}

#[test]
fn the_reaction_is_opposite_to_the_load() {
    let out = read(Vector3::new(0.3, 0.0, -0.4), 2.0).unwrap();
    assert!((out.force_n - Vector3::new(-0.3, 0.0, 0.4)).norm() < 1e-5, "{out:?}");
    assert!((out.normal - Vector3::new(-0.6, 0.0, 0.8)).norm() < 1e-5);
    assert!((out.depth_m - (2.5e-3 * 0.8 - 1e-3 * 0.6)).abs() < 1e-6, "along the normal: {}", out.depth_m);
    assert!((out.point_m - Tissue::new().file.site_m - POINT_M).norm() < 1e-6, "the weighted mean of the points");
    assert_eq!((out.active_nodes, out.fault, out.limiters), (7, None, ClampFlags::default()));
    assert_eq!(read(Vector3::new(0.0, 0.0, 0.4), 2.0).unwrap().depth_m, 0.0, "above the surface of that side");
}

#[test]
fn the_force_is_shortened_to_the_limit() {
    let most_n = 3.0;
    for (times, limited) in [(0.99, false), (1.01, true), (50.0, true)] {
        let out = read(Vector3::new(0.6, 0.0, -0.8) * (most_n * times), 1.0).unwrap();
        assert_eq!(out.limiters.contains(ClampFlags::FORCE), limited);
        let right_n = if limited { most_n } else { most_n * times };
        assert!((out.force_n - Vector3::new(-0.6, 0.0, 0.8) * right_n).norm() < 1e-4 * most_n, "{out:?}");
    }
}

#[test]
fn a_force_that_is_not_finite_is_a_fault() {
    for (force_n, push) in [(f32::NAN, 1.0), (f32::INFINITY, 1.0), (1e30, 1.0), (0.5, f32::NAN), (0.5, 1e-45)] {
        let answer = read(Vector3::new(0.0, 0.0, -force_n), push);
        assert_eq!(answer, Err(Fault::ForceNotFinite), "{force_n} N, weight {push}");
    }
}

#[test]
fn no_push_and_no_direction_are_no_contact() {
    for (force_n, push) in [(Vector3::zeros(), 0.0), (Vector3::zeros(), 1.0)] {
        let out = read(force_n, push).unwrap();
        let point_m = Tissue::new().file.site_m - Vector3::new(0.0, 0.0, 2e-3);
        assert_eq!(out, Output { active_nodes: 7, point_m, limiters: out.limiters, ..Output::NONE });
    }
}
