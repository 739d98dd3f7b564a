//! Scenes that differ from the plain block in one thing each, and every method on each of them:
//! what a scene needs at least.
//!
//! The references are stored: finite elements of held presses and of motions, Coulomb's law, and
//! the relaxation of beef. A method keeps the parameters that it has on the chart, and the
//! product's law those of the plain block, so that the suite shows where a law of one site and one
//! tip ends.

mod measure;
mod scenes;

use serde::{Deserialize, Serialize};

use crate::chart::{Survival, least_substeps, term_errors, tick_time};
use crate::error::Error;
use crate::methods::{Block, Method};
use measure::{held_pct, moving_pct};
pub use scenes::{SCENES, SuiteScene};

/// Result of a method on a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SuiteRow {
    /// Name of the scene.
    pub scene: String,
    /// Name of the method.
    pub method: String,
    /// Number of nodes; 0 for a law.
    pub nodes: usize,
    /// CPU time of a tick on the plain block [us].
    pub tick_us: f64,
    /// Root mean square force error of held presses [%]; `None` without a reference, or if the
    /// method diverges.
    pub held_pct: Option<f64>,
    /// Root mean square force error of motions [% of the peak]; `None` as above.
    pub moving_pct: Option<f64>,
}

impl SuiteRow {
    /// The larger error [%]; `None` if one that the scene has was not measured.
    #[must_use]
    pub fn worst_pct(&self) -> Option<f64> {
        let scene = SCENES.iter().find(|scene| scene.name == self.scene)?;
        let held = if scene.is_held() { self.held_pct? } else { 0.0 };
        let moving = if scene.motions.is_empty() { 0.0 } else { self.moving_pct? };
        Some(held.max(moving))
    }
}

/// Runs a method with a mesh of this many nodes on all scenes; empty if it is not available or
/// survives no press.
///
/// # Errors
/// A method cannot be built, or a stored reference cannot be read.
pub fn run(method: Method, nodes: usize) -> Result<Vec<SuiteRow>, Error> {
    let plain = |pa: f64| match method {
        Method::Calibrated => Ok(Block::calibrated(nodes, pa)),
        _ => Block::standard(nodes, pa).map(Some),
    };
    let Some(block) = plain(scenes::SOFT_PA)? else { return Ok(Vec::new()) };
    let Some(Ok(Survival { substeps, .. })) = least_substeps(method, &block)? else { return Ok(Vec::new()) };
    let Some(Ok(time)) = tick_time(method, &block, substeps)? else { return Ok(Vec::new()) };
    let terms = match plain(scenes::STIFF_PA)? {
        Some(block) => term_errors(method, &block)?,
        None => None,
    };
    let mut rows = Vec::new();
    for scene in &SCENES {
        let own = scene.changed(block.clone());
        let (held_pct, moving_pct) = match scene.term {
            Some(term) => (terms.as_ref().and_then(term), None),
            None => (held_pct(scene, method, &own, substeps)?, moving_pct(scene, method, &own, substeps)?),
        };
        rows.push(SuiteRow {
            scene: scene.name.into(),
            method: method.name().into(),
            nodes: if method == Method::Law { 0 } else { nodes },
            tick_us: time.min_us,
            held_pct,
            moving_pct,
        });
    }
    Ok(rows)
}

/// The cheapest method within an error [%] on a scene.
#[must_use]
pub fn cheapest<'r>(rows: &'r [SuiteRow], scene: &str, most_pct: f64) -> Option<&'r SuiteRow> {
    let within = rows.iter().filter(|row| row.scene == scene && row.worst_pct().is_some_and(|pct| pct <= most_pct));
    within.min_by(|a, b| a.tick_us.total_cmp(&b.tick_us))
}
