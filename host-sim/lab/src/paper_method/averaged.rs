//! Average of the corrections that the springs of a node require: paper 000, eq (7).

use palpate::{NodeStep, State, Tuned, Vector3};

/// Sum of the corrections of every node, and number of springs from which they come.
#[derive(Clone, Debug, Default)]
pub struct Averaged {
    sums: Vec<(Vector3<f32>, f32)>,
}

impl Averaged {
    /// Reserves memory for `nodes` nodes, so that no step allocates.
    pub fn for_nodes(nodes: usize) -> Self {
        Self { sums: vec![(Vector3::zeros(), 0.0); nodes] }
    }

    /// Sets the sums of `nodes` nodes to zero. This allocates only in the first step, and only if
    /// no memory was reserved.
    pub fn clear(&mut self, nodes: usize) {
        self.sums.clear();
        self.sums.resize(nodes, (Vector3::zeros(), 0.0));
    }

    /// Adds the correction that one spring requires of a node [m].
    pub fn add(&mut self, node: usize, correction_m: Vector3<f32>) {
        if let Some((sum, count)) = self.sums.get_mut(node) {
            *sum += correction_m;
            *count += 1.0;
        }
    }

    /// Moves the free nodes by the average correction of their springs.
    pub fn apply(&self, tuned: &Tuned, state: &mut State) {
        for (n, (&(sum, count), &NodeStep { step, .. })) in self.sums.iter().zip(tuned.node_step()).enumerate() {
            if step > 0.0 && count > 0.0 {
                let node = state.nodes()[n];
                state.place(n, node.position_m() + sum * (1.0 / count), node.velocity_m_per_s());
            }
        }
    }
}
