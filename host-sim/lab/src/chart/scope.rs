//! Scope of the chart: which methods, mesh sizes and stiffnesses are run.

use serde::{Deserialize, Serialize};

use crate::methods::Method;

/// One row of the chart, to be measured.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Task {
    /// Method to be measured.
    pub method: Method,
    /// Number of nodes of the mesh.
    pub nodes: usize,
    /// Young's modulus [Pa].
    pub youngs_modulus_pa: f64,
    /// Number of parts into which each surviving substep is split.
    pub refinement: u16,
}

/// The rows of a chart, and whether they include the moving error.
#[derive(Clone, Debug, PartialEq)]
pub struct Scope {
    /// Rows in the order in which they are run; those of one mesh and stiffness are adjacent.
    pub tasks: Vec<Task>,
    /// Whether the moving error is measured too.
    pub moving: bool,
}

/// Numbers of parts into which a chart with moving errors splits the substeps, to compare the gain
/// from shorter substeps with the gain from more nodes.
const REFINEMENTS: [u16; 3] = [1, 2, 4];

impl Scope {
    /// The whole chart: 4 sizes at 3.5 and 20 kPa, and also at 100 kPa if moving errors are
    /// measured.
    pub fn full(moving: bool) -> Self {
        let moduli_pa = [3500.0, 20_000.0, 100_000.0];
        Self::of(&[57, 130, 410, 1020], if moving { &moduli_pa } else { &moduli_pa[..2] }, moving)
    }

    /// The two smallest sizes at 3.5 kPa.
    pub fn quick(moving: bool) -> Self {
        Self::of(&[57, 130], &[3500.0], moving)
    }

    /// All methods at these sizes and stiffnesses [Pa].
    pub fn of(sizes: &[usize], moduli_pa: &[f64], moving: bool) -> Self {
        let mut tasks = Vec::new();
        for &youngs_modulus_pa in moduli_pa {
            for &nodes in sizes {
                // a law has no mesh: it is one row beside all sizes
                let of_size = |method: &Method| *method != Method::Law || sizes.first() == Some(&nodes);
                for method in Method::ALL.into_iter().filter(of_size) {
                    let splits = if moving && method.takes_substeps() { &REFINEMENTS[..] } else { &REFINEMENTS[..1] };
                    tasks.extend(splits.iter().map(|&refinement| Task { method, nodes, youngs_modulus_pa, refinement }));
                }
            }
        }
        Self { tasks, moving }
    }
}
