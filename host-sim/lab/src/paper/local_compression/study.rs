//! Computes everything that the report needs: fits and sweeps over forces.

use palpate::{Fnv, Vector3};

use super::checkpoint;
use super::fit::{Found, Step, Target};
use super::methods::{Fitted, StudyMethod};
use super::progress::AnnealingProgress;
use super::scene::PressScene;
use super::schedule::Schedule;
use super::site::{DEEPEST_RADII, Site};
use super::sweep::{Curve, NODE_DAMPING_PER_S, curve, region_for, static_curve, study_methods};
use super::truth::Truth;
use crate::error::Error;
use crate::methods::{Block, Method, RADIUS_M};
use palpate_tissue::Error as TissueError;
use palpate_tissue::output::OutputFolder;

/// Young's modulus of the block [Pa], at which the paper's forces press a tip of 8 mm radius some 4
/// to 9 mm deep.
pub const BLOCK_PA: f64 = 20e3;
/// Number of nodes of the block, for which a calibrated patch exists.
const BLOCK_NODES: usize = 130;
/// Force of the fits [N], from the middle of the paper's range.
pub const FIT_N: f64 = 1.6;
/// Force at which the region is chosen [N]: the paper's smallest, which most models survive.
const REGION_N: f64 = 0.8;
/// Time steps of the fits [s], for the block and for organs. They limit the k and d that can be
/// tried, because larger ones diverge.
pub const FIT_STEPS_S: [f64; 2] = [2.5e-4, 1.25e-4];
/// Growth of the elements in pictures, divided by that of the scene (1): with smaller elements the
/// shape far from the finger remains visible.
const PICTURE_GROWTH: f64 = 0.4;
/// Forces of the sweeps [N]: ten values up to 4 N, as in the paper.
pub const FORCES_N: [f64; 10] = [0.4, 0.8, 1.2, 1.6, 2.0, 2.4, 2.8, 3.2, 3.6, 4.0];

/// Number and size of the cases that are computed.
#[derive(Clone, Copy, Debug)]
pub struct Size {
    /// Number of trials of each of the two walks on the block, and of the walk on an organ.
    pub trials: [usize; 2],
    /// Forces of the sweeps [N].
    pub forces_n: &'static [f64],
    /// Factor by which the lattices of organs are coarser than in the scene (1).
    pub coarser: f64,
    /// Longest edge near the finger [m] and largest number of nodes of the layered reference;
    /// `None` leaves it out.
    pub layered: Option<(f64, usize)>,
}

impl Size {
    /// The paper's schedule and forces.
    pub fn full() -> Self {
        let trials = [Schedule::PAPER.length(), 2 * Schedule::PAPER.temperatures()];
        Self { trials, forces_n: &FORCES_N, coarser: 1.0, layered: Some((0.0045, 1500)) }
    }

    /// Returns a reduced size: few forces, few trials at each temperature, coarser organs.
    pub fn quick() -> Self {
        Self { trials: [570, 60], forces_n: &[0.8, 1.6, 2.4], coarser: 1.5, layered: None }
    }
}

/// Results of paper 004 on the standard block.
pub struct OnBlock {
    /// The standard block at [`BLOCK_PA`].
    pub block: Block,
    /// The two annealing walks.
    pub walks: Vec<Found>,
    /// Curve of each method over the forces.
    pub curves: Vec<Curve>,
}

/// Results on an organ.
pub struct OnOrgan {
    /// Scene of the organ.
    pub scene: PressScene,
    /// Tissue of the organ under the finger.
    pub site: Site,
    /// The organ on the finer mesh of the pictures, with the product's presses.
    pub pictured: (Site, Curve),
    /// The annealing walk.
    pub walk: Found,
    /// Fitted values, with the smallest region whose error is at most 2 %; without a region if none
    /// was found.
    pub fitted: Fitted,
    /// Curve of each method over the forces.
    pub curves: Vec<Curve>,
    /// The reference whose layers run through its elements, and its number of nodes.
    pub layered: Option<(Curve, usize)>,
}

/// Fingerprint of mesh, stiffnesses, supports and site, to identify a walk.
fn fingerprint(block: &Block) -> u64 {
    let tissue = &block.tissue;
    let mut hash = Fnv::default();
    let mut add = |v: [f64; 3]| hash.vector(Vector3::from(v).cast::<f32>());
    tissue.mesh.nodes_m.iter().for_each(|x| add(*x));
    tissue.mesh.tets.iter().for_each(|t| add([f64::from(t[0]), f64::from(t[1]), f64::from(t[2]) + 0.5 * f64::from(t[3])]));
    tissue.stiffness_ratio.iter().for_each(|r| add([*r, 0.0, 0.0]));
    tissue.anchors.iter().for_each(|a| add([f64::from(*a), 0.0, 0.0]));
    add(tissue.site_m);
    hash.finish()
}

/// Runs one fit, which continues its saved walk if there is one.
fn anneal(
    folder: &OutputFolder,
    name: &str,
    target: &Target,
    trials: usize,
    seed: u64,
    progress: &AnnealingProgress,
) -> Result<Found, Error> {
    let mut simulator = target.simulator();
    let no_start = || TissueError::Usage(format!("{name}: no start for the annealing found: press less or use a finer step"));
    let fresh = simulator.start(Schedule::PAPER, trials, seed).ok_or_else(no_start)?;
    let file = format!("{name}.json");
    let of = format!("{name} {:016x} {} N {:?}", fingerprint(&target.block), target.force_n, target.block.params);
    let (walk, steps) = checkpoint::read(folder, &file, &of, &fresh).unwrap_or((fresh, Vec::new()));
    let (mut done, mut failed) = (walk.trials().0, None);
    progress.tried(done);
    let found = simulator.anneal(walk, steps, |walk, steps: &[Step]| {
        progress.tried(walk.trials().0 - done);
        done = walk.trials().0;
        failed = checkpoint::write(folder, &file, &of, walk, steps).err().or(failed.take());
    });
    failed.map_or(Ok(found), Err)
}

fn block() -> Result<Block, Error> {
    let mut block = match Block::calibrated(BLOCK_NODES, BLOCK_PA) {
        Some(block) => block,
        None => Block::standard(BLOCK_NODES, BLOCK_PA)?,
    };
    block.tissue.depth_limit_m = DEEPEST_RADII * RADIUS_M;
    Ok(block)
}

/// Fits the model to the block and runs all methods under all forces.
pub fn on_block(folder: &OutputFolder, size: &Size, progress: &AnnealingProgress) -> Result<OnBlock, Error> {
    let block = block()?;
    progress.say("block: annealing");
    let target = Target::new(&block, FIT_N, FIT_STEPS_S[0])?;
    let walk = |name, seed| anneal(folder, name, &target, size.trials[0], seed, progress);
    let (first, second) = rayon::join(|| walk("block-1", 1), || walk("block-2", 2));
    let walks = vec![first?, second?];
    let best = walks.iter().map(|w| w.best).min_by(|a, b| a.distance_mm.total_cmp(&b.distance_mm));
    let (k, d) = best.map_or((f64::NAN, f64::NAN), |b| (b.stiffness_n_per_m, b.damping_n_s_per_m));
    progress.say("block: presses");
    let fitted = with_region(&block, k, d)?;
    let curves = curves(&block, fitted, size)?;
    Ok(OnBlock { walks, curves, block })
}

/// Fits the model to an organ and runs all methods under all forces.
pub fn on_organ(
    folder: &OutputFolder,
    scene: PressScene,
    site: Site,
    size: &Size,
    progress: &AnnealingProgress,
) -> Result<OnOrgan, Error> {
    progress.say(format!("{}: pictures", scene.name));
    let mut smooth = scene.clone();
    smooth.mesh.growth *= PICTURE_GROWTH;
    let smooth = Site::of(&smooth, 1.0)?;
    let product = StudyMethod::Charted(Method::Palpate);
    let pictured = curve(&product, &smooth.block, &scene.finger.forces_n)?.unwrap_or_else(|| Curve::empty(product.name()));
    progress.say(format!("{}: annealing", scene.name));
    let target = Target::new(&site.block, FIT_N, FIT_STEPS_S[1])?;
    let walk = anneal(folder, &scene.name, &target, size.trials[1], 1, progress)?;
    progress.say(format!("{}: presses", scene.name));
    let fitted = with_region(&site.block, walk.best.stiffness_n_per_m, walk.best.damping_n_s_per_m)?;
    let curves = curves(&site.block, fitted, size)?;
    let layered = match size.layered {
        None => None,
        Some((edge_m, most_nodes)) => {
            progress.say(format!("{}: layered reference", scene.name));
            let fine = site.refined(&scene, edge_m, most_nodes)?;
            let held = Truth::layered(&fine).press(&scene.finger.forces_n, |_| ())?;
            let points = held.into_iter().zip(&scene.finger.forces_n).map(|(held, &force_n)| super::sweep::Point {
                force_n,
                depth_m: held.depth_m,
                virtual_s: None,
                cpu_s: held.cpu_s,
                position_m: held.position_m,
            });
            let curve = Curve { points: points.collect(), ..Curve::empty("fem-layered") };
            Some((curve, fine.block.size().nodes))
        }
    };
    Ok(OnOrgan { scene, site, pictured: (smooth, pictured), walk, fitted, curves, layered })
}

/// Adds a region to the fitted values. The region is searched with damped masses, so that all
/// presses come to rest.
fn with_region(block: &Block, stiffness_n_per_m: f64, damping_n_s_per_m: f64) -> Result<Fitted, Error> {
    let fitted = Fitted::new(stiffness_n_per_m, damping_n_s_per_m);
    let damped = Fitted { node_damping_per_s: NODE_DAMPING_PER_S, ..fitted };
    let region = match StudyMethod::LocalCompression(damped).step_s(block, REGION_N)? {
        Some(Ok(step_s)) => region_for(block, damped, step_s, REGION_N)?,
        _ => None,
    };
    Ok(Fitted { region, ..fitted })
}

fn curves(block: &Block, fitted: Fitted, size: &Size) -> Result<Vec<Curve>, Error> {
    let mut found = Vec::new();
    for method in study_methods(fitted) {
        found.extend(curve(&method, block, size.forces_n)?);
    }
    found.push(static_curve(&Truth::same_mesh(block), size.forces_n)?);
    Ok(found)
}

/// The curve called `name`, if there is one.
pub fn named<'a>(curves: &'a [Curve], name: &str) -> Option<&'a Curve> {
    curves.iter().find(|c| c.name == name)
}

/// The curve of the product, with a calibrated patch if there is one.
pub fn product(curves: &[Curve]) -> Option<&Curve> {
    named(curves, Method::Calibrated.name()).or_else(|| named(curves, Method::Palpate.name()))
}
