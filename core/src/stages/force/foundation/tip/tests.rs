//! Compares the penetration with the nearest point that a search in double precision finds.

#![expect(clippy::disallowed_types, reason = "the search is in double precision, and no part of the image")]

extern crate std;

use std::vec::Vec;

use super::*;
use crate::params::ProbeShape;

const RADIUS_M: f32 = 6e-3;

/// Pseudo-random numbers from 0 to 1, the same in every run.
struct Numbers(u32);

impl Numbers {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.0 >> 8) as f32 / 16_777_216.0
    }
}

fn probe(shape: ProbeShape) -> Probe {
    Probe { shape, radius_m: RADIUS_M, axis: Vector3::new(0.0, 0.6, 0.8) }
}

/// An orthonormal frame around the probe's axis: along, across, axis.
fn frame() -> [Vector3<f32>; 3] {
    let (axis, along) = (Vector3::new(0.0, 0.6, 0.8), Vector3::x());
    [along, axis.cross(&along), axis]
}

/// Depth of a point inside an ellipsoid and the way out, by bisection of the same equation.
fn exact(semi: [f64; 3], x: [f64; 3]) -> (f64, [f64; 3]) {
    let least = semi.iter().map(|s| s * s).fold(f64::INFINITY, f64::min);
    let excess = |t: f64| (0..3).map(|k| (semi[k] * x[k] / (t + semi[k] * semi[k])).powi(2)).sum::<f64>() - 1.0;
    let (mut low, mut high) = (-least, 0.0);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if excess(middle) > 0.0 { low = middle } else { high = middle }
    }
    let t = 0.5 * (low + high);
    let n: [f64; 3] = std::array::from_fn(|k| x[k] / (t + semi[k] * semi[k]));
    let length = n.iter().map(|c| c * c).sum::<f64>().sqrt();
    (-t * length, n.map(|c| c / length))
}

/// Points all over the inside of an ellipsoid.
fn points(semi: [f64; 3], numbers: &mut Numbers) -> Vec<[f64; 3]> {
    let mut points = Vec::new();
    while points.len() < 3000 {
        let x: [f64; 3] = std::array::from_fn(|k| semi[k] * f64::from(2.0 * numbers.next() - 1.0));
        if (0..3).map(|k| (x[k] / semi[k]).powi(2)).sum::<f64>() < 1.0 {
            points.push(x);
        }
    }
    points
}

#[test]
fn eight_newton_steps_find_the_depth_and_the_way_out_of_an_ellipsoid() {
    let mut numbers = Numbers(3);
    let frame = frame();
    for ratios in
        [[8.0 / 6.0, 1.0], [0.25, 1.0], [4.0, 4.0], [1.0, 1.0], [0.7, 1.9], [4.0, 1.0], [4.0, 2.0], [0.25, 0.5], [1.0, 0.3]]
    {
        let semi_axes_m = ratios.map(|ratio| ratio * RADIUS_M);
        let semi = [semi_axes_m[0], semi_axes_m[1], RADIUS_M].map(f64::from);
        let (mut deep_off, mut way_off) = (0.0_f64, 0.0_f64);
        for x in points(semi, &mut numbers) {
            let d = frame[0] * x[0] as f32 + frame[1] * x[1] as f32 + frame[2] * x[2] as f32;
            let along = frame[0];
            let probe = probe(ProbeShape::Ellipsoid { semi_axes_m, along });
            let Some((pen, out)) = inside_ellipsoid(d, &probe, semi_axes_m, along) else {
                // rounding decides whether a point of the surface is inside
                assert!(exact(semi, x).0 < 1e-8, "{x:?} is inside {semi:?}");
                continue;
            };
            let (wanted, way) = exact(semi, x);
            deep_off = deep_off.max((f64::from(pen) - wanted).abs());
            let found = frame.map(|axis| f64::from(out.dot(&axis)));
            way_off = way_off.max((0..3).map(|k| (found[k] - way[k]).powi(2)).sum::<f64>().sqrt());
        }
        std::println!("{ratios:?}: depth {deep_off:.1e} m, way out {way_off:.1e}");
        assert!(deep_off < 8e-9 && way_off < 3e-4, "{ratios:?}: {deep_off:e} m, {way_off:e}");
    }
}

#[test]
fn an_ellipsoid_of_equal_axes_is_a_sphere_and_a_capsule_without_length_is_one() {
    let mut numbers = Numbers(5);
    let along = Vector3::x();
    for _ in 0..2000 {
        let d = Vector3::new(numbers.next() - 0.5, numbers.next() - 0.5, numbers.next() - 0.5) * (2.2 * RADIUS_M);
        let length = d.norm();
        let of = probe(ProbeShape::Ellipsoid { semi_axes_m: [RADIUS_M; 2], along });
        match inside_ellipsoid(d, &of, [RADIUS_M; 2], along) {
            Some((pen, out)) => {
                assert!((pen - (RADIUS_M - length)).abs() < 4e-9 && (out - d / length).norm() < 1e-6, "{d:?}: {pen} {out:?}");
            }
            None => assert!(length > RADIUS_M * (1.0 - 1e-6), "{d:?}"),
        }
        assert_eq!(from_segment(d, 0.0, along), d);
    }
}

#[test]
fn a_capsule_is_everything_within_its_radius_of_the_segment() {
    let mut numbers = Numbers(9);
    let (along, length_m) = (Vector3::new(0.6, 0.8, 0.0), 0.01_f32);
    for _ in 0..500 {
        let d = Vector3::new(numbers.next() - 0.5, numbers.next() - 0.5, numbers.next() - 0.5) * 0.03;
        let nearest = (0..=4000)
            .map(|n| (d.cast::<f64>() - along.cast::<f64>() * (f64::from(length_m) * (f64::from(n) / 4000.0 - 0.5))).norm())
            .fold(f64::INFINITY, f64::min);
        assert!((f64::from(from_segment(d, length_m, along).norm()) - nearest).abs() < 3e-8, "{d:?}");
    }
}

#[test]
fn the_way_out_of_an_ellipsoid_is_the_gradient_of_the_depth() {
    let mut numbers = Numbers(11);
    let semi_axes_m = [8e-3, 5e-3];
    let along = Vector3::x();
    let of = probe(ProbeShape::Ellipsoid { semi_axes_m, along });
    let semi = [8e-3, 5e-3, f64::from(RADIUS_M)];
    // only up to half of the depth of the middle, where the way out changes abruptly
    for x in points(semi, &mut numbers) {
        let frame = frame();
        let d = frame[0] * x[0] as f32 + frame[1] * x[1] as f32 + frame[2] * x[2] as f32;
        let pen = |d| inside_ellipsoid(d, &of, semi_axes_m, along);
        let Some((_, out)) = pen(d).filter(|(pen, _)| (2e-4..2.5e-3).contains(pen)) else { continue };
        let step = 5e-5;
        for way in [Vector3::x(), Vector3::y(), Vector3::z()] {
            let (Some((more, _)), Some((less, _))) = (pen(d + way * step), pen(d - way * step)) else { continue };
            let slope = (more - less) / (2.0 * step);
            assert!((slope + out.dot(&way)).abs() < 2e-3, "{d:?}: slope {slope} along {way:?}, out {out:?}");
        }
    }
}

#[test]
fn every_point_and_every_shape_gives_a_finite_depth() {
    let along = Vector3::x();
    let axis_m = [f32::MIN_POSITIVE, 1e-30, 1e-3, 1.0];
    for radius_m in axis_m {
        for ratios in [[0.25, 0.25], [0.25, 1.0], [4.0, 4.0], [1.0, 1.0], [4.0, 1.0]] {
            let semi_axes_m = ratios.map(|ratio: f32| ratio * radius_m);
            let shape = ProbeShape::Ellipsoid { semi_axes_m, along };
            let of = Probe { shape, radius_m, axis: Vector3::z() };
            for share in [0.0, 1e-30, 1e-10, 1e-3, 0.1, 0.24, 0.9, 0.999_999, 1.0, 1e3, 1e37] {
                for way in
                    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.6, 0.6, 0.5], [-0.7, 0.0, -0.7], [0.0, 0.7, -0.7]]
                {
                    let d = Vector3::from(way) * (share * radius_m);
                    if let Some((pen, out)) = inside_ellipsoid(d, &of, semi_axes_m, along) {
                        assert!(
                            pen.is_finite() && pen <= 4.0 * radius_m && (out.norm() - 1.0).abs() < 1e-5,
                            "{d:?}: {pen} {out:?}"
                        );
                    }
                }
            }
        }
    }
}
