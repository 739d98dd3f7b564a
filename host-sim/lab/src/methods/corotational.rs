//! Corotational linear tets (Müller and Gross 2004; Etzmuss et al. 2003): linear elasticity in a
//! frame that rotates with the tet.
//!
//! `P = 2 mu (F - R) + lambda tr(R^T F - 1) R`, the exact gradient of `mu |F - R|^2 + lambda/2
//! tr(R^T F - 1)^2` when R is the rotation of F. R is stored as a quaternion and follows F by the
//! warm-started iteration of Müller et al. 2016 ("A robust method to extract the rotational part of
//! deformations"), so that tets that were turned inside out recover. Ours differs in two points: it
//! rotates by the tangent of the quaternion instead of its exponential, which needs no sine, and by
//! 3/2 of their angle, which is Newton's step at small strains.

use palpate::Vector3;

use super::Block;
use super::on_core::Law;
use super::rest_tet::{Matrix, RestTet, diagonal_m};

/// Largest number of rotations in one evaluation; a slow press needs one.
const TURNS: usize = 4;
/// Squared angle below which no further rotation is applied [rad^2]. The remaining error, of the
/// order of the angle times the strain, is removed in the next substep.
const LAST: f32 = 1e-6;
/// Squared angle below which a rotation is skipped [rad^2]: the stress error is of the order of mu
/// times the angle.
const NONE: f32 = 1e-11;

/// Quaternion (w, x, y, z).
type Quaternion = [f32; 4];

/// Rest data and the rotation of every tet.
#[derive(Clone, Debug)]
pub struct Corotational {
    tets: Vec<RestTet>,
    rotation: Vec<Quaternion>,
    diagonal_m: Vec<f32>,
    lambda: f32,
    mu: f32,
}

impl Corotational {
    /// Floating-point operations per tet with one rotation, counted in this file.
    pub const FLOPS_PER_TET: f64 = 310.0;

    /// Creates the method at rest.
    pub fn new(block: &Block) -> Self {
        let tets = RestTet::of(block);
        let (lambda, mu) = block.lame_over_modulus();
        Self {
            rotation: vec![[1.0, 0.0, 0.0, 0.0]; tets.len()],
            diagonal_m: diagonal_m(block, &tets, lambda, mu),
            tets,
            lambda: lambda as f32,
            mu: mu as f32,
        }
    }
}

impl Law for Corotational {
    fn forces(&mut self, position_m: &[Vector3<f32>], force: &mut [Vector3<f32>]) {
        force.fill(Vector3::zeros());
        for (tet, q) in self.tets.iter().zip(&mut self.rotation) {
            let f = tet.deformation(position_m);
            let r = follow(q, &f);
            let trace = f[0].dot(&r[0]) + f[1].dot(&r[1]) + f[2].dot(&r[2]) - 3.0;
            let (shear, bulk) = (2.0 * self.mu * tet.stiffness_ratio, self.lambda * tet.stiffness_ratio);
            let spherical = bulk * trace - shear;
            let stress = [0, 1, 2].map(|k| f[k] * shear + r[k] * spherical);
            tet.scatter(&stress, force);
        }
    }

    fn diagonal_m(&self) -> &[f32] {
        &self.diagonal_m
    }
}

/// Turns `q` towards the rotation of `f` and returns the rows of its matrix.
#[inline(always)]
fn follow(q: &mut Quaternion, f: &Matrix) -> Matrix {
    let f_columns = [0, 1, 2].map(|k| Vector3::new(f[0][k], f[1][k], f[2][k]));
    let mut r = columns(q);
    for _ in 0..TURNS {
        let torque = r[0].cross(&f_columns[0]) + r[1].cross(&f_columns[1]) + r[2].cross(&f_columns[2]);
        let along = r[0].dot(&f_columns[0]) + r[1].dot(&f_columns[1]) + r[2].dot(&f_columns[2]);
        let turn = torque * (1.5 / (along.abs() + 1e-9));
        let square = turn.norm_squared();
        if square < NONE {
            break;
        }
        *q = turned(q, &turn);
        r = columns(q);
        if square < LAST {
            break;
        }
    }
    [0, 1, 2].map(|k| Vector3::new(r[0][k], r[1][k], r[2][k]))
}

/// Returns `(1, turn/2) q`, normalised.
#[inline(always)]
fn turned(q: &Quaternion, turn: &Vector3<f32>) -> Quaternion {
    let ([w, x, y, z], h) = (*q, turn * 0.5);
    let p = [
        w - h.x * x - h.y * y - h.z * z,
        x + h.x * w + h.y * z - h.z * y,
        y + h.y * w + h.z * x - h.x * z,
        z + h.z * w + h.x * y - h.y * x,
    ];
    let scale = 1.0 / p.iter().map(|c| c * c).sum::<f32>().sqrt();
    p.map(|c| c * scale)
}

/// Columns of the rotation matrix of a unit quaternion.
#[inline(always)]
fn columns([w, x, y, z]: &Quaternion) -> Matrix {
    let (xx, yy, zz) = (x * x, y * y, z * z);
    let (xy, xz, yz, wx, wy, wz) = (x * y, x * z, y * z, w * x, w * y, w * z);
    [
        Vector3::new(1.0 - 2.0 * (yy + zz), 2.0 * (xy + wz), 2.0 * (xz - wy)),
        Vector3::new(2.0 * (xy - wz), 1.0 - 2.0 * (xx + zz), 2.0 * (yz + wx)),
        Vector3::new(2.0 * (xz + wy), 2.0 * (yz - wx), 1.0 - 2.0 * (xx + yy)),
    ]
}
