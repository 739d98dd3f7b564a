//! Interpolates presses of a block between their places and depths.
//!
//! Divided by depth^1.5 (Hertz; for a flat end, by the depth), the force changes slowly with depth.
//! The logarithm of this ratio is interpolated by a cubic in the logarithm of the depth, through
//! the four nearest solved depths. Over the top, the ratio to the centred force is one plus an even
//! polynomial of degree four that is fitted to the solved places. It is even because the block has
//! two planes of symmetry, and so has a tip that is aligned with one of them.

use nalgebra::{SMatrix, SVector};

use super::cubic;
use crate::calibrate::targets::Reference;
use crate::statics::Vector;
use palpate_tissue::answer::{Answer, GluedAnswer, SurfaceGrid};
use palpate_tissue::scene::Shape;

/// Number of terms of the polynomial: x^2, y^2, x^4, x^2 y^2, y^4.
const TERMS: usize = 5;
/// Weight of the ridge on each term, whereas the places have weights of about one.
const RIDGE: f64 = 1e-9;
/// Distance from the centre up to which a place counts as the centre [m].
const CENTRED_M: f64 = 1e-9;

/// Forces at places over a disc around the centre of a block's top.
#[derive(Clone, Debug)]
pub struct BlockForces {
    /// Depths of the centred presses in ascending order [m].
    depths_m: Vec<f64>,
    /// ln(F / (E d^p)) of the centred presses, where d is the depth and p is `power`.
    centred: Vec<f64>,
    /// Depth [m] and coefficients of the polynomial, in the order of increasing depth.
    ratios: Vec<(f64, SVector<f64, TERMS>)>,
    surfaces: Vec<(f64, SurfaceGrid)>,
    glued: Vec<GluedAnswer>,
    power: f64,
    length_m: f64,
}

impl BlockForces {
    /// Returns `None` if the answer has fewer than four depths at the centre.
    #[must_use]
    pub fn of(answer: &Answer) -> Option<Self> {
        let away = |place: [f64; 3]| place[0].hypot(place[1]);
        let power = if answer.probe.shape == Shape::Flat { 1.0 } else { 1.5 };
        let at_centre = || answer.holds.iter().filter(|h| away(h.place_m) < CENTRED_M);
        let mut centred: Vec<(f64, f64)> =
            at_centre().map(|h| (h.depth_m, (h.force_over_e_m2 / h.depth_m.powf(power)).ln())).collect();
        centred.sort_by(|a, b| a.0.total_cmp(&b.0));
        if centred.len() < 4 {
            return None;
        }
        let surfaces = at_centre().filter_map(|h| Some((h.depth_m, h.surface.clone()?))).collect();
        let (depths_m, centred) = centred.into_iter().unzip();
        let mut known = Self {
            depths_m,
            centred,
            ratios: Vec::new(),
            surfaces,
            glued: answer.glued.clone(),
            power,
            length_m: answer.probe.radius_m,
        };
        let square = answer.tissue.block_m.is_some_and(|size| size[0] == size[1]) && answer.probe.shape.is_round();
        // if places lie on the axes alone, the force is taken not to depend on their direction
        let on_axes = square && answer.holds.iter().all(|h| h.place_m[0] * h.place_m[1] == 0.0);
        for depth_m in known.depths_m.clone() {
            let aside = answer.holds.iter().filter(|h| h.depth_m == depth_m && away(h.place_m) > CENTRED_M);
            let centre = known.centred_force(depth_m);
            let (mut normal, mut right) = (SMatrix::<f64, TERMS, TERMS>::identity() * RIDGE, SVector::<f64, TERMS>::zeros());
            let mut places = 0;
            for hold in aside {
                let [x, y, _] = hold.place_m;
                let ratio = hold.force_over_e_m2 / centre - 1.0;
                let turned = on_axes.then(|| [std::f64::consts::FRAC_1_SQRT_2 * x.hypot(y); 2]);
                for at in [[x, y], [y, x]].into_iter().take(if square { 2 } else { 1 }).chain(turned) {
                    let shape = known.shape(at);
                    normal += shape * shape.transpose();
                    right += shape * ratio;
                }
                places += 1;
            }
            if places > 0 {
                known.ratios.push((depth_m, normal.cholesky()?.solve(&right)));
            }
        }
        Some(known)
    }

    fn shape(&self, [x, y]: [f64; 2]) -> SVector<f64, TERMS> {
        let (x, y) = ((x / self.length_m).powi(2), (y / self.length_m).powi(2));
        [x, y, x * x, x * y, y * y].into()
    }

    fn centred_force(&self, depth_m: f64) -> f64 {
        cubic(&self.depths_m, depth_m, |n| self.centred[n]).exp() * depth_m.powf(self.power)
    }

    /// Ratio of the force at a place to the centred force (1): linear in the logarithm of the depth
    /// between two solved depths, and constant beyond them.
    fn ratio(&self, place: [f64; 2], depth_m: f64) -> Option<f64> {
        let shape = self.shape(place);
        let above = self.ratios.partition_point(|r| r.0 < depth_m);
        match (above.checked_sub(1).and_then(|n| self.ratios.get(n)), self.ratios.get(above)) {
            (Some(low), Some(high)) => {
                let share = (depth_m / low.0).ln() / (high.0 / low.0).ln();
                Some(1.0 + low.1.dot(&shape) * (1.0 - share) + high.1.dot(&shape) * share)
            }
            (Some(only), None) | (None, Some(only)) => Some(1.0 + only.1.dot(&shape)),
            (None, None) => None,
        }
    }
}

impl Reference for BlockForces {
    fn force(&self, place_m: Vector, depth_m: f64) -> Option<f64> {
        let centred = (depth_m <= self.deepest_m() * (1.0 + 1e-9)).then(|| self.centred_force(depth_m))?;
        if place_m.x.hypot(place_m.y) < CENTRED_M {
            return Some(centred);
        }
        Some(centred * self.ratio([place_m.x, place_m.y], depth_m)?)
    }

    fn deepest_m(&self) -> f64 {
        self.depths_m.last().copied().unwrap_or_default()
    }

    fn shallowest_m(&self) -> f64 {
        self.depths_m.first().copied().unwrap_or_default()
    }

    fn glued(&self) -> &[GluedAnswer] {
        &self.glued
    }

    fn displacement_m(&self, depth_m: f64, offset_m: [f64; 2]) -> Option<[f64; 3]> {
        self.surfaces.iter().find(|(depth, _)| *depth == depth_m)?.1.at_m(offset_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate_tissue::answer::HoldAnswer;

    #[test]
    fn between_solved_depths_and_places_the_law_is_kept() {
        let force = |x: f64, y: f64, d: f64| {
            let fall = 1.0 - 30.0 * x * x - 45.0 * y * y - 4e4 * x * x * y * y;
            d.powf(1.5) * 0.15 * d.powf(0.1) * fall
        };
        let mut answer = Answer::block();
        answer.tissue.block_m = Some([0.08, 0.06, 0.04]);
        answer.holds.clear();
        for d in [0.0005, 0.001, 0.002, 0.004, 0.006] {
            for [x, y] in [[0.0, 0.0], [0.006, 0.0], [0.01, 0.0], [0.0, 0.006], [0.0, 0.01], [0.007, 0.007]] {
                let force_over_e_m2 = force(x, y, d);
                answer.holds.push(HoldAnswer { place_m: [x, y, 0.0], depth_m: d, force_over_e_m2, surface: None });
            }
        }
        let map = BlockForces::of(&answer).unwrap();
        for (x, y, d) in [(0.0, 0.0, 0.003), (0.003, -0.005, 0.001), (-0.006, 0.006, 0.0055)] {
            let found = map.force(Vector::new(x, y, 0.0), d).unwrap();
            assert!((found / force(x, y, d) - 1.0).abs() < 1e-6, "{x} {y} {d}: {found}");
        }
        assert!(map.force(Vector::zeros(), 0.0061).is_none(), "deeper than solved");
    }
}
