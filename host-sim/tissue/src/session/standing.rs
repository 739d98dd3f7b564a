//! Judges how far the force of a scene's patch can be trusted: the conditions of its fit, the
//! scene's differences from them, and the expected error.

use serde::Serialize;

use super::calibrated;
use crate::fit_record::FitRecord;
use crate::patch::Patch;
use crate::scene::{Drive, NO_PATCH, Scene};
use crate::tissue::DEFAULT_NODES;
use crate::trials::{Expected, expected};

/// Relative difference below which depths and lengths count as equal (1).
const SAME: f64 = 1e-6;

/// Evidence for the force of a patch in a scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "standing", rename_all = "kebab-case")]
pub enum Standing {
    /// The patch was fitted to this scene, with measured errors.
    Calibrated {
        /// Record of the fit, with the measured error.
        record: FitRecord,
    },
    /// The patch was fitted to another scene.
    CalibratedForAnother {
        /// Differences between the scene and the fit, in words.
        differs: Vec<String>,
        /// Record of the fit.
        record: FitRecord,
        /// Error of the trial that is most like the scene; `None` if no trial is like it.
        expected: Option<Expected>,
    },
    /// The patch was fitted under unknown conditions: its file has no record.
    Unrecorded {
        /// Number of places at which it was fitted.
        fitted_places: u32,
    },
    /// The constants come from formulas alone.
    Uncalibrated {
        /// Error of the trial that is most like the scene; `None` if no trial is like it.
        expected: Option<Expected>,
    },
}

impl Standing {
    /// Judges the patch of a scene.
    #[must_use]
    pub fn of(scene: &Scene, patch: &Patch) -> Self {
        let fitted_places = patch.fitted_places();
        let file = scene.solver.patch.as_deref().filter(|path| path.as_os_str() != NO_PATCH);
        let record = match file {
            Some(file) => FitRecord::of_file(file),
            None if fitted_places == 0 => None,
            None => calibrated::record(scene.tissue.nodes.unwrap_or(DEFAULT_NODES)),
        };
        match record {
            Some(record) => {
                let differs = differs(scene, patch, &record);
                if differs.is_empty() {
                    return Self::Calibrated { record };
                }
                let expected = expected(scene, patch.model().nodes.len(), Some(&record));
                Self::CalibratedForAnother { differs, record, expected }
            }
            None if fitted_places > 0 => Self::Unrecorded { fitted_places },
            None => Self::Uncalibrated { expected: expected(scene, patch.model().nodes.len(), None) },
        }
    }

    /// A sentence or two that say how the patch of this scene was fitted.
    #[must_use]
    pub fn sentence(&self, scene: &Scene) -> String {
        let advice = match scene.tissue.most_stiffening_b() > 0.0 {
            true => "palpate fit calibrates the tissue without stiffening_b, which serves any",
            false => "palpate fit calibrates this scene",
        };
        match self {
            Self::Calibrated { record } => {
                format!(
                    "calibrated to finite elements over {} places of this scene: {}",
                    record.fitted_places,
                    record.judged.sentence()
                )
            }
            Self::CalibratedForAnother { differs, expected, .. } => {
                format!("{}: {}; {advice}", differs.join(", "), expectation(expected.as_ref()))
            }
            Self::Unrecorded { fitted_places } => {
                format!(
                    "fitted over {fitted_places} places, but its record (.patch.json) is not beside it: to which scene and how wrong is unknown"
                )
            }
            Self::Uncalibrated { expected } => {
                format!("uncalibrated, constants from formulas alone: {}; {advice}", expectation(expected.as_ref()))
            }
        }
    }
}

impl Standing {
    /// The expected error, in a few words.
    #[must_use]
    pub fn short(&self) -> String {
        match self {
            Self::Calibrated { record } => {
                format!("calibrated, {:.1} % rms off finite elements where the fit did not look", record.judged.rms_pct)
            }
            Self::CalibratedForAnother { expected: Some(e), .. } | Self::Uncalibrated { expected: Some(e) } => {
                let about = if e.alike { "about" } else { "perhaps" };
                format!(
                    "not calibrated for this scene, {about} {:.0} % rms off and {:+.0} % at worst",
                    e.rms_pct.ceil(),
                    e.worst_pct
                )
            }
            Self::CalibratedForAnother { expected: None, .. } | Self::Uncalibrated { expected: None } => {
                "not calibrated for this scene, how far off is unknown".into()
            }
            Self::Unrecorded { .. } => "calibrated for a scene that is not recorded, how far off is unknown".into(),
        }
    }
}

fn expectation(expected: Option<&Expected>) -> String {
    match expected {
        None => "how wrong is unknown, no trial is like it".into(),
        Some(e) => {
            let about = if e.alike { "expect about" } else { "no trial is much like it; the nearest was" };
            format!(
                "{about} {:.0} % rms off finite elements, up to {:+.0} % (measured on trial {}, the scene most like it in host-sim/scenes/trials)",
                e.rms_pct.ceil(),
                e.worst_pct,
                e.trial
            )
        }
    }
}

/// Differences between a scene and the conditions of its patch's fit, the tip first.
fn differs(scene: &Scene, patch: &Patch, record: &FitRecord) -> Vec<String> {
    let (tissue, probe) = (&scene.tissue, &scene.probe);
    let mut differs = Vec::new();
    let tip = probe.tip();
    if tip != record.probe {
        differs.push(format!("calibrated for another tip ({})", record.probe));
    }
    if tissue.poisson_ratio != record.tissue.poisson_ratio {
        differs.push(format!("calibrated for another Poisson's ratio ({})", record.tissue.poisson_ratio));
    }
    if tissue.block_m.is_some() && tissue.block_m != record.tissue.block_m {
        differs.push("calibrated for another block".into());
    }
    // a piece of an organ contains the inclusions that it was cut with, and a scene may not add any
    if patch.model().rim_nodes.is_empty() && tissue.elastic_inclusions() != record.tissue.inclusion {
        let what = if record.tissue.inclusion.is_empty() { "without its inclusions" } else { "with other inclusions" };
        differs.push(format!("calibrated {what}"));
    }
    if tissue.most_stiffening_b() != record.tissue.stiffening_b {
        differs.push("calibrated for tissue that does not stiffen".into());
    }
    if probe.friction > 0.0 {
        differs.push("calibrated without friction".into());
    }
    let [x, y] = probe.position_m.unwrap_or_default();
    if x.hypot(y) > record.judged.disc_radius_m * (1.0 + SAME) {
        differs.push(format!("judged within {:.1} mm of the centre only", record.judged.disc_radius_m * 1e3));
    }
    if let Drive::Depth { holds_m, .. } | Drive::Hand { holds_m, .. } = &scene.drive {
        let deepest_m = holds_m.iter().copied().fold(0.0, f64::max);
        if deepest_m > record.judged.to_m * (1.0 + SAME) {
            differs.push(format!("judged to {:.2} mm deep only", record.judged.to_m * 1e3));
        }
    }
    differs
}
