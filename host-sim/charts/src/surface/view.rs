//! A parallel projection that shows the pressed site.

use super::super::place::Frame;

pub type V3 = nalgebra::Vector3<f64>;

/// A unit vector at right angles to the unit vector `axis`, as close to `wish` as possible.
pub fn across(axis: V3, wish: V3) -> V3 {
    // if `wish` is parallel to `axis` no direction is closest: use the next coordinate axis
    let across = |wish: V3| (wish - axis * wish.dot(&axis)).try_normalize(0.3);
    across(wish).or_else(|| across(wish.yzx())).unwrap_or_else(V3::z)
}

/// Orientation and scale of the projection onto the canvas.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// Unit vector to the right on the canvas.
    pub right: V3,
    /// Unit vector upward on the canvas.
    pub up: V3,
    /// Unit vector toward the eye.
    pub eye: V3,
    /// Canvas units per metre.
    pub scale: f64,
    shift: (f64, f64),
}

/// Direction to the eye, as components along the probe's axis, toward the operator (x), and at
/// right angles to both (y): 33 degrees above the surface, and 27 degrees away from the operator's
/// line of sight.
const EYE: [f64; 3] = [0.545, 0.747, 0.381];

impl View {
    /// Looks at the side of the body from which the unit vector `axis` points outward, and fits all
    /// `points` into `frame`.
    pub fn onto(axis: V3, points: &(impl Iterator<Item = V3> + Clone), frame: Frame) -> Self {
        let front = across(axis, V3::x());
        let side = axis.cross(&front);
        let eye = (axis * EYE[0] + front * EYE[1] + side * EYE[2]).try_normalize(0.0).unwrap_or(axis);
        Self::from_eye(eye, axis, points, frame)
    }

    /// Looks from the direction of the unit vector `eye` with the unit vector `axis` upward, and
    /// fits all `points` into `frame`.
    pub fn from_eye(eye: V3, axis: V3, points: &(impl Iterator<Item = V3> + Clone), frame: Frame) -> Self {
        // if the eye is on the axis, "upward" is undefined and any direction to the right will do
        let right = axis.cross(&eye).try_normalize(1e-6).unwrap_or_else(|| across(axis, V3::y()));
        let up = eye.cross(&right);
        let extent = |along: V3| {
            let all = points.clone().map(|p| p.dot(&along));
            all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
        };
        let (x, y) = (extent(right), extent(up));
        let room = (f64::from(frame.high.0 - frame.low.0), f64::from(frame.high.1 - frame.low.1));
        let (wide, tall) = (x.1 - x.0, y.1 - y.0);
        let scale = if wide * room.1 > tall * room.0 { room.0 / wide } else { room.1 / tall };
        // a single point has no extent that could fill the frame
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

    /// Position of the point `p` [m] on the canvas [canvas units], y downward.
    pub fn at(&self, p: V3) -> (f64, f64) {
        (self.shift.0 + self.scale * p.dot(&self.right), self.shift.1 - self.scale * p.dot(&self.up))
    }

    /// Position of the point `p` [m] on the canvas, rounded to whole canvas units, y downward.
    pub fn spot(&self, p: V3) -> (i32, i32) {
        let (x, y) = self.at(p);
        (x.round() as i32, y.round() as i32)
    }
}
