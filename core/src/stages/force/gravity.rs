//! Weight of the nodes. This term uses the true mass (paper 000, eq 10), not the floored one: the
//! mass floor never affects statics.
//!
//! * in: volume of every node at rest
//! * out: forces added to `node.f`
//! * failures: none

use crate::lanes::{add, row};
use crate::model::Model;
use crate::params::Tuned;
use crate::state::State;

/// Adds density times volume times gravity, over E [N/Pa]. Does nothing if gravity is zero.
#[cfg_attr(feature = "stage-cost", inline(never))]
pub fn weigh(model: &Model, tuned: &Tuned, state: &mut State) {
    if tuned.weight == [0.0; 3] {
        return;
    }
    for (node, rest) in state.nodes.iter_mut().zip(model.nodes) {
        add(&mut node.f, &row(tuned.weight.map(|w| w * rest.volume_m3).into()));
    }
}
