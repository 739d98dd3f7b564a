//! The constant model: rest shape and stiffness as borrowed slices, which may be in flash or in a
//! `Vec`.
//!
//! **Everything elastic is stored per pascal of Young's modulus** (a spring constant in N/m is its
//! entry in metres times E). The tick runs on forces divided by E, so one packed patch serves every
//! stiffness at no cost; E enters in [`crate::Tuned`] only.

use bytemuck::{Pod, Zeroable};

use crate::fault::BuildError;
use crate::law::Law;

/// A node at rest.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct NodeRest {
    /// Position [m], patch frame.
    pub rest_m: [f32; 3],
    /// A quarter of the volume of the node's tets [m^3]; times the density it is the node's mass
    /// (paper 000, eq 10).
    pub volume_m3: f32,
    /// Mean diagonal stiffness over E [m]: a third of the trace of the node's block of the rest
    /// stiffness matrix, rim included.
    pub stiffness_m: f32,
    /// One over six times the volume of the node's tets [1/m^3].
    pub six_volume_reciprocal: f32,
    /// Nodal share of the volume stiffness over E, `2 kappa (1 - beta) / 24`, with the node's
    /// multiplier (1).
    pub pressure: f32,
}

/// Spring from node `i` to node `j`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct Spring {
    /// First node; springs are sorted by it unless [`Model::spring_rows`] is empty.
    pub i: u16,
    /// Node at the other end; its index differs from `i`.
    pub j: u16,
    /// Stiffness over E [m] (paper 000, eq 11, times `1/(0.8 (1 + nu))` and the edge's multiplier).
    pub k: f32,
    /// `k` times the rest length [m^2].
    pub k_rest: f32,
}

/// Tetrahedron (a, b, c, d) with `(b-a) x (c-a) . (d-a) > 0`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct Tet {
    /// Nodes a, b, c, d.
    pub node: [u16; 4],
    /// One over six times the rest volume [1/m^3].
    pub six_volume_reciprocal: f32,
    /// Per-tet share of the volume stiffness over E, `beta kappa / 6` (1).
    pub bulk: f32,
    /// Barrier against inversion over E, `3 mu / 6` (1).
    pub barrier: f32,
}

/// Surface triangle, counter-clockwise seen from outside.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct Triangle {
    /// Indices of the corners among the patch's nodes.
    pub node: [u16; 3],
    /// Zero; keeps the layout free of padding.
    pub reserved: u16,
}

/// Force law of one foundation point, described in `stages/force/foundation.rs`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct FoundationPoint {
    /// Initial stiffness over E [m].
    pub k: f32,
}

/// Rim spring between a node and the ground, given by a 3x3 block M: `f_i -= E M u_i`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct RimNode {
    /// Node index, as `u32` to keep the layout free of padding.
    pub node: u32,
    /// xx, yy, zz, xy, xz, yz of the symmetric block over E [m].
    pub block_m: [f32; 6],
}

/// Rim spring between two rim nodes, given by a 3x3 block B: `f_i -= E B u_j`, `f_j -= E B^T u_i`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct RimEdge {
    /// Node indices i, j.
    pub node: [u16; 2],
    /// The block over E [m], row by row.
    pub block_m: [f32; 9],
}

/// A tissue patch at rest; the tick only reads it.
#[derive(Clone, Copy, Debug)]
pub struct Model<'a> {
    /// Poisson's ratio that the stiffnesses were built for.
    pub poisson_ratio: f32,
    /// Coefficient of the stiffening term in the foundation's force law [1/m].
    pub stiffening_per_m: f32,
    /// Largest depth at which the patch can be pressed [m]; the guard clamps a deeper probe to it.
    pub depth_limit_m: f32,
    /// Nodes, shape \[nodes\].
    pub nodes: &'a [NodeRest],
    /// Fixed nodes, ascending.
    pub anchors: &'a [u16],
    /// Number of springs that start at each node, shape \[nodes\], if `springs` is sorted by `i`.
    /// Empty if the springs are ordered for processors with wide registers; the order of the
    /// springs *at each node* is the same in both cases, so the results have the same bits.
    pub spring_rows: &'a [u16],
    /// Springs, one per edge.
    pub springs: &'a [Spring],
    /// Tets, ordered so that neighbours in the list share no node if the mesh allows it.
    pub tets: &'a [Tet],
    /// The surface that a probe can touch.
    pub triangles: &'a [Triangle],
    /// Steepness of the stiffening at each node (1), shape \[nodes\]: the node's exponent divided
    /// by the patch's ([`crate::Params::stiffening_b`]) and by the node's stiffness ratio. Empty if
    /// it is 1 everywhere; boards run no tissue that stiffens.
    #[cfg(not(target_os = "none"))]
    pub steepness: &'a [f32],
    /// Foundation points, shape [triangles][4], [triangles][9] or (except on a board)
    /// [triangles][16], flat.
    pub foundation: &'a [FoundationPoint],
    /// Tet across the face opposite each corner, shape \[tets\]; [`Model::TOUCHABLE`] or
    /// [`Model::HIDDEN`] at the boundary.
    pub neighbours: &'a [[u32; 4]],
    /// Tet under each surface triangle, shape \[triangles\].
    pub owners: &'a [u32],
    /// Rim springs to the ground, which stand in for the rest of the organ. May be empty.
    pub rim_nodes: &'a [RimNode],
    /// Rim springs between rim nodes, in the order of their first nodes in `rim_nodes`. May be
    /// empty.
    pub rim_edges: &'a [RimEdge],
    /// Law that answers in place of the nodes, unless [`crate::Terms::law`] is off. A model with a
    /// law may have no springs and no foundation: its tets are then the rest shape alone.
    pub law: Option<Law<'a>>,
}

impl Model<'_> {
    /// In place of a neighbour: marks a boundary face that is one of `triangles`.
    pub const TOUCHABLE: u32 = u32::MAX - 1;
    /// In place of a neighbour: marks any other boundary face, such as a side, the underside or a
    /// cut.
    pub const HIDDEN: u32 = u32::MAX;

    /// Number of foundation points per triangle: 4, 9, or (except on a board) 16.
    #[must_use]
    #[inline(always)]
    pub fn points_per_triangle(&self) -> usize {
        // a board's image has no room for sixteen points: there `check_sizes` refuses such a patch
        #[cfg(not(target_os = "none"))]
        if self.foundation.len() == 16 * self.triangles.len() {
            return 16;
        }
        if self.foundation.len() == 9 * self.triangles.len() { 9 } else { 4 }
    }

    /// Checks every index, sign and size once, so that the tick need not.
    ///
    /// # Errors
    /// Returns the kind and the index of the first invalid item.
    #[inline]
    pub fn check(&self) -> Result<(), BuildError> {
        self.check_arrays()?;
        self.check_neighbours()
    }

    /// The part of [`Self::check`] that looks at each array on its own.
    #[inline]
    pub(crate) fn check_arrays(&self) -> Result<(), BuildError> {
        let nodes = self.nodes.len();
        let outside = |item, index, node: u16| match usize::from(node) < nodes {
            true => Ok(()),
            false => Err(BuildError::NodeOutOfRange { item, index, node }),
        };
        let positive = |item, index, value: f32| match value.is_finite() && value > 0.0 {
            true => Ok(()),
            false => Err(BuildError::NotPositive { item, index }),
        };
        let finite = |item, index, values: &[f32]| match values.iter().all(|v| v.is_finite()) {
            true => Ok(()),
            false => Err(BuildError::NotFinite { item, index }),
        };
        if nodes == 0 || self.tets.is_empty() {
            return Err(BuildError::Empty);
        }
        if nodes > usize::from(u16::MAX) {
            return Err(BuildError::TooLarge { item: "nodes", need: nodes, have: usize::from(u16::MAX) });
        }
        for (n, node) in self.nodes.iter().enumerate() {
            finite("node", n, &node.rest_m)?;
            positive("node volume", n, node.volume_m3)?;
            positive("node stiffness", n, node.stiffness_m)?;
            positive("node volume reciprocal", n, node.six_volume_reciprocal)?;
            finite("node", n, &[node.pressure])?;
        }
        #[cfg(not(target_os = "none"))]
        for (n, steepness) in self.steepness.iter().enumerate() {
            finite("node steepness", n, &[*steepness])?;
            if *steepness < 0.0 {
                return Err(BuildError::NotPositive { item: "node steepness", index: n });
            }
        }
        for (n, &a) in self.anchors.iter().enumerate() {
            outside("anchor", n, a)?;
        }
        for (n, s) in self.springs.iter().enumerate() {
            outside("spring", n, s.i)?;
            outside("spring", n, s.j)?;
            positive("spring stiffness", n, s.k)?;
            positive("spring length", n, s.k_rest)?;
            if s.i == s.j {
                return Err(BuildError::Degenerate { item: "spring", index: n });
            }
        }
        for (n, t) in self.tets.iter().enumerate() {
            t.node.iter().try_for_each(|&v| outside("tet", n, v))?;
            positive("tet volume", n, t.six_volume_reciprocal)?;
            finite("tet", n, &[t.bulk, t.barrier])?;
        }
        for (n, t) in self.triangles.iter().enumerate() {
            t.node.iter().try_for_each(|&v| outside("surface triangle", n, v))?;
        }
        for (n, p) in self.foundation.iter().enumerate() {
            positive("foundation point", n, p.k)?;
        }
        for (n, r) in self.rim_nodes.iter().enumerate() {
            outside("rim node", n, u16::try_from(r.node).unwrap_or(u16::MAX))?;
            finite("rim node", n, &r.block_m)?;
        }
        for (n, r) in self.rim_edges.iter().enumerate() {
            r.node.iter().try_for_each(|&v| outside("rim edge", n, v))?;
            finite("rim edge", n, &r.block_m)?;
        }
        self.check_rim_order()?;
        self.check_sizes()
    }

    /// Checks that neighbours name each other across the same three nodes, and that every triangle
    /// is a boundary face of its owner. Otherwise a tip could be located inside tissue where there
    /// is none.
    #[inline]
    pub(crate) fn check_neighbours(&self) -> Result<(), BuildError> {
        // written out, because a board calls the library's search as a function
        let has = |tet: &Tet, nodes: &[u16], but: u16| {
            let [a, b, c, d] = tet.node;
            nodes.iter().all(|n| *n == but || *n == a || *n == b || *n == c || *n == d)
        };
        for (index, (tet, across)) in self.tets.iter().zip(self.neighbours).enumerate() {
            for (&corner, &other) in tet.node.iter().zip(across) {
                let mutual = match self.tets.get(other as usize).zip(self.neighbours.get(other as usize)) {
                    Some((to, back)) => has(to, &tet.node, corner) && back.iter().any(|b| *b as usize == index),
                    None => other >= Self::TOUCHABLE,
                };
                if !mutual {
                    return Err(BuildError::Degenerate { item: "tet neighbour", index });
                }
            }
        }
        for (index, (triangle, &owner)) in self.triangles.iter().zip(self.owners).enumerate() {
            let found = self.tets.get(owner as usize).zip(self.neighbours.get(owner as usize)).is_some_and(|(tet, across)| {
                let opposite = |(n, other): (&u16, &u32)| *other == Self::TOUCHABLE && !triangle.node.contains(n);
                has(tet, &triangle.node, u16::MAX) && tet.node.iter().zip(across).any(opposite)
            });
            if !found {
                return Err(BuildError::Degenerate { item: "owner of surface triangle", index });
            }
        }
        Ok(())
    }

    /// Checks that the edges follow the order of the rim nodes. The tick passes over the edges
    /// once, along the rim nodes: an edge out of order, and all edges after it, would be skipped.
    #[inline]
    fn check_rim_order(&self) -> Result<(), BuildError> {
        let mut passed = self.rim_nodes.iter();
        let mut first = None;
        for (index, r) in self.rim_edges.iter().enumerate() {
            let [i, j] = r.node.map(u32::from);
            if first != Some(i) {
                first = passed.find(|n| n.node == i).map(|n| n.node);
            }
            if first.is_none() || i == j {
                return Err(BuildError::Degenerate { item: "rim edge", index });
            }
        }
        Ok(())
    }

    #[inline]
    fn check_sizes(&self) -> Result<(), BuildError> {
        let same = |item, need, have| match need == have {
            true => Ok(()),
            false => Err(BuildError::LengthMismatch { item, need, have }),
        };
        same("tet neighbours", self.tets.len(), self.neighbours.len())?;
        same("owners of surface triangles", self.triangles.len(), self.owners.len())?;
        #[cfg(not(target_os = "none"))]
        if !self.steepness.is_empty() {
            same("node steepnesses", self.nodes.len(), self.steepness.len())?;
        }
        if self.law.is_none() || !self.foundation.is_empty() {
            same("foundation", self.points_per_triangle() * self.triangles.len(), self.foundation.len())?;
        }
        if !self.spring_rows.is_empty() {
            same("spring rows", self.nodes.len(), self.spring_rows.len())?;
            let counted = self.spring_rows.iter().map(|&n| usize::from(n)).sum();
            same("springs", counted, self.springs.len())?;
            let mut springs = self.springs.iter();
            for (i, &count) in self.spring_rows.iter().enumerate() {
                if springs.by_ref().take(usize::from(count)).any(|s| usize::from(s.i) != i) {
                    return Err(BuildError::Degenerate { item: "spring row", index: i });
                }
            }
        }
        if !(self.depth_limit_m.is_finite() && self.depth_limit_m > 0.0) {
            return Err(BuildError::NotPositive { item: "depth_limit_m", index: 0 });
        }
        if !(self.stiffening_per_m.is_finite() && self.stiffening_per_m > 0.0) {
            return Err(BuildError::NotPositive { item: "stiffening_per_m", index: 0 });
        }
        Ok(())
    }
}
