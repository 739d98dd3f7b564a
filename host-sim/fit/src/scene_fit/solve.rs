//! Solves the finite elements of one press.

use nalgebra::Vector3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::presses::{PressJob, Presses};
use super::shifted::shifted;
use crate::reference::body::Material;
use crate::reference::domain::BlockCase;
use crate::reference::newton::Press;
use crate::reference::probe::RigidProbe;
use crate::reference::shape::TetRule;
use palpate_tissue::answer::SurfaceGrid;
use palpate_tissue::error::Error;
use palpate_tissue::mesh::{BlockSpec, block_of_at_least};
use palpate_tissue::scene::Scene;

/// Spacing of the surface grid of a hold [probe radii], and number of its points to each side: 2.75
/// radii.
const GRID_RADII: f64 = 0.125;
const GRID_HALF_COUNT: usize = 22;
/// Radius around the centre within which nodes move with the probe, divided by the reach of the tip
/// (1).
const KEPT_RADII: f64 = 1.0;

/// Forces and surfaces of the presses of one job.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Forces {
    /// Force along the press over E at each depth [m^2], shape \[depths\].
    pub force_over_e_m2: Vec<f64>,
    /// Surfaces at the depths for which one was requested.
    pub surfaces: Vec<SurfaceGrid>,
    /// Number of nodes of the quadratic mesh.
    pub nodes: usize,
}

/// Equilibria at some depths of a mesh, from which solutions on a slightly shifted mesh start.
type Starts = Vec<(f64, Vec<Vector3<f64>>)>;

/// Listener that follows the progress of presses and stores their results.
pub trait PressListener: Sync {
    /// Returns the forces of a press if an earlier run solved it.
    fn stored(&self, job: &PressJob) -> Option<Forces>;

    /// Called when a press has reached a depth [m].
    fn reached(&self, job: &PressJob, depth_m: f64);

    /// Called when a press is complete, either computed `anew` or read from storage.
    ///
    /// # Errors
    /// Fails if the press cannot be stored.
    fn done(&self, job: &PressJob, forces: &Forces, anew: bool) -> Result<(), Error>;
}

/// Solves all presses that are not stored, one per core at a time.
///
/// # Errors
/// Fails if a mesh cannot be generated, or if a press does not converge or cannot be stored.
pub fn solve_all(scene: &Scene, presses: &Presses, watch: &impl PressListener) -> Result<Vec<(PressJob, Forces)>, Error> {
    let one = |job: &PressJob, starts: &Starts| {
        let stored = watch.stored(job);
        let anew = stored.is_none();
        let (forces, own) = match stored {
            Some(forces) => (forces, Starts::new()),
            None => solve(scene, job, starts, watch)?,
        };
        watch.done(job, &forces, anew)?;
        Ok(((job.clone(), forces), own))
    };
    // presses that take longest first, one per core at a time
    let first: Vec<&PressJob> = std::iter::once(&presses.again).chain(presses.centre.iter().rev()).collect();
    let first: Vec<_> =
        first.into_par_iter().with_max_len(1).map(|job| one(job, &Starts::new())).collect::<Result<_, Error>>()?;
    let mut starts = Starts::new();
    let mut found = Vec::new();
    for (pressed, own) in first {
        if pressed.0 == presses.again {
            starts = own;
        }
        found.push(pressed);
    }
    let places: Vec<&PressJob> = presses.aside.iter().chain(&presses.unseen).collect();
    let places = places.into_par_iter().with_max_len(1).map(|job| Ok(one(job, &starts)?.0));
    found.extend(places.collect::<Result<Vec<_>, Error>>()?);
    Ok(found)
}

/// Solves a press of the scene's block with its probe, starting from `starts` if it contains the
/// depth.
fn solve(scene: &Scene, job: &PressJob, starts: &Starts, watch: &impl PressListener) -> Result<(Forces, Starts), Error> {
    let file = &scene.file;
    let size_m = scene.tissue.block_m.unwrap_or_default();
    let radius_m = scene.probe.radius_m;
    let mut case = BlockCase {
        size_m,
        place_m: [0.0; 2],
        material: Material { poisson_ratio: scene.tissue.poisson_ratio, stiffening_b: 0.0, inclusions: Vec::new() },
        nodes: job.nodes,
        fine_radius_m: job.fine_radius_m,
        rule: TetRule::Four,
        may_cut: [!job.whole; 2],
    };
    let refuse = |cause: &dyn std::fmt::Display| Error::Usage(format!("{file}: tissue.block_m: {cause}"));
    let built = if job.whole {
        let spec = BlockSpec { size_m, nodes: job.nodes, fine_at_m: [0.0; 2], fine_radius_m: job.fine_radius_m };
        let mesh = block_of_at_least(&spec).map_err(|cause| refuse(&cause))?;
        let mesh = shifted(&mesh, size_m, KEPT_RADII * scene.probe.tip().reach_m(), job.place_m);
        case.place_m = job.place_m;
        case.support(&mesh, [false; 2])
    } else {
        case.build().map_err(|cause| refuse(&cause))?
    };
    let probe = RigidProbe::new(scene.probe.shape, radius_m, built.place_m, Vector3::z());
    let no_memory = || Error::Usage(format!("{file}: not enough memory for the finite elements: use --quick"));
    let mut press = Press::new(&built.body, probe, built.place_m).ok_or_else(no_memory)?;
    let mut forces = Forces { force_over_e_m2: Vec::new(), surfaces: Vec::new(), nodes: built.body.mesh.nodes_m.len() };
    let mut own = Starts::new();
    for depth_m in &job.depths_m {
        let start = starts.iter().find(|(depth, _)| depth == depth_m);
        let near = start.is_some_and(|(_, displacement_m)| press.start_from(displacement_m, *depth_m));
        if !near {
            press.go_to(*depth_m, |at_m| watch.reached(job, at_m)).map_err(|stalled| {
                Error::Usage(format!(
                    "{file}: drive: at {:?} m no equilibrium was found deeper than {:.5} m: press less deep",
                    job.place_m, stalled.reached_m
                ))
            })?;
        }
        if job.whole {
            own.push((*depth_m, press.displacement_m.clone()));
        }
        forces.force_over_e_m2.push(press.force_over_e_m2());
        if job.surfaces_m.contains(depth_m) {
            forces.surfaces.push(built.grid(&press.displacement_m, GRID_RADII * radius_m, GRID_HALF_COUNT));
        }
    }
    Ok((forces, own))
}
