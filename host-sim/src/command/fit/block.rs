//! `palpate fit` of a block.

use std::sync::atomic::{AtomicUsize, Ordering};

use palpate_fit::force_map::BlockForces;
use palpate_fit::scene_fit::{
    Forces, GluedDiscs, JUDGED_RADII, Judging, Level, PLACES, Prepared, PressJob, PressListener, Presses, Solved, Verdict,
    answer, check_block, prepare, solve_all,
};
use palpate_fit::solved;
use palpate_tissue::Error as TissueError;
use palpate_tissue::answer::AnswerProbe;
use palpate_tissue::budget::MACHINES;
use palpate_tissue::scene::Scene;
use palpate_tissue::session::{Session, calibrated};
use palpate_tissue::trials::Trial;

use super::super::progress::Progress;
use super::bump::Block;
use super::report::Report;
use super::stages::Stages;
use super::store::Store;
use super::{Fitted, LEAST_GAIN, PatchFile};
use crate::command::options::fit::FitArgs;
use crate::error::Error;

impl FitArgs {
    pub(super) fn fit_block(&self, scene: &Scene, size_m: [f64; 3]) -> Result<Fitted, Error> {
        check_block(scene, size_m)?;
        // the force that inclusions add is fitted on top of the patch of the block without them
        let mut plain = scene.clone();
        plain.tissue.inclusion.clear();
        let prepared = prepare(&plain)?;
        let level = if self.options.quick { Level::Quick } else { Level::Full };
        let presses = Presses::of(&plain, &prepared.tissue, level);
        let prepared = prepared.with_enough_points(&plain, &presses).with_points(self.options.points)?;
        let path = self.common.folder("fit");
        let folder = self.common.open("fit", scene)?;
        let store = Store::of(&path, &folder, scene);
        self.print_scene(scene, prepared.tissue.mesh.nodes_m.len(), prepared.material.points_per_triangle, &presses.fitted_m);
        let kept = solved::Solved::beside(&path);
        let (solved, reused_presses) = reference(&plain, &presses, level, &store, &kept)?;
        let known = BlockForces::of(&solved.known)
            .ok_or_else(|| TissueError::Check("the finite elements gave fewer than four depths at the centre".into()))?;
        let settings = self.settings(prepared.tissue.mesh.nodes_m.len(), LEAST_GAIN);
        let problem = format!("{:?} {presses:?} {settings:?} {:?} {:?}", store.pressed(), prepared.material, solved.known.glued);
        let stages = Stages { scene: &plain, known: &known, store: &store, what: "fit" };
        let (fit, reused_fit) =
            stages.fit(&settings, &problem, |progress| prepared.fit(&plain, &presses, &known, &settings, progress))?;
        if !scene.tissue.inclusion.is_empty() {
            let block =
                Block { prepared: &prepared, presses: &presses, known: &known, solved: &solved, fit: &fit, reused_presses };
            return self.fit_bump(scene, folder, level, &block);
        }
        let judging = Judging {
            known: &known,
            fitted_m: &presses.fitted_m,
            unseen: &solved.unseen,
            disc_radii: JUDGED_RADII,
            places: PLACES,
            reference_error: solved.error,
        };
        let judged = stages.judge(&judging, (&prepared.uncalibrated(), &prepared.params), &fit, &MACHINES[0])?;
        let before = judged.before.iter().map(|before| trial(scene, &presses, &prepared, None, before));
        let mut trials: Vec<Trial> = before.collect();
        trials.extend(other_tip(scene, &presses, &prepared, &judging));
        store.write(presses.jobs(), &[&fit])?;
        let mut answer = solved.known.clone();
        answer.holds.extend(solved.unseen.holds.iter().cloned());
        let report = Report {
            scene,
            options: &self.options,
            fitted_m: &presses.fitted_m,
            known: &known,
            answer: &answer,
            reference_nodes: Some(solved.nodes),
            reference_error: solved.error,
            fit: &fit,
            judged: &judged,
            trials: &trials,
            bump: None,
            reused_fit,
            reused_presses,
            places: settings.places,
        };
        Ok(self.judged(report.write(folder, PatchFile::of(scene, &judged.session, &fit))?, &judged.verdict))
    }
}

/// Judges the shipped patch of this size under this scene's tip, if it is of the same tissue.
fn other_tip(scene: &Scene, presses: &Presses, prepared: &Prepared, judging: &Judging) -> Option<Trial> {
    let nodes = prepared.tissue.mesh.nodes_m.len();
    let record = calibrated::record(nodes)?;
    let own = AnswerProbe { shape: scene.probe.shape, radius_m: scene.probe.radius_m };
    let same = record.tissue.block_m == scene.tissue.block_m && record.tissue.poisson_ratio == scene.tissue.poisson_ratio;
    if !same || record.probe == own {
        return None;
    }
    let (patch, packed) = calibrated::sized(nodes)?;
    let params = palpate::Params { probe: prepared.params.probe, ..packed };
    // a patch that cannot be pressed that deep does not count as a trial
    let verdict = judging.judge(&Session::of_fitted(&MACHINES[0], patch, params).ok()?).ok()?;
    Some(trial(scene, presses, prepared, Some(record.probe), &verdict))
}

fn trial(scene: &Scene, presses: &Presses, prepared: &Prepared, fitted: Option<AnswerProbe>, verdict: &Verdict) -> Trial {
    Trial {
        scene: scene.name.clone(),
        block_m: scene.tissue.block_m.unwrap_or_default(),
        poisson_ratio: scene.tissue.poisson_ratio,
        probe: AnswerProbe { shape: scene.probe.shape, radius_m: scene.probe.radius_m },
        nodes: prepared.tissue.mesh.nodes_m.len(),
        deepest_m: presses.fitted_m.last().copied().unwrap_or_default(),
        fitted,
        rms_pct: hundredths(verdict.rms_pct()),
        worst_pct: hundredths(verdict.worst_pct()),
    }
}

fn hundredths(pct: f64) -> f64 {
    (100.0 * pct).round() / 100.0
}

/// Solves the presses that no earlier run has solved.
fn reference(
    scene: &Scene,
    presses: &Presses,
    level: Level,
    store: &Store,
    kept: &solved::Solved,
) -> Result<(Solved, usize), Error> {
    let steps = Progress::new(presses.jobs().count() as u64, "finite elements");
    let watched = Watched { store, steps: &steps, reused: AtomicUsize::new(0) };
    let found = solve_all(scene, presses, &watched)?;
    steps.finish();
    let reused = watched.reused.into_inner();
    if reused > 0 {
        println!("finite elements: {reused} of {} presses as an earlier run left them", found.len());
    }
    let steps = Progress::new(0, "glued discs");
    let discs = GluedDiscs::solve(scene, level, kept, |done, all| steps.show(done, all, "pressed and sheared"))?;
    steps.finish();
    let solved = answer(scene, presses, discs, |job| found.iter().find(|(own, _)| own == job).map(|(_, forces)| forces.clone()))?;
    Ok((solved, reused))
}

/// Stores and reports each press when it is solved.
struct Watched<'a> {
    store: &'a Store<'a>,
    steps: &'a Progress,
    /// Number of presses that an earlier run solved.
    reused: AtomicUsize,
}

impl PressListener for Watched<'_> {
    fn stored(&self, job: &PressJob) -> Option<Forces> {
        self.store.press(job)
    }

    fn reached(&self, job: &PressJob, depth_m: f64) {
        let [x, y] = job.place_m.map(|x| x * 1e3);
        self.steps.say(format!("({x:.1}, {y:.1}) mm, {:.2} mm deep", depth_m * 1e3));
    }

    fn done(&self, job: &PressJob, forces: &Forces, anew: bool) -> Result<(), TissueError> {
        if anew {
            self.store.keep_press(job, forces)?;
        } else {
            self.reused.fetch_add(1, Ordering::Relaxed);
        }
        let [x, y] = job.place_m.map(|x| x * 1e3);
        self.steps.one(&format!("({x:.1}, {y:.1}) mm, {} nodes", forces.nodes));
        Ok(())
    }
}
