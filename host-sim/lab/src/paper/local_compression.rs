//! Paper 004: soft tissue under local compression. A finger presses an abdomen and a foot with
//! layers. Reproduces Figs. 5 to 9.
//!
//! The paper's tomography is not public, and its finite elements are those of another paper. The
//! organs here are therefore our own shapes, and the reference is our own finite elements. Table 1
//! and (14) are checked by a test (`lab/src/score.rs`).

pub mod checkpoint;
mod figures;
mod find_depth;
pub mod fit;
pub mod hausdorff;
pub mod methods;
mod progress;
mod report;
pub mod rest;
pub mod scene;
pub mod schedule;
pub mod site;
mod study;
pub mod sweep;
pub mod truth;

use std::path::Path;

use crate::error::Error;
use crate::paper::Progress;
use palpate_tissue::output::OutputFolder;
use palpate_tissue::scene::SceneError;
use progress::AnnealingProgress;
use scene::{PRESETS, PressScene};
use site::Site;
use study::{Size, on_block, on_organ};

/// Options of a run.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Computes few forces, few trials and coarser organs, in less than a minute.
    pub quick: bool,
    /// Name of a preset; `None` runs both presets.
    pub scene: Option<String>,
    /// Origin of the report, which its summary states.
    pub provenance: serde_json::Value,
}

/// Regenerates the figures and writes the report into the folder `out`, which is made once the
/// organs are meshed.
pub fn run(options: &Options, out: &Path, progress: &dyn Progress) -> Result<(), Error> {
    let size = if options.quick { Size::quick() } else { Size::full() };
    let wanted = |(name, _): &&(&str, &str)| options.scene.as_deref().is_none_or(|only| only == *name);
    let scenes = PRESETS.iter().filter(wanted).map(|(name, text)| PressScene::parse(name, text));
    let scenes = scenes.collect::<Result<Vec<_>, SceneError>>()?;
    let sites = scenes.iter().map(|scene| Site::of(scene, size.coarser)).collect::<Result<Vec<_>, Error>>()?;
    let folder = OutputFolder::open(out)?.made_by(options.provenance.clone());
    let trials = 2 * size.trials[0] + scenes.len() * size.trials[1];
    let annealing = AnnealingProgress::new(progress, trials);
    let block = on_block(&folder, &size, &annealing)?;
    let mut organs = Vec::new();
    for (scene, site) in scenes.into_iter().zip(sites) {
        organs.push(on_organ(&folder, scene, site, &size, &annealing)?);
    }
    progress.clear();

    let mut findings = report::findings(&folder, options.quick, &block, &organs)?;
    findings.fact("paper", "local-compression");
    findings.fact("quick", options.quick);
    findings.report(folder, true)
}
