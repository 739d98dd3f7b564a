//! Rim springs, which stand in for the rest of the organ.
//!
//! There is a symmetric positive block for every rim node and a block for every edge between rim
//! nodes, fitted to the condensed outside. The springs are conservative and can be exchanged for
//! those of another organ. The cost depends on the numbers of rim nodes and rim edges, whatever
//! organ is behind them.
//!
//! Edges are in the order of their first nodes, so that the displacement and force of a first node
//! stay in registers while its edges are processed ([`Model::check`] verifies the order).
//!
//! * in: displacements of the rim nodes
//! * out: adds `-M u` to their `node.f`
//! * cost (M4F, estimated from exact instruction counts): 75 cycles per rim node, 99 per rim edge;
//!   `board_cost` of `palpate-tests` prints it
//! * failures: none

use nalgebra::Vector3;

use crate::lanes::{row, vector};
use crate::model::{Model, RimEdge, RimNode};
use crate::state::State;

/// Adds the rim forces over E [N/Pa].
#[cfg_attr(feature = "stage-cost", inline(never))]
pub fn hold(model: &Model, state: &mut State) {
    let nodes = &mut *state.nodes;
    // `rest` gets the length of `nodes`: one range check serves both
    let Some(rest) = model.nodes.get(..nodes.len()) else { return };
    let mut edges = model.rim_edges;
    for rim in model.rim_nodes {
        let i = rim.node as usize;
        let (Some(node), Some(at)) = (nodes.get(i), rest.get(i)) else { return };
        let u = vector(&node.x) - Vector3::from(at.rest_m);
        let mut f = vector(&node.f) - to_ground(rim, u);
        while let [edge, others @ ..] = edges
            && u32::from(edge.node[0]) == rim.node
        {
            edges = others;
            let j = usize::from(edge.node[1]);
            let (Some(other), Some(at)) = (nodes.get_mut(j), rest.get(j)) else { return };
            let w = vector(&other.x) - Vector3::from(at.rest_m);
            let (on_first, on_second) = between(edge, u, w);
            f -= on_first;
            other.f = row(vector(&other.f) - on_second);
        }
        if let Some(node) = nodes.get_mut(i) {
            node.f = row(f);
        }
    }
}

/// `M_ii u_i` over E.
#[inline(always)]
fn to_ground(rim: &RimNode, u: Vector3<f32>) -> Vector3<f32> {
    let [xx, yy, zz, xy, xz, yz] = rim.block_m;
    Vector3::new(xx * u.x + xy * u.y + xz * u.z, xy * u.x + yy * u.y + yz * u.z, xz * u.x + yz * u.y + zz * u.z)
}

/// `M_ij u_j` and `M_ij^T u_i` over E.
#[inline(always)]
fn between(edge: &RimEdge, u: Vector3<f32>, w: Vector3<f32>) -> (Vector3<f32>, Vector3<f32>) {
    let [a, b, c, d, e, g, h, k, l] = edge.block_m;
    (
        Vector3::new(a * w.x + b * w.y + c * w.z, d * w.x + e * w.y + g * w.z, h * w.x + k * w.y + l * w.z),
        Vector3::new(a * u.x + d * u.y + h * u.z, b * u.x + e * u.y + k * u.z, c * u.x + g * u.y + l * u.z),
    )
}
