//! Fits and evaluates one candidate.

use palpate::{Params, Terms};
use serde::{Serialize, Serializer};

use super::candidate::{Candidate, Weighed};
use super::rim_treatment::RimTreatment;
use crate::calibrate::Settings;
use crate::scene_fit::{Judging, PIECE_JUDGED_RADII, PLACES, PiecePresses, Verdict};
use palpate_tissue::budget::{CostModel, Counts, MACHINES};
use palpate_tissue::error::Error;
use palpate_tissue::scene::Scene;
use palpate_tissue::session::Session;
use palpate_tissue::session::moving::MovingReport;

/// Number of random places at which a full fit is evaluated.
const FULL_PLACES: usize = 240;

/// Effort spent on a fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Effort {
    /// Few places and rounds, which suffice to distinguish good candidates from bad ones.
    Screened,
    /// Full number of places and rounds; the patch that is written comes from such a fit.
    Full,
}

/// Inputs that are common to all trials.
pub struct Bench<'a> {
    /// Scene that is planned.
    pub scene: &'a Scene,
    /// Board for which the scene is planned.
    pub machine: &'static CostModel,
    /// Presses for fitting and evaluating trials.
    pub presses: &'a PiecePresses,
    /// Tolerance of the forces [%].
    pub tolerance_pct: f64,
    /// Whether the search is quick, with fewer and smaller candidates.
    pub quick: bool,
    /// Returns a fitted session in a form that the board accepts, `None` if it has none.
    pub on_board: &'a dyn Fn(&Session) -> Option<Session>,
    /// Receives messages on the progress.
    pub progress: &'a dyn Fn(&str),
}

/// A candidate after fit and evaluation, also called a trial.
#[derive(Clone, Debug, Serialize)]
pub struct JudgedCandidate {
    /// Point of the search space.
    pub candidate: Candidate,
    /// Treatment of the rim of the patch.
    pub edge: RimTreatment,
    /// Terms of the tick that are active.
    #[serde(serialize_with = "by_name")]
    pub terms: Terms,
    /// Effort spent on the fit.
    pub effort: Effort,
    /// Parameters with which the fit started, adapted to the board.
    #[serde(skip)]
    pub params: Params,
    /// Numbers of nodes, springs, tets and the other items that cost time.
    pub counts: Counts,
    /// Number of substeps per tick.
    pub substeps: u16,
    /// Cost per tick [units of the board].
    pub units: f64,
    /// Memory of the state on a board [bytes].
    pub ram_bytes: usize,
    /// Size of the patch file [bytes].
    pub patch_bytes: usize,
    /// Whether the candidate meets the limits of the board on time and memory, and the board
    /// accepts its patch.
    pub fits: bool,
    /// Force errors of the fitted patch.
    pub judged: Verdict,
    /// The tightest tolerance that the candidate meets [%].
    pub keeps_pct: f64,
    /// Error of the shear stiffness of a glued disc that is due to the rim treatment alone [%].
    pub shear_error_pct: Option<f64>,
    /// Error under the scene's motion with these substeps; only after a full fit.
    pub moving: Option<MovingReport>,
    /// Session that can be written; only after a full fit.
    #[serde(skip)]
    pub session: Option<Box<Session>>,
}

fn by_name<S: Serializer>(terms: &Terms, to: S) -> Result<S::Ok, S::Error> {
    let named = [("volume", terms.volume), ("compensation", terms.compensation), ("rim", terms.rim)];
    to.collect_seq(named.into_iter().filter(|t| t.1).map(|t| t.0))
}

impl JudgedCandidate {
    /// Whether presses and the rim in shear meet a tolerance [%], and whether the error under
    /// motion is within the scene's limit.
    #[must_use]
    pub fn keeps(&self, tolerance_pct: f64) -> bool {
        let moving = self.moving.is_none_or(|moving| moving.keeps());
        self.keeps_pct <= tolerance_pct && self.edge_keeps(tolerance_pct) && moving
    }

    /// Whether the rim treatment alone meets the tolerance in shear.
    #[must_use]
    pub fn edge_keeps(&self, tolerance_pct: f64) -> bool {
        self.shear_error_pct.is_some_and(|e| e.abs() <= tolerance_pct)
    }

    /// The slowest named board that can run the candidate.
    #[must_use]
    pub fn slowest_board(&self) -> Option<&'static CostModel> {
        // the desktop is first in the list and is the fastest
        let [desktop, boards @ ..] = &MACHINES;
        boards.iter().chain([desktop]).find(|m| {
            let cost = m.cost_of(&self.counts, &self.params, self.substeps);
            cost.units <= cost.budget && m.has_room(&self.counts, self.patch_bytes)
        })
    }
}

impl Bench<'_> {
    /// Fits a candidate with the given rim treatment, terms and effort, and evaluates it.
    ///
    /// # Errors
    /// Fails if the patch cannot be fitted, pressed or run.
    pub fn run(&self, weighed: &Weighed, edge: RimTreatment, terms: Terms, effort: Effort) -> Result<JudgedCandidate, Error> {
        let candidate = weighed.candidate;
        let what = if effort == Effort::Full { "fitting" } else { "screening" };
        (self.progress)(&format!(
            "{what} {} nodes, radius {} and elements {} probe radii, {}",
            weighed.counts.nodes,
            candidate.radius_radii,
            candidate.element_radii,
            edge.name()
        ));
        let (places, rounds, judged_places) = match effort {
            Effort::Screened => (30, 6, PLACES),
            Effort::Full => (80, 14, FULL_PLACES),
        };
        let settings = Settings { places, rounds, ..Settings::default() };
        let (tissue, rim) = edge.applied(weighed);
        let terms = Terms { rim: rim.is_some(), ..terms };
        let params = self.machine.adapt(&Params { terms, ..weighed.params });
        let terms = params.terms;
        let presses = self.presses;
        let fit = presses.fit((&tissue, rim.as_ref()), &weighed.material, &params, &settings, &mut |_| {})?;
        let judging = Judging {
            known: presses.known.reference(),
            fitted_m: &presses.fitted_m,
            unseen: &presses.unseen,
            disc_radii: PIECE_JUDGED_RADII,
            places: judged_places,
            reference_error: presses.error,
        };
        let unpressed = |cause: &dyn std::fmt::Display| Error::Check(format!("the fitted patch cannot be pressed: {cause}"));
        let ready = Session::of_fitted(self.machine, fit.patch, fit.params)?;
        let judged = judging.judge(&ready).map_err(|cause| unpressed(&cause))?;
        if judged.lost_too_many() {
            return Err(unpressed(&"it does not come to rest"));
        }
        let touched = weighed.counts.touched;
        let counts = Counts::of(&ready.patch.model(), touched);
        let shear_error_pct = edge.shear_error_pct(weighed);
        let (mut substeps, mut patch_bytes, mut moving, mut session) = (weighed.substeps, weighed.patch_bytes, None, None);
        let mut accepted = true;
        if effort == Effort::Full {
            // a limit that the scene asks for may take a faster board
            let ready = match self.scene.solver.moving_error_pct {
                Some(_) => ready.clone().for_motion_as(self.machine, self.scene, |_| true)?.unwrap_or(ready),
                None => ready.for_motion(self.machine, self.scene)?,
            };
            let on_board = (self.on_board)(&ready);
            accepted = on_board.is_some();
            let ready = on_board.unwrap_or(ready);
            moving = ready.report.moving;
            substeps = ready.params.substeps;
            patch_bytes = ready.patch.pack(&ready.params, ready.stable.pressed_s as f32).len();
            session = Some(Box::new(ready));
        }
        let cost = self.machine.cost_of(&counts, &params, substeps);
        Ok(JudgedCandidate {
            candidate,
            edge,
            terms,
            effort,
            params,
            counts,
            substeps,
            units: cost.units,
            ram_bytes: counts.ram_bytes(),
            patch_bytes,
            fits: accepted && cost.units <= cost.budget && self.machine.has_room(&counts, patch_bytes),
            keeps_pct: judged.keeps_pct(),
            judged,
            shear_error_pct,
            moving,
            session,
        })
    }
}
