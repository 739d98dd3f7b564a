//! `palpate fit`: from a scene to a calibrated patch with a judged error.

mod organ;
mod report;
mod stages;
mod store;
mod trials;

use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};

use clap::Args;

use super::Common;
use super::progress::Steps;
use crate::error::Error;
use palpate_fit::calibrate::{Fit, Settings};
use palpate_fit::plan::WORST_RATIO;
use palpate_fit::scene_fit::{
    Forces, JUDGED_RADII, Judging, Known, Level, PLACES_RANGE, Prepared, PressJob, Presses, Solved, Verdict, Watch, answer,
    check, check_block, prepare, solve_all,
};
use palpate_tissue::Error as TissueError;
use palpate_tissue::answer::AnswerProbe;
use palpate_tissue::output::OutputFolder;
use palpate_tissue::scene::{NO_PATCH, Scene};
use palpate_tissue::session::calibrated;
use palpate_tissue::trials::Trial;

use report::Report;
use stages::Stages;
use store::Store;

/// Most nodes that a block is meshed with.
const MOST_NODES: f64 = 5000.0;
/// Places if none are given: patches of few nodes are fitted sooner and gain more by another place.
const PLACES_TIMES_NODES: usize = 33_000;
const PLACES: std::ops::RangeInclusive<usize> = 80..=250;
/// Most rounds of a fit: later ones gain little. With `--quick`.
const ROUNDS: usize = 10;
const QUICK_ROUNDS: usize = 3;
/// A round that gains less than this share of the objective is the last: five more would bring the
/// force error of 410 nodes from 0.88 to 0.84 %.
const LEAST_GAIN: f64 = 0.03;

#[derive(Args, Clone, Debug)]
pub(super) struct FitArgs {
    #[command(flatten)]
    common: Common,
    /// Nodes of the patch [default: the scene's of a block, 100 of a piece of an organ].
    #[arg(long, value_name = "COUNT")]
    nodes: Option<usize>,
    /// Of an organ or a mesh, the patch holds what lies within this of the site [m] [default: 2.125
    /// probe radii].
    #[arg(long, value_name = "METRES", allow_negative_numbers = true)]
    radius_m: Option<f64>,
    /// Places of the probe to fit over, beside the centre [default: 33 000 over the nodes, 80 to
    /// 250: the fewer nodes, the more].
    #[arg(long, value_name = "COUNT")]
    places: Option<usize>,
    /// Force error that is asked for, at places and depths that the fit never saw [%]: root mean
    /// square; a single press may be 2.5 times as far off.
    #[arg(long, value_name = "PERCENT", default_value_t = 2.0, allow_negative_numbers = true)]
    tolerance_pct: f64,
    /// Coarse finite elements and few rounds: a trial of the command, not a patch to rely on.
    #[arg(long)]
    quick: bool,
    /// Fit every scene of a folder, and put their trials together: the table that ships.
    #[arg(long, hide = true, value_name = "FOLDER", conflicts_with = "scene")]
    trials: Option<PathBuf>,
}

impl FitArgs {
    pub(super) fn run(&self) -> Result<(), Error> {
        match &self.trials {
            Some(scenes) => trials::run(self, scenes),
            None => self.fit_scene(),
        }
    }

    fn fit_scene(&self) -> Result<(), Error> {
        let scene = self.scene()?;
        match scene.tissue.block_m {
            Some(size_m) => self.fit_block(&scene, size_m),
            None => self.fit_organ(&scene),
        }
    }

    fn fit_block(&self, scene: &Scene, size_m: [f64; 3]) -> Result<(), Error> {
        check_block(scene, size_m)?;
        if self.radius_m.is_some() {
            let why = format!(
                "--radius-m: the scene {} is a block, which is fitted whole: leave it out, or use palpate cut",
                scene.file
            );
            return Err(TissueError::Usage(why).into());
        }
        let prepared = prepare(scene)?;
        let level = if self.quick { Level::Quick } else { Level::Full };
        let presses = Presses::of(scene, &prepared.tissue, level);
        let path = self.common.folder("fit");
        let folder = OutputFolder::open(&path)?;
        let store = Store::of(&path, &folder, scene);
        self.print_scene(scene, prepared.tissue.mesh.nodes_m.len(), &presses.fitted_m);
        let (solved, reused_presses) = reference(scene, &presses, &store)?;
        let known = Known::of(&solved.known)
            .ok_or_else(|| TissueError::Check("the finite elements gave fewer than four depths at the centre".into()))?;
        let settings = self.settings(prepared.tissue.mesh.nodes_m.len(), LEAST_GAIN);
        let problem = format!("{:?} {presses:?} {settings:?} {:?}", store.pressed(), prepared.material);
        let stages = Stages { scene, known: &known, store: &store };
        let (fit, reused_fit) =
            stages.fit(&settings, &problem, |progress| prepared.fit(scene, &presses, &known, &settings, progress))?;
        let judging = Judging { known: &known, fitted_m: &presses.fitted_m, unseen: &solved.unseen, disc_radii: JUDGED_RADII };
        let judged = stages.judge(&judging, (&prepared.uncalibrated(), &prepared.params), &fit)?;
        let mut trials = vec![trial(scene, &presses, &prepared, None, &judged.before)];
        trials.extend(other_tip(scene, &presses, &prepared, &judging));
        store.write(presses.jobs(), &fit)?;
        let mut answer = solved.known.clone();
        answer.holds.extend(solved.unseen.holds.iter().cloned());
        let report = Report {
            scene,
            fitted_m: &presses.fitted_m,
            known: &known,
            answer: &answer,
            reference_nodes: solved.nodes,
            reference_error: solved.error,
            fit: &fit,
            session: &judged.session,
            before: &judged.before,
            verdict: &judged.verdict,
            trials: &trials,
            reused_fit,
            reused_presses,
            places: settings.places,
            quick: self.quick,
            tolerance_pct: self.tolerance_pct,
        };
        report.write(folder)?;
        self.promise(prepared.tissue.mesh.nodes_m.len(), &judged.verdict)
    }

    fn print_scene(&self, scene: &Scene, nodes: usize, fitted_m: &[f64]) {
        println!(
            "scene {}: {nodes} nodes, nu {}, {}, {:.2} to {:.2} mm deep",
            scene.name,
            scene.tissue.poisson_ratio,
            scene.probe.tip(),
            fitted_m.first().unwrap_or(&f64::NAN) * 1e3,
            fitted_m.last().unwrap_or(&f64::NAN) * 1e3,
        );
    }

    /// The scene, if it can be fitted.
    fn scene(&self) -> Result<Scene, Error> {
        let mut scene = Scene::load(&self.common.scene)?;
        if let Some(places) = self.places.filter(|places| !PLACES_RANGE.contains(places)) {
            let (first, last) = (PLACES_RANGE.start(), PLACES_RANGE.end());
            return Err(TissueError::Usage(format!("--places {places}: take {first} to {last}")).into());
        }
        if !(self.tolerance_pct > 0.0 && self.tolerance_pct <= 100.0) {
            let why = format!("--tolerance-pct {}: give a percentage above 0, at most 100", self.tolerance_pct);
            return Err(TissueError::Usage(why).into());
        }
        check(&scene)?;
        // the scene may already name the patch that is about to be fitted
        scene.solver.patch = Some(NO_PATCH.into());
        scene.tissue.nodes = self.nodes.or(scene.tissue.nodes);
        Ok(scene)
    }

    /// How long a patch of so many nodes is fitted.
    fn settings(&self, nodes: usize, least_gain: f64) -> Settings {
        let rounds = if self.quick { QUICK_ROUNDS } else { ROUNDS };
        let places = self.places.unwrap_or((PLACES_TIMES_NODES / nodes.max(1)).clamp(*PLACES.start(), *PLACES.end()));
        Settings { places, rounds, least_gain, fit: Fit::GaussNewton }
    }

    /// Holds the verdict against the error that was asked for; where it misses, says what would do.
    fn promise(&self, nodes: usize, verdict: &Verdict) -> Result<(), Error> {
        let (asked, rms, worst) = (self.tolerance_pct, verdict.rms_pct(), verdict.worst_pct());
        let keeps = rms.max(worst.abs() / WORST_RATIO);
        if keeps <= asked {
            return Ok(());
        }
        // the error falls about with the root of the node count
        let would_do = match nodes as f64 * (keeps / asked).powi(2) {
            n if n > MOST_NODES => "more nodes than a block is meshed with would (an estimate): ask for".to_owned(),
            n => format!("try --nodes {:.0} (an estimate), or", (n / 10.0).ceil() * 10.0),
        };
        Err(TissueError::Check(format!(
            "{rms:.2} % rms and {worst:+.2} % at the worst unseen press, {asked} % rms and {:.1} % were asked for; all is written: {would_do} --tolerance-pct {:.1}",
            WORST_RATIO * asked,
            (keeps * 10.0).ceil() / 10.0
        ))
        .into())
    }
}

/// The shipped patch of this size under this scene's tip, where the tissue is its own.
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
    // a patch that is not pressed so far is no trial
    let verdict = judging.judge(&patch, &params).ok()?;
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

/// Solves what no earlier run has.
fn reference(scene: &Scene, presses: &Presses, store: &Store) -> Result<(Solved, usize), Error> {
    let steps = Steps::new("finite elements", presses.jobs().count());
    let watched = Watched { store, steps: &steps, reused: AtomicUsize::new(0) };
    let found = solve_all(scene, presses, &watched)?;
    steps.finish();
    let reused = watched.reused.into_inner();
    if reused > 0 {
        println!("finite elements: {reused} of {} presses as an earlier run left them", found.len());
    }
    let solved = answer(scene, presses, |job| found.iter().find(|(own, _)| own == job).map(|(_, forces)| forces.clone()))?;
    Ok((solved, reused))
}

/// Presses are stored, and told.
struct Watched<'a> {
    store: &'a Store<'a>,
    steps: &'a Steps,
    /// Presses that an earlier run solved.
    reused: AtomicUsize,
}

impl Watch for Watched<'_> {
    fn stored(&self, job: &PressJob) -> Option<Forces> {
        self.store.press(job)
    }

    fn reached(&self, job: &PressJob, depth_m: f64) {
        let [x, y] = job.place_m.map(|x| x * 1e3);
        self.steps.at(&format!("({x:.1}, {y:.1}) mm, {:.2} mm deep", depth_m * 1e3));
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
