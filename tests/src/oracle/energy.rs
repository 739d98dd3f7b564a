//! Energies of the model, as documented, divided by Young's modulus [J/Pa = m^3].

use palpate::stages::force::foundation::FLAT_EDGE;
use palpate::{Params, ProbeShape, RimEdge, RimNode, Spring, Tet};

use super::number::Number;

/// A point or a vector.
pub type Point<N> = [N; 3];

/// Spring: `k/2 (l - l0)^2`, plus `chi k/2 (l - (1 - tau) l0)^2` if it is shorter than `(1 - tau)
/// l0`.
pub fn of_spring<N: Number>(spring: &Spring, params: &Params, a: Point<N>, b: Point<N>) -> N {
    let (k, k_rest) = (f64::from(spring.k), f64::from(spring.k_rest));
    let rest_m = k_rest / k;
    let d = minus(b, a);
    let length = dot(d, d).root();
    let stretch = length - N::of(rest_m);
    let mut energy = N::of(0.5 * k) * stretch * stretch;
    let onset_m = (1.0 - f64::from(params.compensation_threshold)) * rest_m;
    if params.terms.compensation && length.value() < onset_m {
        let squeeze = length - N::of(onset_m);
        energy = energy + N::of(0.5 * f64::from(params.compensation) * k) * squeeze * squeeze;
    }
    energy
}

/// A tet's own volume energy `beta kappa V/2 (J - 1)^2` plus its barrier, whose pressure is `3 mu
/// (1 - J/0.4)` below J = 0.4.
pub fn of_tet<N: Number>(tet: &Tet, params: &Params, corners: [Point<N>; 4]) -> N {
    let volume_m3 = 1.0 / (6.0 * f64::from(tet.six_volume_reciprocal));
    let (beta_kappa, mu) = (6.0 * f64::from(tet.bulk), 2.0 * f64::from(tet.barrier));
    let j = six_volume(corners) / N::of(6.0 * volume_m3);
    let mut density = N::of(0.5 * beta_kappa) * (j - N::of(1.0)) * (j - N::of(1.0));
    let below = 0.4;
    if params.terms.compensation && j.value() < below {
        let lack = N::of(below) - j;
        density = density + N::of(3.0 * mu * 0.5 / below) * lack * lack;
    }
    N::of(volume_m3) * density
}

/// Volume energy of a node: `(1 - beta) kappa` times the volume that the node represents times `-2
/// ln J + 4 ln((J + 1)/2)`, where J is the volume ratio of all its tets together. Below J = 0.8 the
/// pressure continues linearly.
pub fn of_node<N: Number>(kappa: f64, volume_m3: f64, j: N) -> N {
    let density = |j: N| N::of(-2.0) * j.log() + N::of(4.0) * ((j + N::of(1.0)) * N::of(0.5)).log();
    let least: f64 = 0.8;
    let slope = 4.0 / (least + 1.0) - 2.0 / least;
    let curvature = 2.0 / (least * least) - 4.0 / ((least + 1.0) * (least + 1.0));
    let below = j - N::of(least);
    let density = match j.value() > least {
        true => density(j),
        false => density(N::of(least)) + N::of(slope) * below + N::of(0.5 * curvature) * below * below,
    };
    N::of(kappa * volume_m3) * density
}

/// Rim spring to the ground: `u . M u / 2`.
pub fn of_rim_node<N: Number>(rim: &RimNode, u: Point<N>) -> N {
    let [xx, yy, zz, xy, xz, yz] = rim.block_m.map(|c| N::of(f64::from(c)));
    let squares = xx * u[0] * u[0] + yy * u[1] * u[1] + zz * u[2] * u[2];
    N::of(0.5) * squares + xy * u[0] * u[1] + xz * u[0] * u[2] + yz * u[1] * u[2]
}

/// Rim spring between two nodes: `u_i . B u_j`.
pub fn of_rim_edge<N: Number>(rim: &RimEdge, ui: Point<N>, uj: Point<N>) -> N {
    let row = |k: usize| [0, 1, 2].map(|m| N::of(f64::from(rim.block_m[3 * k + m])));
    dot(ui, [dot(row(0), uj), dot(row(1), uj), dot(row(2), uj)])
}

/// Foundation point whose stiffness k grows by `2 k s` per metre of depth.
pub fn of_foundation<N: Number>(k: f64, stiffening_per_m: f64, depth: N) -> N {
    N::of(0.5 * k) * depth * depth + N::of(k * stiffening_per_m / 3.0) * depth * depth * depth
}

/// Depth of a point inside the probe [m]; `None` if it is outside.
pub fn depth_inside<N: Number>(params: &Params, tip: Point<f64>, point: Point<N>) -> Option<N> {
    let probe = &params.probe;
    let r = f64::from(probe.radius_m);
    let axis = [0, 1, 2].map(|k| N::of(f64::from(probe.axis[k])));
    let from_tip = minus(point, tip.map(N::of));
    let above_tip = dot(from_tip, axis);
    let from_centre = match probe.shape {
        ProbeShape::Flat => {
            // a disc swept by a ball of the edge's radius, with a cylinder above it
            let edge = r * f64::from(FLAT_EDGE);
            let off_axis = minus(from_tip, axis.map(|c| c * above_tip));
            let beyond_disc = dot(off_axis, off_axis).root() - N::of(r - edge);
            if above_tip.value() <= 0.0 || beyond_disc.value() >= edge {
                return None;
            }
            if beyond_disc.value() <= 0.0 {
                return Some(above_tip);
            }
            let below_ring = N::of(edge) - above_tip;
            let from_ring = match below_ring.value() > 0.0 {
                true => (beyond_disc * beyond_disc + below_ring * below_ring).root(),
                false => beyond_disc,
            };
            return (from_ring.value() < edge).then(|| N::of(edge) - from_ring);
        }
        // above the half-sphere is a cylinder, where only the distance from the axis counts
        ProbeShape::Hemisphere if above_tip.value() > r => minus(from_tip, axis.map(|c| c * above_tip)),
        ProbeShape::Hemisphere | ProbeShape::Sphere => minus(from_tip, axis.map(|c| c * N::of(r))),
        ProbeShape::Capsule { length_m, along } => {
            let (half, along) = (0.5 * f64::from(length_m), [0, 1, 2].map(|k| N::of(f64::from(along[k]))));
            let from_middle = minus(from_tip, axis.map(|c| c * N::of(r)));
            let place = dot(from_middle, along);
            let place = if place.value().abs() < half { place } else { N::of(half.copysign(place.value())) };
            minus(from_middle, along.map(|c| c * place))
        }
        ProbeShape::Ellipsoid { semi_axes_m: [a, b], along } => {
            let (axis, along) = (probe.axis.cast::<f64>(), along.cast::<f64>());
            let frame = [along, axis.cross(&along), axis].map(|side| [0, 1, 2].map(|k| N::of(side[k])));
            let from_middle = minus(from_tip, [0, 1, 2].map(|k| N::of(axis[k] * r)));
            return depth_in_ellipsoid([f64::from(a), f64::from(b), r], frame.map(|side| dot(from_middle, side)));
        }
    };
    let depth = N::of(r) - dot(from_centre, from_centre).root();
    (depth.value() > 0.0).then_some(depth)
}

/// Distance of a point inside an ellipsoid from the tangent plane at the nearest surface point. The
/// plane's normal is `x_i / (t + a_i^2)`, with t found by bisection.
fn depth_in_ellipsoid<N: Number>(semi_axes_m: [f64; 3], point: Point<N>) -> Option<N> {
    let at = point.map(N::value);
    if (0..3).map(|k| (at[k] / semi_axes_m[k]).powi(2)).sum::<f64>() >= 1.0 {
        return None;
    }
    let squares = semi_axes_m.map(|a| a * a);
    let excess = |t: f64| (0..3).map(|k| squares[k] * (at[k] / (t + squares[k])).powi(2)).sum::<f64>() - 1.0;
    let (mut low, mut high) = (-squares[0].min(squares[1]).min(squares[2]), 0.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if excess(middle) > 0.0 { low = middle } else { high = middle }
    }
    let normal: [f64; 3] = std::array::from_fn(|k| at[k] / (high + squares[k]));
    let length = normal.iter().map(|c| c * c).sum::<f64>().sqrt();
    let normal = normal.map(|c| c / length);
    let support = (0..3).map(|k| squares[k] * normal[k] * normal[k]).sum::<f64>().sqrt();
    // to first order the plane stays fixed when the point moves, because the distance is a minimum
    Some(N::of(support) - dot(normal.map(N::of), point))
}

/// Six times the volume of a tet [m^3].
pub fn six_volume<N: Number>([a, b, c, d]: [Point<N>; 4]) -> N {
    let (u, v, w) = (minus(b, a), minus(c, a), minus(d, a));
    let cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    dot(cross, w)
}

/// `a - b`.
pub fn minus<N: Number>(a: Point<N>, b: Point<N>) -> Point<N> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Scalar product of two vectors.
pub fn dot<N: Number>(a: Point<N>, b: Point<N>) -> N {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
