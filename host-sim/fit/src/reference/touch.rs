//! Frictionless penalty contact between the rigid probe and the surface: energy, residual, tangent
//! and force.
//!
//! The penalty acts on the gap g at seven points of each surface triangle: the energy is penalty/2
//! g^2 per rest area where g < 0.

use nalgebra::{Matrix3, Vector3};

use super::body::{Assembled, Body, Contact};
use super::probe::Gap;
use super::shape::{triangle_points, triangle_shape, triangle_slopes};

/// Contact pressure over Young's modulus that hardly any equilibrium exceeds (1).
const HIGHEST_PRESSURE: f64 = 3.0;

/// Force, penetration and area of the contact with the probe.
#[derive(Clone, Copy, Debug, Default)]
pub struct Touch {
    /// Force on the probe over Young's modulus, for the whole tissue and not only the piece [m^2].
    pub force_m2: Vector3<f64>,
    /// Largest penetration [m].
    pub penetration_m: f64,
    /// Rest area in contact, for the whole tissue [m^2].
    pub area_m2: f64,
}

/// Contact pressure at one point of the surface.
#[derive(Clone, Copy, Debug)]
pub struct Pressed {
    /// Position on the deformed surface [m].
    pub at_m: Vector3<f64>,
    /// Deformed area that the point represents, for the whole tissue [m^2].
    pub area_m2: f64,
    /// Pressure at the point over Young's modulus (1).
    pub pressure_over_e: f64,
}

/// A quadrature point of the surface that is inside the probe.
pub(super) struct Point<'a> {
    /// Nodes of the point's triangle.
    pub nodes: &'a [u32; 6],
    /// Shape functions at the point.
    pub shape: &'a [f64; 6],
    /// Index of the point in the quadrature rule, and its share of the triangle's area (1).
    rule: usize,
    share: f64,
    /// Rest area that the point represents [m^2].
    area_m2: f64,
    gap: Gap,
    penalty_per_m: f64,
}

impl Point<'_> {
    fn energy_m3(&self) -> f64 {
        0.5 * self.penalty_per_m * self.area_m2 * self.gap.gap_m * self.gap.gap_m
    }

    /// Gradient of the energy with respect to the point's displacement [m^2].
    pub fn push_m2(&self) -> Vector3<f64> {
        self.gap.normal * (self.penalty_per_m * self.area_m2 * self.gap.gap_m)
    }

    /// Second derivative of the energy [m], with or without the curvature of the probe; without it
    /// the contribution is never indefinite.
    pub fn stiffness_m(&self, curved: bool) -> Matrix3<f64> {
        // the curvature makes the tangent indefinite where the tissue has not yet followed a step,
        // so its contribution is bounded there
        let curved_m = if curved { self.gap.gap_m.max(-HIGHEST_PRESSURE / self.penalty_per_m) } else { 0.0 };
        let normal = self.gap.normal;
        (normal * normal.transpose() + self.gap.curvature_per_m * curved_m) * (self.penalty_per_m * self.area_m2)
    }
}

impl Body {
    pub(super) fn contact_energy_m3(&self, triangles: &[usize], displacement_m: &[Vector3<f64>], contact: &Contact) -> f64 {
        let mut energy_m3 = 0.0;
        self.each_touch(triangles, displacement_m, contact, |point| energy_m3 += point.energy_m3());
        energy_m3
    }

    pub(super) fn add_contact(
        &self,
        triangles: &[usize],
        displacement_m: &[Vector3<f64>],
        contact: &Contact,
        sum: &mut Assembled,
    ) {
        self.each_touch(triangles, displacement_m, contact, |point| {
            sum.energy_m3 += point.energy_m3();
            for (n, share) in point.nodes.iter().zip(point.shape) {
                sum.residual_m2[*n as usize] += point.push_m2() * *share;
            }
        });
        self.stiffen(triangles, displacement_m, contact, true, &mut sum.tangent);
    }

    /// Adds the second derivative of the contact energy to a tangent, with or without the curvature
    /// of the probe.
    pub(super) fn stiffen(
        &self,
        triangles: &[usize],
        displacement_m: &[Vector3<f64>],
        contact: &Contact,
        curved: bool,
        tangent: &mut [f64],
    ) {
        self.each_touch(triangles, displacement_m, contact, |point| {
            let block = point.stiffness_m(curved);
            for (a, i) in point.nodes.iter().enumerate() {
                for (b, j) in point.nodes[..=a].iter().enumerate() {
                    self.pattern.add(tangent, *i, *j, &(block * (point.shape[a] * point.shape[b])));
                }
            }
        });
    }

    /// Adds the gradient of the contact energy to the residual of all nodes.
    pub(super) fn add_push(
        &self,
        triangles: &[usize],
        displacement_m: &[Vector3<f64>],
        contact: &Contact,
        residual_m2: &mut [Vector3<f64>],
    ) {
        self.each_touch(triangles, displacement_m, contact, |point| {
            let push = point.push_m2();
            for (n, share) in point.nodes.iter().zip(point.shape) {
                residual_m2[*n as usize] += push * *share;
            }
        });
    }

    /// Returns force, penetration and contact area of the probe at the given displacements.
    #[must_use]
    pub fn touch(&self, displacement_m: &[Vector3<f64>], contact: &Contact) -> Touch {
        let mut touch = Touch::default();
        self.each_touch(&self.touchable, displacement_m, contact, |point| {
            touch.force_m2 += point.push_m2() * self.copies;
            touch.penetration_m = touch.penetration_m.max(-point.gap.gap_m);
            touch.area_m2 += point.area_m2 * self.copies;
        });
        touch
    }

    /// Returns the pressure at every quadrature point in contact, from which area and peak follow.
    #[must_use]
    pub fn pressed(&self, displacement_m: &[Vector3<f64>], contact: &Contact) -> Vec<Pressed> {
        let slopes = triangle_points().map(|(at, _)| triangle_slopes(at));
        let mut pressed = Vec::new();
        self.each_touch(&self.touchable, displacement_m, contact, |point| {
            let now = point.nodes.map(|n| self.mesh.nodes_m[n as usize] + displacement_m[n as usize]);
            let along = |slopes: &[[f64; 2]; 6], k: usize| (0..6).map(|n| now[n] * slopes[n][k]).sum::<Vector3<f64>>();
            let slopes = &slopes[point.rule];
            let area_m2 = 0.5 * along(slopes, 0).cross(&along(slopes, 1)).norm() * point.share;
            pressed.push(Pressed {
                at_m: (0..6).map(|n| now[n] * point.shape[n]).sum(),
                area_m2: area_m2 * self.copies,
                pressure_over_e: point.push_m2().norm() / area_m2,
            });
        });
        pressed
    }

    /// Smallest distance between the probe and the nodes and quadrature points of a triangle [m];
    /// negative inside the probe.
    pub(super) fn least_gap_m(&self, triangle: usize, displacement_m: &[Vector3<f64>], contact: &Contact) -> f64 {
        let now = self.mesh.triangles[triangle].map(|n| self.mesh.nodes_m[n as usize] + displacement_m[n as usize]);
        let points = triangle_points().map(|(at, _)| triangle_shape(at));
        let inside = points.iter().map(|shape| (0..6).map(|k| now[k] * shape[k]).sum::<Vector3<f64>>());
        now.into_iter().chain(inside).map(|x| contact.probe.gap(&x).gap_m).fold(f64::INFINITY, f64::min)
    }

    /// Calls `each` for every quadrature point of the given triangles that is inside the probe.
    pub(super) fn each_touch(
        &self,
        triangles: &[usize],
        displacement_m: &[Vector3<f64>],
        contact: &Contact,
        mut each: impl FnMut(&Point),
    ) {
        let rule = triangle_points().map(|(at, share)| (triangle_shape(at), share));
        for t in triangles {
            let nodes = &self.mesh.triangles[*t];
            let rest = nodes.map(|n| self.mesh.nodes_m[n as usize]);
            let area = 0.5 * (rest[1] - rest[0]).cross(&(rest[2] - rest[0])).norm();
            let now: [Vector3<f64>; 6] = std::array::from_fn(|k| rest[k] + displacement_m[nodes[k] as usize]);
            for (number, (shape, share)) in rule.iter().enumerate() {
                let x = (0..6).map(|k| now[k] * shape[k]).sum::<Vector3<f64>>();
                let gap = contact.probe.gap(&x);
                if gap.gap_m < 0.0 {
                    each(&Point {
                        nodes,
                        shape,
                        rule: number,
                        share: *share,
                        area_m2: share * area,
                        gap,
                        penalty_per_m: contact.penalty_per_m,
                    });
                }
            }
        }
    }
}
