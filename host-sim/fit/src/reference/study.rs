//! Solves a scene on three meshes of increasing fineness, and estimates the answer and its
//! accuracy.

use nalgebra::Vector3;

use super::body::Body;
use super::domain::{BlockBody, BlockCase, mesh_body};
use super::newton::{Press, Stalled};
use super::probe::RigidProbe;
use super::shape::TetRule;
use super::task::Task;
use palpate_tissue::answer::SurfaceGrid;
use palpate_tissue::error::Error;
use palpate_tissue::scene::{Drive, Scene};
use palpate_tissue::tissue;

/// Numbers of corner nodes of the three levels, for a quarter, a half and the whole of the block.
const FULL_NODES: [[usize; 3]; 3] = [[350, 750, 1600], [600, 1200, 2400], [900, 1700, 3000]];
const QUICK_NODES: [[usize; 3]; 3] = [[130, 270, 540], [180, 330, 600], [300, 500, 800]];
/// Longest edge under the probe, divided by the contact radius, and maximum number of corner nodes,
/// of the three levels of an imported mesh.
const FULL_EDGES: [(f64, usize); 3] = [(0.6, 1500), (0.4, 2500), (0.27, 4000)];
const QUICK_EDGES: [(f64, usize); 3] = [(1.0, 700), (0.7, 1000), (0.5, 1400)];
/// Accepted deviation of the force of a force drive, as a share of its target (1).
const FORCE_TOLERANCE: f64 = 1e-4;
const MOST_TRIES: usize = 40;
/// Step of depth with which a force drive brackets its target [probe radii].
const SEARCH_RADII: f64 = 0.125;
/// Spacing of the surface grid of a hold on a block, and its extent to each side [m].
const SPACING_M: f64 = 1e-3;
const GRID_REACH_M: f64 = 0.022;

/// Answers of a scene on several meshes.
pub struct Study {
    /// Meshes with their answers, from coarse to fine.
    pub levels: Vec<Level>,
    /// Site of the press on the rest surface [m].
    pub place_m: [f64; 3],
}

/// Answer of a scene on one mesh.
pub struct Level {
    /// Number of nodes of the quadratic mesh of the piece that is computed.
    pub nodes: usize,
    /// Number of tets of that mesh.
    pub tets: usize,
    /// Number of mirror images, including the piece itself, of which the whole consists.
    pub copies: f64,
    /// Number of Newton iterations of all holds together.
    pub iterations: usize,
    /// Holds that converged, in the order of the scene.
    pub holds: Vec<LevelHold>,
    /// Reason why the next hold is missing; finer levels do not try that hold.
    pub stopped: Option<Stalled>,
}

/// Answer of a hold on one mesh.
pub struct LevelHold {
    /// Depth [m].
    pub depth_m: f64,
    /// Force along the press over Young's modulus [m^2].
    pub force_over_e_m2: f64,
    /// Largest penetration of the surface into the probe [m].
    pub penetration_m: f64,
    /// Displacement of the top around the place; only for a block.
    pub grid: Option<SurfaceGrid>,
    /// Pairs of rest position and displacement of the nodes that may touch the probe [m].
    pub surface: Vec<(Vector3<f64>, Vector3<f64>)>,
}

/// Estimate of the limit of a quantity under mesh refinement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Value at vanishing element size, from `value + c h^3` through the two finest levels
    /// (Richardson), with h^3 ~ 1/nodes. Quadratic elements reach third order if the edge of the
    /// contact limits the smoothness.
    pub limit: f64,
    /// The larger of two differences: between the finest level and the limit, and between the
    /// finest level and the previous one.
    pub error: f64,
}

/// Extrapolates the pairs (nodes, value) of all levels, coarse to fine; `None` if there are fewer
/// than two.
#[must_use]
pub fn extrapolate(levels: &[(usize, f64)]) -> Option<Estimate> {
    let [.., (coarse, before), (fine, finest)] = levels else { return None };
    let (coarse, fine) = (*coarse as f64, *fine as f64);
    let limit = if fine > coarse { (fine * finest - coarse * before) / (fine - coarse) } else { *finest };
    Some(Estimate { limit, error: (finest - limit).abs().max((finest - before).abs()) })
}

/// Solves a scene on three meshes; calls `progress` with (level, depth [m]).
///
/// # Errors
/// Fails if the scene has no static answer or the tissue cannot be meshed. A hold that does not
/// converge is not an error: its level records it.
pub fn study(scene: &Scene, quick: bool, mut progress: impl FnMut(usize, f64)) -> Result<Study, Error> {
    let mut task = Task::new(scene)?;
    task.deepest_m = deepest_m(scene)?;
    if let Some([_, _, height_m]) = scene.tissue.block_m {
        scene.refuse_deeper_than(height_m, "the tissue is thick")?;
    }
    let mut levels = Vec::new();
    let Some(size_m) = scene.tissue.block_m else {
        let placed = tissue::place(scene, &[])?;
        let (place, axis) = (Vector3::from(placed.tissue.site_m), Vector3::from(placed.axis));
        for (n, (edge, most)) in if quick { QUICK_EDGES } else { FULL_EDGES }.into_iter().enumerate() {
            let fine = task.refined(&placed.tissue.mesh, &place, edge, most);
            let body = mesh_body(&fine, &axis, &task.material, TetRule::Four);
            levels.push(task.level(&levels, &body, None, place, axis, |at_m| progress(n, at_m))?);
        }
        return Ok(Study { levels, place_m: place.into() });
    };
    let place_m = scene.probe.position_m.unwrap_or_default();
    let mut case = BlockCase {
        size_m,
        place_m,
        material: task.material.clone(),
        nodes: 0,
        fine_radius_m: task.fine_radius_m(),
        rule: TetRule::Four,
        may_cut: scene.probe.shape.mirrors(),
    };
    let whole = case.symmetry().into_iter().filter(|cut| !cut).count();
    for (n, nodes) in if quick { QUICK_NODES } else { FULL_NODES }[whole].into_iter().enumerate() {
        case.nodes = nodes;
        let block = case.build().map_err(|cause| Error::Usage(format!("{}: tissue.block_m: {cause}", scene.file)))?;
        let place = block.place_m;
        levels.push(task.level(&levels, &block.body, Some(&block), place, Vector3::z(), |at_m| progress(n, at_m))?);
    }
    Ok(Study { levels, place_m: [place_m[0], place_m[1], 0.0] })
}

impl Task<'_> {
    fn level(
        &self,
        coarser: &[Level],
        body: &Body,
        block: Option<&BlockBody>,
        place: Vector3<f64>,
        axis: Vector3<f64>,
        mut progress: impl FnMut(f64),
    ) -> Result<Level, Error> {
        let probe = RigidProbe::new(self.scene.probe.shape, self.scene.probe.radius_m, place, axis);
        let Some(mut press) = Press::new(body, probe, place) else {
            return Err(Error::Usage(format!("{}: not enough memory for the reference: use --quick", self.scene.file)));
        };
        let mut level = Level {
            nodes: body.mesh.nodes_m.len(),
            tets: body.mesh.tets.len(),
            copies: body.copies,
            iterations: 0,
            holds: Vec::new(),
            stopped: None,
        };
        // a hold that did not converge on a coarser mesh is not tried again
        let within_reach = coarser.iter().filter(|level| level.stopped.is_some()).map(|level| level.holds.len()).min();
        for target in self.scene.drive.targets().iter().take(within_reach.unwrap_or(usize::MAX)) {
            let reached = match self.scene.drive {
                Drive::Force { .. } => {
                    find_depth(&mut press, target / self.scene.tissue.youngs_modulus_pa, self.scene.probe.radius_m, &mut progress)
                }
                _ => press.go_to(*target, &mut progress),
            };
            level.iterations = press.iterations();
            if let Err(stalled) = reached {
                level.stopped = Some(stalled);
                break;
            }
            let half_count = (GRID_REACH_M / SPACING_M).round() as usize;
            let grid = block.map(|block| block.grid(&press.displacement_m, SPACING_M, half_count));
            level.holds.push(LevelHold {
                depth_m: press.depth_m(),
                force_over_e_m2: press.force_over_e_m2(),
                penetration_m: press.touch().penetration_m,
                grid,
                surface: surface_of(body, &press.displacement_m),
            });
        }
        Ok(level)
    }
}

/// Depth of the deepest hold [m]; for a force drive, the depth for which the mesh is refined.
fn deepest_m(scene: &Scene) -> Result<f64, Error> {
    match &scene.drive {
        Drive::Depth { holds_m, .. } => Ok(holds_m.iter().copied().fold(0.0, f64::max)),
        Drive::Force { .. } => Ok(0.5 * scene.probe.radius_m),
        Drive::Hand { .. } | Drive::Trace { .. } => {
            Ok(scene.bad("drive.kind", "has no static answer: use \"depth\" or \"force\"")?)
        }
    }
}

fn surface_of(body: &Body, displacement_m: &[Vector3<f64>]) -> Vec<(Vector3<f64>, Vector3<f64>)> {
    let mut nodes: Vec<u32> = body.touchable.iter().flat_map(|t| body.mesh.triangles[*t]).collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes.into_iter().map(|n| (body.mesh.nodes_m[n as usize], displacement_m[n as usize])).collect()
}

/// Presses until the force over Young's modulus equals `wanted_m2`: steps inward until the force is
/// exceeded, then false position (Illinois).
pub fn find_depth(press: &mut Press, wanted_m2: f64, radius_m: f64, progress: &mut impl FnMut(f64)) -> Result<(), Stalled> {
    let step_m = SEARCH_RADII * radius_m;
    let mut low = (0.0, -wanted_m2);
    let mut high = loop {
        let at = (press.depth_m(), press.force_over_e_m2() - wanted_m2);
        if at.1 >= 0.0 {
            break at;
        }
        low = at;
        press.go_to(press.depth_m() + step_m, &mut *progress)?;
    };
    for _ in 0..MOST_TRIES {
        let off = press.force_over_e_m2() - wanted_m2;
        if off.abs() <= FORCE_TOLERANCE * wanted_m2 {
            return Ok(());
        }
        let middle_m = (low.0 * high.1 - high.0 * low.1) / (high.1 - low.1);
        press.go_to(middle_m, &mut *progress)?;
        let off = press.force_over_e_m2() - wanted_m2;
        if off < 0.0 {
            low = (middle_m, off);
            high.1 *= 0.5;
        } else {
            high = (middle_m, off);
            low.1 *= 0.5;
        }
    }
    Err(Stalled { reached_m: press.depth_m() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_third_order_error_is_extrapolated_away() {
        let value = |n: usize| 3.0 + 40.0 / n as f64;
        let levels = [100, 300, 900].map(|n| (n, value(n)));
        let estimate = extrapolate(&levels).unwrap();
        assert!((estimate.limit - 3.0).abs() < 1e-12);
        assert!((estimate.error - (value(300) - value(900)).max(value(900) - 3.0)).abs() < 1e-12);
        assert_eq!(extrapolate(&levels[..1]), None);
    }
}
