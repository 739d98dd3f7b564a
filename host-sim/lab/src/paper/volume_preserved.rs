//! Paper 000, section 3: a liver with its gallbladder, hung by a thread, at two resolutions.
//! Reproduces Table 1, Fig. 2, Fig. 3 and section 3.4.
//!
//! The paper's reference is computed tomography of a pig's organs, which is not public; ours is
//! finite elements of the same scene.

pub mod assembly;
mod figures;
pub mod measured;
pub mod method;
pub mod network;
mod printed;
mod report;
pub mod scene;
pub mod steps;
pub mod truth;

use std::path::Path;
use std::time::Instant;

use crate::paper_method::damper::DampingLaw;
use palpate::Fault;

use crate::error::Error;
use crate::paper::Progress;
use assembly::Assembly;
use method::{HangingMethod, Rest, Setup, hang};
use palpate_tissue::output::OutputFolder;
use scene::HangingScene;
use truth::{Shipped, Truth, solve};

/// Largest mean landmark error that is promised for the product at full resolution, after each move
/// [m].
pub const PROMISED_M: [f64; 2] = [1.0e-3, 2.0e-3];
/// Largest change of each organ's volume that is promised, after each move [%]: the figure that the
/// paper's authors report for a later version.
pub const PROMISED_VOLUME_PCT: [f64; 2] = [0.03, 0.06];

/// Methods in the order of tables.
pub const METHODS: [HangingMethod; 4] = [
    HangingMethod::Palpate,
    HangingMethod::VolumePreserved { rates: Some([0.0, 0.0]), damping: DampingLaw::PrintedMillimetres },
    HangingMethod::VolumePreserved { rates: Some([0.0, 0.0]), damping: DampingLaw::Critical(0.1) },
    HangingMethod::VolumePreserved { rates: None, damping: DampingLaw::Critical(0.1) },
];

/// A resolution: its name, its meshes, and the results of each method.
pub struct Resolution<'a> {
    /// "full" or "sparse".
    pub name: &'static str,
    /// The scene on its meshes.
    pub assembly: Assembly<'a>,
    /// Finite elements on the same mesh.
    pub truth: Truth,
    /// Setup and final states of each method.
    pub runs: Vec<MethodRun>,
    /// CPU time to draw one picture [s].
    pub picture_s: f64,
}

/// Setup of a method, and its final state after each move or the fault that ended it.
pub type MethodRun = (Setup, Vec<Result<Rest, Fault>>);

/// Options of a run.
#[derive(Clone, Debug)]
pub struct Options {
    /// Preset or file of the scene.
    pub scene: String,
    /// Runs only the sparse resolution.
    pub quick: bool,
    /// Recomputes the finite elements instead of using the shipped answers.
    pub solve: bool,
    /// Origin of the report, which its summary states.
    pub provenance: serde_json::Value,
}

/// Virtual time within which a method should come to rest after a move [s].
const LONGEST_S: f64 = 6.0;
/// Gravity in the additional runs under weight [m/s^2].
const WEIGHT_M_PER_S2: [f64; 3] = [0.0, 0.0, -9.81];

/// Runs the paper's section 3 and writes the report into the folder `out`, which is made once the
/// scene is known to be sound.
pub fn run(options: &Options, out: &Path, progress: &dyn Progress) -> Result<(), Error> {
    let scene = HangingScene::load(&options.scene)?;
    let sizes: &[usize] = if options.quick { &[1] } else { &[0, 1] };
    let assemblies = sizes.iter().map(|at| assemble(&scene, *at)).collect::<Result<Vec<_>, _>>()?;
    let folder = OutputFolder::open(out)?.made_by(options.provenance.clone());
    let started = Instant::now();
    let mut resolutions = Vec::new();
    for (assembly, at) in assemblies.into_iter().zip(sizes) {
        resolutions.push(at_resolution(assembly, NAMES[*at], &METHODS, options.solve, progress)?);
    }
    let sparse = &resolutions[resolutions.len() - 1];
    let subdivided = subdivided(sparse, options.solve, progress)?;
    if options.solve && !options.quick {
        let shipped = subdivided.as_ref().map(|finer| truth::Shipped {
            full: truth::Answer::of(&resolutions[0].assembly, &resolutions[0].truth),
            sparse_subdivided: truth::Answer::of(&sparse.assembly, finer),
        });
        folder.write_json("hanging-liver.json", &shipped)?;
    }
    let mut weighed = scene.clone();
    weighed.gravity_m_per_s2 = WEIGHT_M_PER_S2;
    let weighed = match options.quick || scene.gravity_m_per_s2 != [0.0; 3] {
        true => None,
        false => Some(at_resolution(assemble(&weighed, 1)?, NAMES[1], &[METHODS[0], METHODS[2]], true, progress)?),
    };
    progress.clear();
    let found = report::Measurements {
        scene: &scene,
        resolutions: &resolutions,
        weighed: weighed.as_ref(),
        subdivided: subdivided.as_ref(),
    };
    let mut findings = report::findings(&found, &folder)?;
    findings.fact("scene", scene.name.as_str());
    findings.fact("quick", options.quick);
    findings.fact("elapsed_s", started.elapsed().as_secs_f64());
    findings.report(folder, true)
}

/// Names of the resolutions.
const NAMES: [&str; 2] = ["full", "sparse"];

/// The scene's meshes at full (0) or sparse (1) resolution.
fn assemble(scene: &HangingScene, at: usize) -> Result<Assembly<'_>, Error> {
    let tets: Vec<usize> = scene.organ.iter().map(|organ| organ.tets[at]).collect();
    Assembly::build(scene, &tets, scene.surface.points[at])
}

/// Solves the finite elements of one resolution or loads their shipped answer, then runs every
/// method.
fn at_resolution<'a>(
    assembly: Assembly<'a>,
    name: &'static str,
    methods: &[HangingMethod],
    solve_anew: bool,
    progress: &dyn Progress,
) -> Result<Resolution<'a>, Error> {
    let shipped = Shipped::load().filter(|_| !solve_anew).and_then(|shipped| shipped.full.for_assembly(&assembly));
    let truth = match shipped {
        Some(truth) => truth,
        None => solve(&assembly, |n, share| say_share(progress, name, &assembly, n, share))?,
    };
    let mut runs = Vec::new();
    for method in methods {
        let setup = steps::working_setup(*method, &assembly, LONGEST_S)?;
        let rests = hang(&assembly, &setup, |n, t| {
            progress.say(format!("{name}: {}, move {}, {t:.1} s", method.name(), n + 1));
        })?;
        runs.push((setup, rests));
    }
    let mut resolution = Resolution { name, assembly, truth, runs, picture_s: f64::NAN };
    resolution.picture_s = figures::time_of_one_s(&resolution)?;
    Ok(resolution)
}

/// Finite elements of the sparse resolution with every tet cut into eight; `None` unless they are
/// shipped or requested.
fn subdivided(sparse: &Resolution, solve_anew: bool, progress: &dyn Progress) -> Result<Option<Truth>, Error> {
    if solve_anew {
        let finer = sparse.assembly.subdivided();
        return Ok(Some(solve(&finer, |n, share| say_share(progress, "sparse, subdivided", &finer, n, share))?));
    }
    Ok(Shipped::load().and_then(|shipped| shipped.sparse_subdivided.for_assembly(&sparse.assembly)))
}

fn say_share(progress: &dyn Progress, name: &str, assembly: &Assembly, n: usize, share: f64) {
    let tets = assembly.quadratic.tets.len();
    progress.say(format!("{name}: finite elements, {tets} tets, move {}, {:.0} %", n + 1, 100.0 * share));
}
