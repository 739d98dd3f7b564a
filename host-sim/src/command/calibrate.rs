//! The command `palpate calibrate`.

mod record;

use serde::Serialize;

use super::options::calibrate::{CalibrateArgs, FitName};
use super::progress::Status;
use super::verdict::Verdict;
use crate::error::Error;
use palpate_charts::{self as charts, ConvergencePoint};
use palpate_fit::calibrate::accuracy::{self, Accuracy, DepthError, PLACES};
use palpate_fit::calibrate::reference_map::ReferenceMap;
use palpate_fit::calibrate::targets::{DISC_RADII, GLUED_TOLERANCE};
use palpate_fit::calibrate::{Calibration, Fit, Round, Settings, Targets, annealing, calibrate};
use palpate_fit::scene_fit::{Prepared, prepare, top_nodes};
use palpate_tissue::Error as TissueError;
use palpate_tissue::answer::Answer;
use palpate_tissue::output::OutputFolder;
use palpate_tissue::scene::Scene;
use palpate_tissue::session::{Session, calibrated};
use palpate_tissue::stable_step::StableStep;
use palpate_tissue::tissue::Tissue;

/// Range of the number of probe places.
const PLACES_RANGE: std::ops::RangeInclusive<usize> = 1..=2000;
/// Nodes, places and rounds of a fit with `--quick`.
const QUICK: (usize, usize, usize) = (130, 40, 6);

impl CalibrateArgs {
    pub(super) fn run(&self) -> Result<(), Error> {
        let mut scene = self.common.load()?;
        scene.refuse_stiffening()?;
        scene.refuse_long_tip("calibrate")?;
        let answer = match &self.reference {
            Some(path) => Answer::load(path)?,
            None => Answer::block(),
        };
        if self.check {
            return self.press_shipped(&scene, &answer);
        }
        let (nodes, places, rounds) = match self.quick {
            true => (Some(QUICK.0), QUICK.1, QUICK.2),
            false => (self.nodes, self.places, self.rounds.unwrap_or(self.default_rounds())),
        };
        if scene.tissue.block_m.is_none() || !scene.tissue.inclusion.is_empty() {
            return Err(TissueError::Usage(format!(
                "scene {}: a patch is calibrated on a block without inclusions: use such a scene, or palpate fit, which fits what the inclusions add",
                scene.name
            )).into());
        }
        if !PLACES_RANGE.contains(&places) || rounds == 0 {
            let (first, last) = (PLACES_RANGE.start(), PLACES_RANGE.end());
            return Err(TissueError::Usage(format!(
                "--places {places} --rounds {rounds}: take {first} to {last} places and at least one round"
            ))
            .into());
        }
        scene.probe.position_m = None;
        if nodes.is_some() {
            scene.tissue.nodes = nodes;
        }
        if !answer.is_for(&scene) {
            return Err(TissueError::Usage(format!(
                "scene {}: the reference answer is for another block, Poisson's ratio or probe: palpate fit solves and fits this scene; an answer.json of it is given with --reference",
                scene.name
            )).into());
        }
        let Prepared { tissue, material, params } = prepare(&scene)?.with_points(self.points)?;
        let mut targets = targets(&scene, &tissue, &answer, places)?;
        if self.glued {
            if answer.glued.is_empty() {
                return Err(TissueError::Usage(
                    "--glued: the reference answer has no glued discs: take the one that ships".into(),
                )
                .into());
            }
            targets = targets.with_glued(&answer.glued, GLUED_TOLERANCE);
        }
        let folder = self.common.open("calibrate", &scene)?;
        println!(
            "scene {}: {} nodes, {} points a triangle, {places} places, {} forces and dents of {} nodes",
            scene.name,
            tissue.mesh.nodes_m.len(),
            material.points_per_triangle,
            targets.places.iter().map(|p| p.forces.len()).sum::<usize>(),
            targets.places[0].dents.first().map_or(0, |d| d.nodes.len())
        );
        println!("\n{:>11} {:>12} {:>12} {:>10} {:>8}", "evaluations", "cost", "force rms %", "dent mm", "time s");
        let settings = Settings { places, rounds, fit: self.fit.into(), ..Settings::default() };
        let status = Status::start();
        let calibration =
            calibrate(&tissue, &material, None, &params, &targets, &settings, &mut |r: &Round| status.above(|| print_round(r)))
                .map_err(|cause| TissueError::Usage(format!("scene {}: {cause}", scene.name)))?;
        status.clear();
        self.write(folder, &scene, &answer, &calibration)
    }

    fn default_rounds(&self) -> usize {
        match self.fit {
            FitName::GaussNewton => Settings::default().rounds,
            FitName::Annealing => annealing::SCHEDULE_EVALUATIONS,
        }
    }

    fn write(&self, folder: OutputFolder, scene: &Scene, answer: &Answer, calibration: &Calibration) -> Result<(), Error> {
        let Calibration { patch, params, rounds, .. } = calibration;
        if !matches!((rounds.first(), rounds.last()), (Some(first), Some(last)) if last.cost < first.cost) {
            return Err(TissueError::Check(
                "the fit did not improve the patch, nothing is written: take more places or another node count".into(),
            )
            .into());
        }
        let stable = StableStep::measure(&patch.wide_model(), params, patch.site_m())?;
        let stable_s = stable.map_or(0.0, |s| s.pressed_s);
        let name = format!("{}-{}.patch", scene.name, patch.model().nodes.len());
        let bytes = patch.pack(params, stable_s as f32);
        folder.write(&name, &bytes)?;
        let header = ["evaluations", "cost", "force_rms_pct", "dent_mean_mm", "elapsed_s"];
        let rows = rounds.iter().map(|r| [r.evaluations as f64, r.cost, r.force_rms_pct, r.dent_mean_mm, r.elapsed_s]);
        folder.write_csv("convergence.csv", header, rows)?;
        let points: Vec<ConvergencePoint> = rounds.iter().map(point).collect();
        charts::convergence(folder.draft(), "convergence", &scene.name, &points)?;
        let map = ReferenceMap::of(answer).ok_or_else(|| too_few(scene))?;
        let accuracy = Accuracy::of(patch, params, &map, accuracy::DISC_RADII, PLACES)
            .map_err(|cause| TissueError::Check(cause.to_string()))?;
        print_accuracy(&name, &accuracy);
        write_accuracy(&folder, &accuracy)?;
        record::write(&folder, &name, &bytes, scene, answer, &accuracy, calibration.lost_presses)?;
        folder.write_summary(&Summary {
            scene: &scene.name,
            nodes: patch.model().nodes.len(),
            fitted_places: patch.fitted_places(),
            compensation: params.compensation,
            compensation_threshold: params.compensation_threshold,
            stable_dt_s: stable_s,
            annealing_schedule_evaluations: annealing::SCHEDULE_EVALUATIONS,
            rounds,
            accuracy: &accuracy,
        })?;
        let file = folder.publish()?.join(&name);
        println!("\nwrote {}: summary.json, convergence.csv, accuracy.csv, picture as SVG and PNG", file.display());
        println!("press it with patch = \"{}\" under [solver] of a scene", file.display());
        let gained = |round: Option<&Round>| round.map_or(f64::NAN, |round| round.force_rms_pct);
        let (before, after) = (gained(rounds.first()), gained(rounds.last()));
        let largest = |error: fn(&DepthError) -> Option<f64>| {
            accuracy.forces.iter().filter_map(error).map(f64::abs).reduce(f64::max).map_or("-".into(), |e| format!("{e:.1}"))
        };
        let (rms, worst) = (largest(|f| f.disc_rms_pct), largest(|f| f.disc_worst_pct));
        let trial = if self.quick { "; --quick is a trial, not a patch to rely on" } else { "" };
        Verdict::ok(format!(
            "the fit brought the force error from {before:.2} to {after:.2} % rms at its own places; at unseen ones it is {rms} % rms at the worst depth, {worst} % at worst{trial}"
        ))
        .last()
    }

    fn press_shipped(&self, scene: &Scene, answer: &Answer) -> Result<(), Error> {
        let map = ReferenceMap::of(answer).ok_or_else(|| too_few(scene))?;
        let sizes = self.nodes.map_or(calibrated::SIZES.to_vec(), |n| vec![n]);
        let folder = OutputFolder::add_to(&self.common.folder("calibrate"))?;
        for nodes in sizes {
            let mut scene = scene.clone();
            scene.tissue.nodes = Some(nodes);
            if !answer.is_for(&scene) {
                return Err(TissueError::Usage(format!(
                    "scene {}: the reference answer is for another scene: give one with --reference",
                    scene.name
                ))
                .into());
            }
            let session = Session::prepare(&scene)?;
            let accuracy = Accuracy::of(&session.patch, &session.params, &map, accuracy::DISC_RADII, PLACES)
                .map_err(|cause| TissueError::Check(cause.to_string()))?;
            let fitted = session.patch.fitted_places();
            print_accuracy(&format!("{} nodes, fitted over {fitted} places", session.report.nodes), &accuracy);
            folder.write_json(&format!("accuracy-{nodes}.json"), &accuracy)?;
            if let Some(bytes) = calibrated::bytes(nodes).filter(|_| scene.solver.patch.is_none()) {
                record::write(&folder, &format!("block-{nodes}.patch"), bytes, &scene, answer, &accuracy, 0)?;
            }
        }
        folder.publish()?;
        Ok(())
    }
}

fn too_few(scene: &Scene) -> Error {
    Error::Tissue(TissueError::Usage(format!(
        "scene {}: the reference answer has fewer than four centred presses: solve more depths",
        scene.name
    )))
}

fn targets(scene: &Scene, tissue: &Tissue, answer: &Answer, places: usize) -> Result<Targets, Error> {
    let map = ReferenceMap::of(answer).ok_or_else(|| too_few(scene))?;
    if map.deepest_m() < scene.probe.radius_m {
        return Err(lacking(scene));
    }
    Targets::over_a_disc(&map, &top_nodes(tissue), tissue.site_m.into(), scene.probe.radius_m, DISC_RADII, places)
        .ok_or_else(|| lacking(scene))
}

fn lacking(scene: &Scene) -> Error {
    Error::Tissue(TissueError::Usage(format!(
        "scene {}: the reference answer lacks presses this fit needs (to a probe's radius at the centre, places off it, surfaces at a quarter and a half radius): palpate fit solves what it needs, and fits",
        scene.name
    )))
}

fn print_accuracy(name: &str, accuracy: &Accuracy) {
    println!(
        "\n{name}: force error against finite elements, pressed at the centre, and at random places within 1.5 probe radii that the fit did not see"
    );
    println!("{:>9} {:>10} {:>12} {:>10}", "depth mm", "centred %", "places rms %", "worst %");
    let or_dash =
        |v: Option<f64>, signed: bool| v.map_or("-".into(), |v| if signed { format!("{v:+.2}") } else { format!("{v:.2}") });
    for f in &accuracy.forces {
        let (rms, worst) = (or_dash(f.disc_rms_pct, false), or_dash(f.disc_worst_pct, true));
        println!("{:>9.2} {:>+10.2} {rms:>12} {worst:>10}", f.depth_mm, f.centred_pct);
    }
    for d in &accuracy.dents {
        println!(
            "surface of a press of {:.0} mm: {:.4} mm off on average, {:.3} at most ({:.4} on average at the nodes)",
            d.depth_mm, d.surface_mean_mm, d.surface_max_mm, d.nodes_mean_mm
        );
    }
    for g in &accuracy.glued {
        let ([x, y, _], [i, j, k]) = (g.place_mm, g.direction);
        println!(
            "stiffness of a disc of {:.0} mm glued at ({x:.0}, {y:.0}) mm and moved along ({i:.0}, {j:.0}, {k:.0}): {:+.2} % off",
            g.radius_mm, g.error_pct
        );
    }
}

fn write_accuracy(folder: &OutputFolder, accuracy: &Accuracy) -> Result<(), Error> {
    let rows = accuracy
        .forces
        .iter()
        .map(|f| [f.depth_mm, f.centred_pct, f.disc_rms_pct.unwrap_or(f64::NAN), f.disc_worst_pct.unwrap_or(f64::NAN)]);
    Ok(folder.write_csv("accuracy.csv", ["depth_mm", "centred_pct", "disc_rms_pct", "disc_worst_pct"], rows)?)
}

#[derive(Serialize)]
struct Summary<'a> {
    scene: &'a str,
    nodes: usize,
    fitted_places: u32,
    compensation: f32,
    compensation_threshold: f32,
    stable_dt_s: f64,
    annealing_schedule_evaluations: usize,
    rounds: &'a [Round],
    accuracy: &'a Accuracy,
}

fn print_round(r: &Round) {
    println!("{:>11} {:>12.1} {:>12.3} {:>10.4} {:>8.1}", r.evaluations, r.cost, r.force_rms_pct, r.dent_mean_mm, r.elapsed_s);
}

impl From<FitName> for Fit {
    fn from(name: FitName) -> Self {
        match name {
            FitName::GaussNewton => Self::GaussNewton,
            FitName::Annealing => Self::Annealing,
        }
    }
}

fn point(round: &Round) -> ConvergencePoint {
    ConvergencePoint {
        evaluations: round.evaluations,
        force_rms_pct: round.force_rms_pct,
        dent_mean_mm: round.dent_mean_mm,
        elapsed_s: round.elapsed_s,
    }
}
