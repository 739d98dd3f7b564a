//! Inertia of a node as the tick reads it.

/// Number of smooth fields on which the mass matrix is inverted exactly: see `smooth.rs`.
pub const FIELDS: usize = 4;

/// One gain per field, `E dt / mass` [m/s per (N/Pa)]; zero where the field is not used.
pub type Gains = [f32; FIELDS];

/// Weight of a node's neighbours in its acceleration (1): see `stages/integrate.rs`. From 2.5 on,
/// the approximate mass matrix of shipped patches is no longer positive definite; with 1, a smooth
/// motion feels half of the floor.
pub(crate) const NEIGHBOUR: f32 = 2.0;

/// Inertia of a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeStep {
    /// `E dt / D` [m/s per (N/Pa)], with D the diagonal of the mass matrix; 0 for anchors.
    pub step: f32,
    /// This node's half of the mass between it and each neighbour, over the stiffness of their
    /// spring, times `NEIGHBOUR` and divided by `dt` [s].
    pub added: f32,
    /// Smooth fields at the node (1): see `smooth.rs`; zero for anchors.
    pub smooth: [f32; FIELDS],
    /// Scratch memory of the search for the fields.
    pub(crate) next: f32,
}

impl NodeStep {
    /// Initial value of reserved memory.
    pub const ZERO: Self = Self { step: 0.0, added: 0.0, smooth: [0.0; FIELDS], next: 0.0 };
}

/// Power that the mass added by the floor absorbs in a tick: see `stages/integrate.rs`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Floored {
    /// Sum over the substeps of the power that the floored masses absorb beyond the true masses,
    /// over E [W/Pa]; negative while they return it.
    pub power: f32,
    /// Square of the fastest node's speed [m^2/s^2].
    pub fastest: f32,
}

impl Floored {
    /// The value while every node is at rest.
    pub const NONE: Self = Self { power: 0.0, fastest: 0.0 };
}
