//! `palpate fit` of a block with inclusions: the force that they add is fitted to the patch of the
//! block without them.

use palpate_charts::{Dot, Figure, Plot, ScaledAxis, Series};
use palpate_fit::calibrate::Settings;
use palpate_fit::force_map::BlockForces;
use palpate_fit::scene_fit::{
    BumpFit, Bumps, JUDGED_RADII, Judging, Level, PLACES as JUDGED_PLACES, Prepared, Presses, Solved, Verdict, solve_bumps,
};
use palpate_fit::solved;
use palpate_tissue::Error as TissueError;
use palpate_tissue::budget::MACHINES;
use palpate_tissue::output::OutputFolder;
use palpate_tissue::scene::Scene;
use palpate_tissue::session::{Session, packed};

use super::super::progress::Progress;
use super::added_force::{BumpLine, BumpReport};
use super::report::Report;
use super::stages::Stages;
use super::store::{Store, StoredFit};
use super::{Fitted, PatchFile};
use crate::command::options::fit::FitArgs;
use crate::error::Error;

/// Number of places of the fit (there are more at shallow depths), and of its rounds. More places
/// gain little: 160 places reduce the error of the added force of a ball of 8 mm, 10 mm deep, from
/// 1.8 to 1.6 % rms.
const PLACES: usize = 80;
const ROUNDS: usize = 6;
const QUICK_ROUNDS: usize = 2;
/// Share of the objective that a round must gain for the fit to continue.
const LEAST_GAIN: f64 = 0.1;

/// The fitted block without its inclusions.
pub(super) struct Block<'a> {
    pub prepared: &'a Prepared,
    pub presses: &'a Presses,
    pub known: &'a BlockForces,
    pub solved: &'a Solved,
    pub fit: &'a StoredFit,
    pub reused_presses: usize,
}

impl FitArgs {
    pub(super) fn fit_bump(&self, scene: &Scene, folder: OutputFolder, level: Level, block: &Block) -> Result<Fitted, Error> {
        let deepest_m = block.presses.fitted_m.last().copied().unwrap_or_default();
        let path = self.common.folder("fit");
        let store = Store::of(&path, &folder, scene);
        let kept = solved::Solved::beside(&path);
        let steps = Progress::new(0, "finite elements");
        let told = |done, all| steps.show(done, all, "places with the inclusions and without");
        let bumps = solve_bumps(scene, deepest_m, level, &kept, told)?;
        steps.finish();
        kept.said().iter().for_each(|line| println!("{line}"));
        let (patch, params) = packed::unpack(&block.fit.patch()).map_err(TissueError::from)?;
        let fitting = BumpFit {
            prepared: block.prepared,
            plain: (&patch, &params),
            known: block.known,
            bumps: &bumps,
            inclusions: &scene.tissue.inclusion,
        };
        let bumped = fitting.bumped();
        let stages = Stages { scene, known: &bumped, store: &store, what: "fit of the inclusions" };
        let rounds = if self.options.quick { QUICK_ROUNDS } else { ROUNDS };
        let settings = Settings { places: PLACES, rounds, least_gain: LEAST_GAIN };
        let problem = format!("{:x} {settings:?} {bumps:?}", block.fit.problem());
        let (fit, reused_fit) = stages.fit(&settings, &problem, |progress| fitting.fit(scene, &settings, progress))?;
        let [known, unseen] = fitting.answers(scene);
        let judging = Judging {
            known: &bumped,
            fitted_m: &bumps.fitted_m,
            unseen: &unseen,
            disc_radii: JUDGED_RADII,
            places: JUDGED_PLACES,
            reference_error: block.solved.error,
        };
        let judged = stages.judge(&judging, (&fitting.uncalibrated(), &params), &fit, &MACHINES[0])?;
        let bump = report(scene, &fitting, &bumps, &judged.session)?;
        store.write(block.presses.jobs(), &[block.fit, &fit])?;
        let mut answer = known;
        answer.holds.extend(unseen.holds.iter().cloned());
        draw(scene, &folder, &bump)?;
        // the result is the sum of two fits
        let fit = fit.after(block.fit);
        let report = Report {
            scene,
            options: &self.options,
            fitted_m: &bumps.fitted_m,
            known: &bumped,
            answer: &answer,
            reference_nodes: Some(block.solved.nodes),
            reference_error: block.solved.error,
            fit: &fit,
            judged: &judged,
            trials: &[],
            bump: Some(&bump),
            reused_fit,
            reused_presses: block.reused_presses + kept.found(),
            places: settings.places,
        };
        let written = report.write(folder, PatchFile::of(scene, &judged.session, &fit))?;
        let verdict = Verdict {
            lost_presses: judged.verdict.lost_presses + bump.fitted.lost_presses,
            presses: judged.verdict.presses + bump.fitted.presses,
            ..judged.verdict
        };
        Ok(self.judged(written, &verdict))
    }
}

fn report(scene: &Scene, fitting: &BumpFit, bumps: &Bumps, own: &Session) -> Result<BumpReport, Error> {
    let scaled = Session::of_fitted(&MACHINES[0], fitting.scaled(), *fitting.plain.1)?;
    let (fitted, scaled_in) = (fitting.along_the_line(own)?, fitting.along_the_line(&scaled)?);
    let e_pa = scene.tissue.youngs_modulus_pa;
    let depths = bumps.depths_m.iter().zip(fitted.iter().zip(&scaled_in));
    let line = depths.map(|(depth_m, (fitted, scaled_in))| BumpLine {
        depth_m: *depth_m,
        x_m: bumps.line_m().iter().map(|place| place[0]).collect(),
        finite_elements_n: fitted.iter().map(|(_, wanted)| e_pa * wanted).collect(),
        fitted_n: fitted.iter().map(|(own, _)| e_pa * own).collect(),
        scaled_in_n: scaled_in.iter().map(|(own, _)| e_pa * own).collect(),
    });
    Ok(BumpReport {
        line: line.collect(),
        scaled_in: fitting.judge(&scaled)?,
        fitted: fitting.judge(own)?,
        reference_error_pct: 100.0 * bumps.error,
    })
}

/// Draws the added force along the line, at the middle and at the deepest depth.
fn draw(scene: &Scene, folder: &OutputFolder, bump: &BumpReport) -> Result<(), Error> {
    let count = bump.line.len();
    let shown: Vec<&BumpLine> = [count / 2, count.saturating_sub(1)].iter().filter_map(|n| bump.line.get(*n)).collect();
    let mut series = Vec::new();
    for line in shown {
        let curves = [&line.finite_elements_n, &line.fitted_n, &line.scaled_in_n];
        for (n, (who, force_n)) in ["finite elements", "fitted", "scaled in"].into_iter().zip(curves).enumerate() {
            let found = line.x_m.iter().zip(force_n).filter(|(_, force_n)| force_n.is_finite());
            let dots = found.map(|(x_m, force_n)| Dot::from((x_m * 1e3, force_n * 1e3))).collect();
            let name = format!("{who}, {:.2} mm deep", line.depth_m * 1e3);
            series.push(Series { joined: n > 0, marked: n == 0, ..Series::dots(name, dots) });
        }
    }
    let plot = Plot::new(ScaledAxis::linear("place along x [mm]"), ScaledAxis::linear("force added [mN]"), series);
    let title = format!("{}: force that the inclusions add", scene.name);
    let below = "along a line that no fit has seen; scaled in: every constant times what its formula makes of the inclusions";
    Ok(Figure::plot("bump", title, below, plot).draw(folder.draft())?)
}
