//! Uniform grids of the block, with five tets per cell. On these, explicit engines can take longer
//! steps than on meshes that are refined under the probe.

use palpate_tissue::mesh::TetMesh;

use crate::methods::BLOCK_M;

/// Numbers of cells along x, y and z.
pub const GRIDS: [[usize; 3]; 3] = [[6, 6, 4], [10, 10, 5], [14, 14, 8]];

/// Corners of the five tets of a cell; bits 0, 1 and 2 of a corner are its x, y and z. In every
/// other cell x is mirrored, so that neighbours share the diagonals of their faces.
const FIVE: [[usize; 4]; 5] = [[0, 1, 2, 4], [3, 2, 1, 7], [5, 1, 4, 7], [6, 4, 2, 7], [1, 2, 4, 7]];

/// Name of a grid in press.json.
pub fn grid_name([x, y, z]: [usize; 3]) -> String {
    format!("grid-{}", (x + 1) * (y + 1) * (z + 1))
}

/// The standard block as a grid, with its top at z = 0 and a node under the tip.
pub fn grid(cells: [usize; 3]) -> TetMesh {
    let [nx, ny, nz] = cells;
    let number = |i: usize, j: usize, k: usize| ((k * (ny + 1) + j) * (nx + 1) + i) as u32;
    let mut nodes_m = Vec::new();
    for k in 0..=nz {
        for j in 0..=ny {
            for i in 0..=nx {
                let share = |at: usize, of: usize| at as f64 / of as f64;
                let [x, y, z] = [share(i, nx) - 0.5, share(j, ny) - 0.5, share(k, nz) - 1.0];
                nodes_m.push([x * BLOCK_M[0], y * BLOCK_M[1], z * BLOCK_M[2]]);
            }
        }
    }
    let mut tets = Vec::new();
    for k in 0..nz {
        for j in 0..ny {
            for i in 0..nx {
                let mirrored = (i + j + k) % 2 == 1;
                let corner = |bits: usize| {
                    let x = (bits & 1) ^ usize::from(mirrored);
                    number(i + x, j + (bits >> 1 & 1), k + (bits >> 2 & 1))
                };
                tets.extend(FIVE.map(|tet| upright(tet.map(corner), &nodes_m)));
            }
        }
    }
    let regions = vec![0; tets.len()];
    TetMesh { nodes_m, tets, regions }
}

/// Orders the nodes of a tet so that its volume is positive.
fn upright(tet: [u32; 4], nodes_m: &[[f64; 3]]) -> [u32; 4] {
    let at = tet.map(|n| nalgebra::Vector3::from(nodes_m[n as usize]));
    let six = (at[1] - at[0]).dot(&(at[2] - at[0]).cross(&(at[3] - at[0])));
    let [a, b, c, d] = tet;
    if six > 0.0 { tet } else { [a, c, b, d] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grid_fills_the_block_and_its_faces_meet() {
        for cells in GRIDS {
            let mesh = grid(cells);
            let six = |t: &[u32; 4]| {
                let at = t.map(|n| nalgebra::Vector3::from(mesh.nodes_m[n as usize]));
                (at[1] - at[0]).dot(&(at[2] - at[0]).cross(&(at[3] - at[0])))
            };
            assert!(mesh.tets.iter().all(|t| six(t) > 0.0));
            let volume: f64 = mesh.tets.iter().map(six).sum::<f64>() / 6.0;
            assert!((volume / BLOCK_M.iter().product::<f64>() - 1.0).abs() < 1e-12);
            // the faces that belong to a single tet cover the six sides, two for each square
            let squares = cells[0] * cells[1] + cells[1] * cells[2] + cells[2] * cells[0];
            assert_eq!(palpate_tissue::mesh::surface::surface(&mesh.tets).len(), 4 * squares);
        }
    }
}
