//! Friction that the state keeps: see [`crate::stages::force::friction`].

use nalgebra::Vector3;

/// The bristle of a node.
#[derive(Clone, Copy, Debug)]
pub struct Bristle {
    /// Position of the root on the probe, relative to the probe's centre [m].
    pub(crate) root_m: Vector3<f32>,
    /// Stiffness of the bristle over E in the last substep [m]; zero when the node first touches.
    pub(crate) slope: f32,
    /// Node that the bristle pulls.
    pub(crate) node: u16,
}

impl Bristle {
    /// A bristle that never touched: the initial value of reserved memory.
    pub const ZERO: Self = Self { root_m: Vector3::new(0.0, 0.0, 0.0), slope: 0.0, node: 0 };
}

/// Friction of a tick.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rubbed {
    /// Sum over the substeps of the force on the tissue over E [N/Pa].
    pub force: Vector3<f32>,
    /// Sum over the substeps of the largest force that friction could have carried [N/Pa].
    pub most: f32,
}

impl Rubbed {
    pub const NONE: Self = Self { force: Vector3::new(0.0, 0.0, 0.0), most: 0.0 };
}
