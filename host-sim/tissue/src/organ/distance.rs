//! Distance, depth and rays on an implicit surface.

use super::Organ;
use super::parts::V3;

/// Step of the central differences [m]: their error is far below a micrometre per metre on organs
/// whose surfaces curve over centimetres.
const STEP_M: f64 = 1e-6;
/// Number of rounds of the search for the nearest surface point.
const ROUNDS: usize = 8;
/// Largest number of Newton steps in each round.
const NEWTON: usize = 6;
/// Number of samples along a ray that is long enough to pass through the organ's box; parts that
/// lie between two samples are missed.
const RAY_STEPS: u32 = 4000;

impl Organ {
    pub(super) fn value(&self, at: V3) -> f64 {
        (self.implicit)(at)
    }

    /// Gradient of the implicit function (1); at the surface it points along the outward normal.
    pub(super) fn gradient(&self, at: V3) -> V3 {
        V3::from_fn(|axis, _| {
            let mut step = V3::zeros();
            step[axis] = STEP_M;
            (self.value(at + step) - self.value(at - step)) / (2.0 * STEP_M)
        })
    }

    /// Moves a point to the surface along the gradient, by Newton's method.
    fn settle(&self, mut at: V3) -> V3 {
        for _ in 0..NEWTON {
            let (value, slope) = (self.value(at), self.gradient(at));
            let square = slope.norm_squared();
            if value.abs() < 1e-12 || square < 1e-12 {
                break;
            }
            at -= slope * (value / square);
        }
        at
    }

    /// Nearest surface point and signed distance to it [m], negative inside. The surface point is
    /// moved along the surface until the connecting line is normal (Hartmann's foot-point
    /// iteration). The distance is exact if it is less than the surface's radius of curvature, and
    /// otherwise an upper bound.
    pub(super) fn foot(&self, at: V3) -> (V3, f64) {
        let mut foot = self.settle(at);
        let mut least = (at - foot).norm();
        let mut best = foot;
        for _ in 0..ROUNDS {
            let normal = self.gradient(foot).normalize();
            let tangential = at - normal * (at - foot).dot(&normal);
            foot = self.settle(tangential);
            let far = (at - foot).norm();
            if far < least {
                (least, best) = (far, foot);
            }
        }
        (best, if self.value(at) < 0.0 { -least } else { least })
    }

    pub(super) fn distance(&self, at: V3) -> f64 {
        self.foot(at).1
    }

    /// First crossing of a ray with the surface, by steps and bisection.
    pub(super) fn crossing(&self, from: V3, direction: V3) -> Option<V3> {
        let [low, high] = self.box_m.map(V3::from);
        let reach = (from - 0.5 * (low + high)).norm() + (high - low).norm();
        let unit = direction.try_normalize(0.0)?;
        let inside = |along: f64| self.value(from + unit * along) < 0.0;
        let began = inside(0.0);
        let step = |i: u32| reach * f64::from(i) / f64::from(RAY_STEPS);
        let i = (1..=RAY_STEPS).find(|i| inside(step(*i)) != began)?;
        let (mut near, mut far) = (step(i - 1), step(i));
        for _ in 0..40 {
            let middle = 0.5 * (near + far);
            if inside(middle) == began { near = middle } else { far = middle }
        }
        Some(from + unit * (0.5 * (near + far)))
    }
}
