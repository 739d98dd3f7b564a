//! A mesh of a block whose nodes around the centre are moved to another place on its top.
//!
//! Nodes within `kept_m` of the centre, measured along each side, move together. Between there and
//! the sides, nodes are spread or compressed uniformly, so that the sides do not move.

use palpate_tissue::mesh::TetMesh;

/// Moves the middle of a block with sides `size_m` by `offset_m` [m]. The sum of `kept_m` and the
/// offset must be less than half a side.
#[must_use]
pub fn shifted(mesh: &TetMesh, size_m: [f64; 3], kept_m: f64, offset_m: [f64; 2]) -> TetMesh {
    let mut mesh = mesh.clone();
    for node in &mut mesh.nodes_m {
        for k in 0..2 {
            node[k] = along(node[k], 0.5 * size_m[k], kept_m.min(0.5 * size_m[k]), offset_m[k]);
        }
    }
    mesh
}

fn along(x: f64, half_m: f64, kept_m: f64, offset_m: f64) -> f64 {
    if x.abs() <= kept_m {
        return x + offset_m;
    }
    let side = half_m.copysign(x);
    let edge = kept_m.copysign(x);
    side + (x - side) * (side - edge - offset_m) / (side - edge)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sides_stay_and_the_middle_moves_as_one() {
        for offset in [-0.012, 0.0, 0.014] {
            assert!((along(0.04, 0.04, 0.01, offset) - 0.04).abs() < 1e-15);
            assert!((along(-0.04, 0.04, 0.01, offset) + 0.04).abs() < 1e-15);
            assert!((along(0.005, 0.04, 0.01, offset) - 0.005 - offset).abs() < 1e-15);
            let rising: Vec<f64> = (-40..=40).map(|n| along(f64::from(n) * 1e-3, 0.04, 0.01, offset)).collect();
            assert!(rising.is_sorted_by(|a, b| a < b), "{rising:?}");
        }
    }
}
