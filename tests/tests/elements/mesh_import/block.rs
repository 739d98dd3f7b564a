//! Random valid meshes: a block of cubes with six tets per cube and randomly moved nodes.

use palpate_tissue::mesh::TetMesh;
use proptest::prelude::*;

/// Edge length of a cube [m].
pub const STEP_M: f64 = 0.01;

/// Paths from one corner of a cube to the opposite one; each spans a tet with the diagonal.
const PATHS: [[usize; 3]; 6] = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];

/// A mesh of `cells` cubes along each axis, without moved nodes.
pub fn regular(cells: [usize; 3]) -> TetMesh {
    let [nx, ny, nz] = cells.map(|n| n + 1);
    let index = |at: [usize; 3]| u32::try_from(at[0] + nx * (at[1] + ny * at[2])).unwrap();
    let mut nodes_m = Vec::new();
    let mut tets = Vec::new();
    for z in 0..nz {
        for y in 0..ny {
            for x in 0..nx {
                nodes_m.push([x, y, z].map(|i| STEP_M * i as f64));
                if x + 1 == nx || y + 1 == ny || z + 1 == nz {
                    continue;
                }
                for (path, axes) in PATHS.iter().enumerate() {
                    let mut at = [x, y, z];
                    let mut tet = [index(at); 4];
                    for (corner, &axis) in axes.iter().enumerate() {
                        at[axis] += 1;
                        tet[corner + 1] = index(at);
                    }
                    // The last three paths are odd permutations of the axes.
                    if path > 2 {
                        tet.swap(2, 3);
                    }
                    tets.push(tet);
                }
            }
        }
    }
    let regions = vec![0; tets.len()];
    TetMesh { nodes_m, tets, regions }
}

/// A mesh of up to 2 x 2 x 2 cubes with moved nodes, shuffled nodes and tets, and random regions.
pub fn any() -> impl Strategy<Value = TetMesh> {
    let cells = [1..=2_usize, 1..=2, 1..=2];
    cells.prop_map(regular).prop_flat_map(|mesh| {
        let (nodes, tets) = (mesh.nodes_m.len(), mesh.tets.len());
        // A twentieth of an edge does not move any node near the opposite face, which is 0.7 edges
        // away.
        let shift = prop::array::uniform3(-0.05..0.05);
        (
            prop::collection::vec(shift, nodes),
            Just((0..nodes).collect::<Vec<_>>()).prop_shuffle(),
            Just((0..tets).collect::<Vec<_>>()).prop_shuffle(),
            prop::collection::vec(0..4_u32, tets),
        )
            .prop_map(move |(shifts, node_order, tet_order, regions)| {
                let mut nodes_m = mesh.nodes_m.clone();
                for (old, &new) in node_order.iter().enumerate() {
                    let shifted = |axis: usize| mesh.nodes_m[old][axis] + STEP_M * shifts[old][axis];
                    nodes_m[new] = [shifted(0), shifted(1), shifted(2)];
                }
                let renumbered = |tet: [u32; 4]| tet.map(|node| u32::try_from(node_order[node as usize]).unwrap());
                TetMesh { nodes_m, tets: (tet_order.iter().map(|&old| renumbered(mesh.tets[old]))).collect(), regions }
            })
    })
}

/// `(b-a) x (c-a) . (d-a)`, six times the signed volume.
pub fn six_volumes(mesh: &TetMesh, tet: [u32; 4]) -> f64 {
    let [a, b, c, d] = tet.map(|node| mesh.nodes_m[node as usize]);
    let minus = |p: [f64; 3]| [p[0] - a[0], p[1] - a[1], p[2] - a[2]];
    triple(minus(b), minus(c), minus(d))
}

/// `u x v . w`.
pub fn triple(u: [f64; 3], v: [f64; 3], w: [f64; 3]) -> f64 {
    w[0] * (u[1] * v[2] - u[2] * v[1]) + w[1] * (u[2] * v[0] - u[0] * v[2]) + w[2] * (u[0] * v[1] - u[1] * v[0])
}
