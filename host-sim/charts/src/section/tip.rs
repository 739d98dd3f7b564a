//! Outlines of the probe cut in half: its profile in the cut, and slices of the half behind the
//! cut.

use super::cut::Window;
use crate::surface::view::{V3, across};
use crate::surface::{Probe, ProbeShape};

/// Height of the shaft that is drawn, divided by the radius (1).
const SHAFT: f64 = 1.7;
/// Number of slices of the half behind the cut.
const SLICES: u32 = 40;

/// A slice of the probe parallel to the cut.
pub struct Slice {
    /// Outline of the slice [m].
    pub outline_m: Vec<V3>,
    /// Brightness from 0 (dark) to 1.
    pub light: f64,
}

/// Direction to the right in the cut, at right angles to `up`. The cut contains the longer side of
/// a long tip, and the axis of a round one.
pub fn cut_direction(probe: &Probe, up: V3) -> V3 {
    match probe.shape {
        ProbeShape::Hemisphere | ProbeShape::Sphere | ProbeShape::Flat => {
            let operators_right = up.cross(&across(up, V3::x()));
            let tilt = probe.direction() - up * probe.direction().dot(&up);
            let right = tilt.try_normalize(1e-3).unwrap_or(operators_right);
            right * 1f64.copysign(right.dot(&operators_right))
        }
        ProbeShape::Capsule { along, .. } | ProbeShape::Ellipsoid { along, .. } => across(up, V3::from(along)),
    }
}

/// Half of the probe's width across its axis [m], to which the size of the picture is scaled.
pub fn half_width_m(probe: &Probe) -> f64 {
    match probe.shape {
        ProbeShape::Hemisphere | ProbeShape::Sphere | ProbeShape::Flat => probe.radius_m,
        ProbeShape::Capsule { length_m, .. } => probe.radius_m + 0.25 * length_m,
        ProbeShape::Ellipsoid { semi_axes_m: [a, b], .. } => a.max(b).max(probe.radius_m),
    }
}

/// Cross-sections of a probe parallel to the cut.
struct Across<'a> {
    probe: &'a Probe,
    window: &'a Window,
    /// Unit vector in the cut along a long tip, or at right angles to the axis of a round one.
    side: V3,
    /// Unit vector in the cut at right angles to `side`, out of the tissue.
    up: V3,
    /// Half of the height of the cross-section through the middle [m].
    half_height_m: f64,
    /// Half of the probe's width across the cut [m].
    half_depth_m: f64,
    /// Distance along `up` by which the middle moves per distance behind the cut (1).
    lean: f64,
}

impl<'a> Across<'a> {
    fn new(probe: &'a Probe, window: &'a Window) -> Self {
        let (axis, front) = (probe.direction(), window.front);
        let up = match probe.shape {
            ProbeShape::Hemisphere | ProbeShape::Sphere | ProbeShape::Flat => axis,
            ProbeShape::Capsule { along, .. } | ProbeShape::Ellipsoid { along, .. } => {
                front.cross(&across(axis, V3::from(along)))
            }
        };
        let up = up * 1f64.copysign(up.dot(&window.up));
        let r = probe.radius_m;
        let (half_height_m, half_depth_m, lean) = match probe.shape {
            ProbeShape::Ellipsoid { semi_axes_m: [_, b], along } => {
                // (x / r)^2 + (y / b)^2 of a vector, x along the axis and y along the short side
                let short = axis.cross(&across(axis, V3::from(along)));
                let form = |a: V3, c: V3| a.dot(&axis) * c.dot(&axis) / (r * r) + a.dot(&short) * c.dot(&short) / (b * b);
                let lean = form(up, front) / form(up, up);
                (form(up, up).powf(-0.5), (form(front, front) - lean * form(up, front)).powf(-0.5), lean)
            }
            _ => (r, r, 0.0),
        };
        Self { probe, window, side: up.cross(&front), up, half_height_m, half_depth_m, lean }
    }

    /// Outline in the plane `behind_m` behind the cut [m]; empty beyond the end of the probe.
    fn outline(&self, behind_m: f64) -> Vec<V3> {
        let (probe, r) = (self.probe, self.probe.radius_m);
        let share = 1.0 - (behind_m / self.half_depth_m).powi(2);
        if share <= 0.0 {
            return Vec::new();
        }
        let (w, tall) = (r * share.sqrt(), self.half_height_m * share.sqrt());
        // points from the middle: to the right and up [m]
        let shaft = (SHAFT - 1.0) * r;
        let arc = |from: f64, to: f64, wide: f64, tall: f64, middle: f64| {
            (0..=48).map(move |k| {
                let (sine, cosine) = (from + (to - from) * f64::from(k) / 48.0).sin_cos();
                (middle + wide * cosine, tall * sine)
            })
        };
        let pi = std::f64::consts::PI;
        let flat: Vec<(f64, f64)> = match probe.shape {
            ProbeShape::Hemisphere => [(w, shaft)].into_iter().chain(arc(0.0, -pi, w, w, 0.0)).chain([(-w, shaft)]).collect(),
            ProbeShape::Flat => vec![(w, shaft), (w, -r), (-w, -r), (-w, shaft)],
            ProbeShape::Sphere => arc(0.0, 2.0 * pi, w, w, 0.0).collect(),
            ProbeShape::Capsule { length_m, .. } => {
                let half = 0.5 * length_m;
                arc(-0.5 * pi, 0.5 * pi, w, w, half).chain(arc(0.5 * pi, 1.5 * pi, w, w, -half)).collect()
            }
            ProbeShape::Ellipsoid { semi_axes_m: [a, _], .. } => arc(0.0, 2.0 * pi, a * share.sqrt(), tall, 0.0).collect(),
        };
        let middle =
            V3::from(probe.tip_m) + probe.direction() * r - self.window.front * behind_m + self.up * (self.lean * behind_m);
        flat.into_iter().map(|(x, up)| middle + self.side * x + self.up * up).collect()
    }
}

/// Outline of the probe in the cut [m].
pub fn profile(probe: &Probe, window: &Window) -> Vec<V3> {
    Across::new(probe, window).outline(0.0)
}

/// Slices of the half of the probe behind the cut, farthest first.
pub fn slices(probe: &Probe, window: &Window) -> Vec<Slice> {
    let across = Across::new(probe, window);
    let slice = |k: u32| {
        let share = f64::from(k) / f64::from(SLICES);
        Slice { outline_m: across.outline(across.half_depth_m * share), light: 1.0 - 0.8 * share }
    };
    (1..SLICES).rev().map(slice).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Rotation3;

    #[test]
    fn a_tilted_outline_lies_on_the_tip_and_in_its_plane() {
        let along = [1.0, 0.0, 0.0];
        let shapes = [
            ProbeShape::Sphere,
            ProbeShape::Capsule { length_m: 0.012, along },
            ProbeShape::Ellipsoid { semi_axes_m: [0.007, 0.003], along },
        ];
        for (shape, tilt) in shapes.iter().flat_map(|s| [[0.0, 0.0], [0.0, 0.4], [0.4, 0.0], [-0.3, 0.6]].map(|t| (*s, t))) {
            let turn = Rotation3::from_euler_angles(tilt[0], tilt[1], 0.2);
            let turned = |v: [f64; 3]| -> [f64; 3] { (turn * V3::from(v)).into() };
            let shape = match shape {
                ProbeShape::Capsule { length_m, along } => ProbeShape::Capsule { length_m, along: turned(along) },
                ProbeShape::Ellipsoid { semi_axes_m, along } => ProbeShape::Ellipsoid { semi_axes_m, along: turned(along) },
                other => other,
            };
            let probe = Probe { shape, radius_m: 0.004, tip_m: [0.01, 0.02, 0.03], axis: turned([0.0, 0.0, 1.0]) };
            let (up, right) = (V3::z(), cut_direction(&probe, V3::z()));
            let (site_m, front) = (V3::from(probe.tip_m), right.cross(&up));
            let window = Window { site_m, right, up, front, half_width_m: 0.02, depth_m: 0.02, behind_m: 0.02 };
            let middle = site_m + probe.direction() * probe.radius_m;
            let across = Across::new(&probe, &window);
            for behind_m in [0.0, 0.3, 0.9].map(|share| share * across.half_depth_m) {
                let outline = across.outline(behind_m);
                assert!(outline.len() > 40);
                for point in outline {
                    let p = turn.inverse() * (point - middle);
                    let on = match probe.shape {
                        ProbeShape::Ellipsoid { semi_axes_m: [a, b], .. } => (p.x / a).hypot(p.y / b).hypot(p.z / 0.004),
                        ProbeShape::Capsule { .. } => V3::new(p.x - p.x.clamp(-0.006, 0.006), p.y, p.z).norm() / 0.004,
                        _ => p.norm() / 0.004,
                    };
                    assert!((on - 1.0).abs() < 1e-9, "{:?} tilted by {tilt:?}: {on} at {p:?}", probe.shape);
                    assert!(((middle - point).dot(&front) - behind_m).abs() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn a_tilted_flat_end_leans_over() {
        let (sine, cosine) = 0.5_f64.sin_cos();
        let probe = Probe { shape: ProbeShape::Flat, radius_m: 0.004, tip_m: [0.0; 3], axis: [sine, 0.0, cosine] };
        let right = cut_direction(&probe, V3::z());
        let front = right.cross(&V3::z());
        let window = Window { site_m: V3::zeros(), right, up: V3::z(), front, half_width_m: 0.02, depth_m: 0.02, behind_m: 0.02 };
        let lowest = profile(&probe, &window).into_iter().min_by(|a, b| a.z.total_cmp(&b.z)).expect("an outline");
        assert!((lowest - V3::new(0.004 * cosine, 0.0, -0.004 * sine)).norm() < 1e-9, "{lowest}");
    }
}
