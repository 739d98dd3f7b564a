//! The unknowns of a calibration as one vector, and their effect on a patch.
//!
//! Each unknown is the logarithm of a multiplier in units of its own prior width, so that the ridge
//! is the plain sum of squares, multipliers stay positive, and zero is the uncalibrated patch.

use palpate::Params;

use crate::statics::{Gradient, Statics};
use palpate_tissue::patch::Multipliers;
use palpate_tissue::tissue::Tissue;

/// Prior widths of the logarithms of the multipliers of springs, nodal volume and foundation
/// points.
const SPRING: f64 = 0.2;
const NODE: f64 = 0.3;
const POINT: f64 = 0.4;
/// Prior width of the logarithms of the shared multipliers: of all springs, all nodes, all points,
/// the bulk modulus of the tets, and the stiffening of the foundation.
const SHARED: f64 = 0.25;
/// Prior widths of the logarithm of chi and of `tau_c`, and the upper limit of `tau_c`.
const COMPENSATION: f64 = 0.5;
const THRESHOLD: f64 = 0.03;
const THRESHOLD_MOST: f64 = 0.3;
/// Largest multiplier; its inverse is the smallest one.
const MOST: f64 = 30.0;
/// Largest multiplier of a spring under the probe. With sixteen foundation points and a Poisson's
/// ratio of 1/4, a patch in which one spring was twenty times as stiff as its formula says failed
/// in a press of the tick.
const MOST_OF_SPRING: f64 = 6.0;

/// Layout of the vector of unknowns: the number of each kind.
#[derive(Clone, Debug)]
pub struct Unknowns {
    springs: usize,
    nodes: usize,
    /// Triangles whose foundation points are unknowns.
    triangles: Vec<usize>,
    points_per_triangle: usize,
    /// Whether each unknown is fixed at zero; if empty, none of them is fixed.
    held: Vec<bool>,
    /// Largest multiplier of a spring.
    most_of_spring: f64,
}

/// Number of scalars, which are at the end of the vector, and the index of each among them.
const SCALARS: usize = 7;
const ALL_SPRINGS: usize = 0;
const ALL_NODES: usize = 1;
const ALL_POINTS: usize = 2;
const BULK: usize = 3;
const STIFFENING: usize = 4;
const CHI: usize = 5;
const TAU: usize = 6;

impl Unknowns {
    /// Unknowns of a patch: every spring, every node, and the foundation points of triangles within
    /// `reach_m` of the site.
    #[must_use]
    pub fn of(statics: &Statics, tissue: &Tissue, reach_m: f64) -> Self {
        let site = crate::statics::Vector::from(tissue.site_m);
        let near = |t: &crate::statics::StaticTriangle| {
            let centroid = t.node.iter().map(|&n| statics.rest_m[n]).sum::<crate::statics::Vector>() / 3.0;
            (centroid - site).norm() <= reach_m
        };
        let triangles = statics.triangles.iter().enumerate().filter(|(_, t)| near(t)).map(|(n, _)| n).collect();
        let points_per_triangle = statics.triangles.first().map_or(0, |t| t.k.len());
        Self {
            springs: statics.springs.len(),
            nodes: statics.rest_m.len(),
            triangles,
            points_per_triangle,
            held: Vec::new(),
            most_of_spring: MOST_OF_SPRING,
        }
    }

    /// Fixes all unknowns except those of nodes for which `near` is true and of springs that end at
    /// one of these nodes.
    #[must_use]
    pub fn only(mut self, statics: &Statics, near: &[bool]) -> Self {
        let springs = statics.springs.iter().map(|s| !s.node.iter().any(|n| near[*n]));
        self.held = springs.chain(near.iter().map(|near| !near)).collect();
        self.held.resize(self.len(), true);
        // the springs of an inclusion may differ more from their formula without failing in the
        // tick
        self.most_of_spring = MOST;
        self
    }

    /// Number of unknowns.
    #[must_use]
    pub fn len(&self) -> usize {
        self.springs + self.nodes + self.points_per_triangle * self.triangles.len() + SCALARS
    }

    /// Always false: the scalars are unknown in every patch.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        false
    }

    /// Positions of the multiplier that all springs share and of the one that all nodes share.
    #[must_use]
    pub fn shared_springs_and_nodes(&self) -> [usize; 2] {
        [ALL_SPRINGS, ALL_NODES].map(|which| self.scalar(which))
    }

    fn scalar(&self, which: usize) -> usize {
        self.len() - SCALARS + which
    }

    fn point(&self, slot: usize, point: usize) -> usize {
        self.springs + self.nodes + self.points_per_triangle * slot + point
    }

    /// The patch at the unknowns `z`.
    #[must_use]
    pub fn apply(&self, base: &Statics, z: &[f64]) -> Statics {
        let mut statics = base.clone();
        let shared = |which| SHARED * z[self.scalar(which)];
        let factor = |log: f64| log.clamp(-MOST.ln(), MOST.ln()).exp();
        for (n, s) in statics.springs.iter_mut().enumerate() {
            s.k *= factor(SPRING * z[n] + shared(ALL_SPRINGS)).min(self.most_of_spring);
        }
        for (n, p) in statics.pressure.iter_mut().enumerate() {
            *p *= factor(NODE * z[self.springs + n] + shared(ALL_NODES));
        }
        for t in &mut statics.triangles {
            t.k.iter_mut().for_each(|k| *k *= factor(shared(ALL_POINTS)));
        }
        for (slot, &t) in self.triangles.iter().enumerate() {
            for (point, k) in statics.triangles[t].k.iter_mut().enumerate() {
                let log = POINT * z[self.point(slot, point)];
                *k *= factor(log + shared(ALL_POINTS)) / factor(shared(ALL_POINTS));
            }
        }
        statics.tets.iter_mut().for_each(|t| t.bulk *= factor(shared(BULK)));
        statics.stiffening_per_m *= factor(shared(STIFFENING));
        statics.compensation = base.compensation * factor(COMPENSATION * z[self.scalar(CHI)]);
        statics.compensation_threshold =
            (base.compensation_threshold + THRESHOLD * z[self.scalar(TAU)]).clamp(0.0, THRESHOLD_MOST);
        statics
    }

    /// Writes into `row` the derivatives of an output with respect to the unknowns, multiplied by
    /// `scale`; `gradient` is the gradient of the output at `statics`.
    pub fn slopes(&self, statics: &Statics, gradient: &Gradient, scale: f64, row: &mut [f64]) {
        let mut sums = [0.0; SCALARS];
        for (slot, g) in row[..self.springs].iter_mut().zip(&gradient.spring) {
            *slot = scale * SPRING * g;
            sums[ALL_SPRINGS] += g;
        }
        for (slot, g) in row[self.springs..].iter_mut().zip(&gradient.node) {
            *slot = scale * NODE * g;
            sums[ALL_NODES] += g;
        }
        sums[ALL_POINTS] = gradient.point.iter().flatten().sum();
        for (slot, &t) in self.triangles.iter().enumerate() {
            for (point, g) in gradient.point[t].iter().enumerate() {
                row[self.point(slot, point)] = scale * POINT * g;
            }
        }
        sums[BULK] = gradient.bulk.iter().sum();
        sums[STIFFENING] = gradient.stiffening;
        let last = self.len() - SCALARS;
        row[last..].iter_mut().zip(sums).for_each(|(slot, s)| *slot = scale * SHARED * s);
        row[last + CHI] = scale * COMPENSATION * statics.compensation * gradient.compensation;
        row[last + TAU] = scale * THRESHOLD * gradient.compensation_threshold;
        row.iter_mut().zip(&self.held).filter(|(_, held)| **held).for_each(|(slot, _)| *slot = 0.0);
    }

    /// Multipliers and parameters at the unknowns `z`.
    #[must_use]
    pub fn result(&self, base: &Statics, z: &[f64], params: &Params) -> (Multipliers, Params) {
        let at = self.apply(base, z);
        // at nu = 1/4 the springs alone are the solid, and the volume terms, which are zero, have
        // no multiplier
        let ratio = |a: f64, b: f64| if b == 0.0 { 1.0 } else { a / b };
        let multipliers = Multipliers {
            edge: at.springs.iter().zip(&base.springs).map(|(a, b)| a.k / b.k).collect(),
            node: at.pressure.iter().zip(&base.pressure).map(|(a, b)| ratio(*a, *b)).collect(),
            point: at
                .triangles
                .iter()
                .zip(&base.triangles)
                .map(|(a, b)| a.k.iter().zip(&b.k).map(|(a, b)| a / b).collect())
                .collect(),
            bulk: at.tets.iter().zip(&base.tets).map(|(a, b)| ratio(a.bulk, b.bulk)).next().unwrap_or(1.0),
            stiffening: at.stiffening_per_m / base.stiffening_per_m,
        };
        let params =
            Params { compensation: at.compensation as f32, compensation_threshold: at.compensation_threshold as f32, ..*params };
        (multipliers, params)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate_tissue::patch::{Material, Patch};
    use palpate_tissue::scene::Scene;
    use palpate_tissue::tissue::place;

    /// At nu = 1/4 the springs alone are the solid, and its volume terms are zero.
    #[test]
    fn without_volume_terms_all_multipliers_are_finite() {
        let (_, text) = palpate_tissue::scene::PRESETS[0];
        let mut scene = Scene::parse("block", text).unwrap();
        (scene.tissue.nodes, scene.tissue.poisson_ratio) = (Some(60), 0.25);
        let placed = place(&scene, &[]).unwrap();
        let params = scene.params(placed.axis);
        let patch = Patch::build(&placed.tissue, &Material { poisson_ratio: 0.25, ..Material::default() }, None);
        let statics = Statics::of(&patch.model(), &params).unwrap();
        let unknowns = Unknowns::of(&statics, &placed.tissue, 0.02);
        let z: Vec<f64> = (0..unknowns.len()).map(|n| 0.1 * (n as f64).sin()).collect();
        let (multipliers, _) = unknowns.result(&statics, &z, &params);
        let all = multipliers.edge.iter().chain(&multipliers.node).chain(multipliers.point.iter().flatten());
        assert!(all.chain([&multipliers.bulk, &multipliers.stiffening]).all(|m| m.is_finite() && *m > 0.0), "{multipliers:?}");
    }
    #[test]
    fn only_an_inclusions_springs_go_far_from_their_formula() {
        let (_, text) = palpate_tissue::scene::PRESETS[0];
        let mut scene = Scene::parse("block", text).unwrap();
        scene.tissue.nodes = Some(60);
        let placed = place(&scene, &[]).unwrap();
        let patch = Patch::build(&placed.tissue, &Material::default(), None);
        let statics = Statics::of(&patch.model(), &scene.params(placed.axis)).unwrap();
        let most = |unknowns: &Unknowns| {
            let at = unknowns.apply(&statics, &vec![100.0; unknowns.len()]);
            at.springs.iter().zip(&statics.springs).map(|(a, b)| a.k / b.k).fold(0.0, f64::max)
        };
        let unknowns = Unknowns::of(&statics, &placed.tissue, 0.02);
        assert!((most(&unknowns) - MOST_OF_SPRING).abs() < 1e-6, "{}", most(&unknowns));
        let inclusion = unknowns.only(&statics, &vec![true; statics.rest_m.len()]);
        assert!((most(&inclusion) - MOST).abs() < 1e-6, "{}", most(&inclusion));
    }
}
