//! The solved presses of a scene as an answer, with its accuracy.

use super::discs::GluedDiscs;
use super::piece::tissue_of;
use super::presses::{PressJob, Presses};
use super::solve::Forces;
use crate::reference::extrapolate::extrapolate;
use palpate_tissue::answer::{Answer, AnswerProbe, GluedAnswer, HoldAnswer};
use palpate_tissue::error::Error;
use palpate_tissue::scene::Scene;

/// Presses as two answers, one for the fit and one for the evaluation.
#[derive(Clone, Debug, PartialEq)]
pub struct Solved {
    /// Presses for the fit: the fitted depths at the centre, and those at places around it.
    pub known: Answer,
    /// Presses for the evaluation alone: other depths at the centre, and presses at other places.
    pub unseen: Answer,
    /// Estimated relative error of the force at the centre (1), the largest over all depths: the
    /// larger of the finer mesh's differences from the coarser one and from their extrapolated
    /// limit.
    pub error: f64,
    /// Number of nodes of the finest quadratic mesh.
    pub nodes: usize,
}

/// Combines presses and glued discs into answers; `found` returns the result of a job.
///
/// # Errors
/// Fails if a press is missing.
pub fn answer(
    scene: &Scene,
    presses: &Presses,
    discs: GluedDiscs,
    found: impl Fn(&PressJob) -> Option<Forces>,
) -> Result<Solved, Error> {
    let of = |job: &PressJob| found(job).ok_or_else(|| Error::Check(format!("{}: a press is missing: run it again", scene.file)));
    let (mut error, mut nodes) = (0.0_f64, 0);
    let mut centred: Vec<HoldAnswer> = Vec::new();
    for pair in presses.centre.chunks_exact(2) {
        let [coarse, fine] = [of(&pair[0])?, of(&pair[1])?];
        nodes = nodes.max(fine.nodes);
        let mut surfaces = fine.surfaces.into_iter();
        for (n, depth_m) in pair[1].depths_m.iter().enumerate() {
            let (before, finest) = (coarse.force_over_e_m2[n], fine.force_over_e_m2[n]);
            let estimate = extrapolate(&[(coarse.nodes, before), (fine.nodes, finest)]);
            error = estimate.map_or(error, |e| error.max(e.error / finest));
            let surface = if pair[1].surfaces_m.contains(depth_m) { surfaces.next() } else { None };
            let force_over_e_m2 = estimate.map_or(finest, |e| e.limit);
            centred.push(HoldAnswer { place_m: [0.0; 3], depth_m: *depth_m, force_over_e_m2, surface });
        }
    }
    let again = of(&presses.again)?;
    let ratio = |depth_m: f64| {
        let at = presses.again.depths_m.iter().position(|d| *d == depth_m)?;
        let fine = centred.iter().find(|h| h.depth_m == depth_m)?;
        Some(fine.force_over_e_m2 / again.force_over_e_m2[at])
    };
    let aside = |jobs: &[PressJob]| -> Result<Vec<HoldAnswer>, Error> {
        let mut holds = Vec::new();
        for job in jobs {
            for (depth_m, force) in job.depths_m.iter().zip(of(job)?.force_over_e_m2) {
                let Some(ratio) = ratio(*depth_m) else { continue };
                let place_m = [job.place_m[0], job.place_m[1], 0.0];
                holds.push(HoldAnswer { place_m, depth_m: *depth_m, force_over_e_m2: force * ratio, surface: None });
            }
        }
        Ok(holds)
    };
    let (known_aside, unseen_aside) = (aside(&presses.aside)?, aside(&presses.unseen)?);
    let (known, unseen): (Vec<_>, Vec<_>) = centred.into_iter().partition(|h| presses.fitted_m.contains(&h.depth_m));
    Ok(Solved {
        known: of_holds(scene, known.into_iter().chain(known_aside), discs.known),
        unseen: of_holds(scene, unseen.into_iter().chain(unseen_aside), discs.unseen),
        error,
        nodes,
    })
}

fn of_holds(scene: &Scene, holds: impl Iterator<Item = HoldAnswer>, glued: Vec<GluedAnswer>) -> Answer {
    let tissue = tissue_of(scene);
    let probe = AnswerProbe { shape: scene.probe.shape, radius_m: scene.probe.radius_m };
    Answer { tissue, probe, holds: holds.collect(), glued }
}
