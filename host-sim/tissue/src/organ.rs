//! Organs as closed smooth shapes, and their tetrahedral meshes.
//!
//! A shape ([`Organ`]) is an implicit function of space, negative inside, composed of a few parts.
//! Its mesh is cut out of a body-centred cubic lattice by isosurface stuffing (Labelle and Shewchuk
//! 2007). Lengths are in metres and z points up; the file of each organ says what x and y are.

mod abdomen;
mod balls;
mod count;
mod distance;
mod error;
mod foot;
mod gallbladder;
mod lattice;
mod liver;
mod parts;
mod sound;
mod split;
mod stuffing;
mod turned;

pub use error::OrganError;
pub use turned::{Expected, Stance, Turned, tangents};

use crate::mesh::TetMesh;
use lattice::Lattice;
use parts::V3;

/// Mean edge of a uniform lattice over its spacing (1): each node has six edges of length one and
/// eight of `sqrt(3)/2`.
pub const MEAN_EDGE: f64 = (6.0 + 8.0 * 0.866_025_403_784_438_6) / 14.0;

/// Meshes any closed shape with elements of one size: the part of the box `bounds_m` where
/// `implicit_m` is negative. Every tet is positively oriented, the mesh is one piece, every node
/// belongs to a tet, and all regions are 0. `name` is used in messages; `spacing_m` is that of the
/// lattice.
///
/// # Errors
/// Fails if the spacing is not positive, too coarse for the shape or too fine for memory.
pub fn even_mesh(
    name: &str,
    implicit_m: &dyn Fn([f64; 3]) -> f64,
    bounds_m: [[f64; 3]; 2],
    spacing_m: f64,
) -> Result<TetMesh, OrganError> {
    let lattice = Lattice::uniform(spacing_m, bounds_m, 0.0).map_err(|refusal| refusal.of(name))?;
    let shape = stuffing::Shape { implicit: &|x: parts::V3| implicit_m(x.into()), is_distance: false };
    stuffing::stuff_any(name, shape, &lattice)
}

/// A part of an organ with its own material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Region {
    /// Number of the part in [`TetMesh::regions`].
    pub id: u32,
    /// Name of the part, as scenes give it.
    pub name: &'static str,
}

/// An organ: its shape, its regions and its bones.
#[derive(Clone, Copy, Debug)]
pub struct Organ {
    name: &'static str,
    implicit: fn(V3) -> f64,
    /// Box that contains the shape [m].
    box_m: [[f64; 3]; 2],
    regions: &'static [Region],
    region: fn(&Organ, V3) -> u32,
    bone: Option<fn(V3) -> f64>,
}

/// Grading of a mesh that is finest around a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fine {
    /// Place at which the elements are smallest [m]; a node lies there.
    pub at_m: [f64; 3],
    /// Distance from the place within which elements keep their smallest size [m].
    pub radius_m: f64,
    /// Edge of the lattice's cubes there [m]: nodes are at least 0.87 of it apart, and edges are
    /// 0.92 of it long on average.
    pub spacing_m: f64,
    /// Growth of the elements outside that distance (1). At 0 they do not grow. At 1, n radii from
    /// the place, an edge toward the place is about `2 n^(2/3)` times as long as there, and one
    /// across `0.7 n^(2/3)` times. Larger values stretch the elements more.
    pub growth: f64,
}

/// Parameters of an organ's meshing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Spec {
    /// Edge of the lattice's cubes [m], the same everywhere.
    Spacing(f64),
    /// Number of tets, to which the uniform spacing comes as near as it can.
    Tets(usize),
    /// Fine around a place, and coarser away from it.
    Fine(Fine),
}

impl Organ {
    /// All built-in organs.
    pub const ALL: [Self; 4] = [liver::LIVER, gallbladder::GALLBLADDER, abdomen::ABDOMEN, foot::FOOT];

    /// Finds the organ of this name.
    ///
    /// # Errors
    /// There is no such organ; the message lists the known ones.
    pub fn named(name: &str) -> Result<Self, OrganError> {
        Self::ALL.into_iter().find(|o| o.name == name).ok_or_else(|| OrganError::Unknown {
            name: name.chars().take(40).collect::<String>().replace(char::is_control, "\u{fffd}"),
            known: Self::ALL.map(|o| o.name).join(", "),
        })
    }

    /// Name of the organ in scenes.
    #[must_use]
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// Lowest and highest corner [m] of a box around the organ, some millimetres larger than the
    /// organ.
    #[must_use]
    pub fn bounds_m(&self) -> [[f64; 3]; 2] {
        self.box_m
    }

    /// Regions of the organ; their ids run from 1 without gaps.
    #[must_use]
    pub fn regions(&self) -> &'static [Region] {
        self.regions
    }

    /// Implicit function at a point [m]: negative inside, zero on the surface, and close to the
    /// signed distance near the surface.
    #[must_use]
    pub fn implicit_m(&self, at_m: [f64; 3]) -> f64 {
        self.value(at_m.into())
    }

    /// Signed distance to the surface [m], negative inside; its magnitude is never less than the
    /// true one. Compared with fine meshes it is right within 0.1 mm down to 10 mm in the foot and
    /// 30 mm in the abdomen, the depths of their layers. Deeper in the liver and the foot, at about
    /// equal distances from two sides, the nearest point may be taken on the wrong side, some
    /// millimetres further away.
    #[must_use]
    pub fn distance_m(&self, at_m: [f64; 3]) -> f64 {
        self.distance(at_m.into())
    }

    /// Signed distance to the surface [m] in first order, negative inside, and the outward unit
    /// normal, at a point near the surface.
    #[must_use]
    pub fn near_m(&self, at_m: [f64; 3]) -> (f64, [f64; 3]) {
        let slope = self.gradient(at_m.into());
        let steep = slope.norm();
        (self.value(at_m.into()) / steep, (slope / steep).into())
    }

    /// Outward unit normal at a point of the surface.
    #[must_use]
    pub fn normal(&self, at_m: [f64; 3]) -> [f64; 3] {
        self.gradient(at_m.into()).normalize().into()
    }

    /// Id of the region at a point; for a point outside, that of the nearest layer.
    #[must_use]
    pub fn region_at(&self, at_m: [f64; 3]) -> u32 {
        (self.region)(self, at_m.into())
    }

    /// Distance to the nearest bone [m], negative inside one; `None` for an organ without bones.
    #[must_use]
    pub fn bone_m(&self, at_m: [f64; 3]) -> Option<f64> {
        self.bone.map(|bone| bone(at_m.into()))
    }

    /// Point of the surface nearest to a place [m]; as accurate as [`Self::distance_m`].
    #[must_use]
    pub fn nearest_m(&self, at_m: [f64; 3]) -> [f64; 3] {
        self.foot(at_m.into()).0.into()
    }

    /// Point at which a ray first crosses the surface [m]; `None` if the ray misses the organ, or
    /// has no direction. Parts thinner than a four-thousandth of the ray's length may be missed.
    #[must_use]
    pub fn surface_point(&self, from_m: [f64; 3], direction: [f64; 3]) -> Option<[f64; 3]> {
        self.crossing(from_m.into(), direction.into()).map(Into::into)
    }

    /// Meshes the organ. Every tet is positively oriented, the surface is one closed sphere in
    /// topology, every node belongs to a tet, and each tet has the region at its centroid. The mesh
    /// is the same on every machine.
    ///
    /// # Errors
    /// A size that is out of range, a spacing too coarse for the shape or too fine for memory, or a
    /// number of tets that no spacing gives.
    pub fn mesh(&self, spec: &Spec) -> Result<TetMesh, OrganError> {
        let mut mesh = match *spec {
            Spec::Spacing(spacing_m) => self.uniform(spacing_m)?,
            Spec::Tets(tets) => self.counted(tets)?,
            Spec::Fine(fine) => {
                let lattice = Lattice::fine(&fine, f64::INFINITY, self.box_m).map_err(|refusal| refusal.of(self.name))?;
                stuffing::stuff(self.name, &self.implicit, &lattice)?
            }
        };
        mesh.regions = mesh.tets.iter().map(|tet| self.region_of(&mesh, *tet)).collect();
        Ok(mesh)
    }

    fn uniform(&self, spacing_m: f64) -> Result<TetMesh, OrganError> {
        let lattice = Lattice::uniform(spacing_m, self.box_m, 0.0).map_err(|refusal| refusal.of(self.name))?;
        stuffing::stuff(self.name, &self.implicit, &lattice)
    }

    fn region_of(&self, mesh: &TetMesh, tet: [u32; 4]) -> u32 {
        let sum: V3 = tet.iter().map(|n| V3::from(mesh.nodes_m[*n as usize])).sum();
        (self.region)(self, 0.25 * sum)
    }
}
