//! Stages shared by blocks and organs: the fit, new or from an earlier run, and its evaluation.

use palpate_fit::calibrate::targets::Reference;
use palpate_fit::calibrate::{Calibration, Round, Settings};
use palpate_fit::scene_fit::{Judging, Verdict, refuse_beyond_the_guard};
use palpate_fit::statics::Vector;
use palpate_tissue::Error as TissueError;
use palpate_tissue::budget::CostModel;
use palpate_tissue::patch::Patch;
use palpate_tissue::scene::Scene;
use palpate_tissue::session::{Session, packed};
use palpate_tissue::stable_step::StableStep;

use super::super::progress::Progress;
use super::board::{accepted, on_board};
use super::store::{Store, StoredFit};
use crate::error::Error;

/// Inputs that the stages share.
pub(super) struct Stages<'a> {
    pub scene: &'a Scene,
    /// Forces to which the patch is fitted.
    pub known: &'a dyn Reference,
    pub store: &'a Store<'a>,
    /// Name of the fit, for the progress display.
    pub what: &'static str,
}

/// A fitted patch and its verdict.
pub(super) struct JudgedFit {
    /// The patch as the machine runs it.
    pub session: Session,
    /// Verdict of the patch before the fit; `None` if it cannot run.
    pub before: Option<Verdict>,
    pub verdict: Verdict,
}

impl Stages<'_> {
    /// Returns the fit of an earlier run to the same problem, or a new one, and whether it is an
    /// earlier one.
    pub(super) fn fit(
        &self,
        settings: &Settings,
        problem: &str,
        make: impl FnOnce(&mut dyn FnMut(&Round)) -> Result<Calibration, TissueError>,
    ) -> Result<(StoredFit, bool), Error> {
        let force = |depth_m| self.known.force(Vector::zeros(), depth_m).unwrap_or(0.0);
        refuse_beyond_the_guard(self.scene, force)?;
        if let Some(stored) = self.store.fit(problem) {
            println!("{}: as an earlier run left it", self.what);
            stored.print_lost();
            return Ok((stored, true));
        }
        let steps = Progress::new(settings.rounds as u64 + 1, self.what);
        let fit = make(&mut |r: &Round| steps.one(&format!("force error {:.2} % rms", r.force_rms_pct)))?;
        steps.finish();
        let stable = StableStep::measure(&fit.patch.wide_model(), &fit.params, fit.patch.site_m()).map_err(TissueError::from)?;
        let patch = fit.patch.pack(&fit.params, stable.map_or(0.0, |s| s.pressed_s) as f32);
        let stored = StoredFit::new(problem, &patch, fit.rounds, fit.lost_presses);
        stored.print_lost();
        self.store.keep_fit(&stored)?;
        Ok((stored, false))
    }

    /// Evaluates the patch before and after the fit, as `machine` runs it.
    pub(super) fn judge(
        &self,
        judging: &Judging,
        uncalibrated: (&Patch, &palpate::Params),
        fit: &StoredFit,
        machine: &CostModel,
    ) -> Result<JudgedFit, Error> {
        let (patch, params) = packed::unpack(&fit.patch()).map_err(TissueError::from)?;
        let steps = Progress::new(2, "judging");
        let before = Session::of_fitted(machine, uncalibrated.0.clone(), *uncalibrated.1);
        let before = before.and_then(|session| judging.judge(&session)).ok();
        steps.one("the patch before the fit");
        let session = on_board(&patch, params, machine)?;
        let session = accepted(&session.clone().for_motion(machine, self.scene)?, self.scene, machine).unwrap_or(session);
        let verdict = judging.judge(&session)?;
        steps.one("the fitted patch");
        steps.finish();
        Ok(JudgedFit { session, before, verdict })
    }
}
