//! The piece of a scene's tissue that is computed: a quarter or half of a block if shape and motion
//! of the probe are symmetric, the whole block otherwise, or an imported mesh.

use nalgebra::Vector3;
use palpate_tissue::error::Error;
use palpate_tissue::scene::Scene;
use palpate_tissue::tissue;

use super::error::DynamicError;
use super::motion::{Motion, Pose};
use super::settings::Settings;
use super::task::Task;
use palpate_fit::reference::body::Body;
use palpate_fit::reference::domain::{BlockCase, mesh_body};
use palpate_fit::reference::shape::TetRule;

/// Longest edge under the probe of an imported mesh, divided by the contact radius (1).
const EDGE: f64 = 0.4;

/// The piece of tissue that is computed.
pub struct Piece {
    /// Elements, supports and the surface that the probe may touch.
    pub body: Body,
    /// Whether the piece is cut at x = 0 and at y = 0, with mirror images beyond the cut.
    pub mirror: [bool; 2],
    /// Place on the rest surface at which the motion's tangential displacement is zero [m].
    pub place_m: Vector3<f64>,
    /// Unit vector from the tip of the probe to its handle.
    pub axis: Vector3<f64>,
}

impl Piece {
    /// Meshes the tissue of a scene for a motion.
    pub fn of(scene: &Scene, motion: &Motion, settings: &Settings) -> Result<Self, DynamicError> {
        let mut task = Task::new(scene)?;
        task.deepest_m = motion.deepest_m();
        let reach_m = motion.reach_m();
        let half_travel_m = reach_m.map(|[least, most]| 0.5 * (most - least));
        let middle_m = reach_m.map(|[least, most]| 0.5 * (most + least));
        let fine_radius_m = settings.fine_radius_m.unwrap_or(task.fine_radius_m()) + half_travel_m[0].hypot(half_travel_m[1]);
        let Some(size_m) = scene.tissue.block_m else {
            let placed = tissue::place(scene, &[])?;
            let (place_m, axis) = (Vector3::from(placed.tissue.site_m), Vector3::from(placed.axis));
            let centre = place_m + across(&axis, middle_m);
            let mesh = task.refined(&placed.tissue.mesh, &centre, EDGE, settings.corner_nodes);
            let body = mesh_body(&mesh, &axis, &task.material, TetRule::Four);
            return Ok(Self { body, mirror: [false; 2], place_m, axis });
        };
        if task.deepest_m >= size_m[2] {
            let range = "less than the tissue is thick";
            return Err(DynamicError::Motion { key: "depth_m", value: task.deepest_m, range });
        }
        let [x, y] = scene.probe.position_m.unwrap_or_default();
        let mirrors = scene.probe.shape.mirrors();
        let case = BlockCase {
            size_m,
            place_m: [x + middle_m[0], y + middle_m[1]],
            material: task.material.clone(),
            nodes: settings.corner_nodes,
            fine_radius_m,
            rule: TetRule::Four,
            may_cut: [0, 1].map(|k| half_travel_m[k] == 0.0 && mirrors[k]),
        };
        let block = case.build().map_err(|cause| Error::Usage(format!("{}: tissue.block_m: {cause}", scene.file)))?;
        Ok(Self { body: block.body, mirror: block.mirror, place_m: Vector3::new(x, y, 0.0), axis: Vector3::z() })
    }

    /// Position of the tip of the probe at a pose [m].
    pub fn tip_m(&self, pose: &Pose) -> Vector3<f64> {
        self.place_m - self.axis * pose.depth_m + across(&self.axis, pose.across_m)
    }
}

/// Vector at right angles to `axis` [m] with components along two perpendicular directions, which
/// are x and y if the axis is z.
fn across(axis: &Vector3<f64>, [x, y]: [f64; 2]) -> Vector3<f64> {
    let first = if axis.y.abs() < 0.9 { Vector3::y().cross(axis).normalize() } else { axis.cross(&Vector3::x()).normalize() };
    let second = axis.cross(&first);
    first * x + second * y
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_motion_across_a_block_keeps_its_axes() {
        let moved = across(&Vector3::z(), [1.0, 2.0]);
        assert!((moved - Vector3::new(1.0, 2.0, 0.0)).norm() < 1e-15);
        for axis in [Vector3::new(0.6, 0.8, 0.0), Vector3::y(), Vector3::new(0.0, -0.28, 0.96)] {
            let moved = across(&axis, [3.0, 4.0]);
            assert!(moved.dot(&axis).abs() < 1e-14 && (moved.norm() - 5.0).abs() < 1e-14);
        }
    }
}
