//! Penetration of the tips that are not round: capsule and ellipsoid.
//!
//! The capsule is exact. The depth of a point inside an ellipsoid is the minimum of `h(n) - n.x`
//! over unit vectors n, where h is the support function `sqrt(sum (a_i n_i)^2)`. The minimum is at
//! `n_i ~ x_i / (t + a_i^2)` with t the only root above `-min a_i^2` of
//! `sum (a_i x_i / (t + a_i^2))^2 = 1` (Eberly, Distance from a point to an ellipsoid, 2013).
//! [`STEPS`] Newton steps on the inverse root of that sum, which is nearly linear in t (More and
//! Sorensen, Computing a trust region step, 1983), find it from below. An error of n makes the
//! depth larger only by its square, so depth and direction agree as a function and its gradient do.

use nalgebra::Vector3;

use crate::lanes::sqrt;
use crate::params::Probe;

/// Number of Newton steps, with which depth and direction agree with double precision to rounding,
/// for every point and every permitted ellipsoid (test below).
const STEPS: usize = 8;
/// Least distance of a point from each plane of symmetry, over the radius (1). Near the middle of
/// such a plane two ways out are equally short, and the equation does not select one of them.
const ASIDE: f32 = 1e-7;
/// Least permitted `t + min a_i^2`, over `min a_i^2` (1).
const MIDDLE: f32 = 1e-8;

/// Vector from the nearest point of a capsule's segment to a point [m].
#[inline(always)]
pub(crate) fn from_segment(d: Vector3<f32>, length_m: f32, along: Vector3<f32>) -> Vector3<f32> {
    let half = 0.5 * length_m;
    let at = d.dot(&along);
    let at = if at < -half {
        -half
    } else if at > half {
        half
    } else {
        at
    };
    d - along * at
}

/// Half of the gradient of `sum (x_i / a_i)^2` at a point, times the radius squared [m].
#[inline(always)]
pub(super) fn slope_of_ellipsoid(d: Vector3<f32>, probe: &Probe, [a, b]: [f32; 2], along: Vector3<f32>) -> Vector3<f32> {
    let across = probe.axis.cross(&along);
    let (p, q) = (probe.radius_m / a, probe.radius_m / b);
    along * (d.dot(&along) * (p * p)) + across * (d.dot(&across) * (q * q)) + probe.axis * d.dot(&probe.axis)
}

/// Depth of a point inside an ellipsoid [m] and the unit vector of the shortest way out; `d` is the
/// point relative to the centre [m]. The results are finite for every finite point.
#[inline(never)]
pub(super) fn inside_ellipsoid(
    d: Vector3<f32>,
    probe: &Probe,
    semi_axes_m: [f32; 2],
    along: Vector3<f32>,
) -> Option<(f32, Vector3<f32>)> {
    let (scale, across) = (1.0 / probe.radius_m, probe.axis.cross(&along));
    let semi = [semi_axes_m[0] * scale, semi_axes_m[1] * scale, 1.0];
    let x = [d.dot(&along) * scale, d.dot(&across) * scale, d.dot(&probe.axis) * scale];
    if sum(each(semi, x, |s, x| (x / s) * (x / s))) >= 1.0 {
        return None;
    }
    let (pen, out) = depth_in_ellipsoid(d, probe, semi_axes_m, along);
    // NaN is not at most zero: it reaches the node, and `integrate` turns it into a fault
    if pen <= 0.0 { None } else { Some((pen, out)) }
}

/// Depth of a point below the surface of an ellipsoid [m], negative outside, and the unit vector of
/// the shortest way out.
pub(crate) fn depth_in_ellipsoid(d: Vector3<f32>, probe: &Probe, [a, b]: [f32; 2], along: Vector3<f32>) -> (f32, Vector3<f32>) {
    let (r, across) = (probe.radius_m, probe.axis.cross(&along));
    // lengths are over the radius, so that no square underflows or overflows
    let scale = 1.0 / r;
    let semi = [a * scale, b * scale, 1.0];
    let x = [d.dot(&along) * scale, d.dot(&across) * scale, d.dot(&probe.axis) * scale];
    let x = x.map(|x| if x.abs() < ASIDE { if x > 0.0 { ASIDE } else { -ASIDE } } else { x });
    let mut least = 1.0;
    let mut most = 1.0;
    for s in semi {
        let square = s * s;
        least = if square < least { square } else { least };
        most = if square > most { square } else { most };
    }
    // t is counted from the least squared semi-axis, whose term would otherwise lose its digits
    let beyond = semi.map(|s| s * s - least);
    let floor = MIDDLE * least;
    // the largest value known to be below the root
    let part = each(semi, x, |s, x| s * x);
    let mut t = sqrt(sum(part.map(|p| p * p))) - (most - least);
    for below in each(part, beyond, |p, b| p.abs() - b) {
        t = if below > t { below } else { t };
    }
    t = if t < floor { floor } else { t };
    for _ in 0..STEPS {
        let place = beyond.map(|b| t + b);
        let share = each(part, place, |p, place| (p / place) * (p / place));
        let (square, steep) = (sum(share), sum(each(share, place, |share, place| share / place)));
        t += square * (sqrt(square) - 1.0) / steep;
        t = if t < floor { floor } else { t };
    }
    let [u, v, w] = each(x, beyond, |x, b| x / (t + b));
    let n = Vector3::new(u, v, w);
    let n = n * (1.0 / sqrt(n.dot(&n)));
    let support = Vector3::new(semi[0] * n.x, semi[1] * n.y, n.z);
    let pen = (sqrt(support.dot(&support)) - n.dot(&Vector3::from(x))) * r;
    (pen, along * n.x + across * n.y + probe.axis * n.z)
}

#[inline(always)]
fn each(a: [f32; 3], b: [f32; 3], f: impl Fn(f32, f32) -> f32) -> [f32; 3] {
    [f(a[0], b[0]), f(a[1], b[1]), f(a[2], b[2])]
}

#[inline(always)]
fn sum([a, b, c]: [f32; 3]) -> f32 {
    a + b + c
}

#[cfg(test)]
mod tests;
