//! Smooth fields: motions of many nodes together, on which the mass matrix is inverted exactly.
//!
//! With the two series terms of the inverse mass matrix that [`crate::stages::integrate`] uses,
//! nodes that move together still feel a third of the floor, and stiff tissue needs a floor of ten
//! to a hundred times its mass. Only a few fields are smooth enough to be affected, and they are
//! the ones that a hand moves. For `FIELDS` of them, the part that the series leaves out is added:
//! `a += phi gain (phi . f)`.
//!
//! A field starts as 1, x, y or z. In each round, every node takes the mean of its neighbours,
//! weighted by the mass between them. This is the power iteration of `1 - D^-1 A`; its slowest
//! fields belong to the smallest eigenvalues l of `D^-1 A`. For a field with the eigenvalue l the
//! gain is `(1 / l - (3 - 2 l)) / (phi . D phi) = (1 - l) (1 - 2 l) / l / (phi . D phi)`, or zero
//! from l = 1/2 on. The sum stays symmetric and positive definite for *any* field, so a field that
//! has not converged costs accuracy only.
//!
//! A board that has no time for the sum over neighbours adds the smoothest field to the diagonal
//! alone ([`crate::Terms::smooth_mass`]): `a = D^-1 f + phi gain (phi . f)`, with the gain
//! `(1 / l - 1) / (phi . D phi)`.
//!
//! Contact is implicit in a node's own mass ([`crate::stages::force::foundation`]): a force on a
//! pressed node acts divided by `1 + K b`. The node takes the same share of a field's motion.
//! Otherwise it would drive the field with one share and follow it with another, and patches of 410
//! nodes rang under a probe at rest.
//!
//! All functions are `inline` so that a board's image compiles them for size, with the crate that
//! opens patches.
//!
//! * in: the masses of [`crate::Params::build`]
//! * out: `NodeStep::smooth` and the gains
//! * cost: nothing within the tick; 128 passes over the springs when a patch is started, five when
//!   its modulus changes; a quarter of that with one field
//! * failures: none; a field that is not finite is left out

use crate::inertia::{FIELDS, Gains, NEIGHBOUR, NodeStep};
use crate::model::{Model, Spring};

/// Rounds of averaging. On the finest shipped patch, a second field converges by 7 % per round.
const ROUNDS: usize = 32;

/// Smallest eigenvalue that single precision resolves (1): a field feels at least this share of its
/// diagonal mass.
const LEAST: f32 = 0.01;

/// Finds the fields of these masses and sets unused ones to zero; `after_round` is called after
/// every round.
#[inline]
pub(crate) fn find(model: &Model, node_step: &mut [NodeStep], series: bool, after_round: &mut dyn FnMut()) {
    for (node, rest) in node_step.iter_mut().zip(model.nodes) {
        let [x, y, z] = rest.rest_m;
        node.smooth = match (node.step > 0.0, series) {
            (true, true) => [1.0, x, y, z],
            (true, false) => [1.0, 0.0, 0.0, 0.0],
            (false, _) => [0.0; FIELDS],
        };
    }
    for field in 0..count(series) {
        // x, y and z are first made orthogonal to the earlier fields, which would otherwise
        // dominate them
        clear_of_earlier(node_step, field);
        for _ in 0..ROUNDS {
            scale(node_step, field);
            average(model, node_step, field);
            after_round();
        }
        clear_of_earlier(node_step, field);
        scale(node_step, field);
    }
}

/// Value of a field at a node. A modulus changes between two ticks, so this must not panic: the
/// remainder makes sure of that and takes no instruction.
#[inline(always)]
fn at(node: &NodeStep, field: usize) -> f32 {
    node.smooth[field % FIELDS]
}

/// Number of fields: all of them with the two terms of the series, one with the diagonal alone.
#[inline]
const fn count(series: bool) -> usize {
    if series { FIELDS } else { 1 }
}

/// Gains of the fields that [`find`] computed, for the present masses.
#[inline]
pub(crate) fn gains(model: &Model, node_step: &[NodeStep], series: bool) -> Gains {
    let mut gains = [0.0; FIELDS];
    for (field, gain) in gains.iter_mut().enumerate().take(count(series)) {
        *gain = gain_of(model, node_step, field, series);
    }
    gains
}

#[inline]
fn gain_of(model: &Model, node_step: &[NodeStep], field: usize, series: bool) -> f32 {
    let mut between = 0.0;
    for spring in model.springs {
        let Some((a, b, mass)) = ends(spring, node_step) else { continue };
        between += mass * at(a, field) * at(b, field);
    }
    let all = product(node_step, field, field);
    let l = 1.0 - 2.0 * between / all;
    let l = if l < LEAST { LEAST } else { l };
    let (lacks, below) = if series { ((1.0 - l) * (1.0 - 2.0 * l), 0.5) } else { (1.0 - l, 1.0) };
    let gain = lacks / (l * all);
    if l < below && gain.is_finite() { gain } else { 0.0 }
}

/// Both ends of a spring and the mass between them, over `E dt`.
#[inline]
fn ends<'a>(spring: &Spring, node_step: &'a [NodeStep]) -> Option<(&'a NodeStep, &'a NodeStep, f32)> {
    let (a, b) = (node_step.get(usize::from(spring.i))?, node_step.get(usize::from(spring.j))?);
    Some((a, b, spring.k * (a.added + b.added) * (1.0 / NEIGHBOUR)))
}

/// Runs one round: every node takes the mean of its neighbours.
#[inline]
fn average(model: &Model, node_step: &mut [NodeStep], field: usize) {
    for node in node_step.iter_mut() {
        node.next = 0.0;
    }
    for spring in model.springs {
        let Some((a, b, mass)) = ends(spring, node_step) else { continue };
        let (to_i, to_j) = (mass * at(b, field), mass * at(a, field));
        for (n, part) in [(spring.i, to_i), (spring.j, to_j)] {
            if let Some(node) = node_step.get_mut(usize::from(n)) {
                node.next += part;
            }
        }
    }
    for node in node_step.iter_mut() {
        node.smooth[field % FIELDS] = node.next * node.step;
    }
}

/// Divides a field by its largest value; one that is zero or not finite becomes zero.
#[inline]
fn scale(node_step: &mut [NodeStep], field: usize) {
    let mut largest = 0.0_f32;
    for node in node_step.iter() {
        let size = node.smooth[field % FIELDS].abs();
        // a NaN is kept
        largest = if size <= largest { largest } else { size };
    }
    let share = 1.0 / largest;
    let share = if share > 0.0 && share.is_finite() { share } else { 0.0 };
    for node in node_step.iter_mut() {
        node.smooth[field % FIELDS] = if share > 0.0 { node.smooth[field % FIELDS] * share } else { 0.0 };
    }
}

/// Subtracts from a field its parts along the earlier fields.
#[inline]
fn clear_of_earlier(node_step: &mut [NodeStep], field: usize) {
    for earlier in 0..field {
        let own = product(node_step, earlier, earlier);
        let share = if own > 0.0 { product(node_step, field, earlier) / own } else { 0.0 };
        for node in node_step.iter_mut() {
            node.smooth[field % FIELDS] -= share * at(node, earlier);
        }
    }
}

/// Inner product of two fields, weighted with the diagonal of the mass matrix, over `E dt`.
#[inline]
fn product(node_step: &[NodeStep], a: usize, b: usize) -> f32 {
    node_step.iter().filter(|node| node.step > 0.0).map(|node| at(node, a) * at(node, b) / node.step).sum()
}
