//! Several organs in one mesh, and the change of the volume of each under a deformation.

use std::ops::Range;

use nalgebra::{Matrix3, Vector3};

use palpate_fit::reference::quadratic::QuadraticMesh;
use palpate_fit::reference::shape::{TetRule, tet_gradients, tet_slopes};

/// Ranges of one organ in a mesh of several organs that share no nodes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Organ {
    /// Range of the organ's nodes.
    pub nodes: Range<usize>,
    /// Range of the organ's tets.
    pub tets: Range<usize>,
    /// Range of the triangles on the organ's surface.
    pub triangles: Range<usize>,
}

/// Volume of an organ at rest and deformed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Volume {
    /// Volume at rest [m^3].
    pub rest_m3: f64,
    /// Present volume [m^3].
    pub now_m3: f64,
    /// Smallest local volume ratio J at the quadrature points (1).
    pub least_j: f64,
}

/// Combines meshes into one; the nodes, tets and triangles of each keep their order.
pub fn join(meshes: &[QuadraticMesh]) -> (QuadraticMesh, Vec<Organ>) {
    let mut all = QuadraticMesh { nodes_m: vec![], tets: vec![], triangles: vec![] };
    let mut organs = Vec::with_capacity(meshes.len());
    for mesh in meshes {
        let (nodes, tets, triangles) = (all.nodes_m.len(), all.tets.len(), all.triangles.len());
        all.nodes_m.extend_from_slice(&mesh.nodes_m);
        all.tets.extend(mesh.tets.iter().map(|t| t.map(|n| n + nodes as u32)));
        all.triangles.extend(mesh.triangles.iter().map(|t| t.map(|n| n + nodes as u32)));
        organs.push(Organ {
            nodes: nodes..all.nodes_m.len(),
            tets: tets..all.tets.len(),
            triangles: triangles..all.triangles.len(),
        });
    }
    (all, organs)
}

impl Organ {
    /// The organ that consists of a whole mesh.
    pub fn whole(mesh: &QuadraticMesh) -> Self {
        Self { nodes: 0..mesh.nodes_m.len(), tets: 0..mesh.tets.len(), triangles: 0..mesh.triangles.len() }
    }

    /// Volume of the organ under displacements of the mesh's nodes [m].
    pub fn volume(&self, mesh: &QuadraticMesh, displacement_m: &[Vector3<f64>]) -> Volume {
        // J is cubic within a tet, and this rule integrates it exactly
        let rule = TetRule::Eleven.points();
        let mut sum = Volume { rest_m3: 0.0, now_m3: 0.0, least_j: f64::INFINITY };
        for tet in &mesh.tets[self.tets.clone()] {
            let (slopes, volume_m3) = tet_slopes([0, 1, 2, 3].map(|k| mesh.nodes_m[tet[k] as usize]));
            sum.rest_m3 += volume_m3;
            for (at, share) in &rule {
                let parts = tet.iter().zip(tet_gradients(*at, &slopes));
                let slope: Matrix3<f64> = parts.map(|(n, g)| displacement_m[*n as usize] * g.transpose()).sum();
                let j = (Matrix3::identity() + slope).determinant();
                sum.now_m3 += share * volume_m3 * j;
                sum.least_j = sum.least_j.min(j);
            }
        }
        sum
    }
}
