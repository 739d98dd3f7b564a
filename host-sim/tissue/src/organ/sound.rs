//! Checks that a mesh is one solid with the topology of a ball, as every organ here.

use std::collections::BTreeMap;

use crate::mesh::{TetMesh, surface};

type Edges = BTreeMap<[u32; 2], Vec<usize>>;

/// Triangles at every edge; `None` unless every edge has exactly two.
fn sides(triangles: &[[u32; 3]]) -> Option<Edges> {
    let mut edges = Edges::new();
    for (index, &[a, b, c]) in triangles.iter().enumerate() {
        for [i, j] in [[a, b], [b, c], [c, a]] {
            edges.entry([i.min(j), i.max(j)]).or_default().push(index);
        }
    }
    edges.values().all(|sides| sides.len() == 2).then_some(edges)
}

/// Returns the defect of a solid that may have holes through it and hollows, if any: it must be one
/// piece, every edge of its surface in two triangles.
pub(super) fn torn(tets: &[[u32; 4]]) -> Option<&'static str> {
    if sides(&surface::surface(tets)).is_none() {
        return Some("touches itself along an edge");
    }
    (surface::pieces(tets) != 1).then_some("is in pieces")
}

/// Returns the defect of the surface, if any: it must be one sphere, every edge of it in two
/// triangles.
pub(super) fn defect(tets: &[[u32; 4]]) -> Option<&'static str> {
    let triangles = surface::surface(tets);
    let Some(edges) = sides(&triangles) else {
        return Some("touches itself along an edge");
    };
    let mut nodes: Vec<u32> = triangles.iter().flatten().copied().collect();
    nodes.sort_unstable();
    nodes.dedup();
    let mut around = vec![Vec::new(); triangles.len()];
    for sides in edges.values() {
        if let [a, b] = sides[..] {
            around[a].push(b);
            around[b].push(a);
        }
    }
    let mut seen = vec![false; triangles.len()];
    let mut next: Vec<usize> = (!triangles.is_empty()).then_some(0).into_iter().collect();
    while let Some(triangle) = next.pop() {
        if !std::mem::replace(&mut seen[triangle], true) {
            next.extend(&around[triangle]);
        }
    }
    if seen.contains(&false) {
        return Some("is in pieces or hollow");
    }
    // one closed piece without a hole through it: vertices - edges + faces = 2; less with handles
    // or pinched nodes
    (nodes.len() + triangles.len() != edges.len() + 2).then_some("has a hole through it or touches itself at a node")
}

/// Six times the volume of a tet [m^3].
pub(super) fn six_volumes(mesh: &TetMesh, tet: [u32; 4]) -> f64 {
    let [a, b, c, d] = tet.map(|n| nalgebra::Vector3::from(mesh.nodes_m[n as usize]));
    (b - a).cross(&(c - a)).dot(&(d - a))
}
