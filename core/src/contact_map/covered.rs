//! Area of a surface triangle that lies inside the probe.

use nalgebra::Vector3;

use crate::lanes::sqrt;
use crate::params::{Probe, ProbeShape};
use crate::stages::force::foundation::FLAT_EDGE;
#[cfg(feature = "long-tips")]
use crate::stages::force::foundation::tip;

/// Number of parts into which each side is divided; the depth is taken as linear over a part. For
/// an element of 3 mm under a probe of 8 mm, this puts the edge of the contact 0.01 mm off.
const DIVISIONS: u8 = 4;

/// Calls `each` for every part of a triangle that is at least partly inside the probe, with its
/// position relative to the probe's centre [m] and its covered area [m^2]; returns the area of the
/// whole triangle [m^2].
pub(super) fn of_triangle(
    probe: &Probe,
    shaft: bool,
    [a, b, c]: [Vector3<f32>; 3],
    mut each: impl FnMut(Vector3<f32>, f32),
) -> f32 {
    let share = 1.0 / f32::from(DIVISIONS);
    let (u, v) = ((b - a) * share, (c - a) * share);
    let twice = u.cross(&v);
    let part_m2 = 0.5 * sqrt(twice.dot(&twice));
    let mut part = |corners: [Vector3<f32>; 3]| {
        let covered = positive_share(corners.map(|d| depth_m(probe, shaft, d)));
        if covered > 0.0 {
            each((corners[0] + corners[1] + corners[2]) * (1.0 / 3.0), covered * part_m2);
        }
    };
    for i in 0..DIVISIONS {
        for j in 0..DIVISIONS - i {
            let p = a + u * f32::from(i) + v * f32::from(j);
            part([p, p + u, p + v]);
            if i + j + 1 < DIVISIONS {
                part([p + u, p + u + v, p + v]);
            }
        }
    }
    part_m2 * f32::from(DIVISIONS * DIVISIONS)
}

/// Depth of a point inside the probe [m], negative outside. Its sign agrees with the foundation's.
fn depth_m(probe: &Probe, shaft: bool, mut d: Vector3<f32>) -> f32 {
    let r = probe.radius_m;
    let along = d.dot(&probe.axis);
    match probe.shape {
        ProbeShape::Flat => {
            let off = d - probe.axis * along;
            let (edge, off) = (FLAT_EDGE * r, sqrt(off.dot(&off)));
            let beyond = off - (r - edge);
            if beyond <= 0.0 {
                return along;
            }
            let below = if along < edge { edge - along } else { 0.0 };
            return edge - sqrt(beyond * beyond + below * below);
        }
        ProbeShape::Hemisphere if along > 0.0 && shaft => d -= probe.axis * along,
        #[cfg(feature = "long-tips")]
        ProbeShape::Capsule { length_m, along } => d = tip::from_segment(d, length_m, along),
        #[cfg(feature = "long-tips")]
        ProbeShape::Ellipsoid { semi_axes_m, along } => return tip::depth_in_ellipsoid(d, probe, semi_axes_m, along).0,
        _ => {}
    }
    r - sqrt(d.dot(&d))
}

/// Share of a triangle in which a linear quantity is above zero, from its values at the corners.
fn positive_share([a, b, c]: [f32; 3]) -> f32 {
    // `one` is the corner that is alone on its side, `p` and `q` are the two others
    let cut = |one: f32, p: f32, q: f32| one / (one - p) * (one / (one - q));
    match [a > 0.0, b > 0.0, c > 0.0] {
        [false, false, false] => 0.0,
        [true, true, true] => 1.0,
        [true, false, false] => cut(a, b, c),
        [false, true, false] => cut(b, c, a),
        [false, false, true] => cut(c, a, b),
        [false, true, true] => 1.0 - cut(a, b, c),
        [true, false, true] => 1.0 - cut(b, c, a),
        [true, true, false] => 1.0 - cut(c, a, b),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_share_is_that_of_the_cut_triangle() {
        assert_eq!([positive_share([1.0; 3]), positive_share([-1.0; 3]), positive_share([0.0; 3])], [1.0, 0.0, 0.0]);
        // the line through the middles of two sides leaves a quarter
        assert_eq!(positive_share([1.0, -1.0, -1.0]), 0.25);
        assert_eq!(positive_share([-1.0, 1.0, 1.0]), 0.75);
        // a line through a corner and the middle of the opposite side
        assert_eq!(positive_share([0.0, 1.0, -1.0]), 0.5);
        assert_eq!(positive_share([3.0, -1.0, -1.0]), 0.5625);
    }

    /// Area inside the probe of a plane 2 mm above the tip, and the area of all its triangles
    /// [m^2].
    fn covered_m2(shape: ProbeShape) -> (f32, f32) {
        let probe = Probe { radius_m: 8e-3, axis: Vector3::z(), shape };
        let at = |x: i8, y: i8| Vector3::new(f32::from(x) * 3e-3, f32::from(y) * 3e-3, -6e-3);
        let (mut covered, mut whole) = (0.0, 0.0);
        for (x, y) in (-4..4).flat_map(|x| (-4..4).map(move |y| (x, y))) {
            for corners in [[at(x, y), at(x + 1, y), at(x, y + 1)], [at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)]] {
                whole += of_triangle(&probe, false, corners, |_, area_m2| covered += area_m2);
            }
        }
        (covered, whole)
    }

    #[test]
    fn a_cap_has_the_area_of_its_circle() {
        // radius sqrt(28) mm
        let (covered, whole) = covered_m2(ProbeShape::Sphere);
        assert!((whole / 24e-3_f32.powi(2) - 1.0).abs() < 1e-5, "{whole}");
        let circle = core::f32::consts::PI * 28e-6;
        assert!((covered / circle - 1.0).abs() < 6e-3, "{covered} of {circle}");
    }

    #[cfg(feature = "long-tips")]
    #[test]
    fn long_tips_have_the_area_of_their_stadium_and_of_their_ellipse() {
        let (circle, along) = (core::f32::consts::PI * 28e-6, Vector3::new(0.6, 0.8, 0.0));
        let capsule = covered_m2(ProbeShape::Capsule { length_m: 6e-3, along }).0;
        let stadium = circle + 6e-3 * 2.0 * libm::sqrtf(28e-6);
        assert!((capsule / stadium - 1.0).abs() < 6e-3, "{capsule} of {stadium}");
        let ellipsoid = covered_m2(ProbeShape::Ellipsoid { semi_axes_m: [12e-3, 6e-3], along }).0;
        let ellipse = circle * 12.0 * 6.0 / 64.0;
        assert!((ellipsoid / ellipse - 1.0).abs() < 6e-3, "{ellipsoid} of {ellipse}");
    }
}
