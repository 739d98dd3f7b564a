//! Checks that the site of a patch lies on its surface, faces the probe, and has tissue below it
//! down to the depth limit. Counts the triangles that a probe reaches at most.

use palpate::{BuildError, Model, PatchFile, Triangle, Vector3};

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
    let near = near(file, &file.site_m);
    for triangle in model.triangles.iter().filter(|triangle| touches(triangle, &near)) {
        touched += 1;
        let [a, b, c] = triangle.node.map(|node| corner_m(model, node));
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
    let model = &file.model;
    let mut most = 0;
    for triangle in model.triangles {
        let [a, b, c] = triangle.node.map(|node| corner_m(model, node));
        let (along_m, across_m) = ((b - a) * (1.0 / PARTS as f32), (c - a) * (1.0 / PARTS as f32));
        let mut row_m = a;
        for row in 0..=PARTS {
            let mut place_m = row_m;
            for _ in row..=PARTS {
                let near = near(file, &place_m);
                most = most.max(model.triangles.iter().filter(|triangle| touches(triangle, &near)).count());
                after_round();
                place_m += across_m;
            }
            row_m += along_m;
        }
    }
    most
}

#[inline(never)]
fn corner_m(model: &Model<'_>, node: u16) -> Vector3<f32> {
    model.nodes.get(usize::from(node)).map_or([0.0; 3], |node| node.rest_m).into()
}

/// Marks the nodes within the probe's radius of a place.
#[inline(never)]
fn near(file: &PatchFile<'_>, place_m: &Vector3<f32>) -> [bool; MOST_NODES] {
    let mut near = [true; MOST_NODES];
    let radius_m = file.params.probe.radius_m;
    for (node, near) in file.model.nodes.iter().zip(&mut near) {
        // no vectors, because each of their functions would be a call in code built for size
        let [x, y, z] = node.rest_m;
        let (x, y, z) = (x - place_m.x, y - place_m.y, z - place_m.z);
        *near = x * x + y * y + z * z <= radius_m * radius_m;
    }
    near
}

/// Whether at least one corner of a triangle is marked.
#[inline(never)]
fn touches(triangle: &Triangle, near: &[bool; MOST_NODES]) -> bool {
    triangle.node.iter().any(|node| near.get(usize::from(*node)) != Some(&false))
}

#[cfg(test)]
mod tests;
