//! Checks that the site of a patch lies on its surface, faces the probe, and has tissue below it
//! down to the depth limit. Counts the triangles that a probe reaches at most.

use palpate::{BuildError, Model, PatchFile, Vector3};

/// Parameter of [`BuildError::OutOfRange`] for a site with no surface triangle in reach.
pub const SITE: &str = "surface triangles in reach of the patch's site";
/// Parameter of [`BuildError::OutOfRange`] for a depth limit below the patch's deepest node.
pub const DEPTH: &str = "depth_limit_m of the patch";
/// Parameter of [`BuildError::OutOfRange`] for an axis that does not point out of the surface.
pub const AXIS: &str = "probe.axis along the outward normal";
/// Parameter of [`BuildError::OutOfRange`] for an axis that is not a unit vector.
pub const AXIS_LENGTH: &str = "square of the length of probe.axis";
/// Places of the probe along each edge of a triangle, less one.
const PARTS: u32 = 6;
/// Nodes that [`super::Memory`] holds.
const MOST_NODES: usize = 480;
/// Tolerance on the squared length of the axis, for rounding (1).
const UNIT: f32 = 1e-5;

/// Checks site, axis and depth limit; returns the number of surface triangles near the site.
///
/// # Errors
/// [`BuildError::OutOfRange`] with [`SITE`], [`DEPTH`], [`AXIS`] or [`AXIS_LENGTH`].
pub fn check(file: &PatchFile<'_>) -> Result<usize, BuildError> {
    let (model, axis) = (&file.model, file.params.probe.axis);
    // a longer axis would scale the forces on the device
    BuildError::within(AXIS_LENGTH, axis.dot(&axis), 1.0 - UNIT, 1.0 + UNIT)?;
    let (mut touched, mut outward_m2) = (0_usize, Vector3::zeros());
    for corners in in_reach(file) {
        touched += 1;
        let [a, b, c] = corners;
        outward_m2 += (b - a).cross(&(c - a));
    }
    BuildError::within(SITE, touched as f32, 1.0, f32::MAX)?;
    BuildError::within(AXIS, if outward_m2.dot(&axis) > 0.0 { 1.0 } else { 0.0 }, 1.0, 1.0)?;
    let below_m = |node: &palpate::NodeRest| (file.site_m - Vector3::from(node.rest_m)).dot(&axis);
    let deepest_m = model.nodes.iter().map(below_m).fold(0.0, |most: f32, depth| if depth > most { depth } else { most });
    BuildError::within(DEPTH, model.depth_limit_m, 0.0, deepest_m)?;
    Ok(touched)
}

/// Largest number of surface triangles that have a corner within the radius of a probe, anywhere on
/// the surface at rest. It bounds the cost of a tick, which presses no more of them.
#[inline(never)]
pub fn most_in_reach(file: &PatchFile<'_>, after_round: &mut dyn FnMut()) -> usize {
    let (model, radius_m) = (&file.model, file.params.probe.radius_m);
    let mut most = 0;
    for triangle in model.triangles {
        // arrays, because every function of a vector would be a call in code built for size
        let [a, b, c] = triangle.node.map(|node| model.nodes.get(usize::from(node)).map_or([0.0; 3], |node| node.rest_m));
        for place in 0..(PARTS + 1) * (PARTS + 1) {
            let (i, j) = (place / (PARTS + 1), place % (PARTS + 1));
            if i + j > PARTS {
                continue;
            }
            let shares = [PARTS - i - j, i, j].map(|part| part as f32 * (1.0 / PARTS as f32));
            let place_m: [f32; 3] = core::array::from_fn(|k| a[k] * shares[0] + b[k] * shares[1] + c[k] * shares[2]);
            let mut near = [true; MOST_NODES];
            for (node, near) in model.nodes.iter().zip(&mut near) {
                let square_m2 = node.rest_m.iter().zip(&place_m).map(|(at, place)| (at - place) * (at - place)).sum::<f32>();
                *near = square_m2 <= radius_m * radius_m;
            }
            let is_near = |node: &u16| near.get(usize::from(*node)) != Some(&false);
            most = most.max(model.triangles.iter().filter(|triangle| triangle.node.iter().any(is_near)).count());
        }
        after_round();
    }
    most
}

/// Corners of each surface triangle with at least one corner within the probe's radius of the site.
fn in_reach<'f>(file: &'f PatchFile<'_>) -> impl Iterator<Item = [Vector3<f32>; 3]> + 'f {
    let radius_m = file.params.probe.radius_m;
    let near = move |corner: &Vector3<f32>| {
        let displacement_m = corner - file.site_m;
        displacement_m.dot(&displacement_m) <= radius_m * radius_m
    };
    let corners = |model: &Model<'_>, nodes: [u16; 3]| {
        nodes.map(|node| model.nodes.get(usize::from(node)).map_or_else(|| Vector3::repeat(f32::MAX), |node| node.rest_m.into()))
    };
    file.model.triangles.iter().map(move |triangle| corners(&file.model, triangle.node)).filter(move |c| c.iter().any(near))
}

#[cfg(test)]
mod tests;
