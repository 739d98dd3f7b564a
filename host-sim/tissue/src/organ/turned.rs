//! Meshes any closed shape on a lattice that is aligned with the surface at a place.
//!
//! The lattice's densest planes, `(110)`, consist of whole faces of its tets. If one of them is
//! turned so that it is tangent to the surface at the place, a flat surface there cuts no tets, and
//! a curved one cuts them only slightly.

use nalgebra::Matrix3;

use super::balls::Balls;
use super::lattice::{Lattice, NEIGHBOURS, Refusal};
use super::parts::V3;
use super::{Fine, OrganError, stuffing};
use crate::mesh::TetMesh;

/// A lattice that is aligned with a surface and finest at a place on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turned {
    /// Place where the lattice is finest, and how its cubes grow from there.
    pub fine: Fine,
    /// Outward unit normal of the surface at the place.
    pub axis: [f64; 3],
    /// Largest length of an element along a ray from the place [m].
    pub coarsest_m: f64,
}

/// How a lattice stands on the surface at the place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stance {
    /// With whole faces of its tets in the surface.
    Face,
    /// With an edge of its cubes along the normal: a tip that is narrower than the angle between
    /// edges would have no node below it otherwise, and be cut off.
    Edge,
}

/// Cost of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Expected {
    /// About the number of its nodes.
    pub nodes: f64,
    /// Number of points of the lattice, to which the time is proportional; the largest number there
    /// is if the lattice does not fit into memory.
    pub points: usize,
}

/// Share of the cut edges of a lattice that leave a node: the others are drawn onto points (1).
const CUT_NODES: f64 = 0.3;
/// Number of samples of a lattice.
const SAMPLES: u32 = 8192;

impl Turned {
    /// Meshes the shape where `implicit_m` is negative, which must lie within `bounds_m`. Every tet
    /// is positively oriented, the mesh is one piece, every node belongs to a tet, and all regions
    /// are 0. `name` is used in messages.
    ///
    /// # Errors
    /// A size that is out of range, or a spacing too coarse for the shape or too fine for memory.
    pub fn mesh(&self, name: &str, implicit_m: &dyn Fn([f64; 3]) -> f64, bounds_m: [[f64; 3]; 2]) -> Result<TetMesh, OrganError> {
        self.mesh_with(name, (implicit_m, false), bounds_m, Stance::Face)
    }

    /// Meshes the shape as [`Self::mesh`] does, on a lattice of the given stance. `is_distance`
    /// says that the implicit function is the distance, which saves most of its evaluations.
    ///
    /// # Errors
    /// Errors of [`Self::mesh`].
    pub fn mesh_with(
        &self,
        name: &str,
        (implicit_m, is_distance): (&dyn Fn([f64; 3]) -> f64, bool),
        bounds_m: [[f64; 3]; 2],
        stance: Stance,
    ) -> Result<TetMesh, OrganError> {
        let turn = self.turn(stance);
        let at = V3::from(self.fine.at_m);
        let out = |x: V3| at + turn * x;
        let lattice = self.lattice(bounds_m, stance).map_err(|refusal| refusal.of(name))?;
        let shape = stuffing::Shape { implicit: &|x| implicit_m(out(x).into()), is_distance };
        let mut mesh = stuffing::stuff_any(name, shape, &lattice)?;
        for node in &mut mesh.nodes_m {
            *node = out(V3::from(*node)).into();
        }
        Ok(mesh)
    }

    /// Cost of a mesh of the shape, from samples of the lattice. A lattice that does not
    /// fit into memory is sampled as a coarser one that grows alike. `is_distance` is that of
    /// [`Self::mesh_with`].
    pub fn expected(
        &self,
        (implicit_m, is_distance): (&dyn Fn([f64; 3]) -> f64, bool),
        bounds_m: [[f64; 3]; 2],
        stance: Stance,
    ) -> Expected {
        let mut coarser = 1.0;
        let lattice = loop {
            let fine = Fine { spacing_m: coarser * self.fine.spacing_m, ..self.fine };
            let own = Self { fine, coarsest_m: coarser * self.coarsest_m, ..*self };
            match own.lattice(bounds_m, stance) {
                Ok(lattice) => break lattice,
                Err(Refusal::TooFine { .. }) => coarser *= 2.0,
                Err(_) => return Expected { nodes: f64::INFINITY, points: usize::MAX },
            }
        };
        let turn = self.turn(stance);
        let at = V3::from(self.fine.at_m);
        let mut balls = Balls::new(is_distance);
        let mut value_m = |from: V3| balls.value_m(from, &|from| implicit_m((at + turn * from).into()));
        let step = (lattice.len() / SAMPLES as usize).max(1);
        // a step that has no factor in common with the sides of the box
        let samples = (0..lattice.len()).step_by(step | 1);
        let count = samples.len() as f64;
        let (mut inside, mut cuts) = (0.0, 0.0);
        for name in samples {
            let triple = lattice.triple(name as u32);
            let own = lattice.place(triple);
            let own_m = value_m(own);
            if own_m < 0.0 {
                inside += 1.0;
                let mut is_cut = |way: &[i32; 3]| value_m(lattice.place([0, 1, 2].map(|k| triple[k] + way[k]))) >= 0.0;
                cuts += NEIGHBOURS.iter().filter(|way| is_cut(way)).count() as f64;
            }
        }
        // a quarter of the triples are points of the lattice
        let each = 0.25 * lattice.len() as f64 / count;
        Expected {
            nodes: each * (inside * coarser.powi(3) + CUT_NODES * cuts * coarser.powi(2)),
            points: if coarser > 1.0 { usize::MAX } else { lattice.len() },
        }
    }

    fn lattice(&self, bounds_m: [[f64; 3]; 2], stance: Stance) -> Result<Lattice, Refusal> {
        let turn = self.turn(stance);
        let at = V3::from(self.fine.at_m);
        let corner = |n: usize| V3::from([0, 1, 2].map(|k| bounds_m[n >> k & 1][k]));
        let corners = (0..8).map(|n| turn.transpose() * (corner(n) - at));
        let (low, high) = corners
            .fold((V3::repeat(f64::INFINITY), V3::repeat(f64::NEG_INFINITY)), |(low, high), x| (low.inf(&x), high.sup(&x)));
        let fine = Fine { at_m: [0.0; 3], ..self.fine };
        Lattice::fine(&fine, self.coarsest_m, [low.into(), high.into()])
    }

    /// Rotation from the lattice's frame to the shape's.
    fn turn(&self, stance: Stance) -> Matrix3<f64> {
        let up = V3::from(self.axis).normalize();
        let [along, across] = tangents(self.axis).map(V3::from);
        let r = std::f64::consts::FRAC_1_SQRT_2;
        let frame = Matrix3::from_columns(&[up, along, across]);
        if stance == Stance::Edge {
            return frame;
        }
        frame * Matrix3::from_rows(&[[r, r, 0.0].into(), [0.0, 0.0, 1.0].into(), [r, -r, 0.0].into()])
    }
}

/// Two unit vectors that form a right-handed frame with a unit normal, `[first, second, normal]`: x
/// and y if the normal is z, otherwise with the first as near to x as possible (to y, if the normal
/// is nearly x).
#[must_use]
pub fn tangents(normal: [f64; 3]) -> [[f64; 3]; 2] {
    let up = V3::from(normal).normalize();
    let near = if up.x.abs() < 0.9 { V3::x() } else { V3::y() };
    let first = (near - up * near.dot(&up)).normalize();
    [first.into(), up.cross(&first).into()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_turned_lattice_lies_in_a_flat_surface_with_whole_faces() {
        let axis = [0.36, 0.48, 0.8];
        let at_m = [0.01, -0.02, 0.03];
        let fine = Fine { at_m, radius_m: 0.02, spacing_m: 0.004, growth: 0.5 };
        let turned = Turned { fine, axis, coarsest_m: 0.02 };
        let height = |x: [f64; 3]| (V3::from(x) - V3::from(at_m)).dot(&V3::from(axis));
        // half of a ball
        let shape = |x: [f64; 3]| height(x).max((V3::from(x) - V3::from(at_m)).norm() - 0.05);
        let mesh = turned.mesh("half ball", &shape, [[-0.06; 3], [0.09; 3]]).unwrap();
        assert!(mesh.nodes_m.iter().any(|x| (V3::from(*x) - V3::from(at_m)).norm() < 1e-12));
        let near = |n: u32| (V3::from(mesh.nodes_m[n as usize]) - V3::from(at_m)).norm() < 0.014;
        let mut faces = 0;
        for t in crate::mesh::surface::surface(&mesh.tets).into_iter().filter(|t| t.iter().all(|n| near(*n))) {
            let place = |k: usize| V3::from(mesh.nodes_m[t[k] as usize]);
            let mut sides = [0, 1, 2].map(|k| (place(k) - place((k + 1) % 3)).norm() / 0.004);
            sides.sort_by(f64::total_cmp);
            assert!(
                (sides[0] - 0.75_f64.sqrt()).abs() < 1e-6 && (sides[1] - sides[0]).abs() < 1e-6 && (sides[2] - 1.0).abs() < 1e-6
            );
            assert!((0..3).all(|k| height(place(k).into()).abs() < 1e-12));
            faces += 1;
        }
        assert!(faces > 40, "{faces}");
    }

    #[test]
    fn a_mesh_is_expected_alike_with_and_without_knowing_that_the_function_is_a_distance() {
        let ball = |x: [f64; 3]| V3::from(x).norm() - 0.03;
        let fine = Fine { at_m: [0.0, 0.0, 0.03], radius_m: 0.01, spacing_m: 0.002, growth: 1.0 };
        let turned = Turned { fine, axis: [0.0, 0.0, 1.0], coarsest_m: 0.02 };
        let asked = std::cell::Cell::new(0);
        let counted = |x: [f64; 3]| {
            asked.set(asked.get() + 1);
            ball(x)
        };
        let expected = |is_distance| turned.expected((&counted, is_distance), [[-0.03; 3], [0.03; 3]], Stance::Face);
        let plain = expected(false);
        let plainly = asked.replace(0);
        assert_eq!(expected(true), plain);
        assert!(5 * asked.get() < 3 * plainly, "{} of {plainly}", asked.get());
        let nodes = turned.mesh("ball", &ball, [[-0.03; 3], [0.03; 3]]).unwrap().nodes_m.len() as f64;
        assert!((plain.nodes / nodes - 1.0).abs() < 0.2, "{} for {nodes}", plain.nodes);
    }

    #[test]
    fn on_a_block_the_tangents_are_its_axes() {
        assert_eq!(tangents([0.0, 0.0, 1.0]), [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        let [first, second] = tangents([1.0, 0.0, 0.0]).map(V3::from);
        assert!((first.cross(&second) - V3::x()).norm() < 1e-12);
    }
}
