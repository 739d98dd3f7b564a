//! A rigid disc glued to the tissue and moved slightly: its stiffness along the displacement, by
//! quadratic finite elements at rest.
//!
//! The mesh is refined towards the disc's edge, where the traction is singular (`r^-1/2`), and
//! surface edges that cross the edge are cut there, so that the glued triangles end on the circle.
//! Their nodes move with the disc, the anchors stay; at zero displacement the tangent of
//! [`super::body`] is that of linear elasticity. Three meshes are used, with the elements at the
//! edge halved each time; the remaining error is of first order there.

use nalgebra::Vector3;
use rayon::prelude::*;
use thiserror::Error;

use super::body::{Body, Stiffness};
use super::nearest::nearest;
use super::quadratic::QuadraticMesh;
use super::refine::refine;
use super::shape::TetRule;
use palpate_tissue::mesh::TetMesh;

mod circle;

/// Growth of the longest edge per distance from there.
const GROWTH: f64 = 0.6;
/// Largest number of corner nodes of a refined mesh.
const MOST_NODES: usize = 20_000;
/// Tolerance for the parts of a refined surface triangle [m].
const SAME_M: f64 = 1e-9;

/// Why a glued disc has no reference.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum GluedError {
    /// No whole triangle is glued.
    #[error("no surface lies within {radius_m} m of the place of the glued disc: move it onto the surface that faces the probe")]
    Off {
        /// The disc's radius [m].
        radius_m: f64,
    },
    /// The tissue has no support against the disc.
    #[error("the tissue under the glued disc has no anchors: anchor at least one of its surface triangles")]
    Loose,
    /// A tet is inside out or a stiffness is not positive.
    #[error(
        "the stiffness of the tissue under the glued disc is not positive: check the mesh, and stay below Poisson's ratio 0.5"
    )]
    Unsound,
    /// The factor does not fit.
    #[error("not enough memory for the reference of the glued disc: take a coarser mesh")]
    Memory,
}

/// A glued disc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// Centre of the disc, on the surface [m].
    pub place_m: Vector3<f64>,
    /// Outward unit normal of the surface there: triangles that face the other way are not glued.
    pub axis: Vector3<f64>,
    /// Its radius [m]: all surface within it of the centre is glued.
    pub radius_m: f64,
}

/// Stiffness along some directions, and its accuracy.
#[derive(Clone, Debug, PartialEq)]
pub struct GluedStiffness {
    /// Force along the direction over E, per displacement [m], extrapolated to vanishing elements,
    /// shape \[directions\].
    pub limit_m: Vec<f64>,
    /// Force along the direction over E, per displacement [m], on each mesh, shape \[meshes\]
    /// [directions].
    pub levels_m: Vec<Vec<f64>>,
    /// Nodes of each quadratic mesh.
    pub nodes: Vec<usize>,
}

/// Solves on one mesh for every edge length in `edges` (in disc radii, each half the one before)
/// and extrapolates from the last two. `stiffness` is called with a tet of `mesh` and a point in it
/// [m]; `anchors` are nodes of `mesh`.
///
/// # Errors
/// [`GluedError`].
pub fn glued_stiffness(
    mesh: &TetMesh,
    stiffness: impl Fn(usize, &Vector3<f64>) -> Stiffness,
    anchors: &[u32],
    disc: &Disc,
    directions: &[Vector3<f64>],
    edges: &[f64],
) -> Result<GluedStiffness, GluedError> {
    let (mut levels_m, mut nodes): (Vec<Vec<f64>>, Vec<usize>) = (Vec::new(), Vec::new());
    for edge in edges {
        let (level, count) = on_one_mesh(mesh, &stiffness, anchors, disc, directions, edge * disc.radius_m)?;
        levels_m.push(level);
        nodes.push(count);
    }
    let limit_m = match levels_m.as_slice() {
        [.., before, last] => last.iter().zip(before).map(|(f, c)| 2.0 * f - c).collect(),
        only => only.first().cloned().unwrap_or_default(),
    };
    Ok(GluedStiffness { limit_m, levels_m, nodes })
}

fn on_one_mesh(
    mesh: &TetMesh,
    stiffness: &impl Fn(usize, &Vector3<f64>) -> Stiffness,
    anchors: &[u32],
    disc: &Disc,
    directions: &[Vector3<f64>],
    edge_m: f64,
) -> Result<(Vec<f64>, usize), GluedError> {
    // tets are identified by their origin; a surface is anchored where all corners are, before and
    // after refinement
    let mut own = mesh.clone();
    own.regions = (0..own.tets.len() as u32).collect();
    let coarse = QuadraticMesh::new(&own);
    let mut anchor = vec![false; own.nodes_m.len()];
    anchors.iter().for_each(|n| anchor[*n as usize] = true);
    let anchored: Vec<usize> =
        (0..coarse.triangles.len()).filter(|t| coarse.triangles[*t][..3].iter().all(|n| anchor[*n as usize])).collect();
    let longest_m = |x: [f64; 3]| edge_m + GROWTH * disc.edge_distance_m(&Vector3::from(x));
    let fine = refine(&own, longest_m, MOST_NODES.max(mesh.nodes_m.len()));
    let fine = circle::cut(&fine, disc);
    let regions = fine.regions.clone();
    let quadratic = QuadraticMesh::new(&fine);
    let (mut fixed, mut glued) = (vec![false; quadratic.nodes_m.len()], vec![false; quadratic.nodes_m.len()]);
    anchors.iter().for_each(|n| fixed[*n as usize] = true);
    for triangle in &quadratic.triangles {
        let corners = [0, 1, 2].map(|k| quadratic.nodes_m[triangle[k] as usize]);
        if nearest(&coarse, anchored.iter().copied(), &(corners.iter().sum::<Vector3<f64>>() / 3.0), SAME_M).is_some() {
            triangle.iter().for_each(|n| fixed[*n as usize] = true);
        } else if disc.covers(&corners) {
            triangle.iter().for_each(|n| glued[*n as usize] = true);
        }
    }
    if !glued.iter().any(|g| *g) {
        return Err(GluedError::Off { radius_m: disc.radius_m });
    }
    if !fixed.iter().any(|f| *f) {
        return Err(GluedError::Loose);
    }
    let held = fixed.iter().zip(&glued).map(|(f, g)| [*f || *g; 3]).collect();
    let body = Body::with_stiffness(quadratic, |t, x| stiffness(regions[t] as usize, x), held, Vec::new(), 1.0, TetRule::Four);
    let rest = vec![Vector3::zeros(); body.mesh.nodes_m.len()];
    let tangent = body.assemble(&rest, None).ok_or(GluedError::Unsound)?.tangent;
    let mut kept = tangent.clone();
    body.pattern.fix(&mut kept, &body.fixed);
    let mut factor = body.pattern.analyse(&[]).ok_or(GluedError::Memory)?;
    if !factor.factorise(&kept) {
        return Err(GluedError::Unsound);
    }
    let along = |direction: &Vector3<f64>| {
        let direction = direction.normalize();
        let mut u: Vec<_> = fixed.iter().zip(&glued).map(|(f, g)| if *g && !*f { direction } else { Vector3::zeros() }).collect();
        let pull = body.pattern.multiply(&tangent, &u);
        let mut right: Vec<f64> =
            pull.iter().zip(&body.fixed).flat_map(|(p, f)| (0..3).map(|k| if f[k] { 0.0 } else { -p[k] })).collect();
        factor.solve(&mut right);
        u.iter_mut().zip(right.chunks(3)).for_each(|(u, r)| *u += Vector3::new(r[0], r[1], r[2]));
        let force = body.pattern.multiply(&tangent, &u);
        // on the glued nodes alone: the force on the disc, not twice the energy
        force.iter().zip(&glued).filter(|(_, g)| **g).map(|(f, _)| f.dot(&direction)).sum()
    };
    Ok((directions.par_iter().map(along).collect(), body.mesh.nodes_m.len()))
}

impl Disc {
    /// Distance to the disc's edge [m].
    fn edge_distance_m(&self, x: &Vector3<f64>) -> f64 {
        let arm = x - self.place_m;
        let height = arm.dot(&self.axis);
        ((arm - self.axis * height).norm() - self.radius_m).hypot(height)
    }

    /// Distance of a surface point outside the disc [m].
    fn outside_m(&self, x: &Vector3<f64>) -> f64 {
        (x - self.place_m).norm() - self.radius_m
    }

    /// Whether a surface triangle that the edge does not cross is glued.
    fn covers(&self, corners: &[Vector3<f64>; 3]) -> bool {
        let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
        normal.dot(&self.axis) > 0.0 && corners.iter().all(|x| self.outside_m(x) <= circle::ON_EDGE * self.radius_m)
    }
}
