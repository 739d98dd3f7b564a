//! Sum of all forces on the nodes, divided by Young's modulus [N/Pa].
//!
//! * in: node positions and velocities, the probe
//! * out: `node.f`; the probe's load on the tissue
//! * cost: see the terms
//! * failures: none; `integrate` detects a divergence

#[cfg(armv7em_fp)]
mod armv7em;
pub mod compensation;
pub mod foundation;
pub mod friction;
pub mod gravity;
pub mod relaxation;
pub mod rim;
pub mod spring;
#[cfg(not(target_os = "none"))]
pub mod stiffening;
pub mod volume;

use nalgebra::Vector3;

use crate::lanes::ROW;
use crate::model::Model;
use crate::params::Tuned;
use crate::state::State;
use foundation::Load;

/// Clears the last substep's forces and adds every active term, contact last, because it depends on
/// the other forces on a node. In tissue that relaxes, contact ends with [`relaxation`].
// inlined on boards only: in another crate of a desktop its loops would be compiled anew, in pieces
// whose small functions are not inlined, and take twice as long
#[cfg_attr(all(target_os = "none", not(feature = "stage-cost")), inline(always))]
pub fn accumulate(model: &Model, tuned: &Tuned, state: &mut State, tip_m: Vector3<f32>, velocity_m_per_s: Vector3<f32>) -> Load {
    #[cfg(not(target_os = "none"))]
    if tuned.stiffens() {
        return stiffening::accumulate(model, tuned, state, tip_m, velocity_m_per_s);
    }
    accumulate_inner(model, tuned, state);
    foundation::press(model, tuned, state, tip_m, velocity_m_per_s)
}

/// Adds every term except contact and stiffening. A method with forces of its own adds them between
/// this call and [`foundation::press`].
#[cfg_attr(all(target_os = "none", not(feature = "stage-cost")), inline(always))]
pub fn accumulate_inner(model: &Model, tuned: &Tuned, state: &mut State) {
    for node in state.nodes.iter_mut() {
        node.f = [0.0; ROW];
        node.p = 0.0;
    }
    gravity::weigh(model, tuned, state);
    spring::pull(model, tuned, state);
    if tuned.terms.volume {
        volume::resist(model, tuned, state);
    }
    if tuned.terms.rim {
        rim::hold(model, state);
    }
}
