//! Plan of the chart: methods, sizes, stiffnesses.

use crate::rivals::Method;

/// One row to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Task {
    /// Method.
    pub method: Method,
    /// Nodes of the mesh.
    pub nodes: usize,
    /// Young's modulus [Pa].
    pub youngs_modulus_pa: f64,
}

/// Rows, mesh by mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Rows in the order of running: those of one mesh and stiffness together.
    pub tasks: Vec<Task>,
}

impl Plan {
    /// Everything: 4 sizes, 3.5 and 20 kPa.
    #[must_use]
    pub fn full() -> Self {
        Self::of(&[57, 130, 410, 1020], &[3500.0, 20_000.0])
    }

    /// The two smallest sizes at 3.5 kPa.
    #[must_use]
    pub fn quick() -> Self {
        Self::of(&[57, 130], &[3500.0])
    }

    /// All methods at these sizes and stiffnesses [Pa].
    #[must_use]
    pub fn of(sizes: &[usize], moduli_pa: &[f64]) -> Self {
        let mut tasks = Vec::new();
        for &youngs_modulus_pa in moduli_pa {
            for &nodes in sizes {
                tasks.extend(Method::ALL.map(|method| Task { method, nodes, youngs_modulus_pa }));
            }
        }
        Self { tasks }
    }
}
