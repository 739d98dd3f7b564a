//! Meshless total-Lagrangian explicit dynamics (Horton, Wittek, Joldes and Miller 2010):
//! moving-least-squares shape functions of the rest positions, integrated in background cells.
//!
//! `F = 1 + sum_n u_n grad phi_n`, neo-Hookean stress P as in [`super::NeoHookean`], `f_n -= V P
//! grad phi_n`. The tets serve as cells, with one stress in each. Our version differs in two
//! points, because on meshes as coarse as these the plain form is wrong. The rms force errors
//! quoted below are those at 57 and 130 nodes; our version has 10 and 7 %:
//!
//! * gradients are means over a cell, computed from its faces by the divergence theorem (Chen et
//!   al. 2001, there over nodal cells). Neighbours share faces, so a uniform stress gives exactly
//!   the boundary forces, and linear fields stay exact. Gradients taken at the centroid do not
//!   integrate to the boundary: the errors are 17 and 23 %, and at 57 nodes a press of 8 mm turns
//!   tets inside out;
//! * the weight function makes the field nearly interpolate the nodal values, to within 1e-10 m
//!   (see [`super::ShapeFunctions`]), so that contact and anchors, which act on nodal values, act
//!   on the field. With the paper's quartic spline they act on parameters that the field smooths
//!   away: the errors are 65 and 24 %, all of them too soft.
//!
//! The volume term is evaluated per cell: averaged over nodes, as linear tets need it, it is too
//! soft here (26 and 16 %).
//!
//! The result remains too soft. On coarse meshes one cause is that contact treats the surface
//! between nodes as flat, whereas the field is curved: in a press of 4 mm, within 8 mm of the axis,
//! the centres of triangles are on average 0.48, 0.09 and 0.00 mm less deep in the field than on
//! the flat triangles at 57, 130 and 410 nodes. The remaining 7 % at 410 nodes have another cause.
//! The method is limited by its cost: a cell has 26 nodes instead of 4.

use palpate::Vector3;

use super::Block;
use super::moving_least_squares::{FACES, ShapeFunctions, summed};
use super::on_core::Law;
use super::rest_tet::{Matrix, cofactors};
use palpate_tissue::error::Error;

/// Reach of a node, divided by the distance of its farthest integration point (1). A value of 1.2
/// takes up to a third more time and changes the error from 10.5 to 12.2 % at 57 nodes and from 7.4
/// to 6.2 % at 130.
const REACH: f64 = 1.05;

/// Contribution of a node to a cell.
#[derive(Clone, Copy, Debug)]
struct Part {
    node: u32,
    /// Mean gradient of the node's shape function [1/m].
    gradient: Vector3<f32>,
}

/// An integration cell.
#[derive(Clone, Copy, Debug)]
struct Cell {
    /// End of the cell's range in `parts`, which begins where that of the previous cell ends.
    end: usize,
    /// Volume of the cell, times its stiffness as a multiple of the tissue's [m^3].
    stiff_volume_m3: f32,
}

/// Cells with their gradients, computed at rest, and the state of a tick.
#[derive(Clone, Debug)]
pub struct Meshless {
    cells: Vec<Cell>,
    parts: Vec<Part>,
    rest_m: Vec<Vector3<f32>>,
    displacement_m: Vec<Vector3<f32>>,
    diagonal_m: Vec<f32>,
    lambda: f32,
    mu: f32,
}

impl Meshless {
    /// Floating-point operations per cell, counted in this file; a logarithm counts as 20.
    pub const FLOPS_PER_CELL: f64 = 95.0;
    /// Floating-point operations per node of a cell.
    pub const FLOPS_PER_PART: f64 = 36.0;

    /// Creates the method at rest.
    pub fn new(block: &Block) -> Result<Self, Error> {
        let mesh = &block.tissue.mesh;
        let shape = ShapeFunctions::new(mesh, REACH);
        let (mut cells, mut parts) = (Vec::with_capacity(mesh.tets.len()), Vec::new());
        for (tet, ratio) in mesh.tets.iter().zip(&block.tissue.stiffness_ratio) {
            let corners_m = tet.map(|n| Vector3::from(mesh.nodes_m[n as usize]));
            let [a, b, c, d] = corners_m;
            let volume_m3 = (b - a).dot(&(c - a).cross(&(d - a))) / 6.0;
            let mut gradients = Vec::new();
            for face in FACES {
                let [a, b, c] = face.map(|k| corners_m[k]);
                let area_over_volume = (b - a).cross(&(c - a)) * (0.5 / volume_m3);
                gradients.extend(shape.mean(&[a, b, c])?.into_iter().map(|(n, phi)| (n, area_over_volume * phi)));
            }
            parts.extend(summed(gradients).into_iter().map(|(node, g)| Part { node, gradient: g.cast() }));
            cells.push(Cell { end: parts.len(), stiff_volume_m3: (volume_m3 * ratio) as f32 });
        }
        let (lambda, mu) = block.lame_over_modulus();
        let rest_m: Vec<Vector3<f32>> = mesh.nodes_m.iter().map(|x| Vector3::from(*x).cast()).collect();
        let diagonal_m = diagonal_m(&cells, &parts, rest_m.len(), (lambda + 4.0 * mu) as f32 / 3.0);
        Ok(Self {
            cells,
            parts,
            displacement_m: vec![Vector3::zeros(); rest_m.len()],
            rest_m,
            diagonal_m,
            lambda: lambda as f32,
            mu: mu as f32,
        })
    }

    /// Sum of the numbers of nodes over all cells.
    pub fn parts(&self) -> usize {
        self.parts.len()
    }
}

impl Law for Meshless {
    fn forces(&mut self, position_m: &[Vector3<f32>], force: &mut [Vector3<f32>]) {
        // displacements, because sums of the positions themselves over this many nodes would lose
        // one more digit
        for ((u, x), rest) in self.displacement_m.iter_mut().zip(position_m).zip(&self.rest_m) {
            *u = x - rest;
        }
        force.fill(Vector3::zeros());
        let mut begin = 0;
        for cell in &self.cells {
            let parts = &self.parts[begin..cell.end];
            begin = cell.end;
            let mut f: Matrix = [Vector3::x(), Vector3::y(), Vector3::z()];
            for part in parts {
                let u = &self.displacement_m[part.node as usize];
                f[0] += part.gradient * u.x;
                f[1] += part.gradient * u.y;
                f[2] += part.gradient * u.z;
            }
            let (cofactors, j) = cofactors(&f);
            let pressure = (self.lambda * j.ln() - self.mu) / j;
            let stress = [0, 1, 2].map(|k| (f[k] * self.mu + cofactors[k] * pressure) * cell.stiff_volume_m3);
            for part in parts {
                let on = &mut force[part.node as usize];
                on.x -= stress[0].dot(&part.gradient);
                on.y -= stress[1].dot(&part.gradient);
                on.z -= stress[2].dot(&part.gradient);
            }
        }
    }

    fn diagonal_m(&self) -> &[f32] {
        &self.diagonal_m
    }
}

/// Mean diagonal stiffness over E of each node [m]: the sum of `V (lambda + 4 mu) |g|^2 / 3` over
/// its cells, as for tets.
fn diagonal_m(cells: &[Cell], parts: &[Part], nodes: usize, modulus: f32) -> Vec<f32> {
    let mut diagonal = vec![0.0_f32; nodes];
    let mut begin = 0;
    for cell in cells {
        for part in &parts[begin..cell.end] {
            diagonal[part.node as usize] += modulus * cell.stiff_volume_m3 * part.gradient.norm_squared();
        }
        begin = cell.end;
    }
    diagonal
}
