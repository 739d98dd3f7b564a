//! Symplectic Euler with mass-proportional damping: `v = (1 - alpha dt) v + dt a`, `x += v dt`.
//!
//! (Paper 000, eq 3 is the same step; adding the "missing" half of `f dt^2 / m` while keeping `v =
//! dx / dt` would halve the acceleration.)
//!
//! A step of one millisecond needs more mass than small elements have. The mass floor adds it
//! *between* neighbours, as a mass matrix `A = diag(m) + L` with m the true masses and L the
//! Laplacian of weights w on the springs. This slows the motion of nodes relative to each other,
//! which is what limits the step, and leaves their common motion, which a moving probe feels,
//! nearly as light as it is. `a = A^-1 f` is approximated by two terms of its series about the
//! diagonal D of A: with `y = D^-1 f`, `a_i = y_i + 2 / D_i sum_j w_ij y_j`. In terms of the
//! eigenvalues l of `D^-1 A`, which are below 1.5 in all patches, this puts the factor `3 - 2 l` in
//! place of `1 / l`. That factor is positive, so the approximate matrix is a mass matrix too and
//! adds no energy. It is 1 for a node between fixed ones, which sets the longest stable step, and 3
//! for smooth motion, which therefore feels a third of the floor. On the smoothest fields the
//! difference from `1 / l` is added (`core/src/smooth.rs`), so that they feel the exact matrix.
//! Where a board has no time for the sum over neighbours, the smoothest field is added to the
//! diagonal alone (`Terms::smooth_mass`). Statics do not depend on mass at all.
//!
//! The force that the approximate masses need beyond the true ones is known at every node without
//! the matrix: `r = f - m (v' - (1 - alpha dt) v) / dt`. Its power `sum r . (v + v') / 2` is the
//! rate at which the hand does work on mass that tissue does not have; [`crate::stages::output`]
//! takes it out of the force.
//!
//! * in: `node.f`
//! * out: `node.v`, `node.x`; the power absorbed by the added mass, `State::floored`
//! * cost (M4F, estimated): about 95 cycles per node, with one field 125; with relative masses
//!   about 70 more per spring and 90 per node
//! * failures: [`Fault::Diverged`], when a node is not finite or faster than [`FASTEST_M_PER_S`]

use crate::fault::Fault;
use crate::inertia::FIELDS;
use crate::lanes::{ROW, Row};
#[cfg(target_os = "none")]
use crate::lanes::{row, vector};
use crate::model::Model;
use crate::params::Tuned;
use crate::state::State;

/// Speed above which the integration has diverged [m/s]: shear waves in soft tissue run at 1-10
/// m/s.
pub const FASTEST_M_PER_S: f32 = 100.0;

/// Moves the free nodes by one substep and returns how many there are.
///
/// # Errors
/// Fails with [`Fault::Diverged`] if a node is not finite or faster than [`FASTEST_M_PER_S`].
// inlining it would take registers from the loops around it: 0.8 % more instructions per tick on
// the board
#[cfg_attr(any(feature = "stage-cost", target_os = "none"), inline(never))]
pub fn advance(model: &Model, tuned: &Tuned, state: &mut State) -> Result<u16, Fault> {
    match (tuned.relative_mass, tuned.fields) {
        (true, _) => {
            let moved = accelerate(model, tuned, state);
            drift::<true, true>(model, tuned, state, &moved)
        }
        (false, true) => {
            let moved = smoothest(tuned, state);
            drift::<false, true>(model, tuned, state, &moved)
        }
        (false, false) => drift::<false, false>(model, tuned, state, &[[0.0; ROW]; FIELDS]),
    }
}

/// Two factors for twice the power over E that a true mass absorbs in a substep, damping included,
/// per volume [s/m^2]: the first multiplies the square of its speed after the substep, the second
/// the square of its speed before it, to be subtracted.
#[inline(always)]
fn true_power(tuned: &Tuned) -> (f32, f32) {
    (tuned.density_rate * (1.5 - 0.5 * tuned.keep), tuned.density_rate * (1.5 * tuned.keep - 0.5))
}

/// Velocity that the smoothest field gains in this substep.
fn smoothest(tuned: &Tuned, state: &State) -> [Row; FIELDS] {
    let mut moved = [[0.0; ROW]; FIELDS];
    let [sum, ..] = &mut moved;
    for (node, inertia) in state.nodes.iter().zip(tuned.node_step.iter()) {
        let [smooth, ..] = inertia.smooth;
        for (sum, f) in sum.iter_mut().zip(node.f) {
            *sum += f * smooth;
        }
    }
    let [gain, ..] = tuned.gains;
    for part in sum {
        *part *= gain;
    }
    moved
}

/// Moves the nodes. With `ACCELERATED`, their velocities are already the new ones except for the
/// part of the smooth fields, which `moved` gives as one velocity per field. Otherwise the new
/// velocities are computed here, with the first field alone if `FIELDS_MOVE`.
#[inline(always)]
fn drift<const ACCELERATED: bool, const FIELDS_MOVE: bool>(
    model: &Model,
    tuned: &Tuned,
    state: &mut State,
    moved: &[Row; FIELDS],
) -> Result<u16, Fault> {
    let (keep, dt) = (tuned.keep, tuned.substep_s);
    let (after, earlier) = true_power(tuned);
    let (mut active, mut power, mut fastest) = (0, 0.0, 0.0);
    for ((node, inertia), rest) in state.nodes.iter_mut().zip(tuned.node_step.iter()).zip(model.nodes) {
        let step = inertia.step;
        if ACCELERATED {
            node.pass = [0.0; ROW];
        }
        if step == 0.0 {
            continue;
        }
        active += 1;
        let (mut before, mut square, mut gained) = (0.0, 0.0, 0.0);
        let free = node.free;
        if FIELDS_MOVE {
            node.free = 1.0;
        }
        #[expect(clippy::needless_range_loop, reason = "one axis of several rows")]
        for k in 0..ROW {
            let [p, q, r, s] = inertia.smooth;
            let v = match (ACCELERATED, FIELDS_MOVE) {
                (true, _) => node.v[k] + free * ((moved[0][k] * p + moved[1][k] * q) + (moved[2][k] * r + moved[3][k] * s)),
                (false, true) => node.v[k] * keep + node.f[k] * step + free * (moved[0][k] * p),
                (false, false) => node.v[k] * keep + node.f[k] * step,
            };
            let mut twice_mean = v;
            if !ACCELERATED {
                before += node.v[k] * node.v[k];
                twice_mean += node.v[k];
            }
            node.v[k] = v;
            node.x[k] += v * dt;
            square += v * v;
            gained += node.f[k] * twice_mean;
        }
        power += gained - rest.volume_m3 * (after * square - earlier * before);
        fastest = if square > fastest { square } else { fastest };
        #[expect(clippy::neg_cmp_op_on_partial_ord, reason = "a NaN is not slower than the limit")]
        if !(square <= FASTEST_M_PER_S * FASTEST_M_PER_S) {
            return Err(Fault::Diverged);
        }
    }
    state.floored.power += 0.5 * power;
    state.floored.fastest = if fastest > state.floored.fastest { fastest } else { state.floored.fastest };
    Ok(active)
}

/// Computes the new velocities with the mass matrix: first each node's own part, then that of its
/// neighbours. The order of additions *at each node* is the patch's. Returns the velocity of every
/// smooth field.
#[cfg_attr(feature = "stage-cost", inline(never))]
fn accelerate(model: &Model, tuned: &Tuned, state: &mut State) -> [Row; FIELDS] {
    let keep = tuned.keep;
    let mut moved = [[0.0; ROW]; FIELDS];
    let (_, earlier) = true_power(tuned);
    let mut power = 0.0;
    for ((node, inertia), rest) in state.nodes.iter_mut().zip(tuned.node_step.iter()).zip(model.nodes) {
        let (mut before, mut gained) = (0.0, 0.0);
        for k in 0..ROW {
            let f = node.f[k];
            before += node.v[k] * node.v[k];
            gained += f * node.v[k];
            let y = f * inertia.step;
            node.pass[k] = y;
            node.v[k] = node.v[k] * keep + y;
            for (sum, smooth) in moved.iter_mut().zip(inertia.smooth) {
                sum[k] += f * smooth;
            }
        }
        power += gained + rest.volume_m3 * earlier * before;
    }
    state.floored.power += 0.5 * power;
    for (sum, gain) in moved.iter_mut().zip(tuned.gains) {
        for part in sum {
            *part *= gain;
        }
    }
    #[cfg(target_os = "none")]
    by_rows(model, tuned, state);
    #[cfg(not(target_os = "none"))]
    by_springs(model, tuned, state);
    moved
}

/// Adds the neighbours' part, spring by spring.
#[cfg(not(target_os = "none"))]
fn by_springs(model: &Model, tuned: &Tuned, state: &mut State) {
    for spring in model.springs {
        let [i, j] = [spring.i, spring.j].map(usize::from);
        let (Some(&a), Some(&b)) = (tuned.node_step.get(i), tuned.node_step.get(j)) else { return };
        let (Some(y_i), Some(y_j)) = (state.nodes.get(i).map(|n| n.pass), state.nodes.get(j).map(|n| n.pass)) else { return };
        let mass = spring.k * (a.added + b.added);
        for (n, y, gain) in [(i, y_j, mass * a.step), (j, y_i, mass * b.step)] {
            if let Some(node) = state.nodes.get_mut(n) {
                for (v, y) in node.v.iter_mut().zip(y) {
                    *v += y * gain;
                }
            }
        }
    }
}

/// Adds the neighbours' part, node by node, with the sums of one node in registers.
#[cfg(target_os = "none")]
fn by_rows(model: &Model, tuned: &Tuned, state: &mut State) {
    let mut springs = model.springs;
    for (i, &count) in model.spring_rows.iter().enumerate() {
        let Some((mine, others)) = springs.split_at_checked(usize::from(count)) else { return };
        springs = others;
        let (Some(node), Some(&a)) = (state.nodes.get(i), tuned.node_step.get(i)) else { return };
        let (y_i, mut v_i) = (vector(&node.pass), vector(&node.v));
        for spring in mine {
            let j = usize::from(spring.j);
            let (Some(other), Some(&b)) = (state.nodes.get_mut(j), tuned.node_step.get(j)) else { return };
            let mass = spring.k * (a.added + b.added);
            v_i += vector(&other.pass) * (mass * a.step);
            other.v = row(vector(&other.v) + y_i * (mass * b.step));
        }
        if let Some(node) = state.nodes.get_mut(i) {
            node.v = row(v_i);
        }
    }
}
