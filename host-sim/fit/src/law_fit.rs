//! Fits a law without nodes: its held part to the forces over places and depths, its branches to
//! stored ramps.
//!
//! The held part is linear in its constants and is solved by least squares of the relative errors.
//! The branches are linear in their dashpots for given lengths; for every choice of lengths the
//! dashpots are solved by non-negative least squares, and the best choice is taken. One set of
//! branches serves every Young's modulus, because times scale with the waves of the tissue.

pub mod block;
mod held;
mod moving;
mod squares;

use palpate::{Branch, LawShape, MOST_BRANCHES, Params};

pub use moving::branches;

use crate::calibrate::targets::Reference;
use crate::statics::Vector;
use palpate_tissue::error::Error;
use palpate_tissue::mesh::TetMesh;
use palpate_tissue::organ::tangents;
use palpate_tissue::patch::OwnLaw;
use palpate_tissue::tissue::Tissue;

/// Radius of the probe for which [`HEMISPHERE`] was fitted [m].
const FITTED_RADIUS_M: f64 = 8e-3;
/// Branches of the shipped block under its hemisphere, as [`branches`] finds them from ramps of 40,
/// 100 and 200 mm/s at 3.5 and 100 kPa. They stand in where no ramp of a scene is stored: under
/// another radius, dashpots and lengths scale with it.
pub const HEMISPHERE: [Branch; MOST_BRANCHES] = [
    Branch { c: 0.0, length_m: 1.0 },
    Branch { c: 0.0, length_m: 1.0 },
    Branch { c: 0.0, length_m: 1.0 },
    Branch { c: 0.0, length_m: 1.0 },
];

/// The branches of [`HEMISPHERE`] for another radius of a round tip [m].
#[must_use]
pub fn scaled_branches(radius_m: f64) -> [Branch; MOST_BRANCHES] {
    let ratio = radius_m / FITTED_RADIUS_M;
    let mut scaled = HEMISPHERE;
    for (n, branch) in scaled.iter_mut().enumerate() {
        // force over E is an area; g^2 is sqrt(d) in the first two, d in the others
        let c = if n < 2 { ratio.powf(1.5) } else { ratio };
        (branch.c, branch.length_m) = (branch.c * c as f32, branch.length_m * ratio as f32);
    }
    scaled
}

/// The rest shape of a block, in six tets, with its top as the only surface that can be touched.
#[must_use]
pub fn block_shape(size_m: [f64; 3], site_m: [f64; 3], depth_limit_m: f64) -> Tissue {
    let corner = |n: usize| {
        let side = |k: usize| if n >> k & 1 == 1 { 0.5 } else { -0.5 };
        [side(0) * size_m[0], side(1) * size_m[1], if n >> 2 & 1 == 1 { 0.0 } else { -size_m[2] }]
    };
    // one tet for each order in which the three coordinates rise from the first corner to the last
    let orders = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [1, 0, 2], [0, 2, 1], [2, 1, 0]];
    let tet = |(n, [a, b, _]): (usize, [u32; 3])| {
        let (first, second) = (1 << a, 1 << a | 1 << b);
        if n < 3 { [0, first, second, 7] } else { [0, second, first, 7] }
    };
    let tets: Vec<[u32; 4]> = orders.into_iter().enumerate().map(tet).collect();
    let stiffness_ratio = vec![1.0; tets.len()];
    let mesh = TetMesh { nodes_m: (0..8).map(corner).collect(), regions: vec![0; tets.len()], tets };
    let skin = vec![[4, 5, 7], [4, 7, 6]];
    Tissue { mesh, stiffness_ratio, skin, anchors: vec![0, 1, 2, 3], site_m, depth_limit_m }
}

/// What a law is fitted to.
#[derive(Clone, Copy)]
pub struct LawTask<'a> {
    /// Forces over places and depths.
    pub known: &'a dyn Reference,
    /// Depths of the fit [m], in ascending order.
    pub depths_m: &'a [f64],
    /// Radius of the disc of places [m].
    pub reach_m: f64,
    /// Rows of the table along each side: 1 for constants alone.
    pub side: usize,
    /// Unit vector from the tip to the handle.
    pub axis: Vector,
    /// Place of the rest surface in the middle of the disc [m].
    pub site_m: [f64; 3],
}

impl LawTask<'_> {
    /// Fits a law; its branches are those of [`scaled_branches`].
    ///
    /// # Errors
    /// The reference lacks places or depths.
    pub fn fit(&self, params: &Params) -> Result<OwnLaw, Error> {
        let lacks = || Error::Check("the finite elements lack presses that a law needs: fit it anew".into());
        let table = held::fit(self).ok_or_else(lacks)?;
        let [along, _] = tangents(self.axis.into());
        let shape = LawShape {
            origin_m: self.site_m.map(|c| c as f32),
            along: along.map(|c| c as f32),
            reach_m: self.reach_m as f32,
            side: self.side as u32,
            branches: scaled_branches(params.probe.radius_m.into()),
        };
        Ok(OwnLaw { shape, table })
    }
}
