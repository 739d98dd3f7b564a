//! Converts the file's numbers to indices, and file units to metres.

use super::TetMesh;
use super::error::{Defect, MeshError};
use super::quality::{corners, six_volumes};
use super::raw::{RawMesh, RawNode};
use super::solid::{Origin, Solid};

/// Resolves a mesh, keeping the nodes that tets name, in the order of the file, and of several tets
/// of the same nodes the first: Gmsh 2 writes an element once for every group that it belongs to.
pub(super) fn resolve(raw: &RawMesh, unit_m: f64) -> Result<Solid, MeshError> {
    let all = tet_indices(raw)?;
    let is_copy = copies(&all);
    let own = || is_copy.iter().zip(&raw.tets).filter(|(is_copy, _)| !**is_copy).map(|(_, tet)| tet);
    let tets: Vec<[usize; 4]> = all.iter().zip(&is_copy).filter(|(_, is_copy)| !**is_copy).map(|(tet, _)| *tet).collect();
    let mut in_use = vec![false; raw.nodes.len()];
    for &node in tets.iter().flatten() {
        in_use[node] = true;
    }
    let nodes = in_use.iter().filter(|used| **used).count();
    let mut new_index = vec![0_u32; raw.nodes.len()];
    let places = new_index.iter_mut().zip(&in_use);
    for (next, (index, _)) in (0..).zip(places.filter(|(_, used)| **used)) {
        *index = next;
    }
    let kept = || raw.nodes.iter().zip(&in_use).filter(|(_, used)| **used);
    let nodes_m: Vec<[f64; 3]> = kept().map(|(node, _)| node.position.map(|x| x * unit_m)).collect();
    let mut tets: Vec<[u32; 4]> = tets.iter().map(|tet| tet.map(|i| new_index[i])).collect();
    for (tet, _) in tets.iter_mut().zip(own()).filter(|(_, raw)| raw.is_part) {
        if six_volumes(corners(&nodes_m, *tet)) < 0.0 {
            tet.swap(2, 3);
        }
    }
    Ok(Solid {
        copies: all.len() - tets.len(),
        mesh: TetMesh { nodes_m, tets, regions: own().map(|tet| tet.region).collect() },
        file: raw.file.clone(),
        node_origins: kept().map(|(&RawNode { number, line, .. }, _)| Origin { number, line }).collect(),
        tet_origins: own().map(|tet| Origin { number: tet.number, line: tet.line }).collect(),
        unused_nodes: raw.nodes.len() - nodes,
    })
}

/// Whether each tet has the same nodes as one before it.
fn copies(tets: &[[usize; 4]]) -> Vec<bool> {
    let mut keys: Vec<([u32; 4], u32)> = (0..).zip(tets).map(|(index, tet)| (tet.map(|node| node as u32), index)).collect();
    for (nodes, _) in &mut keys {
        nodes.sort_unstable();
    }
    keys.sort_unstable();
    let mut is_copy = vec![false; tets.len()];
    for pair in keys.windows(2) {
        if pair[0].0 == pair[1].0 {
            is_copy[pair[1].1 as usize] = true;
        }
    }
    is_copy
}

/// Indices in `raw.nodes` of the nodes of every tet, shape `[tets][4]`.
fn tet_indices(raw: &RawMesh) -> Result<Vec<[usize; 4]>, MeshError> {
    let by_number = nodes_by_number(raw)?;
    let last = by_number.last().map_or(0, |&(number, _)| number);
    let mut tets = Vec::with_capacity(raw.tets.len());
    for tet in &raw.tets {
        let error = |defect| MeshError { file: raw.file.clone(), line: tet.line, defect };
        let mut indices = [0; 4];
        for (place, (index, &node)) in indices.iter_mut().zip(&tet.nodes).enumerate() {
            if tet.nodes.iter().take(place).any(|&before| before == node) {
                return Err(error(Defect::RepeatedNode { tet: tet.number, node }));
            }
            *index = by_number
                .binary_search_by_key(&node, |&(number, _)| number)
                .ok()
                .and_then(|found| by_number.get(found))
                .map(|&(_, index)| index)
                .ok_or_else(|| error(Defect::UnknownNode { tet: tet.number, node, nodes: raw.nodes.len(), last }))?;
        }
        tets.push(indices);
    }
    Ok(tets)
}

/// Number and index of every node, in rising order of the numbers.
pub(super) fn nodes_by_number(raw: &RawMesh) -> Result<Vec<(u64, usize)>, MeshError> {
    let mut by_number: Vec<_> = raw.nodes.iter().enumerate().map(|(index, node)| (node.number, index)).collect();
    by_number.sort_unstable();
    for pair in by_number.windows(2) {
        if let &[(number, first), (same, second)] = pair
            && number == same
        {
            return Err(MeshError {
                file: raw.file.clone(),
                line: raw.nodes[second].line,
                defect: Defect::RepeatedNodeNumber { node: number, first_line: raw.nodes[first].line },
            });
        }
    }
    Ok(by_number)
}
