//! The reference of an organ between its solved places and depths.
//!
//! Over depth the force over depth^1.5 (Hertz) changes slowly, over a smooth surface too: its
//! logarithm at every solved depth is a quadratic of the offset from the site, fitted to the solved
//! places; between depths a cubic of the depth's logarithm through the four nearest.

use nalgebra::{SMatrix, SVector};

use super::organ_reference::OrganReference;
use crate::calibrate::targets::Reference;
use crate::statics::Vector;
use palpate_tissue::mesh::triangle::entry_m;
use palpate_tissue::organ::tangents;
use palpate_tissue::tissue::Placed;

/// Terms of the quadratic.
const TERMS: usize = 6;
/// Weight of zero for each term but the constant, beside places that weigh one.
const RIDGE: f64 = 1e-6;

/// Forces over a disc around a site.
#[derive(Clone, Debug)]
pub struct SurfaceMap {
    axis: Vector,
    across: [Vector; 2],
    /// Corners of the surface near the site, from the site [m].
    triangles_m: Vec<[Vector; 3]>,
    /// Solved depths [m], rising.
    depths_m: Vec<f64>,
    /// Quadratic at each of them.
    terms: Vec<SVector<f64, TERMS>>,
    length_m: f64,
    /// Root mean square of what the quadratics miss at the solved places (1).
    pub misfit: f64,
}

impl SurfaceMap {
    /// `None` with fewer than four depths or eight places. `radius_m` is the probe's.
    #[must_use]
    pub fn of(reference: &OrganReference, placed: &Placed, radius_m: f64) -> Option<Self> {
        if reference.depths_m.len() < 4 || reference.places.len() < TERMS + 2 {
            return None;
        }
        let mut map = Self {
            axis: placed.axis.into(),
            across: tangents(placed.axis).map(Vector::from),
            triangles_m: near_site(placed, radius_m),
            depths_m: reference.depths_m.clone(),
            terms: Vec::new(),
            length_m: radius_m,
            misfit: 0.0,
        };
        let mut missed = 0.0;
        for (d, depth_m) in reference.depths_m.iter().enumerate() {
            let value = |p: &super::organ_reference::PlaceForces| (p.force_over_e_m2[d] / depth_m.powf(1.5)).ln();
            let (mut normal, mut right) = (SMatrix::<f64, TERMS, TERMS>::zeros(), SVector::<f64, TERMS>::zeros());
            for place in &reference.places {
                let basis = map.basis(place.offset_m);
                normal += basis * basis.transpose();
                right += basis * value(place);
            }
            (1..TERMS).for_each(|k| normal[(k, k)] += RIDGE);
            let fit = normal.cholesky()?.solve(&right);
            missed += reference.places.iter().map(|p| (map.basis(p.offset_m).dot(&fit) - value(p)).powi(2)).sum::<f64>();
            map.terms.push(fit);
        }
        // degrees of freedom that the fit itself used up are not counted
        let free = (reference.places.len() - TERMS) * reference.depths_m.len();
        map.misfit = (missed / free as f64).sqrt();
        Some(map)
    }

    /// Returns the forces on another mesh of the same organ, whose surface lies elsewhere by a
    /// little.
    #[must_use]
    pub fn on(&self, placed: &Placed) -> Self {
        Self { triangles_m: near_site(placed, self.length_m), ..self.clone() }
    }

    fn basis(&self, offset_m: [f64; 2]) -> SVector<f64, TERMS> {
        let [u, v] = offset_m.map(|c| c / self.length_m);
        SVector::from([1.0, u, v, u * u, u * v, v * v])
    }
}

/// Corners of the surface's triangles near the site, from the site [m].
fn near_site(placed: &Placed, radius_m: f64) -> Vec<[Vector; 3]> {
    let site_m = Vector::from(placed.tissue.site_m);
    let corners = |t: &[u32; 3]| t.map(|n| Vector::from(placed.tissue.mesh.nodes_m[n as usize]) - site_m);
    let near = |t: &[Vector; 3]| t.iter().any(|x| x.norm() < 4.0 * radius_m);
    placed.tissue.skin.iter().map(corners).filter(near).collect()
}

impl Reference for SurfaceMap {
    fn force(&self, place_m: Vector, depth_m: f64) -> Option<f64> {
        let deepest = self.deepest_m() * (1.0 + 1e-9);
        let shallowest = 0.99 * self.depths_m[0];
        if !(shallowest..=deepest).contains(&depth_m) {
            return None;
        }
        let basis = self.basis(self.across.map(|t| place_m.dot(&t)));
        let above = self.depths_m.partition_point(|d| *d < depth_m);
        let first = above.saturating_sub(2).min(self.depths_m.len() - 4);
        let mut sum = 0.0;
        for n in first..first + 4 {
            let others = (first..first + 4).filter(|m| *m != n);
            let share: f64 =
                others.map(|m| (depth_m / self.depths_m[m]).ln() / (self.depths_m[n] / self.depths_m[m]).ln()).product();
            sum += share * basis.dot(&self.terms[n]);
        }
        Some(sum.exp() * depth_m.powf(1.5))
    }

    fn deepest_m(&self) -> f64 {
        self.depths_m.last().copied().unwrap_or_default()
    }

    fn shallowest_m(&self) -> f64 {
        0.99 * self.depths_m[0]
    }

    fn place_m(&self, offset_m: [f64; 2]) -> Option<Vector> {
        if offset_m == [0.0; 2] {
            return Some(Vector::zeros());
        }
        let high_m = 4.0 * self.length_m;
        let from = self.across[0] * offset_m[0] + self.across[1] * offset_m[1] + self.axis * high_m;
        let ways = self.triangles_m.iter().filter_map(|t| entry_m(*t, &from, &-self.axis));
        let displacement_m = ways.min_by(|a, b| (a - high_m).abs().total_cmp(&(b - high_m).abs()))?;
        Some(from - self.axis * displacement_m)
    }

    fn displacement_m(&self, _: f64, _: [f64; 2]) -> Option<[f64; 3]> {
        None
    }
}
