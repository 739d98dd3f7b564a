//! Interpolates the reference between the depths and places for which it was solved.
//!
//! Over depth, the force divided by depth^1.5 (Hertz) varies smoothly and slowly, and is
//! interpolated by a cubic through the four nearest depths. Over the top of a homogeneous block the
//! force hardly changes (under 1 % within 1.5 probe radii). Its ratio to the centred force has the
//! symmetry of the square, `1 + a r^2 + b r^4 + c r^4 cos(4 angle)`, and is fitted to the solved
//! places.

use nalgebra::Matrix3;

use super::targets::Reference;
use crate::statics::Vector;
use palpate_tissue::answer::{Answer, GluedAnswer};

/// Distance from the site up to which a place counts as the centre [m].
const CENTRED_M: f64 = 1e-9;
/// Weights of the ridge on a, b and c in the fit of the ratio, whereas the places have weights of
/// about one. Without a place off the axes, the ridge makes c zero.
const RIDGE: [f64; 3] = [1e-9, 1e-9, 1e-6];

/// An answer that can be interpolated anywhere on the top of its block.
#[derive(Clone, Debug)]
pub struct ReferenceMap<'a> {
    answer: &'a Answer,
    /// Depth [m] and force over E [m^2] of the centred presses, in the order of increasing depth.
    centred: Vec<(f64, f64)>,
    /// Depth [m] and the coefficients a, b and c (1), in the order of increasing depth.
    ratios: Vec<(f64, [f64; 3])>,
    length_m: f64,
}

impl<'a> ReferenceMap<'a> {
    /// Returns `None` if the answer has fewer than four centred presses.
    #[must_use]
    pub fn of(answer: &'a Answer) -> Option<Self> {
        let away = |place: [f64; 3]| place[0].hypot(place[1]);
        let mut centred: Vec<(f64, f64)> =
            answer.holds.iter().filter(|h| away(h.place_m) < CENTRED_M).map(|h| (h.depth_m, h.force_over_e_m2)).collect();
        centred.sort_by(|a, b| a.0.total_cmp(&b.0));
        if centred.len() < 4 {
            return None;
        }
        let length_m = answer.probe.radius_m;
        let mut map = Self { answer, centred, ratios: Vec::new(), length_m };
        let depths: Vec<f64> = map.centred.iter().map(|c| c.0).collect();
        for depth_m in depths {
            let aside: Vec<_> = answer.holds.iter().filter(|h| h.depth_m == depth_m && away(h.place_m) > CENTRED_M).collect();
            if aside.len() < 3 {
                continue;
            }
            let at_centre = map.centred_force(depth_m);
            // normal equations with a slight ridge, because places on one axis cannot distinguish b
            // from c
            let (mut normal, mut right) = (Matrix3::from_diagonal(&RIDGE.into()), Vector::zeros());
            for hold in aside {
                let shape = Vector::from(map.shape(hold.place_m));
                normal += shape * shape.transpose();
                right += shape * (hold.force_over_e_m2 / at_centre - 1.0);
            }
            if let Some(fit) = normal.try_inverse().map(|inverse| inverse * right) {
                map.ratios.push((depth_m, fit.into()));
            }
        }
        Some(map)
    }

    /// Glued discs of the answer; there may be none.
    #[must_use]
    pub fn glued(&self) -> &[GluedAnswer] {
        &self.answer.glued
    }

    /// Depth of the deepest centred press [m].
    #[must_use]
    pub fn deepest_m(&self) -> f64 {
        self.centred.last().map_or(0.0, |c| c.0)
    }

    /// Force over E of a centred press [m^2].
    #[must_use]
    pub fn centred_force(&self, depth_m: f64) -> f64 {
        let above = self.centred.partition_point(|c| c.0 < depth_m);
        let first = above.saturating_sub(2).min(self.centred.len() - 4);
        let near = &self.centred[first..first + 4];
        let smooth = |(depth, force): (f64, f64)| force / depth.powf(1.5);
        let mut sum = 0.0;
        for (n, at) in near.iter().enumerate() {
            let others = near.iter().enumerate().filter(|(m, _)| *m != n);
            sum += smooth(*at) * others.map(|(_, o)| (depth_m - o.0) / (at.0 - o.0)).product::<f64>();
        }
        sum * depth_m.powf(1.5)
    }

    fn shape(&self, place: [f64; 3]) -> [f64; 3] {
        let (x, y) = (place[0] / self.length_m, place[1] / self.length_m);
        let square = x * x + y * y;
        // r^4 cos(4 angle)
        [square, square * square, x.powi(4) - 6.0 * x * x * y * y + y.powi(4)]
    }

    fn ratio(&self, place: [f64; 3], depth_m: f64) -> Option<f64> {
        let shape = self.shape(place);
        let of = |fit: &[f64; 3]| 1.0 + fit.iter().zip(shape).map(|(f, s)| f * s).sum::<f64>();
        let above = self.ratios.partition_point(|r| r.0 < depth_m);
        match (above.checked_sub(1).and_then(|n| self.ratios.get(n)), self.ratios.get(above)) {
            (Some(low), Some(high)) => {
                let share = (depth_m - low.0) / (high.0 - low.0);
                Some(of(&low.1) * (1.0 - share) + of(&high.1) * share)
            }
            (Some(only), None) | (None, Some(only)) => Some(of(&only.1)),
            (None, None) => None,
        }
    }
}

impl Reference for ReferenceMap<'_> {
    fn deepest_m(&self) -> f64 {
        Self::deepest_m(self)
    }

    fn glued(&self) -> &[GluedAnswer] {
        Self::glued(self)
    }

    fn force(&self, place_m: Vector, depth_m: f64) -> Option<f64> {
        let centred = (depth_m <= self.deepest_m() * (1.0 + 1e-9)).then(|| self.centred_force(depth_m))?;
        if place_m.x.hypot(place_m.y) < CENTRED_M {
            return Some(centred);
        }
        Some(centred * self.ratio(place_m.into(), depth_m)?)
    }

    fn displacement_m(&self, depth_m: f64, offset_m: [f64; 2]) -> Option<[f64; 3]> {
        let hold = self.answer.hold([0.0; 3], depth_m)?;
        hold.surface.as_ref()?.at_m(offset_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate_tissue::answer::HoldAnswer;

    #[test]
    fn between_solved_depths_and_places_the_law_is_kept() {
        // Hertz's law with a slow change over depth, decreasing outward with the symmetry of the
        // square
        let force = |x: f64, y: f64, d: f64| {
            let fall = 1.0 - 30.0 * (x * x + y * y) - 4e5 * (x.powi(4) - 6.0 * x * x * y * y + y.powi(4));
            d.powf(1.5) * (0.15 + 2.0 * d - 50.0 * d * d) * fall
        };
        let mut answer = Answer::block();
        answer.holds.clear();
        for d in [0.0005, 0.001, 0.002, 0.004, 0.008] {
            for [x, y] in [[0.0, 0.0], [0.004, 0.0], [0.008, 0.0], [0.0085, 0.0085]] {
                let force_over_e_m2 = force(x, y, d);
                answer.holds.push(HoldAnswer { place_m: [x, y, 0.0], depth_m: d, force_over_e_m2, surface: None });
            }
        }
        let map = ReferenceMap::of(&answer).unwrap();
        for (x, y, d) in [(0.0, 0.0, 0.003), (0.003, -0.005, 0.001), (-0.006, 0.006, 0.0055), (0.01, 0.002, 0.0007)] {
            let found = map.force(Vector::new(x, y, 0.0), d).unwrap();
            assert!((found / force(x, y, d) - 1.0).abs() < 1e-6, "{x} {y} {d}: {found}");
        }
        assert!(map.force(Vector::zeros(), 0.009).is_none(), "deeper than solved");
    }
}
