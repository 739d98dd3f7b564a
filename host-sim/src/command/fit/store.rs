//! Stages that earlier runs into the same folder have finished: each press, and each fit.
//!
//! Until the result is published, a finished stage is a note beside the folder; afterwards it is in
//! the result. It is reused if all of its inputs are the same.

use std::fmt::Write;
use std::path::Path;

use palpate_fit::calibrate::Round;
use palpate_fit::scene_fit::{Forces, PressJob};
use palpate_fit::solved::checksum;
use palpate_tissue::answer::AnswerProbe;
use palpate_tissue::error::Error;
use palpate_tissue::output::OutputFolder;
use palpate_tissue::scene::Scene;
use serde::{Deserialize, Serialize};

/// Version of the stages: it rises when a stage computes another result from the same input.
const FORM: u32 = 6;
/// File of the stages in a result.
const STAGES: &str = "stages.json";

/// The tissue that is pressed, and the tip.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Pressed {
    form: u32,
    block_m: Option<[f64; 3]>,
    poisson_ratio: f64,
    probe: AnswerProbe,
}

/// A finished press.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct StoredPress {
    pressed: Pressed,
    job: PressJob,
    forces: Forces,
}

/// A finished fit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct StoredFit {
    /// Checksum of all inputs of the fit.
    problem: u64,
    /// Patch file as hexadecimal digits.
    patch: String,
    pub rounds: Vec<Round>,
    /// Presses that did not count in the last round, because the patch has no equilibrium there.
    pub lost_presses: usize,
}

impl StoredFit {
    pub(super) fn new(problem: &str, patch: &[u8], rounds: Vec<Round>, lost_presses: usize) -> Self {
        let mut digits = String::with_capacity(2 * patch.len());
        for byte in patch {
            let _infallible = write!(digits, "{byte:02x}");
        }
        Self { problem: checksum(problem), patch: digits, rounds, lost_presses }
    }

    /// This fit with the presses that an earlier one, which it begins with, left out as well.
    pub(super) fn after(self, earlier: &Self) -> Self {
        Self { lost_presses: self.lost_presses + earlier.lost_presses, ..self }
    }

    /// Checksum of all inputs of the fit.
    pub(super) fn problem(&self) -> u64 {
        self.problem
    }

    /// Says how many presses the last round left out.
    pub(super) fn print_lost(&self) {
        if self.lost_presses > 0 {
            println!("presses left out of the last round, where the patch has no static equilibrium: {}", self.lost_presses);
        }
    }

    /// Bytes of the patch file; cut short at the first damaged digit.
    pub(super) fn patch(&self) -> Vec<u8> {
        let pair = |n: usize| self.patch.get(n..n + 2).and_then(|pair| u8::from_str_radix(pair, 16).ok());
        (0..self.patch.len()).step_by(2).map_while(pair).collect()
    }
}

/// All stages of a result.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct Stages {
    presses: Vec<StoredPress>,
    /// Fits of the block, and of the force that its inclusions add.
    #[serde(default)]
    fits: Vec<StoredFit>,
}

/// Store of the finished stages of a scene.
pub(super) struct Store<'a> {
    folder: &'a OutputFolder,
    pressed: Pressed,
    stages: Stages,
}

impl<'a> Store<'a> {
    /// Reads the stored stages; an unreadable file is ignored.
    pub(super) fn of(path: &Path, folder: &'a OutputFolder, scene: &Scene) -> Self {
        let pressed = Pressed {
            form: FORM,
            block_m: scene.tissue.block_m,
            poisson_ratio: scene.tissue.poisson_ratio,
            probe: AnswerProbe { shape: scene.probe.shape, radius_m: scene.probe.radius_m },
        };
        let published = std::fs::read_to_string(path.join(STAGES)).ok();
        let mut stages: Stages = published.and_then(|text| serde_json::from_str(&text).ok()).unwrap_or_default();
        stages.presses.retain(|press| press.pressed == pressed);
        Self { folder, pressed, stages }
    }

    /// The tissue that is pressed, and the tip.
    pub(super) fn pressed(&self) -> &Pressed {
        &self.pressed
    }

    /// Forces of a press, if an earlier run has solved it.
    pub(super) fn press(&self, job: &PressJob) -> Option<Forces> {
        let stored = self.stages.presses.iter().find(|press| press.job == *job);
        if let Some(stored) = stored {
            return Some(stored.forces.clone());
        }
        let note: StoredPress = serde_json::from_str(&self.folder.read_note(&name(job))?).ok()?;
        (note.pressed == self.pressed && note.job == *job).then_some(note.forces)
    }

    /// Stores a press.
    pub(super) fn keep_press(&self, job: &PressJob, forces: &Forces) -> Result<(), Error> {
        let stored = StoredPress { pressed: self.pressed.clone(), job: job.clone(), forces: forces.clone() };
        self.folder.write_note(&name(job), &stored)
    }

    /// The stored fit, if it belongs to the same problem.
    pub(super) fn fit(&self, problem: &str) -> Option<StoredFit> {
        let problem = checksum(problem);
        let noted = || serde_json::from_str(&self.folder.read_note(&fit_name(problem))?).ok();
        self.stages.fits.iter().cloned().chain(noted()).find(|fit: &StoredFit| fit.problem == problem)
    }

    /// Stores a fit.
    pub(super) fn keep_fit(&self, fit: &StoredFit) -> Result<(), Error> {
        self.folder.write_note(&fit_name(fit.problem), fit)
    }

    /// Writes all stages into the result.
    pub(super) fn write<'j>(&self, jobs: impl Iterator<Item = &'j PressJob>, fits: &[&StoredFit]) -> Result<(), Error> {
        let stored =
            |job: &PressJob| Some(StoredPress { pressed: self.pressed.clone(), job: job.clone(), forces: self.press(job)? });
        let stages = Stages { presses: jobs.filter_map(stored).collect(), fits: fits.iter().map(|fit| (*fit).clone()).collect() };
        let text = serde_json::to_string(&stages).map_err(|e| Error::Write { path: STAGES.into(), source: e.into() })?;
        self.folder.write(STAGES, text.as_bytes())
    }
}

fn fit_name(problem: u64) -> String {
    format!("fit-{problem:016x}.json")
}

/// File name of the note for a press: one for each mesh, place and depth.
fn name(job: &PressJob) -> String {
    let [x, y] = job.place_m.map(|x| (x * 1e7).round());
    let deepest = job.depths_m.last().map_or(0.0, |d| (d * 1e7).round());
    format!("press-{}-{x}-{y}-{deepest}-{}.json", job.nodes, if job.whole { "whole" } else { "piece" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_press_is_found_again_whatever_its_numbers() {
        for n in 1..2000_u32 {
            let m = f64::from(n) * 1e-7 / 3.0;
            let job =
                PressJob { place_m: [m, -m], depths_m: vec![m], surfaces_m: vec![], nodes: 1, fine_radius_m: m, whole: true };
            let again: PressJob = serde_json::from_str(&serde_json::to_string(&job).unwrap()).unwrap();
            assert!(again == job, "{job:?} {again:?}");
        }
    }
}
