//! Symplectic Euler with mass-proportional damping: `v = (1 - alpha dt) v + f dt / m`, `x += v dt`.
//!
//! (Paper 000, eq 3 is the same step; adding the "missing" half of `f dt^2 / m` while keeping `v =
//! dx / dt` would halve the acceleration.) `dt / m` holds the mass floor; it is zero for anchors.
//!
//! * in: `node.f`
//! * out: `node.v`, `node.x`
//! * cost (M4F, estimated): about 60 cycles a node
//! * may fail: [`Fault::Diverged`], when a node is not finite or faster than [`FASTEST_M_PER_S`]

use crate::fault::Fault;
use crate::lanes::ROW;
use crate::params::Tuned;
use crate::state::State;

/// Shear waves in soft tissue run at 1-10 m/s: whatever moves at 100 is not tissue.
pub const FASTEST_M_PER_S: f32 = 100.0;

/// Moves the free nodes by one substep and returns how many there are.
///
/// # Errors
/// [`Fault::Diverged`].
// inlined, it takes registers from the loops around it: 0.8 % more instructions per tick on the
// board
#[cfg_attr(any(feature = "stage-cost", target_os = "none"), inline(never))]
pub fn advance(tuned: &Tuned, state: &mut State) -> Result<u16, Fault> {
    let (keep, dt) = (tuned.keep, tuned.substep_s);
    let mut active = 0;
    for (node, &step) in state.nodes.iter_mut().zip(tuned.node_step.iter()) {
        if step == 0.0 {
            continue;
        }
        active += 1;
        let mut square = 0.0;
        for k in 0..ROW {
            let v = node.v[k] * keep + node.f[k] * step;
            node.v[k] = v;
            node.x[k] += v * dt;
            square += v * v;
        }
        #[expect(clippy::neg_cmp_op_on_partial_ord, reason = "a NaN is not slower than the limit")]
        if !(square <= FASTEST_M_PER_S * FASTEST_M_PER_S) {
            return Err(Fault::Diverged);
        }
    }
    Ok(active)
}
