//! A rigid disc glued to the tissue and moved slightly: its stiffness along the displacement, by
//! quadratic finite elements linearised about rest.
//!
//! The mesh is refined towards the edge of the disc, where the traction is singular (`r^-1/2`).
//! Edges of the surface that cross the edge of the disc are cut there, so that the glued triangles
//! end on the circle. Their nodes move with the disc, and the anchors are fixed. At zero
//! displacement the tangent of [`super::body`] is that of linear elasticity. A sequence of meshes
//! is solved, in which the elements at the edge are halved each time, because the error is of first
//! order in their size.

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

/// Growth of the longest edge per distance from the edge of the disc (1).
const GROWTH: f64 = 0.6;
/// Maximum number of corner nodes of a refined mesh.
const MOST_NODES: usize = 20_000;
/// Distance up to which a refined surface triangle counts as part of a coarse one [m].
const SAME_M: f64 = 1e-9;

/// Reason why a glued disc has no reference.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum GluedError {
    /// No surface triangle is completely inside the disc.
    #[error("no surface lies within {radius_m} m of the place of the glued disc: move it onto the surface that faces the probe")]
    Off {
        /// Radius of the disc [m].
        radius_m: f64,
    },
    /// The tissue is not supported against the force of the disc.
    #[error("the tissue under the glued disc has no anchors: anchor at least one of its surface triangles")]
    Loose,
    /// A tet is inverted, or the stiffness is not positive definite.
    #[error(
        "the stiffness of the tissue under the glued disc is not positive: check the mesh, and stay below Poisson's ratio 0.5"
    )]
    Unsound,
    /// The factor does not fit into memory.
    #[error("not enough memory for the reference of the glued disc: take a coarser mesh")]
    Memory,
}

/// A rigid disc that is glued to the surface of the tissue.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// Centre of the disc, on the surface [m].
    pub place_m: Vector3<f64>,
    /// Outward unit normal of the surface at the centre; triangles that face the other way are not
    /// glued.
    pub axis: Vector3<f64>,
    /// Radius of the disc [m]; all of the surface within this distance of the centre is glued.
    pub radius_m: f64,
}

/// Stiffness of a glued disc along several directions, on several meshes.
#[derive(Clone, Debug, PartialEq)]
pub struct GluedStiffness {
    /// Force along the direction over E, divided by the displacement [m], extrapolated to vanishing
    /// element size, shape \[directions\].
    pub limit_m: Vec<f64>,
    /// Force along the direction over E, divided by the displacement [m], on each mesh, shape
    /// \[meshes\] [directions].
    pub levels_m: Vec<Vec<f64>>,
    /// Number of nodes of each quadratic mesh.
    pub nodes: Vec<usize>,
}

/// Solves one mesh for every edge length in `edges` (in disc radii, each half of the previous one),
/// and extrapolates from the last two. `stiffness` is called with a tet of `mesh` and a point in it
/// [m]; `anchors` are nodes of `mesh`.
///
/// # Errors
/// See [`GluedError`].
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
    // each refined tet is identified with the tet from which it came; a refined surface triangle is
    // anchored if it is part of a coarse triangle whose corners are all anchored
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
        // only forces on the glued nodes count: this is the force on the disc, not twice the energy
        force.iter().zip(&glued).filter(|(_, g)| **g).map(|(f, _)| f.dot(&direction)).sum()
    };
    Ok((directions.par_iter().map(along).collect(), body.mesh.nodes_m.len()))
}

impl Disc {
    /// Distance of a point from the edge of the disc [m].
    fn edge_distance_m(&self, x: &Vector3<f64>) -> f64 {
        let arm = x - self.place_m;
        let height = arm.dot(&self.axis);
        ((arm - self.axis * height).norm() - self.radius_m).hypot(height)
    }

    /// Distance of a surface point from the edge of the disc [m]; negative inside.
    fn outside_m(&self, x: &Vector3<f64>) -> f64 {
        (x - self.place_m).norm() - self.radius_m
    }

    /// Whether a surface triangle that does not cross the edge of the disc is glued.
    fn covers(&self, corners: &[Vector3<f64>; 3]) -> bool {
        let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
        normal.dot(&self.axis) > 0.0 && corners.iter().all(|x| self.outside_m(x) <= circle::ON_EDGE * self.radius_m)
    }
}
