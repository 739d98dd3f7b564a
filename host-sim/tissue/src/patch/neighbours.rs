//! Connectivity of a patch's tets, for the core's walk from tet to tet to the sensed tip.

use std::collections::HashMap;

use palpate::{Model, Tet, Triangle};

use crate::mesh::surface::face_sides;

/// The tet across the face opposite each corner, shape `[tets][4]`, and the tet under each surface
/// triangle, shape `[triangles]`. At the boundary the entry is [`Model::TOUCHABLE`] under a surface
/// triangle and [`Model::HIDDEN`] elsewhere; a triangle that is not a face of the boundary has the
/// owner [`Model::HIDDEN`], which the core refuses.
pub(super) fn of(tets: &[Tet], triangles: &[Triangle]) -> (Vec<[u32; 4]>, Vec<u32>) {
    let nodes: Vec<[u32; 4]> = tets.iter().map(|t| t.node.map(u32::from)).collect();
    let place_of: HashMap<[u32; 3], usize> = triangles
        .iter()
        .enumerate()
        .map(|(place, triangle)| {
            let mut key = triangle.node.map(u32::from);
            key.sort_unstable();
            (key, place)
        })
        .collect();
    let mut neighbours = vec![[Model::HIDDEN; 4]; tets.len()];
    let mut owners = vec![Model::HIDDEN; triangles.len()];
    for face in face_sides(&nodes).chunk_by(|a, b| a.key == b.key) {
        match face {
            [side] => {
                if let Some(&place) = place_of.get(&side.key) {
                    neighbours[side.tet][side.face] = Model::TOUCHABLE;
                    owners[place] = side.tet as u32;
                }
            }
            [one, two] => {
                neighbours[one.tet][one.face] = two.tet as u32;
                neighbours[two.tet][two.face] = one.tet as u32;
            }
            _ => {}
        }
    }
    (neighbours, owners)
}
