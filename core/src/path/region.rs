//! Which nodes move: all of them, or those near the contact (paper 004, the local region; stress rule (7)-(8) gives its radius).
//!
//! * in: the contact of the last tick
//! * out: the region
//! * cost: nothing while all nodes move; else one comparison a node
//! * may fail: never

use nalgebra::Vector3;

use crate::params::Tuned;
use crate::state::State;

/// The nodes that move in this tick.
#[derive(Clone, Copy, Debug)]
pub enum Region {
    /// Every free node.
    All,
    /// Free nodes whose rest position is within a ball. The rest stand still where they are.
    Ball {
        /// Centre: the contact, on the rest surface [m].
        centre_m: Vector3<f32>,
        /// Radius squared [m^2].
        radius_squared_m2: f32,
    },
}

/// Chooses the region.
pub fn select(tuned: &Tuned, state: &State) -> Region {
    match state.touch {
        Some(touch) if tuned.region_radius_m.is_finite() => {
            Region::Ball { centre_m: touch.rest_m, radius_squared_m2: tuned.region_radius_m * tuned.region_radius_m }
        }
        _ => Region::All,
    }
}

impl Region {
    /// True if a node with this rest position moves.
    #[inline(always)]
    pub(crate) fn contains(&self, rest_m: [f32; 3]) -> bool {
        match self {
            Self::All => true,
            Self::Ball { centre_m, radius_squared_m2 } => {
                let d = Vector3::from(rest_m) - centre_m;
                d.dot(&d) <= *radius_squared_m2
            }
        }
    }
}
