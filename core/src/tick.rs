//! **Open this first.** The path of one tick, in data order.
//!
//! ```text
//! pose ─ probe ─ contact ───┬─ force ──────────── integrate ──┬─ output ─ force on the probe
//!        guard:   triangles │  gravity, springs,  symplectic  │  reaction [N], depth,
//!        finite,  the probe │  volume, rim,       Euler,      │  normal, limiters
//!        presence,can reach │  foundation         mass floor  │
//!        speed, depth       └─────── once per substep ────────┘
//! ```
//! A tick answers one sensed pose with one force, every millisecond, and must end before the next
//! one. It allocates nothing and cannot panic; any failure gives **zero force and a numbered
//! fault**, latched until [`State::reset`]. A probe that starts inside the tissue gets no force
//! until it has been outside, nor does one that left other than through the surface
//! ([`crate::stages::presence`]). [`crate::stages`] says how further terms take part.

use crate::bristle::Rubbed;
use crate::fault::Fault;
use crate::inertia::Floored;
use crate::method::{Method, Product};
use crate::model::Model;
use crate::params::Tuned;
use crate::stages::force::foundation::Load;
use crate::stages::output::Output;
use crate::stages::probe::ProbePose;
use crate::stages::{contact, output, probe};
use crate::state::State;

/// Runs one tick of the product, as in `examples/tick.rs`.
#[cfg_attr(feature = "stage-cost", inline(never))]
pub fn tick(model: &Model, tuned: &Tuned, state: &mut State, pose: ProbePose) -> Output {
    tick_with(model, tuned, state, pose, &mut Product)
}

/// Runs one tick with another method; [`crate::method`] lists the stages that it may replace.
pub fn tick_with(model: &Model, tuned: &Tuned, state: &mut State, pose: ProbePose, method: &mut impl Method) -> Output {
    let answer = match state.fault {
        None => run(model, tuned, state, pose, method),
        Some(fault) => Err(fault),
    };
    answer.unwrap_or_else(|fault| {
        state.fault = Some(fault);
        state.touch = None;
        Output { fault: Some(fault), ..Output::NONE }
    })
}

fn run(model: &Model, tuned: &Tuned, state: &mut State, pose: ProbePose, method: &mut impl Method) -> Result<Output, Fault> {
    if state.nodes.len() != model.nodes.len() || tuned.node_step.len() != model.nodes.len() {
        return Err(Fault::SizeMismatch);
    }
    if tuned.remembers {
        let no_memory = tuned.relaxes() && state.faded.len() != model.nodes.len();
        if no_memory || tuned.rubs() && state.bristles.is_empty() {
            return Err(Fault::SizeMismatch);
        }
        state.rubbed = Rubbed::NONE;
    }
    state.floored = Floored::NONE;
    let mut motion = probe::admit(model, tuned, state, pose)?;
    contact::find(model, tuned, state, &mut motion);
    if !tuned.rubs() {
        // switching friction off discards the bristles
        state.rubbing = 0;
    }
    method.begin(tuned, state);
    let mut total = Load::NONE;
    let mut active = 0;
    for substep in 1..=tuned.substeps {
        let tip_m = motion.at(f32::from(substep) * tuned.substep_share);
        let load = method.force(model, tuned, state, tip_m, motion.velocity_m_per_s);
        active = method.advance(model, tuned, state)?;
        method.correct(model, tuned, state);
        total.add(&load);
    }
    let output = output::read(model, tuned, state, &motion, &total, active);
    state.previous_m_per_s = motion.velocity_m_per_s;
    output
}
