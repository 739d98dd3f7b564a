//! Reasons for which a motion has no dynamic reference.

use palpate_tissue::error::Error;

/// Reason why a motion cannot be computed.
#[derive(Debug, thiserror::Error)]
pub enum DynamicError {
    /// Finite elements cannot solve the scene, or the tissue cannot be meshed.
    #[error(transparent)]
    Scene(#[from] Error),
    /// A parameter of the motion is out of range.
    #[error("motion.{key} = {value}: must be {range}")]
    Motion {
        /// Name of the parameter, with its unit.
        key: &'static str,
        /// Value of the parameter.
        value: f64,
        /// Description of the allowed values.
        range: &'static str,
    },
    /// A setting of the computation is out of range.
    #[error("settings.{key} = {value}: must be {range}")]
    Setting {
        /// Name of the setting, with its unit.
        key: &'static str,
        /// Value of the setting.
        value: f64,
        /// Description of the allowed values.
        range: &'static str,
    },
    /// The Cholesky factor does not fit into memory.
    #[error("not enough memory for {nodes} nodes: use fewer corner_nodes")]
    Memory {
        /// Number of nodes of the quadratic mesh.
        nodes: usize,
    },
    /// Newton's method found no solution, even with the shortest step.
    #[error("no solution beyond {t_s} s, tip {depth_m} m deep: use a shorter step_s or more corner_nodes")]
    Stalled {
        /// Time of the last solution [s].
        t_s: f64,
        /// Depth of the tip at that time [m].
        depth_m: f64,
    },
}
