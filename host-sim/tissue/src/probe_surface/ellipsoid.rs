//! Signed distance of an ellipsoid in double precision, with its first two derivatives.

use nalgebra::{Matrix3, Vector3};

/// Largest number of Newton steps; four to eight are enough for ratios of the semi-axes up to four.
const MOST_STEPS: usize = 60;
/// Step at which the iteration ends, over the least squared semi-axis (1).
const SETTLED: f64 = 1e-15;
/// Least distance that a point is given from each plane of symmetry, over the least semi-axis (1):
/// in these planes, near the middle, two surface points are equally near, and the equation does not
/// select one.
const ASIDE: f64 = 1e-12;

/// Signed distance [m], the unit normal out of the ellipsoid, and the distance's second derivative
/// [1/m], at a point with coordinates `x` along the three semi-axes [m].
///
/// The nearest point of the surface is `a_i^2 x_i / (t + a_i^2)`, with t the only root above `-min
/// a_i^2` of `sum (a_i x_i / (t + a_i^2))^2 = 1` (Eberly, Distance from a point to an ellipsoid,
/// 2013). It is found from below by Newton's method on the inverse root of the sum.
#[must_use]
pub fn ellipsoid(semi_axes_m: [f64; 3], x: Vector3<f64>) -> (f64, Vector3<f64>, Matrix3<f64>) {
    let semi = Vector3::from(semi_axes_m);
    let square = semi.component_mul(&semi);
    let (least, most) = (square.min(), square.max());
    let aside_m = ASIDE * least.sqrt();
    let x = x.map(|c| if c.abs() < aside_m { aside_m.copysign(if c > 0.0 { c } else { -1.0 }) } else { c });
    let part = semi.component_mul(&x);
    let beyond = square.map(|s| s - least);
    // t is counted from minus the least squared semi-axis, and starts at the largest value known to
    // be below the root
    let mut t = (part.norm() - (most - least)).max((part.abs() - beyond).max());
    for _ in 0..MOST_STEPS {
        let place = beyond.add_scalar(t);
        let share = part.component_div(&place).map(|p| p * p);
        let step = share.sum() * (share.sum().sqrt() - 1.0) / share.component_div(&place).sum();
        t += step;
        if step.abs() < SETTLED * least {
            break;
        }
    }
    let slope = x.component_div(&beyond.add_scalar(t));
    let steep = slope.norm();
    let normal = slope / steep;
    let distance_m = (t - least) * steep;
    // curvature of the surface at the nearest point, then of the parallel surface through x
    let flat = Matrix3::identity() - normal * normal.transpose();
    let own = flat * Matrix3::from_diagonal(&square.map(|s| 1.0 / s)) * flat / steep;
    let parallel = (Matrix3::identity() + own * distance_m).try_inverse().map_or_else(Matrix3::zeros, |inverse| own * inverse);
    (distance_m, normal, 0.5 * (parallel + parallel.transpose()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Distance to the surface by search: the nearest surface point lies in the octant of `x`, in
    /// which a grid of directions is refined around the best direction.
    fn nearest(semi: [f64; 3], x: &Vector3<f64>) -> f64 {
        let x = x.abs();
        let at = |u: f64, v: f64| Vector3::new(semi[0] * u.cos() * v.cos(), semi[1] * u.sin() * v.cos(), semi[2] * v.sin());
        let (mut best, mut step) = ((0.0, 0.0), 0.2);
        let mut found = f64::INFINITY;
        for n in 0..8 {
            for m in 0..8 {
                let (u, v) = (f64::from(n) * step, f64::from(m) * step);
                let d = (at(u, v) - x).norm();
                if d < found {
                    (found, best) = (d, (u, v));
                }
            }
        }
        while step > 1e-12 {
            let around = [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0], [1.0, 1.0], [-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0]];
            let tried = around.map(|[a, b]| (best.0 + a * step, best.1 + b * step));
            let better = tried.into_iter().map(|(u, v)| ((at(u, v) - x).norm(), (u, v))).min_by(|a, b| a.0.total_cmp(&b.0));
            match better {
                Some((d, place)) if d < found => (found, best) = (d, place),
                _ => step *= 0.5,
            }
        }
        found
    }

    #[test]
    fn the_distance_is_that_of_the_nearest_point_and_its_derivatives_are_its_own() {
        let mut number = 1_u64;
        let mut next = || {
            number = number.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (number >> 33) as f64 / f64::from(1_u32 << 31) * 2.0 - 1.0
        };
        for semi in [[8e-3, 6e-3, 6e-3], [4e-3, 9e-3, 6e-3], [24e-3, 6e-3, 6e-3], [2e-3, 3e-3, 6e-3]] {
            let mut inside = 0;
            for _ in 0..200 {
                let x = Vector3::new(next(), next(), next()).component_mul(&Vector3::from(semi)) * 1.3;
                let (distance_m, normal, curvature) = ellipsoid(semi, x);
                assert!((distance_m.abs() - nearest(semi, &x)).abs() < 1e-9, "{semi:?} {x:?}: {distance_m}");
                let within = (0..3).map(|k| (x[k] / semi[k]).powi(2)).sum::<f64>() < 1.0;
                assert_eq!(within, distance_m < 0.0);
                inside += usize::from(within);
                let step = 1e-7;
                for k in 0..3 {
                    let mut way = Vector3::zeros();
                    way[k] = step;
                    let (more, less) = (ellipsoid(semi, x + way), ellipsoid(semi, x - way));
                    assert!(((more.0 - less.0) / (2.0 * step) - normal[k]).abs() < 1e-5, "{semi:?} {x:?}");
                    let bend = (more.1 - less.1) / (2.0 * step);
                    let off = (bend - curvature.column(k)).norm();
                    // near the middle the direction out changes within the step
                    assert!(off < 1e-3 * (1.0 + curvature.norm()).powi(2) / 100.0, "{semi:?} {x:?}: {off}");
                }
            }
            assert!(inside > 20);
        }
    }

    #[test]
    fn equal_semi_axes_make_a_sphere() {
        for x in [[1e-3, 2e-3, -3e-3], [9e-3, 0.0, 1e-3], [0.0, 0.0, -5.9e-3]] {
            let x = Vector3::from(x);
            let (distance_m, normal, curvature) = ellipsoid([6e-3; 3], x);
            let out = x.normalize();
            assert!((distance_m - (x.norm() - 6e-3)).abs() < 1e-14 && (normal - out).norm() < 1e-9);
            let wanted = (Matrix3::identity() - out * out.transpose()) / x.norm();
            assert!((curvature - wanted).norm() < 1e-6 * wanted.norm());
        }
    }
}
