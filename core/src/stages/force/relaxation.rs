//! Relaxation: the force that holds tissue in a shape fades, and the tissue keeps a memory of it.
//!
//! This is nodal quasi-linear viscoelasticity: the elastic force f at each node, whatever terms it
//! came from, becomes `f - sum g (low-pass filtered f)`, with up to three time constants. The
//! filter is linear and the same everywhere. So in a hold after a step to any depth, the force
//! fades as `1 - sum g (1 - exp(-t / tau))`, and the shape is the elastic one. The memory belongs
//! to the tissue: a probe that slides on meets tissue that has not relaxed, and a dent recovers as
//! the faded force returns.
//!
//! One memory serves a node and the foundation above it. Both carry the same force: the node's
//! elastic force and the push are in balance except for inertia, which has no lasting part. So the
//! push fades with the memory of the node ([`super::foundation`]), and the equilibrium of a held
//! node does not shift.
//!
//! Weight is filtered with the other forces: hanging tissue does not creep further.
//!
//! * in: `node.f`, the elastic forces; `node.pass`, the push of the probe, faded already
//! * out: `node.f` of free nodes, the forces that act (at an anchor, where a force moves nothing,
//!   the elastic force); the memory; `node.pass`, set to zero
//! * cost (M4F, estimated): 75 cycles per node, 30 more with three terms
//! * failures: none

use crate::lanes::ROW;
use crate::params::Tuned;
use crate::state::State;

/// Fades the elastic forces over E [N/Pa] by one substep and adds the pushes.
#[cfg_attr(not(feature = "stage-cost"), inline(always))]
pub(crate) fn fade(tuned: &Tuned, state: &mut State) {
    match tuned.prony.terms {
        // a term whose constants are zero changes no bit
        1 | 2 => by_terms::<2>(tuned, state),
        _ => by_terms::<3>(tuned, state),
    }
}

#[cfg_attr(feature = "stage-cost", inline(never))]
fn by_terms<const TERMS: usize>(tuned: &Tuned, state: &mut State) {
    let prony = tuned.prony;
    for ((node, faded), inertia) in state.nodes.iter_mut().zip(state.faded.iter_mut()).zip(tuned.node_step.iter()) {
        if inertia.step == 0.0 {
            // an anchor carries its push as in elastic tissue: none of it fades
            for (f, push) in node.f.iter_mut().zip(node.pass) {
                *f += push;
            }
            node.pass = [0.0; ROW];
            continue;
        }
        let (elastic, mut acts) = (node.f, node.pass);
        for (f, e) in acts.iter_mut().zip(elastic) {
            *f += prony.stays * e;
        }
        for ((faded, rises), fades) in faded.0.iter_mut().zip(prony.rises).zip(prony.fades).take(TERMS) {
            for ((f, s), e) in acts.iter_mut().zip(faded).zip(elastic) {
                let h = *s + rises * e;
                *s -= fades * h;
                *f += h;
            }
        }
        (node.f, node.pass) = (acts, [0.0; ROW]);
    }
}
