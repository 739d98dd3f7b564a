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

/// Direction of the probe's longer side, at right angles to its axis. For a round tip it is the
/// direction to the operator's right.
pub fn long_side(probe: &Probe) -> V3 {
    let axis = probe.direction();
    match probe.shape {
        ProbeShape::Hemisphere | ProbeShape::Sphere | ProbeShape::Flat => axis.cross(&across(axis, V3::x())),
        ProbeShape::Capsule { along, .. } | ProbeShape::Ellipsoid { along, .. } => across(axis, V3::from(along)),
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

/// Outline of the probe in the plane `behind_m` behind the cut [m]; empty beyond the end of the
/// probe.
pub fn profile(probe: &Probe, window: &Window, behind_m: f64) -> Vec<V3> {
    let r = probe.radius_m;
    let depth_of = |half_m: f64| {
        let share = 1.0 - (behind_m / half_m).powi(2);
        (share > 0.0).then(|| share.sqrt())
    };
    let half_m = if let ProbeShape::Ellipsoid { semi_axes_m: [_, b], .. } = probe.shape { b } else { r };
    let Some(share) = depth_of(half_m) else { return Vec::new() };
    // points as (distance to the right, height above the tip) [m]
    let top = SHAFT * r;
    let arc = |from: f64, to: f64, wide: f64, tall: f64, middle: f64| {
        (0..=48).map(move |k| {
            let (sine, cosine) = (from + (to - from) * f64::from(k) / 48.0).sin_cos();
            (middle + wide * cosine, r + tall * sine)
        })
    };
    let pi = std::f64::consts::PI;
    let flat: Vec<(f64, f64)> = match probe.shape {
        ProbeShape::Hemisphere => {
            let w = r * share;
            [(w, top)].into_iter().chain(arc(0.0, -pi, w, w, 0.0)).chain([(-w, top)]).collect()
        }
        ProbeShape::Flat => vec![(r * share, top), (r * share, 0.0), (-r * share, 0.0), (-r * share, top)],
        ProbeShape::Sphere => arc(0.0, 2.0 * pi, r * share, r * share, 0.0).collect(),
        ProbeShape::Capsule { length_m, .. } => {
            let (w, half) = (r * share, 0.5 * length_m);
            arc(-0.5 * pi, 0.5 * pi, w, w, half).chain(arc(0.5 * pi, 1.5 * pi, w, w, -half)).collect()
        }
        ProbeShape::Ellipsoid { semi_axes_m: [a, _], .. } => arc(0.0, 2.0 * pi, a * share, r * share, 0.0).collect(),
    };
    let origin = V3::from(probe.tip_m) - window.front * behind_m;
    flat.into_iter().map(|(x, up)| origin + window.right * x + window.axis * up).collect()
}

/// Slices of the half of the probe behind the cut, farthest first.
pub fn slices(probe: &Probe, window: &Window) -> Vec<Slice> {
    let half_m = if let ProbeShape::Ellipsoid { semi_axes_m: [_, b], .. } = probe.shape { b } else { probe.radius_m };
    let slice = |k: u32| {
        let share = f64::from(k) / f64::from(SLICES);
        Slice { outline_m: profile(probe, window, half_m * share), light: 1.0 - 0.8 * share }
    };
    (1..SLICES).rev().map(slice).collect()
}
