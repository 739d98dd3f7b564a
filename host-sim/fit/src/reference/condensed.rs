//! Condenses the stiffness of a body to a few of its nodes.
//!
//! The condensation uses linear elasticity about the rest shape (the tangent of [`super::body`]
//! there). Nodes may be tied: their displacement is then a weighted mean of displacements of the
//! kept nodes, so that a curved quadratic face can follow a flat linear one.

use faer::Mat;
use nalgebra::Vector3;

use super::body::Body;

/// Constraint on a node's displacement.
#[derive(Clone, Debug, PartialEq)]
pub enum Tie {
    /// Unconstrained; equilibrium determines the displacement.
    Free,
    /// The sum of weights times displacements of kept nodes; without any term the node is fixed.
    To(Vec<(usize, f64)>),
}

/// Stiffness over E of a body with respect to `kept` displacements [m], shape [3 kept][3 kept];
/// `tie` gives the constraint of each node of the body's mesh. Components that the body itself
/// fixes remain fixed. `None` if a part is unsupported or there is not enough memory.
#[must_use]
pub fn condensed(body: &Body, tie: &[Tie], kept: usize) -> Option<Mat<f64>> {
    let nodes = body.mesh.nodes_m.len();
    let rest = body.assemble(&vec![Vector3::zeros(); nodes], None)?;
    let fixed: Vec<[bool; 3]> = body.fixed.iter().zip(tie).map(|(f, t)| if *t == Tie::Free { *f } else { [true; 3] }).collect();
    let mut matrix = rest.tangent.clone();
    body.pattern.fix(&mut matrix, &fixed);
    let mut solver = body.pattern.analyse(&[])?;
    if !solver.factorise(&matrix) {
        return None;
    }
    let mut followers: Vec<Vec<(usize, f64)>> = vec![Vec::new(); kept];
    for (node, tie) in tie.iter().enumerate() {
        if let Tie::To(weights) = tie {
            weights.iter().for_each(|(k, w)| followers[*k].push((node, *w)));
        }
    }
    let mut stiffness = Mat::zeros(3 * kept, 3 * kept);
    let mut column = vec![0.0; 3 * nodes];
    for (k, own) in followers.iter().enumerate() {
        for c in 0..3 {
            let mut moved = vec![Vector3::zeros(); nodes];
            for (node, weight) in own {
                moved[*node][c] = if body.fixed[*node][c] { 0.0 } else { *weight };
            }
            let pull = body.tangent_times(&rest, &moved);
            for ((right, pull), fixed) in column.chunks_mut(3).zip(&pull).zip(&fixed) {
                (0..3).for_each(|a| right[a] = if fixed[a] { 0.0 } else { -pull[a] });
            }
            solver.solve(&mut column);
            for (moved, answer) in moved.iter_mut().zip(column.chunks(3)) {
                *moved += Vector3::from_column_slice(answer);
            }
            let reaction = body.tangent_times(&rest, &moved);
            for (row, own) in followers.iter().enumerate() {
                for a in 0..3 {
                    stiffness[(3 * row + a, 3 * k + c)] =
                        own.iter().filter(|(n, _)| !body.fixed[*n][a]).map(|(n, w)| w * reaction[*n][a]).sum::<f64>();
                }
            }
        }
    }
    // the matrix is symmetric except for rounding
    for i in 0..3 * kept {
        for j in 0..i {
            let mean = 0.5 * (stiffness[(i, j)] + stiffness[(j, i)]);
            stiffness[(i, j)] = mean;
            stiffness[(j, i)] = mean;
        }
    }
    Some(stiffness)
}
