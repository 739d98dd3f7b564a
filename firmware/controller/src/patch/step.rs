//! Checks that one substep can be stable, from the masses and stiffnesses in the file and not from
//! the step limit that the file states.
//!
//! The tick floors the diagonal of its mass matrix at about `f E D T^2`, with D the mean diagonal
//! stiffness *that the file gives for each node*. Here D is recomputed from springs, tets and rim,
//! the constants are compared with the rest shape, and every mass must be at least [`LEAST_FLOOR`]
//! times `E D dt^2`. D is the stiffness of tissue under load: it includes the compensation of every
//! spring and the barrier of every tet. The mass is the effective mass of a node that moves alone,
//! including the contribution of the smooth fields.
//!
//! Two further properties of a file are bounded. The tick approximates the inverse mass matrix by
//! two terms of its series. The result is positive definite only while `I + N` is, where N is the
//! part of a node's acceleration that its neighbours add: the least eigenvalue of N is found by
//! power iteration (`series`). And the foundation, which is implicit at each node but not between
//! nodes, may be at most [`MOST_CONTACT`] times as stiff as the tissue under it (`contact`).
//!
//! These checks do not prove that the whole patch is stable: divergence is still detected in the
//! tick in which it occurs, and is a fault.

use palpate::stages::force::foundation::point_weights;
use palpate::{BuildError, Model, Params, Tuned, Vector3, square_root};

/// Smallest accepted ratio of mass to `E D dt^2` (1): twice the 1/4 at which a single node between
/// fixed ones diverges. The shipped patches, which come to rest after taps, have larger ratios.
pub const LEAST_FLOOR: f32 = 0.5;
/// Largest accepted ratio of mass to `E D dt^2` (1): far above that of the softest tissue, far
/// below that of a node which never moves.
const MOST_MASS: f32 = 1e4;
/// Relative tolerance between a constant and its value for the rest shape, for rounding (1).
const ROUNDED: f32 = 1e-2;
/// Parameter of [`BuildError::OutOfRange`] for a mass below the floor.
pub const FLOOR: &str = "mass of a node over E D dt^2";

/// Parameter of [`BuildError::OutOfRange`] for a least eigenvalue of N that is too low.
pub const SERIES: &str = "least eigenvalue of what neighbours add";
/// Smallest accepted least eigenvalue of N (1). The inverse mass matrix is no longer positive
/// definite at -1; the shipped patches have -0.8, and power iteration ends slightly above the true
/// value.
const LEAST_SERIES: f32 = -0.95;
/// Rounds of the power iteration.
const ROUNDS: usize = 24;
/// Parameter of [`BuildError::OutOfRange`] for a foundation that is too stiff.
pub const CONTACT: &str = "stiffness of the foundation over the tissue's";
/// Largest accepted ratio of the stiffness of a node's foundation, pressed to the depth limit, to
/// the node's own stiffness (1).
pub const MOST_CONTACT: f32 = 20.0;

/// Number of tets that are checked between two calls of `after_round`; a board takes 800
/// instructions for each.
const TETS_PER_ROUND: usize = 64;

/// Checks rest shape and masses. `tuned` was built from `params`; `stiffness_m` and `six_volume_m3`
/// are scratch memory with one entry per node. `after_round` is called in between.
///
/// # Errors
/// [`BuildError::Degenerate`] names the first item that contradicts the rest shape.
/// [`BuildError::OutOfRange`] has the parameter [`FLOOR`] if a node is too light for its stiffness,
/// [`SERIES`] or [`CONTACT`] if one of the two further bounds of the module is exceeded.
pub fn check(
    model: &Model<'_>,
    params: &Params,
    tuned: &Tuned<'_>,
    [stiffness_m, six_volume_m3]: [&mut [f32]; 2],
    after_round: &mut dyn FnMut(),
) -> Result<(), BuildError> {
    stiffness_m.fill(0.0);
    six_volume_m3.fill(0.0);
    springs(model, 1.0 + params.compensation, stiffness_m)?;
    tets(model, stiffness_m, six_volume_m3, after_round)?;
    after_round();
    rim(model, stiffness_m);
    let sums = stiffness_m.iter().zip(six_volume_m3.iter());
    for (index, ((node, inertia), (own_m, six_m3))) in model.nodes.iter().zip(tuned.node_step()).zip(sums).enumerate() {
        if !near_one(node.six_volume_reciprocal * six_m3) || !near_one(24.0 * node.volume_m3 * node.six_volume_reciprocal) {
            return Err(BuildError::Degenerate { item: "node volume", index });
        }
        if model.anchors.binary_search(&(index as u16)).is_err() {
            let fields = inertia.smooth.iter().zip(tuned.gains());
            let yields = inertia.step + fields.map(|(at, gain)| gain * (at * at)).sum::<f32>();
            BuildError::within(FLOOR, 1.0 / (yields * own_m * tuned.substep_s()), LEAST_FLOOR, MOST_MASS)?;
        }
    }
    after_round();
    contact(model, stiffness_m, six_volume_m3)?;
    series(model, tuned, [stiffness_m, six_volume_m3], after_round)
}

/// Checks the ratio of the foundation's stiffness at each node to the node's own.
fn contact(model: &Model<'_>, stiffness_m: &[f32], slope_m: &mut [f32]) -> Result<(), BuildError> {
    slope_m.fill(0.0);
    let stiffened = 1.0 + 2.0 * model.stiffening_per_m * model.depth_limit_m;
    let points = model.points_per_triangle();
    for (triangle, laws) in model.triangles.iter().zip(model.foundation.chunks(points)) {
        for (weights, law) in point_weights(points).iter().zip(laws) {
            for (node, weight) in triangle.node.iter().zip(weights) {
                add(slope_m, *node, weight * law.k * stiffened);
            }
        }
    }
    for (slope_m, own_m) in slope_m.iter().zip(stiffness_m) {
        BuildError::within(CONTACT, slope_m / own_m, 0.0, MOST_CONTACT)?;
    }
    Ok(())
}

/// Checks the least eigenvalue of N. The iteration uses `N - I`, whose eigenvalue of largest
/// magnitude belongs to the least one of N.
fn series(
    model: &Model<'_>,
    tuned: &Tuned<'_>,
    [shape, next]: [&mut [f32]; 2],
    after_round: &mut dyn FnMut(),
) -> Result<(), BuildError> {
    let inertia = tuned.node_step();
    if inertia.iter().all(|node| node.added == 0.0) {
        return Ok(());
    }
    let mut seed = 1_u32;
    for (at, node) in shape.iter_mut().zip(inertia) {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        *at = if node.step > 0.0 { (seed >> 8) as f32 / 8_388_608.0 - 1.0 } else { 0.0 };
    }
    let mut least = 0.0;
    for _ in 0..ROUNDS {
        after_round();
        next.fill(0.0);
        for spring in model.springs {
            let [i, j] = [spring.i, spring.j].map(usize::from);
            let (Some(a), Some(b), Some(at_i), Some(at_j)) = (inertia.get(i), inertia.get(j), shape.get(i), shape.get(j)) else {
                continue;
            };
            let mass = spring.k * (a.added + b.added);
            add(next, spring.i, mass * at_j);
            add(next, spring.j, mass * at_i);
        }
        let (mut turned, mut all, mut largest) = (0.0, 0.0, 0.0_f32);
        for ((at, sum), node) in shape.iter_mut().zip(next.iter()).zip(inertia).filter(|(_, node)| node.step > 0.0) {
            turned += *at * sum;
            all += *at * *at / node.step;
            *at -= sum * node.step;
            largest = if at.abs() > largest { at.abs() } else { largest };
        }
        least = turned / all;
        for at in shape.iter_mut() {
            *at /= largest;
        }
    }
    BuildError::within(SERIES, least, LEAST_SERIES, 1.0)
}

fn near_one(value: f32) -> bool {
    (value - 1.0).abs() <= ROUNDED
}

/// Adds a third of each spring's stiffness to the mean diagonal of both its nodes, and compares the
/// springs' lengths with the rest shape.
fn springs(model: &Model<'_>, factor: f32, stiffness_m: &mut [f32]) -> Result<(), BuildError> {
    for (index, spring) in model.springs.iter().enumerate() {
        let [a, b] = [spring.i, spring.j].map(|node| position_m(model, node));
        let displacement_m = b - a;
        let (square, length_m) = (displacement_m.dot(&displacement_m), spring.k_rest / spring.k);
        if !near_one(square / (length_m * length_m)) {
            return Err(BuildError::Degenerate { item: "spring length", index });
        }
        for node in [spring.i, spring.j] {
            add(stiffness_m, node, factor * spring.k * THIRD);
        }
    }
    Ok(())
}

/// Adds volume term and barrier to the mean diagonal, and sums six times the volume around each
/// node.
fn tets(
    model: &Model<'_>,
    stiffness_m: &mut [f32],
    six_volume_m3: &mut [f32],
    after_round: &mut dyn FnMut(),
) -> Result<(), BuildError> {
    for (index, tet) in model.tets.iter().enumerate() {
        if index.is_multiple_of(TETS_PER_ROUND) {
            after_round();
        }
        let [a, b, c, d] = tet.node.map(|node| position_m(model, node));
        let (u, v, w) = (b - a, c - a, d - a);
        // gradients of six times the volume
        let (gb, gc, gd) = (v.cross(&w), w.cross(&u), u.cross(&v));
        let ga = -(gb + gc + gd);
        let six_m3 = gb.dot(&u);
        let constants = [tet.bulk, tet.barrier].iter().all(|constant| *constant >= 0.0);
        if !(constants && near_one(six_m3 * tet.six_volume_reciprocal)) {
            return Err(BuildError::Degenerate { item: "tet volume", index });
        }
        let mut per_square = (tet.bulk + BARRIER_SLOPE * tet.barrier) * tet.six_volume_reciprocal;
        for node in tet.node.iter().filter_map(|node| model.nodes.get(usize::from(*node))) {
            if node.pressure < 0.0 {
                return Err(BuildError::Degenerate { item: "node pressure", index });
            }
            per_square += PRESSURE_SLOPE * node.pressure * node.six_volume_reciprocal;
        }
        for (node, gradient) in tet.node.iter().zip([ga, gb, gc, gd]) {
            add(stiffness_m, *node, per_square * gradient.dot(&gradient) * THIRD);
            add(six_volume_m3, *node, six_m3);
        }
    }
    Ok(())
}

/// Adds the root mean square of the column norms of the rim's blocks to the mean diagonal.
fn rim(model: &Model<'_>, stiffness_m: &mut [f32]) {
    for rim in model.rim_nodes {
        let [xx, yy, zz, xy, xz, yz] = rim.block_m;
        let square = xx * xx + yy * yy + zz * zz + 2.0 * (xy * xy + xz * xz + yz * yz);
        add(stiffness_m, rim.node as u16, square_root(square * THIRD));
    }
    for edge in model.rim_edges {
        let square: f32 = edge.block_m.iter().map(|entry| entry * entry).sum();
        edge.node.iter().for_each(|node| add(stiffness_m, *node, square_root(square * THIRD)));
    }
}

const THIRD: f32 = 1.0 / 3.0;
/// Slopes in `palpate::stages::force`: of a node's pressure at rest, and of a tet's barrier, each
/// relative to its constant.
const PRESSURE_SLOPE: f32 = 0.5;
const BARRIER_SLOPE: f32 = 2.5;

fn position_m(model: &Model<'_>, node: u16) -> Vector3<f32> {
    model.nodes.get(usize::from(node)).map_or_else(Vector3::zeros, |node| node.rest_m.into())
}

fn add(sums: &mut [f32], node: u16, value: f32) {
    if let Some(sum) = sums.get_mut(usize::from(node)) {
        *sum += value;
    }
}

#[cfg(test)]
mod tests;
