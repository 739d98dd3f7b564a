//! Hanging organs: weight, ties, moved nodes and derived quantities, each compared with an
//! independent computation.

mod derivatives;
mod tied;
mod turned;
mod weight;

use palpate::Vector3;
use palpate_fit::reference::body::{Body, Stiffness};
use palpate_fit::reference::quadratic::QuadraticMesh;
use palpate_fit::reference::shape::TetRule;
use palpate_tissue::mesh::{BlockSpec, TetMesh, block};

/// A block with a corner at x = y = 0, its top at z = 0 and a uniform mesh.
fn bar(size_m: [f64; 3], nodes: usize) -> TetMesh {
    let even = BlockSpec { size_m, nodes, fine_at_m: [0.0; 2], fine_radius_m: 1.0 };
    let mut mesh = block(&even).expect("meshed");
    for node in &mut mesh.nodes_m {
        node[0] += 0.5 * size_m[0];
        node[1] += 0.5 * size_m[1];
    }
    mesh
}

/// A body of uniform stiffness in which some displacement components of the nodes are fixed.
fn body(mesh: QuadraticMesh, poisson_ratio: f64, fixed: impl Fn(&Vector3<f64>) -> [bool; 3]) -> Body {
    let fixed = mesh.nodes_m.iter().map(fixed).collect();
    Body::with_stiffness(
        mesh,
        |_, _| Stiffness { ratio: 1.0, poisson_ratio, stiffening_b: 0.0 },
        fixed,
        vec![],
        1.0,
        TetRule::Four,
    )
}

/// Nodes of a mesh whose positions satisfy a condition.
fn nodes_where(mesh: &QuadraticMesh, at: impl Fn(&Vector3<f64>) -> bool) -> Vec<u32> {
    (0_u32..).zip(&mesh.nodes_m).filter(|(_, x)| at(x)).map(|(n, _)| n).collect()
}

pub fn assert_within(what: &str, value: f64, known: f64, share: f64) {
    assert!((value / known - 1.0).abs() < share, "{what}: {value:e}, should be {known:e} within {share:e}");
}
