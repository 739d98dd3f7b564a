//! Stages shared by blocks and organs: the fit, new or from an earlier run, and its evaluation.

use palpate_fit::calibrate::targets::Reference;
use palpate_fit::calibrate::{Calibration, Round, Settings};
use palpate_fit::scene_fit::{Judging, Verdict, refuse_beyond_the_guard};
use palpate_fit::statics::{Unbalanced, Vector};
use palpate_tissue::Error as TissueError;
use palpate_tissue::budget::MACHINES;
use palpate_tissue::patch::Patch;
use palpate_tissue::scene::Scene;
use palpate_tissue::session::{Session, packed};
use palpate_tissue::stable_step::StableStep;

use super::super::progress::Progress;
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
    pub session: Session,
    /// Parameters of the patch as it was fitted.
    pub params: palpate::Params,
    /// Verdict of the patch before the fit.
    pub before: Verdict,
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

    /// Evaluates the patch before and after the fit.
    pub(super) fn judge(
        &self,
        judging: &Judging,
        uncalibrated: (&Patch, &palpate::Params),
        fit: &StoredFit,
    ) -> Result<JudgedFit, Error> {
        let unbalanced = |cause: Unbalanced| Error::Tissue(TissueError::Check(format!("scene {}: {cause}", self.scene.name)));
        let (patch, params) = packed::unpack(&fit.patch()).map_err(TissueError::from)?;
        let steps = Progress::new(2, "judging");
        let before = judging.judge(uncalibrated.0, uncalibrated.1).map_err(unbalanced)?;
        steps.one("the patch before the fit");
        let verdict = judging.judge(&patch, &params).map_err(unbalanced)?;
        steps.one("the fitted patch");
        steps.finish();
        let session = Session::of_fitted(&MACHINES[0], patch, params)?.for_motion(&MACHINES[0], self.scene)?;
        Ok(JudgedFit { session, params, before, verdict })
    }
}
