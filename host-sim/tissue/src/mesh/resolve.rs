//! Converts the file's numbers to indices, and file units to metres.

use super::TetMesh;
use super::error::{Defect, MeshError};
use super::raw::{RawMesh, RawNode};
use super::solid::{Origin, Solid};

/// Largest number of nodes, since node indices are `u16` in the core.
const MAX_NODES: usize = u16::MAX as usize;

/// Resolves a mesh, keeping the nodes that tets name, in the order of the file.
pub(super) fn resolve(raw: &RawMesh, unit_m: f64) -> Result<Solid, MeshError> {
    let tets = tet_indices(raw)?;
    let mut in_use = vec![false; raw.nodes.len()];
    for &node in tets.iter().flatten() {
        in_use[node] = true;
    }
    let nodes = in_use.iter().filter(|used| **used).count();
    if nodes > MAX_NODES {
        return Err(MeshError { file: raw.file.clone(), line: None, defect: Defect::TooManyNodes { nodes, limit: MAX_NODES } });
    }
    let mut new_index = vec![0_u32; raw.nodes.len()];
    let places = new_index.iter_mut().zip(&in_use);
    for (next, (index, _)) in (0..).zip(places.filter(|(_, used)| **used)) {
        *index = next;
    }
    let kept = || raw.nodes.iter().zip(&in_use).filter(|(_, used)| **used);
    Ok(Solid {
        mesh: TetMesh {
            nodes_m: kept().map(|(node, _)| node.position.map(|x| x * unit_m)).collect(),
            tets: tets.iter().map(|tet| tet.map(|i| new_index[i])).collect(),
            regions: raw.tets.iter().map(|tet| tet.region).collect(),
        },
        file: raw.file.clone(),
        node_origins: kept().map(|(&RawNode { number, line, .. }, _)| Origin { number, line }).collect(),
        tet_origins: raw.tets.iter().map(|tet| Origin { number: tet.number, line: tet.line }).collect(),
        unused_nodes: raw.nodes.len() - nodes,
    })
}

/// Indices in `raw.nodes` of the nodes of every tet, shape `[tets][4]`.
fn tet_indices(raw: &RawMesh) -> Result<Vec<[usize; 4]>, MeshError> {
    if raw.tets.is_empty() {
        return Err(no_tets(raw));
    }
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
fn nodes_by_number(raw: &RawMesh) -> Result<Vec<(u64, usize)>, MeshError> {
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

fn no_tets(raw: &RawMesh) -> MeshError {
    let kinds: Vec<_> = raw.ignored.iter().map(|(kind, count)| format!("{count} {kind}")).collect();
    let ignored = match kinds.as_slice() {
        [] => String::new(),
        kinds => format!(", only {}", kinds.join(", ")),
    };
    MeshError { file: raw.file.clone(), line: None, defect: Defect::NoTets { ignored } }
}
