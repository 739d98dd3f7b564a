//! Whether one substep can be stable, from the masses and stiffnesses that the file lists and not
//! from the limit that it states.
//!
//! The tick floors its masses at `f E D T^2`, with D the mean diagonal stiffness *that the file
//! gives for each node*. Here D is computed anew from springs, tets and rim, the rest shape is
//! compared with what the constants were derived from, and every mass must be at least
//! [`LEAST_FLOOR`] times `E D dt^2`. D is taken as stiff as tissue gets under load: with the
//! compensation of every spring and the barrier of every tet. That bounds each node by itself, it
//! does not prove that the whole patch is stable: one that diverges all the same is a fault in
//! the tick that finds it.

use palpate::{BuildError, Model, Params, Vector3};

/// Smallest mass over `E D dt^2` (1): three times the 1/4 at which a single node between fixed ones
/// diverges. The shipped patches, which come to rest after taps, have 1.07 to 2.09.
pub const LEAST_FLOOR: f32 = 0.75;
/// Largest slope of the contact over mass over `dt^2` (1): half of what a single node bears.
const MOST_CONTACT: f32 = 2.0;
/// Parameter of the bounds of the contact, of which the item is told and not the value.
const SHARES: &str = "contact";
/// Relative difference between a constant and the rest shape that rounding explains (1).
const ROUNDED: f32 = 1e-2;
/// Parameter of [`BuildError::OutOfRange`] for a mass below the floor.
pub const FLOOR: &str = "mass of a node over E D dt^2";

/// Checks rest shape and masses. `stiffness_m` and `six_volume_m3` are scratch memory, an entry for
/// each node.
///
/// # Errors
/// [`BuildError::Degenerate`] names the first item that contradicts the rest shape;
/// [`BuildError::OutOfRange`] with [`FLOOR`]: a node is too light for its stiffness.
pub fn check(
    model: &Model<'_>,
    params: &Params,
    youngs_modulus_pa: f32,
    [stiffness_m, six_volume_m3]: [&mut [f32]; 2],
) -> Result<(), BuildError> {
    let (Some(stiffness_m), Some(six_volume_m3)) =
        (stiffness_m.get_mut(..model.nodes.len()), six_volume_m3.get_mut(..model.nodes.len()))
    else {
        return Err(BuildError::TooLarge { item: "nodes", need: model.nodes.len(), have: stiffness_m.len() });
    };
    stiffness_m.fill(0.0);
    six_volume_m3.fill(0.0);
    springs(model, 1.0 + params.compensation, stiffness_m)?;
    tets(model, stiffness_m, six_volume_m3)?;
    rim(model, stiffness_m);
    let substeps = f32::from(params.substeps);
    let per_volume = params.density_kg_per_m3 / (youngs_modulus_pa * params.tick_s * params.tick_s);
    for (index, ((node, own_m), six_m3)) in model.nodes.iter().zip(stiffness_m.iter()).zip(six_volume_m3.iter()).enumerate() {
        let misfit = Err(BuildError::Degenerate { item: "node volume", index });
        if !near_one(node.six_volume_reciprocal * six_m3) || !near_one(24.0 * node.volume_m3 * node.six_volume_reciprocal) {
            return misfit;
        }
        if model.anchors.binary_search(&(index as u16)).is_ok() {
            continue; // never moves
        }
        // as `Params::build` weighs, over E T^2; what it adds for the contact is left out
        let lumped = per_volume * node.volume_m3;
        let floor = params.mass_floor * node.stiffness_m;
        let mass = if lumped > floor { lumped } else { floor };
        super::within(FLOOR, mass * substeps * substeps / own_m, LEAST_FLOOR, f32::INFINITY)?;
    }
    super::within("contact_cap", params.contact_cap, 0.0, MOST_CONTACT * substeps * substeps)?;
    foundation(model, six_volume_m3)
}

/// The contact's slope is capped by a share of each corner's mass. All shares at a node, with their
/// points, come to three.
fn foundation(model: &Model<'_>, shares: &mut [f32]) -> Result<(), BuildError> {
    shares.fill(0.0);
    let points = model.points_per_triangle();
    for triangle in model.triangles {
        for (node, share) in triangle.node.iter().zip(triangle.share) {
            add(shares, *node, share * points as f32);
        }
    }
    if let Some(index) = shares.iter().position(|share| super::within(SHARES, *share, 0.0, 3.0 + 3.0 * ROUNDED).is_err()) {
        return Err(BuildError::Degenerate { item: "surface triangle share of node", index });
    }
    for (index, point) in model.foundation.iter().enumerate() {
        if !near_one(2.0 * point.k * point.bend * model.stiffening_per_m) {
            return Err(BuildError::Degenerate { item: "foundation bend", index });
        }
    }
    Ok(())
}

/// A point that is stiffer than its cap would not be held by it. `cap_m` as [`Params::build`] left
/// it.
///
/// # Errors
/// [`BuildError::Degenerate`] names the point.
pub fn check_caps(model: &Model<'_>, cap_m: &[f32]) -> Result<(), BuildError> {
    let per_triangle = model.foundation.chunks(model.points_per_triangle());
    for (triangle, (points, cap_m)) in per_triangle.zip(cap_m).enumerate() {
        if points.iter().any(|point| super::within(SHARES, point.k, 0.0, *cap_m).is_err()) {
            return Err(BuildError::Degenerate { item: "foundation of surface triangle", index: triangle });
        }
    }
    Ok(())
}

fn near_one(value: f32) -> bool {
    (value - 1.0).abs() <= ROUNDED
}

/// Adds what springs put on the diagonal, a third of their stiffness along each axis, and compares
/// their lengths with the rest shape.
fn springs(model: &Model<'_>, factor: f32, stiffness_m: &mut [f32]) -> Result<(), BuildError> {
    for (index, spring) in model.springs.iter().enumerate() {
        let [a, b] = [spring.i, spring.j].map(|node| position_m(model, node));
        let way_m = b - a;
        let (square, length_m) = (way_m.dot(&way_m), spring.k_rest / spring.k);
        if !near_one(square / (length_m * length_m)) {
            return Err(BuildError::Degenerate { item: "spring length", index });
        }
        for node in [spring.i, spring.j] {
            add(stiffness_m, node, factor * spring.k * THIRD);
        }
    }
    Ok(())
}

/// Adds what volume and barrier put on the diagonal, and the volume around each node.
fn tets(model: &Model<'_>, stiffness_m: &mut [f32], six_volume_m3: &mut [f32]) -> Result<(), BuildError> {
    for (index, tet) in model.tets.iter().enumerate() {
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
            if !(node.pressure >= 0.0 && node.contact_m >= 0.0) {
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

/// Adds the mean length of the columns of the rim's blocks.
fn rim(model: &Model<'_>, stiffness_m: &mut [f32]) {
    for rim in model.rim_nodes {
        let [xx, yy, zz, xy, xz, yz] = rim.block_m;
        let square = xx * xx + yy * yy + zz * zz + 2.0 * (xy * xy + xz * xz + yz * yz);
        add(stiffness_m, rim.node as u16, libm::sqrtf(square * THIRD));
    }
    for edge in model.rim_edges {
        let square: f32 = edge.block_m.iter().map(|entry| entry * entry).sum();
        edge.node.iter().for_each(|node| add(stiffness_m, *node, libm::sqrtf(square * THIRD)));
    }
}

const THIRD: f32 = 1.0 / 3.0;
/// Slope of a node's pressure at rest over its constant, and of a tet's barrier
/// (`palpate::stages::force`).
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
