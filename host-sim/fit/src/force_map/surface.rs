//! Interpolates the reference of an organ between the places and depths for which it was solved.
//!
//! On a curved or faceted surface the force of a small contact depends on its position. This
//! geometric effect is removed first: the *effective depth* of a press is the depth at which
//! the probe would displace the same volume from a plane. Divided by the effective depth^1.5
//! (Hertz; for a flat end, by the effective depth itself), the force changes slowly with depth and
//! over the surface. At every solved depth, the logarithm of this ratio is a quadratic function of
//! the offset from the site, fitted to the solved places. Between the depths it is interpolated by
//! a cubic in the logarithm of the depth, through the four nearest.

use std::f64::consts::PI;

use nalgebra::{SMatrix, SVector};

use super::cubic;
use crate::calibrate::targets::Reference;
use crate::far_field::organ_reference::{OrganReference, PlaceForces};
use crate::far_field::shape_surface::ShapeSurface;
use crate::statics::Vector;
use palpate_tissue::organ::tangents;
use palpate_tissue::scene::{ProbeScene, Shape, Tip, level};

/// Number of terms of the quadratic.
const TERMS: usize = 6;
/// Numbers of rings, and of rays per ring, of the points at which the volume under the probe is
/// summed.
const RINGS: usize = 12;
const RAYS: usize = 16;
/// Number of halvings in the bisection for an effective depth.
const HALVINGS: usize = 40;
/// Weight of the ridge on each term except the constant, whereas the places have weights of one.
const RIDGE: f64 = 1e-6;

/// Forces over the surface around a site.
#[derive(Clone, Debug)]
pub struct SurfaceForces {
    across: [Vector; 2],
    /// Surface of the shape around the site.
    surface: ShapeSurface,
    /// Solved depths in ascending order [m].
    depths_m: Vec<f64>,
    /// Coefficients of the quadratic over the surface at each depth.
    terms: Vec<SVector<f64, TERMS>>,
    length_m: f64,
    tip: Tip,
    /// Root mean square of the relative errors of the quadratics at the solved places (1).
    pub misfit: f64,
}

impl SurfaceForces {
    /// Returns `None` if the reference has fewer than four depths or eight places.
    #[must_use]
    pub fn of(reference: &OrganReference, site_m: [f64; 3], probe: &ProbeScene) -> Option<Self> {
        if reference.depths_m.len() < 4 || reference.places.len() < TERMS + 2 {
            return None;
        }
        let mut map = Self {
            across: tangents(reference.surface.axis.into()).map(Vector::from),
            surface: reference.surface.clone(),
            depths_m: reference.depths_m.clone(),
            terms: Vec::new(),
            length_m: probe.radius_m,
            tip: probe.tip(),
            misfit: 0.0,
        };
        let site_m = Vector::from(site_m);
        let mut missed = 0.0;
        for (d, depth_m) in reference.depths_m.iter().enumerate() {
            let value = |p: &PlaceForces| {
                let shallow = map.law(Vector::from(p.place_m) - site_m, *depth_m)?;
                Some((p.force_over_e_m2[d] / shallow).ln())
            };
            let values: Vec<f64> = reference.places.iter().map(value).collect::<Option<_>>()?;
            let (mut normal, mut right) = (SMatrix::<f64, TERMS, TERMS>::zeros(), SVector::<f64, TERMS>::zeros());
            for (place, value) in reference.places.iter().zip(&values) {
                let basis = map.basis(place.offset_m);
                normal += basis * basis.transpose();
                right += basis * *value;
            }
            (1..TERMS).for_each(|k| normal[(k, k)] += RIDGE);
            let fit = normal.cholesky()?.solve(&right);
            let off = |(p, value): (&PlaceForces, &f64)| (map.basis(p.offset_m).dot(&fit) - value).powi(2);
            missed += reference.places.iter().zip(&values).map(off).sum::<f64>();
            map.terms.push(fit);
        }
        // corrected for the degrees of freedom that the fit uses
        let free = (reference.places.len() - TERMS) * reference.depths_m.len();
        map.misfit = (missed / free as f64).sqrt();
        Some(map)
    }

    /// Force of Hertz, or of a flat end, at the effective depth of a press, up to a constant
    /// factor.
    fn law(&self, place_m: Vector, depth_m: f64) -> Option<f64> {
        let effective_m = self.effective_m(place_m, depth_m)?;
        Some(if self.tip.shape == Shape::Flat { effective_m } else { effective_m.powf(1.5) })
    }

    /// Depth [m] at which the probe would displace from a plane the volume that it displaces from
    /// the surface when its tip is `depth_m` below `place_m`.
    fn effective_m(&self, place_m: Vector, depth_m: f64) -> Option<f64> {
        let radius_m = self.length_m;
        // the surface may rise beside the place, so the sum extends further than the contact with a
        // plane
        let reach_m = radius_m.min(1.5 * (2.0 * radius_m * depth_m).sqrt());
        match self.tip.shape {
            Shape::Flat => {
                let above = |_, _| 0.0;
                Some(self.volume_m3(place_m, depth_m, radius_m, above) / (PI * radius_m * radius_m))
            }
            Shape::Hemisphere | Shape::Sphere => {
                let above = |r_m: f64, _| radius_m - (radius_m * radius_m - r_m * r_m).max(0.0).sqrt();
                let of_plane = |d: f64| PI * d * d * (radius_m - d / 3.0);
                self.depth_of(self.volume_m3(place_m, depth_m, reach_m, above), of_plane)
            }
            Shape::Capsule { length_m, along } => {
                let (along, half_m) = (level(along, self.surface.axis), 0.5 * length_m);
                let above = |_, off_m: Vector| {
                    let place = off_m.dot(&along);
                    let r_m = (off_m - along * place.clamp(-half_m, half_m)).norm();
                    radius_m - (radius_m * radius_m - r_m * r_m).max(0.0).sqrt()
                };
                self.long_depth_m(place_m, depth_m, reach_m + half_m, above)
            }
            Shape::Ellipsoid { semi_axes_m: [a, b], along } => {
                let along = level(along, self.surface.axis);
                let across = self.surface.axis.cross(&along);
                let above = |_, off_m: Vector| {
                    let share = (off_m.dot(&along) / a).powi(2) + (off_m.dot(&across) / b).powi(2);
                    radius_m * (1.0 - (1.0 - share).max(0.0).sqrt())
                };
                self.long_depth_m(place_m, depth_m, reach_m * self.tip.reach_m() / radius_m, above)
            }
        }
    }

    /// Effective depth of a tip that is not round. The volumes displaced from a plane and from the
    /// surface are summed at the same points.
    fn long_depth_m(
        &self,
        place_m: Vector,
        depth_m: f64,
        reach_m: f64,
        above: impl Fn(f64, Vector) -> f64 + Copy,
    ) -> Option<f64> {
        let of_plane =
            |d: f64| self.points(reach_m).map(|(r_m, area_m2, off_m)| area_m2 * (d - above(r_m, off_m)).max(0.0)).sum();
        self.depth_of(self.volume_m3(place_m, depth_m, reach_m, above), of_plane)
    }

    /// Depth at which the volume `of_plane`, which grows with depth, equals `volume_m3`; `None` if
    /// that is zero.
    fn depth_of(&self, volume_m3: f64, of_plane: impl Fn(f64) -> f64) -> Option<f64> {
        let (mut low, mut high) = (0.0, 1.5 * self.length_m);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if of_plane(middle) < volume_m3 { low = middle } else { high = middle }
        }
        (low > 0.0).then_some(low)
    }

    /// Points around the axis: distance from it [m], area that each represents [m^2], and vector
    /// from the axis [m].
    fn points(&self, reach_m: f64) -> impl Iterator<Item = (f64, f64, Vector)> {
        (0..RINGS).flat_map(move |ring| {
            let r_m = reach_m * (ring as f64 + 0.5) / RINGS as f64;
            let area_m2 = 2.0 * PI * r_m * reach_m / (RINGS * RAYS) as f64;
            (0..RAYS).map(move |ray| {
                // rotated from ring to ring, and never along an axis, where an edge of the mesh may
                // be
                let (sin, cos) = (2.0 * PI * (ray as f64 + 0.25 + 0.5 * (ring % 2) as f64) / RAYS as f64).sin_cos();
                (r_m, area_m2, (self.across[0] * cos + self.across[1] * sin) * r_m)
            })
        })
    }

    /// Volume [m^3] that a probe displaces when its tip is `depth_m` below `place_m`, up to
    /// `reach_m` from its axis. The surface of the probe is `above` the tip by a height that
    /// depends on distance and vector from the axis [m].
    fn volume_m3(&self, place_m: Vector, depth_m: f64, reach_m: f64, above: impl Fn(f64, Vector) -> f64) -> f64 {
        let mut volume_m3 = 0.0;
        for (r_m, area_m2, off_m) in self.points(reach_m) {
            let at_m = place_m + off_m;
            let height_m =
                self.surface.height_m(at_m).map_or(f64::NEG_INFINITY, |height_m| height_m - place_m.dot(&self.surface.axis));
            volume_m3 += area_m2 * (height_m + depth_m - above(r_m, off_m)).max(0.0);
        }
        volume_m3
    }

    fn basis(&self, offset_m: [f64; 2]) -> SVector<f64, TERMS> {
        let [u, v] = offset_m.map(|c| c / self.length_m);
        SVector::from([1.0, u, v, u * u, u * v, v * v])
    }
}

impl Reference for SurfaceForces {
    fn force(&self, place_m: Vector, depth_m: f64) -> Option<f64> {
        let deepest = self.deepest_m() * (1.0 + 1e-9);
        let shallowest = 0.99 * self.depths_m[0];
        if !(shallowest..=deepest).contains(&depth_m) {
            return None;
        }
        let basis = self.basis(self.across.map(|t| place_m.dot(&t)));
        let ln = cubic(&self.depths_m, depth_m, |n| basis.dot(&self.terms[n]));
        Some(ln.exp() * self.law(place_m, depth_m)?)
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
        let plane = self.across[0] * offset_m[0] + self.across[1] * offset_m[1];
        Some(plane + self.surface.axis * self.surface.height_m(plane)?)
    }

    fn touch_m(&self, offset_m: [f64; 2]) -> Option<f64> {
        let tip_m = self.place_m(offset_m)?.dot(&self.surface.axis);
        let plane = self.across[0] * offset_m[0] + self.across[1] * offset_m[1];
        let radius_m = self.length_m;
        // a round tip touches a slope beside its lowest point
        let lift_m = |(r_m, _, off_m): (f64, f64, Vector)| {
            let above_m = radius_m - (radius_m * radius_m - r_m * r_m).max(0.0).sqrt();
            self.surface.height_m(plane + off_m).map_or(f64::NEG_INFINITY, |height_m| height_m - above_m)
        };
        let round = !matches!(self.tip.shape, Shape::Flat);
        Some(self.points(radius_m).filter(|_| round).map(lift_m).fold(tip_m, f64::max))
    }

    fn displacement_m(&self, _: f64, _: [f64; 2]) -> Option<[f64; 3]> {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RADIUS_M: f64 = 0.008;

    /// A map of two squares of 80 mm that meet at x = 0; the one at x > 0 is lower and slopes
    /// downward.
    fn surface(lower_m: f64, slope: f64) -> SurfaceForces {
        let wide = 10.0 * RADIUS_M;
        let square = |near: f64, far: f64, [z_near, z_far]: [f64; 2]| {
            let corner = |x: f64, y: f64, z: f64| Vector::new(x, y, z);
            let [a, b] = [corner(near, -wide, z_near), corner(far, -wide, z_far)];
            let [c, d] = [corner(far, wide, z_far), corner(near, wide, z_near)];
            [[a, b, c], [a, c, d]]
        };
        let low = [-lower_m, -lower_m - slope * wide];
        let triangles_m = [square(-wide, 0.0, [0.0; 2]), square(0.0, wide, low)].concat();
        SurfaceForces {
            across: [Vector::x(), Vector::y()],
            surface: ShapeSurface::around(triangles_m, Vector::z(), RADIUS_M),
            depths_m: Vec::new(),
            terms: Vec::new(),
            length_m: RADIUS_M,
            tip: Tip { shape: Shape::Sphere, radius_m: RADIUS_M },
            misfit: 0.0,
        }
    }

    #[test]
    fn on_a_plane_the_effective_depth_is_the_depth() {
        for depth_m in [0.0005, 0.001, 0.004, 0.006] {
            let along = [0.3, 1.0, 0.0];
            let long = [Shape::Capsule { length_m: 0.01, along }, Shape::Ellipsoid { semi_axes_m: [0.012, 0.006], along }];
            for shape in [Shape::Sphere, Shape::Flat].into_iter().chain(long) {
                let plane = SurfaceForces { tip: Tip { shape, radius_m: RADIUS_M }, ..surface(0.0, 0.0) };
                let found = plane.effective_m(Vector::new(0.001, -0.002, 0.0), depth_m).unwrap();
                assert!((found / depth_m - 1.0).abs() < 0.01, "{depth_m}: {found}");
            }
        }
    }

    #[test]
    fn beside_a_step_half_the_volume_is_of_the_lower_side() {
        let (depth_m, lower_m) = (0.002, 0.0008);
        let cap = |d: f64| PI * d * d * (RADIUS_M - d / 3.0);
        let wanted = 0.5 * (cap(depth_m) + cap(depth_m - lower_m));
        let effective_m = surface(lower_m, 0.0).effective_m(Vector::zeros(), depth_m).unwrap();
        assert!((cap(effective_m) / wanted - 1.0).abs() < 0.02, "{effective_m}");
    }

    #[test]
    fn an_edge_that_falls_away_is_pressed_less_deep_and_no_surface_not_at_all() {
        let at = |slope: f64| surface(0.0, slope).effective_m(Vector::zeros(), 0.002).unwrap();
        assert!(at(0.1) < at(0.0) && at(0.3) < at(0.1));
        assert!(surface(0.0, 0.0).effective_m(Vector::new(1.0, 0.0, 0.0), 0.002).is_none());
    }
}
