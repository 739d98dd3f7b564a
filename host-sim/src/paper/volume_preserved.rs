//! Paper 000, section 3: a liver with its gallbladder hung by a thread, at two resolutions. Table 1, Fig. 2, Fig. 3 and section 3.4.
//!
//! The paper's truth is computed tomography of a pig's organs, which is not public; ours is finite elements of the same scene.

pub mod assembly;
pub mod measured;
pub mod method;
pub mod network;
mod pictures;
mod printed;
pub mod scene;
pub mod steps;
mod tables;
pub mod truth;

use std::time::Instant;

use indicatif::ProgressBar;
use palpate::Fault;
use palpate::path::force::damper::DampingLaw;

use crate::error::Error;
use crate::output::OutputFolder;
use assembly::Assembly;
use method::{HangingMethod, Rest, Setup, hang};
use scene::HangingScene;
use steps::Steps;
use truth::{Truth, solve};

/// Largest mean landmark error of the product at full resolution that is promised, after each move [m].
pub const PROMISED_M: [f64; 2] = [1.0e-3, 2.0e-3];
/// Largest change of each organ's volume that is promised, after each move [%]: what the paper's authors report for a later version of theirs.
pub const PROMISED_VOLUME_PCT: [f64; 2] = [0.03, 0.06];

/// Methods, in the order of tables.
pub const METHODS: [HangingMethod; 4] = [
    HangingMethod::Palpate,
    HangingMethod::VolumePreserved { rates: Some([0.0, 0.0]), damping: DampingLaw::PrintedMillimetres },
    HangingMethod::VolumePreserved { rates: Some([0.0, 0.0]), damping: DampingLaw::Critical(0.1) },
    HangingMethod::VolumePreserved { rates: None, damping: DampingLaw::Critical(0.1) },
];

/// A resolution: its name, its meshes, what each method made of it.
pub struct Resolution<'a> {
    /// "full" or "sparse".
    pub name: &'static str,
    /// The scene on its meshes.
    pub assembly: Assembly<'a>,
    /// Finite elements on the finest mesh, at this resolution's landmarks.
    pub truth: Truth,
    /// Step [s] and, for each move, where it ended.
    pub runs: Vec<(Setup, Vec<Result<Rest, Fault>>)>,
}

/// Runs the paper's section 3 and writes the report into `folder`. `quick` takes the sparse resolution alone.
///
/// # Errors
/// Bad scene; finite elements that do not converge; a promise of the product that did not hold.
pub fn run(scene: &str, quick: bool, folder: &OutputFolder) -> Result<(), Error> {
    let scene = HangingScene::load(scene)?;
    let started = Instant::now();
    let bar = ProgressBar::new_spinner();
    bar.enable_steady_tick(std::time::Duration::from_millis(200));
    let wanted: &[usize] = if quick { &[1] } else { &[0, 1] };
    let mut resolutions = Vec::new();
    for at in wanted.iter().copied() {
        let name = ["full", "sparse"][at];
        bar.set_message(format!("{name}: meshing"));
        let tets: Vec<usize> = scene.organ.iter().map(|organ| organ.tets[at]).collect();
        let assembly = Assembly::build(&scene, &tets, scene.surface.points[at])?;
        let runs = hang_all(&assembly, name, &bar)?;
        resolutions.push((name, assembly, runs));
    }
    let finest = truth_of(&scene, 1.0, quick, &bar)?;
    let coarser = truth_of(&scene, COARSER, quick, &bar)?;
    let mut complete = Vec::new();
    for (name, assembly, runs) in resolutions {
        let truth = finest.0.at_points_of(&finest.1, &assembly);
        complete.push(Resolution { name, assembly, truth, runs });
    }
    bar.set_message("steps that survive");
    let steps = Steps::measure(&complete[complete.len() - 1].assembly, quick)?;
    bar.finish_and_clear();
    let coarser = coarser.0.at_points_of(&coarser.1, &complete[0].assembly);
    let findings = tables::Findings {
        scene: &scene,
        resolutions: &complete,
        coarser: &coarser,
        steps: &steps,
        quick,
        elapsed_s: started.elapsed().as_secs_f64(),
    };
    tables::write(&findings, folder)
}

/// Every method at one resolution.
fn hang_all(assembly: &Assembly, name: &str, bar: &ProgressBar) -> Result<Vec<(Setup, Vec<Result<Rest, Fault>>)>, Error> {
    let mut runs = Vec::new();
    for method in METHODS {
        let dt_s = steps::working_step_s(method, assembly)?;
        let setup = Setup { method, dt_s, longest_s: LONGEST_S };
        let rests = hang(assembly, &setup, |n, t| {
            bar.set_message(format!("{name}: {}, move {}, {t:.1} s", method.name(), n + 1));
        })?;
        runs.push((setup, rests));
    }
    Ok(runs)
}

/// Longest virtual time that a method gets to come to rest after a move [s].
const LONGEST_S: f64 = 6.0;

/// Finite elements with as many tets as a share of the scene's.
fn truth_of<'a>(scene: &'a HangingScene, share: f64, quick: bool, bar: &ProgressBar) -> Result<(Truth, Assembly<'a>), Error> {
    let tets = |o: &scene::OrganScene| (share * if quick { o.tets[1] as f64 } else { FINEST * o.tets[0] as f64 }) as usize;
    let tets: Vec<usize> = scene.organ.iter().map(tets).collect();
    let assembly = Assembly::build(scene, &tets, scene.surface.points[1])?;
    let truth = solve(&assembly, |n, share| {
        let size = assembly.quadratic.tets.len();
        bar.set_message(format!("finite elements, {size} tets, move {}, {:.0} %", n + 1, 100.0 * share));
    })?;
    Ok((truth, assembly))
}

/// Tets of the finest finite-element mesh, over those of the full resolution: a quadratic tet does what eight linear ones do.
const FINEST: f64 = 0.4;
/// Tets of the coarser mesh over those of the finer, for the error estimate.
const COARSER: f64 = 0.4;
