//! Building blocks of organ shapes: implicit functions that are negative inside a body and close to
//! the signed distance [m] near its surface.
//!
//! They use only `+ - * /` and square roots, so that a mesh made from them has the same nodes and
//! tets on every machine. Blends are the quadratic minimum of two distances.

use nalgebra::Vector3;

pub(super) type V3 = Vector3<f64>;

/// Converts millimetres to metres.
pub(super) const fn mm(length: f64) -> f64 {
    1e-3 * length
}

/// Vector in metres from coordinates in millimetres.
pub(super) const fn mm3(x: f64, y: f64, z: f64) -> V3 {
    V3::new(1e-3 * x, 1e-3 * y, 1e-3 * z)
}

/// Ellipsoid with axes along the frame: the value of its equation over the gradient, which is exact
/// at the surface and too small far away.
pub(super) fn ellipsoid(x: V3, center: V3, radii: V3) -> f64 {
    let u = (x - center).component_div(&radii);
    let slope = u.component_div(&radii).norm();
    if slope > 0.0 { u.norm() * (u.norm() - 1.0) / slope } else { -radii.min() }
}

/// Ball of `radius` swept from `a` to `b`; the distance is exact.
pub(super) fn capsule(x: V3, a: V3, b: V3, radius: f64) -> f64 {
    pear(x, a, b, radius, radius)
}

/// Ball whose radius changes from `at_a` to `at_b` between `a` and `b`; the distance is exact, to
/// the two balls and the cone that touches both.
pub(super) fn pear(x: V3, a: V3, b: V3, at_a: f64, at_b: f64) -> f64 {
    let length = (b - a).norm();
    let along = (x - a).dot(&(b - a)) / length;
    let off = ((x - a).norm_squared() - along * along).max(0.0).sqrt();
    let sine = (at_a - at_b) / length;
    let cosine = (1.0 - sine * sine).sqrt();
    let foot = along - off * sine / cosine;
    if foot <= 0.0 {
        (x - a).norm() - at_a
    } else if foot >= length {
        (x - b).norm() - at_b
    } else {
        cosine * off + sine * along - at_a
    }
}

/// Union of two bodies, given by their distances, with the groove between them filled over about
/// `blend`.
pub(super) fn join(a: f64, b: f64, blend: f64) -> f64 {
    let overlap = (1.0 - (a - b).abs() / blend).max(0.0);
    a.min(b) - 0.25 * blend * overlap * overlap
}

/// Intersection of two bodies, given by their distances, with the ridge between them rounded over
/// about `blend`.
pub(super) fn meet(a: f64, b: f64, blend: f64) -> f64 {
    -join(-a, -b, blend)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pear_is_as_far_as_the_nearest_of_its_balls() {
        let (a, b) = (mm3(-25.0, 3.0, 0.0), mm3(30.0, 0.0, 5.0));
        for at in [mm3(10.0, 40.0, 3.0), mm3(-40.0, 2.0, 9.0), mm3(60.0, -9.0, 4.0), mm3(0.0, 15.0, -30.0), mm3(3.0, 1.0, 2.0)] {
            let nearest = (0..=20_000).map(|i| {
                let t = f64::from(i) / 20_000.0;
                (at - (a + t * (b - a))).norm() - (mm(6.0) + t * mm(11.0))
            });
            let nearest = nearest.fold(f64::INFINITY, f64::min);
            assert!((pear(at, a, b, mm(6.0), mm(17.0)) - nearest).abs() < 1e-9, "{at}");
        }
    }

    #[test]
    fn a_blend_only_adds_and_a_meeting_only_removes() {
        for (a, b) in [(-1.0, 2.0), (0.3, 0.2), (0.0, 0.0), (-0.5, -0.6)] {
            assert!(join(a, b, 1.0) <= f64::min(a, b));
            assert!(meet(a, b, 1.0) >= f64::max(a, b));
        }
        assert_eq!(join(0.0, 0.0, 1.0), -0.25);
        assert_eq!(join(3.0, 1.0, 1.0), 1.0);
    }
}
