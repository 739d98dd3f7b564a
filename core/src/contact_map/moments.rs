//! Sums over the contact, and the map that follows from them.

use nalgebra::Vector3;

use super::ContactMap;
use crate::lanes::sqrt;

/// Sums over parts of the surface, relative to the probe's centre.
#[derive(Default)]
pub(super) struct Moments {
    /// Area [m^2] and its first moment [m^3].
    area: f32,
    area_at: Vector3<f32>,
    /// Second moments of the area, xx, yy, zz and yz, zx, xy [m^4].
    squares: Vector3<f32>,
    products: Vector3<f32>,
    /// Push over E [m^2], its first moment [m^3], and its vector on the tissue [m^2].
    push: f32,
    push_at: Vector3<f32>,
    force: Vector3<f32>,
    /// Friction over E on the tissue [m^2], and the moment of push and friction [m^3].
    friction: Vector3<f32>,
    moment: Vector3<f32>,
    /// Largest pressure over E (1), and how many triangles push.
    peak: f32,
    triangles: u16,
}

impl Moments {
    pub(super) fn add_area(&mut self, at: Vector3<f32>, area: f32) {
        self.area += area;
        self.area_at += at * area;
        self.squares += at.component_mul(&at) * area;
        self.products += Vector3::new(at.y * at.z, at.z * at.x, at.x * at.y) * area;
    }

    pub(super) fn add_push(&mut self, at: Vector3<f32>, out: Vector3<f32>, push: f32) {
        self.push += push;
        self.push_at += at * push;
        self.force += out * push;
        self.moment += at.cross(&out) * push;
    }

    pub(super) fn add_friction(&mut self, at: Vector3<f32>, friction: Vector3<f32>) {
        self.friction += friction;
        self.moment += at.cross(&friction);
    }

    /// Counts a triangle that pushes, with its pressure over E (1).
    pub(super) fn add_triangle(&mut self, pressure: f32) {
        self.peak = if pressure > self.peak { pressure } else { self.peak };
        self.triangles += 1;
    }

    /// Computes the map of a contact; the sums are relative to the probe's centre [m].
    pub(super) fn map(&self, centre_m: Vector3<f32>, tip_m: Vector3<f32>, modulus_pa: f32) -> ContactMap {
        let square = self.force.dot(&self.force);
        // a contact that is pushed from both sides has no plane; a NaN is not above zero either
        if !(square > 0.0 && self.push > 0.0 && self.area > 0.0) {
            return ContactMap::NONE;
        }
        let normal = self.force * (-1.0 / sqrt(square));
        let (axes, half_lengths_m) = self.ellipse(normal);
        ContactMap {
            area_m2: self.area,
            centre_m: centre_m + self.push_at * (1.0 / self.push),
            force_n: self.force * -modulus_pa,
            friction_n: self.friction * -modulus_pa,
            torque_nm: (self.moment + (centre_m - tip_m).cross(&(self.force + self.friction))) * -modulus_pa,
            axes,
            half_lengths_m,
            peak_pressure_pa: self.peak * modulus_pa,
            triangles: self.triangles,
        }
    }

    /// Axes and semi-axes [m] of the ellipse across `normal` that has the second moments of the
    /// area: the variance along an axis is a quarter of the semi-axis squared.
    fn ellipse(&self, normal: Vector3<f32>) -> ([Vector3<f32>; 2], [f32; 2]) {
        let aside = if normal.x * normal.x < 0.5 { Vector3::x() } else { Vector3::y() };
        let u = aside - normal * normal.dot(&aside);
        let u = u * (1.0 / sqrt(u.dot(&u)));
        let v = normal.cross(&u);
        let (uu, vv, uv) = (self.variance(u, u), self.variance(v, v), self.variance(u, v));
        let (middle, half) = (0.5 * (uu + vv), 0.5 * (uu - vv));
        let spread = sqrt(half * half + uv * uv);
        // of the two forms of the eigenvector, the one without cancellation
        let (along, across) = if half > 0.0 { (half + spread, uv) } else { (uv, spread - half) };
        let length = sqrt(along * along + across * across);
        // a circle has no longer axis: any will do
        let (cos, sin) = if length > 0.0 { (along / length, across / length) } else { (1.0, 0.0) };
        let half_length = |variance: f32| if variance > 0.0 { 2.0 * sqrt(variance) } else { 0.0 };
        ([u * cos + v * sin, v * cos - u * sin], [half_length(middle + spread), half_length(middle - spread)])
    }

    /// Covariance of the area along two directions [m^2].
    fn variance(&self, a: Vector3<f32>, b: Vector3<f32>) -> f32 {
        let [s, p] = [self.squares, self.products];
        let second = a.component_mul(&b).dot(&s)
            + (a.y * b.z + a.z * b.y) * p.x
            + (a.z * b.x + a.x * b.z) * p.y
            + (a.x * b.y + a.y * b.x) * p.z;
        let per_area = 1.0 / self.area;
        (second - self.area_at.dot(&a) * self.area_at.dot(&b) * per_area) * per_area
    }
}

#[cfg(test)]
mod tests {
    use super::super::ZERO;
    use super::*;

    #[test]
    fn an_ellipse_has_its_own_half_axes() {
        let mut sum = Moments::default();
        let long = Vector3::new(0.6, 0.8, 0.0);
        let wide = Vector3::new(-0.8, 0.6, 0.0);
        for (i, j) in (-30..=30_i8).flat_map(|i| (-30..=30_i8).map(move |j| (i, j))) {
            let (x, y) = (f32::from(i) / 30.0, f32::from(j) / 30.0);
            if x * x + y * y < 1.0 {
                let at = Vector3::new(2e-3, -1e-3, -5e-3) + long * (6e-3 * x) + wide * (3e-3 * y);
                sum.add_area(at, 1e-9);
                sum.add_push(at, -Vector3::z(), 1e-9);
            }
        }
        let map = sum.map(ZERO, Vector3::new(2e-3, 0.0, 0.0), 1e3);
        let [a, b] = map.half_lengths_m;
        assert!((a / 6e-3 - 1.0).abs() < 5e-3 && (b / 3e-3 - 1.0).abs() < 5e-3, "{a} {b}");
        assert!(map.axes[0].dot(&long).abs() > 0.9999 && map.axes[1].dot(&wide).abs() > 0.9999, "{:?}", map.axes);
        assert!((map.centre_m - Vector3::new(2e-3, -1e-3, -5e-3)).norm() < 1e-6, "{}", map.centre_m);
        assert!(map.force_n.z > 0.0);
        // the force at (0, -1, -5) mm from the tip
        let torque_nm = Vector3::new(-1e-3 * map.force_n.z, 0.0, 0.0);
        assert!((map.torque_nm - torque_nm).norm() < 1e-3 * torque_nm.norm(), "{}", map.torque_nm);
    }

    #[test]
    fn nothing_is_an_empty_map() {
        assert_eq!(Moments::default().map(ZERO, ZERO, 1e3), ContactMap::NONE);
    }
}
