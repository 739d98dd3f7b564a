//! Checks that a mesh is one solid with the topology of a ball, as every organ is.

use std::collections::BTreeMap;

use crate::mesh::{TetMesh, surface};

type Edges = BTreeMap<[u32; 2], Vec<usize>>;

/// Triangles at every edge; `None` unless every edge has exactly two triangles.
fn sides(triangles: &[[u32; 3]]) -> Option<Edges> {
    let mut edges = Edges::new();
    for (index, &[a, b, c]) in triangles.iter().enumerate() {
        for [i, j] in [[a, b], [b, c], [c, a]] {
            edges.entry([i.min(j), i.max(j)]).or_default().push(index);
        }
    }
    edges.values().all(|sides| sides.len() == 2).then_some(edges)
}

/// Defect, if any, of a solid that may have holes through it and internal cavities: it must be one
/// piece, and every edge of its surface must be in two triangles.
pub(super) fn torn(tets: &[[u32; 4]]) -> Option<&'static str> {
    if sides(&surface::surface(tets)).is_none() {
        return Some("touches itself along an edge");
    }
    (surface::pieces(tets) != 1).then_some("is in pieces")
}

/// Defect, if any, of a solid that must have the topology of a ball: its surface must be one
/// sphere, and every edge of it must be in two triangles.
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
    // one closed surface without a hole through it has vertices - edges + faces = 2; handles and
    // pinched nodes make it less
    (nodes.len() + triangles.len() != edges.len() + 2).then_some("has a hole through it or touches itself at a node")
}

/// Six times the volume of a tet [m^3].
pub(super) fn six_volumes(mesh: &TetMesh, tet: [u32; 4]) -> f64 {
    let [a, b, c, d] = tet.map(|n| nalgebra::Vector3::from(mesh.nodes_m[n as usize]));
    (b - a).cross(&(c - a)).dot(&(d - a))
}
