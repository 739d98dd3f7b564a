//! Discs glued to the top of a block, pressed and sheared: they measure the stiffness of a contact
//! that sticks.
//!
//! Frictionless presses do not determine this stiffness. A patch of 410 nodes that is fitted to
//! frictionless presses alone is 10-15 % too soft under a pressed disc.

mod law;

use nalgebra::Vector3;
use rayon::prelude::*;

use self::law::Law;
use super::presses::Level;
use crate::calibrate::places::sunflower;
use crate::reference::body::Stiffness;
use crate::reference::glued::{Disc, glued_stiffness};
use crate::solved::Solved;
use palpate_tissue::answer::GluedAnswer;
use palpate_tissue::error::Error;
use palpate_tissue::mesh::{BlockSpec, block};
use palpate_tissue::scene::Scene;

/// Centres and radii of the discs that determine the law for the fit, and of those for the
/// evaluation alone [probe radii].
const SOLVED: [[f64; 3]; 7] =
    [[0.0, 0.0, 1.0], [0.0, 0.0, 0.65], [1.1, 0.0, 0.8], [0.0, -1.1, 0.8], [0.8, 0.8, 0.95], [-0.8, 0.5, 0.7], [-0.4, -1.0, 1.1]];
const UNSEEN: [[f64; 3]; 4] = [[0.4, -1.0, 1.0], [-0.6, -0.3, 0.85], [0.9, 0.2, 0.7], [-0.5, 0.9, 0.95]];
/// Discs of the fit: their number, the radius of the disc over which they are spread, and their
/// smallest and largest radius [probe radii].
const FITTED: usize = 24;
const FITTED_AROUND: f64 = 1.125;
const FITTED_RADII: [f64; 2] = [0.65, 1.1];
/// Step between the radii of consecutive discs, as a share of their range and taken modulo 1; this
/// step spreads them most evenly.
const GOLDEN_RATIO: f64 = 1.618_033_988_749_895;
/// Directions along which each disc is moved.
const DIRECTIONS: [[f64; 3]; 3] = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// Number of corner nodes before refinement, radius around the disc within which they are dense,
/// and lengths of the edges at the rim of the disc [disc radii]. The result is within 0.3 % of
/// meshes with edges a fifth as long.
const NODES: usize = 150;
const FINE_RADII: f64 = 1.5;
const EDGES: [f64; 2] = [0.28, 0.14];
const COARSE_EDGES: [f64; 1] = [0.4];

/// Answers for the glued discs of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct GluedDiscs {
    /// Answers of the discs for the fit.
    pub known: Vec<GluedAnswer>,
    /// Answers of the discs for the evaluation alone.
    pub unseen: Vec<GluedAnswer>,
}

impl GluedDiscs {
    /// Solves the discs of a scene's block that are not in `kept`; calls `told` with the number of
    /// finished discs and the total number.
    ///
    /// # Errors
    /// Fails if a mesh cannot be generated or solved.
    pub fn solve(scene: &Scene, level: Level, kept: &Solved, told: impl Fn(usize, usize) + Sync) -> Result<Self, Error> {
        let done = std::sync::atomic::AtomicUsize::new(0);
        let all = SOLVED.len() + UNSEEN.len();
        told(0, all);
        let one = |disc: &[f64; 3]| {
            let answers = solve(scene, *disc, level, kept)?;
            told(done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1, all);
            Ok(answers)
        };
        let discs: Vec<&[f64; 3]> = SOLVED.iter().chain(&UNSEEN).collect();
        let solved: Vec<[f64; 3]> = discs.into_par_iter().with_max_len(1).map(one).collect::<Result<_, Error>>()?;
        let (solved, unseen) = solved.split_at(SOLVED.len());
        let law = Law::through(&SOLVED, solved)
            .ok_or_else(|| Error::Check(format!("{}: the glued discs have no stiffness to go through", scene.file)))?;
        let radius_m = scene.probe.radius_m;
        let known = fitted().into_iter().flat_map(|disc| answers(disc, law.stiffness(disc), radius_m));
        let unseen = UNSEEN.iter().zip(unseen).flat_map(|(disc, stiffness)| answers(*disc, *stiffness, radius_m));
        Ok(Self { known: known.collect(), unseen: unseen.collect() })
    }
}

/// Centres and radii of the discs for the fit [probe radii].
fn fitted() -> Vec<[f64; 3]> {
    let [least, most] = FITTED_RADII;
    let radius = |n: usize| least + (most - least) * (n as f64 * GOLDEN_RATIO).fract();
    let places = sunflower(FITTED, FITTED_AROUND).into_iter().enumerate();
    places.map(|(n, [x, y])| [x, y, radius(n)]).collect()
}

/// Answers of a disc along each direction, from its stiffness over E [probe radii].
fn answers(disc: [f64; 3], stiffness: [f64; 3], radius_m: f64) -> impl Iterator<Item = GluedAnswer> {
    let [x, y, own] = disc.map(|radii| radii * radius_m);
    DIRECTIONS.into_iter().zip(stiffness).map(move |(direction, stiffness)| GluedAnswer {
        place_m: [x, y, 0.0],
        radius_m: own,
        direction,
        stiffness_over_e_m: stiffness * radius_m,
    })
}

/// Stiffness over E along each direction [probe radii], of a disc given by its centre and radius
/// [probe radii].
fn solve(scene: &Scene, disc: [f64; 3], level: Level, kept: &Solved) -> Result<[f64; 3], Error> {
    let size_m = scene.tissue.block_m.unwrap_or_default();
    let poisson_ratio = scene.tissue.poisson_ratio;
    let [x, y, radius_m] = disc.map(|radii| radii * scene.probe.radius_m);
    let edges: &[f64] = if level == Level::Full { &EDGES } else { &COARSE_EDGES };
    let problem =
        format!("glued disc {size_m:?} {poisson_ratio:?} {x:?} {y:?} {radius_m:?} {NODES} {FINE_RADII} {edges:?} {DIRECTIONS:?}");
    let stiffness_m = kept.answer(&problem, DIRECTIONS.len(), || {
        let refuse = |cause: &dyn std::fmt::Display| Error::Usage(format!("{}: tissue.block_m: {cause}", scene.file));
        let spec = BlockSpec { size_m, nodes: NODES, fine_at_m: [x, y], fine_radius_m: FINE_RADII * radius_m };
        let mesh = block(&spec).map_err(|cause| refuse(&cause))?;
        let bottom = (0_u32..).zip(&mesh.nodes_m).filter(|(_, x)| x[2] <= -size_m[2]).map(|(n, _)| n);
        let anchors: Vec<u32> = bottom.collect();
        let disc = Disc { place_m: Vector3::new(x, y, 0.0), axis: Vector3::z(), radius_m };
        let tissue = Stiffness { ratio: 1.0, poisson_ratio, stiffening_b: 0.0 };
        glued_stiffness(&mesh, |_, _| tissue, &anchors, &disc, &DIRECTIONS.map(Vector3::from), edges)
            .map(|found| found.limit_m)
            .map_err(|cause| refuse(&cause))
    })?;
    let mut stiffness = [0.0; DIRECTIONS.len()];
    stiffness.iter_mut().zip(stiffness_m).for_each(|(radii, m)| *radii = m / scene.probe.radius_m);
    Ok(stiffness)
}
