//! Local refinement: the longest edge of a tet that is too large is halved, in all tets around that
//! edge (Rivara 1984).

use std::collections::HashMap;

use palpate_tissue::mesh::TetMesh;

/// Corner pairs of a tet's edges.
const EDGES: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];

/// Halves edges that are longer than `longest_m` at their midpoint [m], until there are none or the
/// mesh has `most_nodes`. The surface keeps its shape.
#[must_use]
pub fn refine(mesh: &TetMesh, longest_m: impl Fn([f64; 3]) -> f64, most_nodes: usize) -> TetMesh {
    let mut mesh = mesh.clone();
    while mesh.nodes_m.len() < most_nodes {
        let longest: Vec<[u32; 2]> = mesh.tets.iter().map(|t| longest_edge(&mesh, t)).collect();
        let mut around: HashMap<[u32; 2], Vec<usize>> = HashMap::new();
        for (t, tet) in mesh.tets.iter().enumerate() {
            for edge in edges_of(tet) {
                around.entry(edge).or_default().push(t);
            }
        }
        // from each large tet, follow longest edges to one that is the longest of all tets around
        // it: halving such an edge keeps the mesh closed
        let mut halved: Vec<[u32; 2]> = Vec::new();
        for (t, own) in longest.iter().enumerate() {
            let [i, j] = own.map(|n| mesh.nodes_m[n as usize]);
            let middle = [0, 1, 2].map(|k| 0.5 * (i[k] + j[k]));
            if length(&mesh, *own) <= longest_m(middle) {
                continue;
            }
            let mut at = t;
            while let Some(next) = around[&longest[at]].iter().find(|n| longest[**n] != longest[at]) {
                at = *next;
            }
            halved.push(longest[at]);
        }
        halved.sort_unstable();
        halved.dedup();
        if halved.is_empty() {
            break;
        }
        for edge in halved {
            let [i, j] = edge;
            let middle = mesh.nodes_m.len() as u32;
            let ends = [mesh.nodes_m[i as usize], mesh.nodes_m[j as usize]];
            mesh.nodes_m.push([0, 1, 2].map(|k| 0.5 * (ends[0][k] + ends[1][k])));
            // no tet is adjacent to two such edges
            for t in &around[&edge] {
                let with = |from: u32| mesh.tets[*t].map(|n| if n == from { middle } else { n });
                let halves = [with(i), with(j)];
                mesh.tets[*t] = halves[0];
                mesh.tets.push(halves[1]);
                mesh.regions.push(mesh.regions[*t]);
            }
        }
    }
    mesh
}

fn edges_of(tet: &[u32; 4]) -> [[u32; 2]; 6] {
    EDGES.map(|[a, b]| [tet[a].min(tet[b]), tet[a].max(tet[b])])
}

fn length(mesh: &TetMesh, edge: [u32; 2]) -> f64 {
    let [i, j] = edge.map(|n| mesh.nodes_m[n as usize]);
    (0..3).map(|k| (i[k] - j[k]).powi(2)).sum::<f64>().sqrt()
}

/// The longest edge of a tet; of equally long ones the one with the higher node numbers, so that
/// neighbours agree.
fn longest_edge(mesh: &TetMesh, tet: &[u32; 4]) -> [u32; 2] {
    let edges = edges_of(tet);
    edges.into_iter().max_by(|a, b| length(mesh, *a).total_cmp(&length(mesh, *b)).then(a.cmp(b))).unwrap_or(edges[0])
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate_tissue::mesh::{BlockSpec, block, surface};

    fn volume(mesh: &TetMesh, tet: &[u32; 4]) -> f64 {
        let [a, b, c, d] = tet.map(|n| nalgebra::Vector3::from(mesh.nodes_m[n as usize]));
        (b - a).cross(&(c - a)).dot(&(d - a)) / 6.0
    }

    #[test]
    fn a_refined_block_is_closed_fills_the_same_space_and_is_fine_where_asked() {
        let coarse = block(&BlockSpec { size_m: [0.04; 3], nodes: 60, fine_at_m: [0.0; 2], fine_radius_m: 0.01 }).unwrap();
        let distance = |x: [f64; 3]| x.iter().map(|v| v * v).sum::<f64>().sqrt();
        let fine = refine(&coarse, |x| 0.003 + 0.8 * distance(x), 5000);
        assert!(fine.nodes_m.len() > 2 * coarse.nodes_m.len());
        let volumes: Vec<f64> = fine.tets.iter().map(|t| volume(&fine, t)).collect();
        assert!(volumes.iter().all(|v| *v > 0.0));
        assert!((volumes.iter().sum::<f64>() / 0.04_f64.powi(3) - 1.0).abs() < 1e-12);
        // the mesh is closed: every boundary triangle is in a face of the block, so the surface
        // area is that of the block
        let corners = |t: &[u32; 3]| t.map(|n| nalgebra::Vector3::from(fine.nodes_m[n as usize]));
        let area: f64 =
            surface::surface(&fine.tets).iter().map(corners).map(|[a, b, c]| 0.5 * (b - a).cross(&(c - a)).norm()).sum();
        assert!((area / (6.0 * 0.04 * 0.04) - 1.0).abs() < 1e-9, "{area}");
        for tet in &fine.tets {
            let edge = longest_edge(&fine, tet);
            let [i, j] = edge.map(|n| fine.nodes_m[n as usize]);
            assert!(length(&fine, edge) <= 0.003 + 0.8 * distance([0, 1, 2].map(|k| 0.5 * (i[k] + j[k]))));
        }
    }
}
