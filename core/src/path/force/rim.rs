//! Rim springs: what stands in for the rest of the organ.
//!
//! A symmetric positive block per rim node and a block per edge between rim nodes, fitted to the condensed outside: conservative, and
//! exchangeable for another organ's.
//!
//! * in: displacements of the rim nodes
//! * out: adds `-M u` to their `node.f`
//! * cost (M4F, estimated): 76 cycles a rim node, 145 a rim edge
//! * may fail: never

use nalgebra::Vector3;

use crate::lanes::{row, subtract, vector};
use crate::model::Model;
use crate::state::State;

/// Adds the rim forces over E [N/Pa].
#[cfg_attr(feature = "stage-cost", inline(never))]
pub fn hold(model: &Model, state: &mut State) {
    let moved = |state: &State, n: usize| match (state.nodes.get(n), model.nodes.get(n)) {
        (Some(node), Some(rest)) => vector(&node.x) - Vector3::from(rest.rest_m),
        _ => Vector3::zeros(),
    };
    let pull = |state: &mut State, n: usize, f: Vector3<f32>| {
        if let Some(node) = state.nodes.get_mut(n) {
            subtract(&mut node.f, &row(f));
        }
    };
    for rim in model.rim_nodes {
        let [xx, yy, zz, xy, xz, yz] = rim.block_m;
        let n = rim.node as usize;
        let u = moved(state, n);
        let f = Vector3::new(xx * u.x + xy * u.y + xz * u.z, xy * u.x + yy * u.y + yz * u.z, xz * u.x + yz * u.y + zz * u.z);
        pull(state, n, f);
    }
    for edge in model.rim_edges {
        let [a, b, c, d, e, g, h, k, l] = edge.block_m;
        let [i, j] = edge.node.map(usize::from);
        let (ui, uj) = (moved(state, i), moved(state, j));
        let on_i = Vector3::new(a * uj.x + b * uj.y + c * uj.z, d * uj.x + e * uj.y + g * uj.z, h * uj.x + k * uj.y + l * uj.z);
        let on_j = Vector3::new(a * ui.x + d * ui.y + h * ui.z, b * ui.x + e * ui.y + k * ui.z, c * ui.x + g * ui.y + l * ui.z);
        pull(state, i, on_i);
        pull(state, j, on_j);
    }
}
