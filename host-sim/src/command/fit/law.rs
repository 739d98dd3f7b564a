//! `palpate fit --law`: the force of a site over place, depth and speed, without nodes.

use palpate_fit::calibrate::targets::Reference;
use palpate_fit::far_field::prepared::{Prepared, Recipe};
use palpate_fit::force_map::BlockForces;
use palpate_fit::law_fit::motions::{self, MotionError};
use palpate_fit::law_fit::{LawPresses, STORED_RADII, block_shape, fit, stored};
use palpate_fit::scene_fit::{JUDGED_RADII, Judging, Level, PIECE_JUDGED_RADII, PIECE_RADII, PLACES, PiecePresses, Verdict};
use palpate_fit::solved::Solved;
use palpate_tissue::Error as TissueError;
use palpate_tissue::answer::Answer;
use palpate_tissue::budget::{CostModel, MACHINES};
use palpate_tissue::fit_record::{FitRecord, Moving};
use palpate_tissue::output::OutputFolder;
use palpate_tissue::scene::Scene;
use palpate_tissue::session::Session;
use palpate_tissue::tissue::{Placed, Tissue, place};
use serde::Serialize;

use super::super::progress::{Progress, told};
use super::report::record;
use super::{Fitted, Written};
use crate::command::options::fit::{FitArgs, FitOptions};
use crate::error::Error;

/// Edge length of the elements of a piece's rest shape [probe radii].
const ELEMENT_RADII: f64 = 0.56;
/// Radius of the disc of places of a piece [probe radii], as far as its presses are solved.
const PIECE_REACH_RADII: f64 = 1.15;

/// Tissue that a law is fitted to.
pub(super) struct Whole {
    placed: Placed,
    /// The piece that is the law's rest shape; none for a block, which may be thinner than a piece.
    piece: Option<Tissue>,
}

impl Whole {
    fn of(scene: &Scene) -> Result<Self, TissueError> {
        if scene.tissue.block_m.is_some() {
            return Ok(Self { placed: place(scene, &[])?, piece: None });
        }
        let radius_m = scene.probe.radius_m;
        let recipe = Recipe::new(PIECE_RADII * radius_m, ELEMENT_RADII * radius_m, radius_m);
        Ok(Self::prepared(scene, Prepared::of(scene, &recipe)?))
    }

    pub(super) fn prepared(scene: &Scene, prepared: Prepared) -> Self {
        let piece = scene.tissue.block_m.is_none().then_some(prepared.far.cut.patch);
        Self { placed: prepared.placed, piece }
    }
}

/// A fitted law and its errors.
pub(super) struct LawFit {
    pub(super) session: Session,
    pub(super) verdict: Verdict,
    /// Errors along the stored motions; none if no motion of the tissue is stored.
    pub(super) motions: Vec<MotionError>,
    /// Estimated error of the finite elements (1).
    reference_error: f64,
    fitted_m: Vec<f64>,
    answer: Answer,
}

#[derive(Serialize)]
struct Summary<'a> {
    scene: &'a str,
    quick: bool,
    constants: usize,
    tolerance_pct: f64,
    reference_error_pct: f64,
    fitted_depths_m: &'a [f64],
    calibrated: &'a Verdict,
    motions: &'a [MotionError],
    record: &'a FitRecord,
}

impl LawFit {
    /// Fits and judges the law of a scene whose stored answer or solved presses are `presses`.
    pub(super) fn of_piece(
        scene: &Scene,
        machine: &CostModel,
        whole: &Whole,
        presses: &PiecePresses,
    ) -> Result<Self, TissueError> {
        let deepest_m = presses.fitted_m.last().copied().unwrap_or_default();
        let placed = &whole.placed;
        let block = || block_shape(scene.tissue.block_m.unwrap_or_default(), placed.tissue.site_m, deepest_m);
        let rest = whole.piece.clone().unwrap_or_else(block);
        let known = presses.known.reference();
        let depths_m = [presses.fitted_m.first().copied().unwrap_or_default(), deepest_m];
        let law = LawPresses { known, depths_m, reach_radii: PIECE_REACH_RADII };
        let (patch, params) = fit(scene, &rest, placed.axis, &law)?;
        let mut unseen = presses.unseen.clone();
        unseen.holds.iter_mut().for_each(|hold| hold.surface = None);
        unseen.glued.clear();
        let judging = Judging {
            known,
            fitted_m: &presses.fitted_m,
            unseen: &unseen,
            disc_radii: PIECE_JUDGED_RADII,
            places: PLACES,
            reference_error: presses.error,
        };
        let session = Session::of_fitted(machine, patch, params)?;
        Self::judged(scene, session, &judging, presses.answer.clone())
    }

    /// Fits and judges the law of the preset block from its stored answer; `None` for another
    /// scene.
    fn of_stored(scene: &Scene, machine: &CostModel) -> Result<Option<Self>, TissueError> {
        let (Some((known, unseen, fitted_m)), Some(size_m)) = (stored(scene), scene.tissue.block_m) else { return Ok(None) };
        let all = Answer::block();
        let (Some(known), Some(between)) = (BlockForces::of(&known), BlockForces::of(&all)) else { return Ok(None) };
        let deepest_m = known.deepest_m();
        let rest = block_shape(size_m, [0.0; 3], deepest_m);
        let law = LawPresses { known: &known, depths_m: [fitted_m[0], deepest_m], reach_radii: STORED_RADII };
        let (patch, params) = fit(scene, &rest, [0.0, 0.0, 1.0], &law)?;
        let judging = Judging {
            known: &between,
            fitted_m: &fitted_m,
            unseen: &unseen,
            disc_radii: JUDGED_RADII,
            places: PLACES,
            reference_error: STORED_ERROR,
        };
        let session = Session::of_fitted(machine, patch, params)?;
        Self::judged(scene, session, &judging, all.clone()).map(Some)
    }

    fn judged(scene: &Scene, session: Session, judging: &Judging, answer: Answer) -> Result<Self, TissueError> {
        let mut verdict = judging.judge(&session)?;
        verdict.surfaces.clear(); // a law has none
        let motions = motions::errors(scene, &session.patch, &session.params)?;
        let fitted_m = judging.fitted_m.to_vec();
        Ok(Self { session, verdict, motions, reference_error: judging.reference_error, fitted_m, answer })
    }

    /// Largest error along a motion that the fit did not see.
    pub(super) fn worst_motion(&self) -> Option<&MotionError> {
        self.motions.iter().filter(|motion| !motion.fitted).max_by(|a, b| a.rms_pct.total_cmp(&b.rms_pct))
    }

    /// Number of constants of the law.
    pub(super) fn constants(&self) -> usize {
        self.session.patch.model().law.map_or(0, |law| {
            let table = if law.table.len() == 1 { palpate::LAW_FIELDS - 1 } else { law.table.len() * palpate::LAW_FIELDS };
            table + law.shape.branches.iter().filter(|branch| branch.c > 0.0).count() * 2
        })
    }

    /// Name, bytes and record of the patch file.
    pub(super) fn file(&self, scene: &Scene, name: String) -> Result<(Vec<u8>, Written), Error> {
        let session = &self.session;
        let bytes = session.patch.pack(&session.params, session.stable.pressed_s as f32);
        let mut record = record(scene, session, &self.verdict, &self.fitted_m, &bytes)?;
        record.reference_error_pct = Some(100.0 * self.reference_error);
        record.moving = self.worst_motion().map(|motion| Moving {
            speed_m_per_s: self.fastest_m_per_s(),
            rms_pct: motion.rms_pct,
            motion: Some(motion.name.clone()),
        });
        Ok((bytes, Written { name, record, model: format!("a law of {} constants", self.constants()), load: None }))
    }

    fn fastest_m_per_s(&self) -> f64 {
        let speed = |motion: &MotionError| f64::from(motion.mm_per_s) * 1e-3;
        self.motions.iter().map(speed).fold(0.0, f64::max)
    }
}

/// Relative error of the stored answer of the preset block (1).
const STORED_ERROR: f64 = 0.003;

impl FitArgs {
    pub(super) fn fit_law(&self, scene: &Scene, machine: Option<&'static CostModel>) -> Result<Fitted, Error> {
        let machine = machine.unwrap_or(&MACHINES[0]);
        let path = self.common.folder("fit");
        let folder = self.common.open("fit", scene)?;
        let fitted = match LawFit::of_stored(scene, machine)? {
            Some(fitted) => fitted,
            None => {
                let whole = told("meshing the whole", || Whole::of(scene))?;
                let kept = Solved::beside(&path);
                let level = if self.options.quick { Level::Quick } else { Level::Full };
                let steps = Progress::new(0, "finite elements");
                let presses = PiecePresses::of(scene, &whole.placed, (level, machine.is_board()), &kept, |done, all| {
                    steps.show(done, all, "presses of the whole");
                })?;
                steps.finish();
                kept.said().iter().for_each(|line| println!("{line}"));
                LawFit::of_piece(scene, machine, &whole, &presses)?
            }
        };
        let written = fitted.write(folder, scene, &self.options, format!("{}-law.patch", scene.name))?;
        Ok(self.judged((written, Vec::new()), &fitted.verdict))
    }
}

impl LawFit {
    /// Writes all files, publishes them, and prints the errors.
    pub(super) fn write(
        &self,
        folder: OutputFolder,
        scene: &Scene,
        options: &FitOptions,
        name: String,
    ) -> Result<Written, Error> {
        let (bytes, mut written) = self.file(scene, name)?;
        written.record.quick = options.quick;
        folder.write(&written.name, &bytes)?;
        written.record.write(&folder, &written.name)?;
        self.answer.save(&folder, "answer.json")?;
        folder.write_csv(
            "accuracy.csv",
            ["depth_mm", "fitted_depth", "centred_pct", "disc_rms_pct", "disc_worst_pct"],
            self.verdict
                .depths
                .iter()
                .map(|d| [d.depth_mm, f64::from(u8::from(d.fitted_depth)), d.centred_pct, d.rms_pct, d.worst_pct]),
        )?;
        folder.write_summary(&Summary {
            scene: &scene.name,
            quick: options.quick,
            constants: self.constants(),
            tolerance_pct: options.tolerance_pct,
            reference_error_pct: 100.0 * self.reference_error,
            fitted_depths_m: &self.fitted_m,
            calibrated: &self.verdict,
            motions: &self.motions,
            record: &written.record,
        })?;
        let file = folder.publish()?.join(&written.name);
        self.print();
        println!(
            "\nwrote {} ({} bytes): its record beside it, summary.json, accuracy.csv, answer.json",
            file.display(),
            bytes.len()
        );
        println!("press it with patch = \"{}\" under [solver] of the scene", file.display());
        Ok(written)
    }

    /// The reason why a law is enough for a tolerance [%], or why it is not.
    pub(super) fn reason(&self, scene: &Scene, tolerance_pct: f64) -> Result<String, String> {
        let (constants, keeps_pct) = (self.constants(), self.verdict.keeps_pct());
        let moved = self.worst_motion().map_or_else(String::new, |motion| {
            format!(", and {:.1} % in the worst motion that it did not see ({})", motion.rms_pct, motion.name)
        });
        let held = format!("a law of {constants} constants holds {keeps_pct:.1} % here{moved}");
        let allowed_pct = scene.solver.moving_error_pct.unwrap_or(f64::INFINITY);
        let moves = self.worst_motion().is_none_or(|motion| motion.rms_pct <= allowed_pct);
        if keeps_pct <= tolerance_pct && moves && !self.verdict.lost_too_many() {
            let patch = "friction, a contact map, the dent, another tip or a nodule that moves";
            return Ok(format!("{held}, so that no node is needed; a patch is needed for {patch}"));
        }
        Err(format!("{held}, where {tolerance_pct} % is asked for, so that nodes are needed"))
    }

    fn print(&self) {
        println!("law of {} constants, force error against finite elements; * depths unknown to the fit", self.constants());
        println!("{:>10} {:>10} {:>11} {:>9}", "depth mm", "centred %", "disc rms %", "worst %");
        for d in &self.verdict.depths {
            let unseen = if d.fitted_depth { ' ' } else { '*' };
            println!("{:>9.3}{unseen} {:>+10.2} {:>11.2} {:>+9.2}", d.depth_mm, d.centred_pct, d.rms_pct, d.worst_pct);
        }
        let v = &self.verdict;
        println!(
            "{} presses solved at unseen places and depths: {:.2} % rms, worst {:+.2} %",
            v.unseen_presses, v.unseen_rms_pct, v.unseen_worst_pct
        );
        println!(
            "{} random places within {:.1} mm at all depths: {:.2} % rms, worst {:+.2} %; the finite elements themselves within {:.2} %",
            v.disc_places,
            v.disc_radius_m * 1e3,
            v.disc_rms_pct,
            v.disc_worst_pct,
            100.0 * self.reference_error
        );
        if self.motions.is_empty() {
            println!(
                "moving: no motion of this tissue is stored; the branches are those of the preset block, scaled with the radius"
            );
        } else {
            println!("moving, % rms of the peak; * unknown to the fit");
            for motion in &self.motions {
                println!("{:>24}{} {:>6.2}", motion.name, if motion.fitted { ' ' } else { '*' }, motion.rms_pct);
            }
        }
    }
}
