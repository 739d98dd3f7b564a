//! A parallel projection that looks at the pressed site.

use super::super::place::Frame;

pub type V3 = [f64; 3];

pub fn sub(a: V3, b: V3) -> V3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `a + k b`
pub fn add(a: V3, k: f64, b: V3) -> V3 {
    [a[0] + k * b[0], a[1] + k * b[1], a[2] + k * b[2]]
}

pub fn dot(a: V3, b: V3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn cross(a: V3, b: V3) -> V3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub fn length(a: V3) -> f64 {
    dot(a, a).sqrt()
}

/// `a` at length one; `None` for the null vector.
pub fn unit(a: V3) -> Option<V3> {
    let l = length(a);
    (l > 0.0).then(|| [a[0] / l, a[1] / l, a[2] / l])
}

/// A unit vector at right angles to the unit vector `axis`, as near to `wish` as that allows.
pub fn across(axis: V3, wish: V3) -> V3 {
    // along `wish` itself there is no nearest one: turn to the next axis
    let other = [wish[1], wish[2], wish[0]];
    [wish, other]
        .into_iter()
        .map(|w| add(w, -dot(w, axis), axis))
        .find(|w| length(*w) > 0.3)
        .and_then(unit)
        .unwrap_or([0.0, 0.0, 1.0])
}

/// Where the eye is and how the picture lies on the canvas.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// Right on the canvas, unit vector.
    pub right: V3,
    /// Up on the canvas, unit vector.
    pub up: V3,
    /// Toward the eye, unit vector.
    pub eye: V3,
    /// Canvas units per metre.
    pub scale: f64,
    shift: (f64, f64),
}

/// The eye's direction: this much along the probe's axis, along the operator's side (x), and to
/// the right of it (y). 33 degrees above the surface, 27 degrees off the operator's line of sight.
const EYE: [f64; 3] = [0.545, 0.747, 0.381];

impl View {
    /// Looks at the side of the body that `axis` (unit, out of the body) points from, with
    /// everything in `points` inside `frame`.
    pub fn onto(axis: V3, points: &(impl Iterator<Item = V3> + Clone), frame: Frame) -> Self {
        let front = across(axis, [1.0, 0.0, 0.0]);
        let side = cross(axis, front);
        let eye = add(add([0.0; 3], EYE[0], axis), EYE[1], front);
        let eye = unit(add(eye, EYE[2], side)).unwrap_or(axis);
        Self::from_eye(eye, axis, points, frame)
    }

    /// Looks from the unit vector `eye` with the unit vector `axis` upward, everything in `points`
    /// inside `frame`.
    pub fn from_eye(eye: V3, axis: V3, points: &(impl Iterator<Item = V3> + Clone), frame: Frame) -> Self {
        // straight along the axis there is no upward: any right will do
        let side = across(axis, [0.0, 1.0, 0.0]);
        let right = Some(cross(axis, eye)).filter(|r| length(*r) > 1e-6).and_then(unit).unwrap_or(side);
        let up = cross(eye, right);
        let extent = |along: V3| {
            let all = points.clone().map(|p| dot(p, along));
            all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
        };
        let (x, y) = (extent(right), extent(up));
        let room = (f64::from(frame.high.0 - frame.low.0), f64::from(frame.high.1 - frame.low.1));
        let (wide, tall) = (x.1 - x.0, y.1 - y.0);
        let scale = if wide * room.1 > tall * room.0 { room.0 / wide } else { room.1 / tall };
        // a single point has no size to fill the frame with
        let scale = if scale.is_finite() { scale } else { 1.0 };
        let middle = |low: i32, high: i32| f64::midpoint(f64::from(low), f64::from(high));
        Self {
            right,
            up,
            eye,
            scale,
            shift: (
                middle(frame.low.0, frame.high.0) - scale * f64::midpoint(x.0, x.1),
                middle(frame.low.1, frame.high.1) + scale * f64::midpoint(y.0, y.1),
            ),
        }
    }

    /// Place of a point [m] on the canvas [canvas units], y down.
    pub fn at(&self, p: V3) -> (f64, f64) {
        (self.shift.0 + self.scale * dot(p, self.right), self.shift.1 - self.scale * dot(p, self.up))
    }

    /// Returns the place of a point [m] on the canvas in whole canvas units, y down.
    pub fn spot(&self, p: V3) -> (i32, i32) {
        let (x, y) = self.at(p);
        (x.round() as i32, y.round() as i32)
    }
}
