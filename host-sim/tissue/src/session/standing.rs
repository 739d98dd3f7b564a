//! Judges how far the force of a scene's patch can be trusted: the conditions of its fit, the
//! scene's differences from them, and the expected error.

use serde::Serialize;

use palpate::Vector3;

use super::{Session, calibrated};
use crate::fit_record::FitRecord;
use crate::scene::{Drive, NO_PATCH, Scene};
use crate::trials::{Expected, expected};

/// Relative difference below which depths and lengths count as equal (1).
const SAME: f64 = 1e-6;

/// Largest force error of the shipped patches in tissue that stiffens [%], rms at the centre and
/// beside it, by number of nodes and largest exponent (`stiffening_agrees`).
const STIFFENED: [(usize, f64, f64); 6] =
    [(130, 0.3, 3.0), (130, 3.0, 4.5), (130, 10.0, 10.0), (130, 20.0, 16.0), (410, 20.0, 3.0), (1020, 20.0, 3.0)];
/// Largest error of a drag of the shipped patches [% of mu N], by number of nodes
/// (`partial_slip_is_near_cattaneo_and_mindlin`).
const DRAGGED: [(usize, f64); 3] = [(130, 15.0), (410, 7.0), (1020, 6.0)];

/// Evidence for the force of a patch in a scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "standing", rename_all = "kebab-case")]
pub enum Standing {
    /// The patch was fitted to this scene, with measured errors.
    Calibrated {
        /// Terms of the scene that no fit has, with what is known of their errors, in words.
        beside: Vec<String>,
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
    pub fn of(scene: &Scene, session: &Session) -> Self {
        let patch = &session.patch;
        let (nodes, fitted_places) = (patch.model().nodes.len(), patch.fitted_places());
        let file = scene.solver.patch.as_deref().filter(|path| path.as_os_str() != NO_PATCH);
        let record = match file {
            Some(file) => FitRecord::of_file(file),
            None if fitted_places == 0 => None,
            None => calibrated::record(nodes),
        };
        match record {
            Some(record) => {
                let differs = differs(scene, session, &record);
                if differs.is_empty() {
                    return Self::Calibrated { beside: beside(scene, &record, file.is_none()), record };
                }
                let expected = expected(scene, nodes, Some(&record));
                Self::CalibratedForAnother { differs, record, expected }
            }
            None if fitted_places > 0 => Self::Unrecorded { fitted_places },
            None => Self::Uncalibrated { expected: expected(scene, nodes, None) },
        }
    }

    /// A sentence or two that say how the patch of this scene was fitted.
    #[must_use]
    pub fn sentence(&self, scene: &Scene) -> String {
        let advice = match scene.tissue.most_stiffening_b() > 0.0 {
            true => "palpate fit calibrates the tissue without stiffening_b, which serves any",
            false => "palpate fit calibrates this scene",
        };
        let sentence = match self {
            Self::Calibrated { record, beside } => {
                let beside: String = beside.iter().map(|words| format!("; {words}")).collect();
                format!(
                    "calibrated to finite elements over {} places of this scene: {}{beside}",
                    record.fitted_places,
                    record.judged.sentence()
                )
            }
            Self::CalibratedForAnother { differs, expected: Some(expected), .. } => {
                format!("{}: {}; {advice}", differs.join(", "), expectation(Some(expected)))
            }
            Self::CalibratedForAnother { differs, expected: None, record } => {
                format!("{}: {}; beyond that how wrong is unknown; {advice}", differs.join(", "), record.judged.sentence())
            }
            Self::Unrecorded { fitted_places } => {
                format!(
                    "fitted over {fitted_places} places, but its record (.patch.json) is not beside it: to which scene and how wrong is unknown"
                )
            }
            Self::Uncalibrated { expected } => {
                format!("uncalibrated, constants from formulas alone: {}; {advice}", expectation(expected.as_ref()))
            }
        };
        sentence + self.quickly()
    }

    /// Remark on a fit that was made with `--quick`.
    fn quickly(&self) -> &'static str {
        match self {
            Self::Calibrated { record, .. } | Self::CalibratedForAnother { record, .. } => record.quickly(),
            Self::Unrecorded { .. } | Self::Uncalibrated { .. } => "",
        }
    }
}

impl Standing {
    /// The expected error, in a few words.
    #[must_use]
    pub fn short(&self) -> String {
        let short = match self {
            Self::Calibrated { record, beside } => {
                let beside: String = beside.iter().map(|words| format!("; {words}")).collect();
                format!(
                    "calibrated, {:.1} % rms off finite elements where the fit did not look, {:.2} to {:.2} mm deep{beside}",
                    record.judged.rms_pct,
                    record.judged.from_m * 1e3,
                    record.judged.to_m * 1e3
                )
            }
            Self::CalibratedForAnother { expected: Some(e), .. } | Self::Uncalibrated { expected: Some(e) } => {
                format!("not calibrated for this scene, {}", e.bound())
            }
            Self::CalibratedForAnother { expected: None, differs, record } => format!(
                "{}: {:.1} % rms off finite elements there, how far off beyond is unknown",
                differs.join(", "),
                record.judged.rms_pct
            ),
            Self::Uncalibrated { expected: None } => "not calibrated for this scene, how far off is unknown".into(),
            Self::Unrecorded { .. } => "calibrated for a scene that is not recorded, how far off is unknown".into(),
        };
        short + self.quickly()
    }
}

fn expectation(expected: Option<&Expected>) -> String {
    match expected {
        None => "how wrong is unknown, no trial is like it".into(),
        Some(e) => e.bound(),
    }
}

/// Terms of a scene that no fit has, with what is known of their errors: those of the shipped
/// patches were measured against finite elements that stiffen.
fn beside(scene: &Scene, record: &FitRecord, shipped: bool) -> Vec<String> {
    let (mut beside, nodes) = (Vec::new(), record.nodes);
    let b = scene.tissue.most_stiffening_b();
    if b == 0.0 && record.tissue.stiffening_b > 0.0 {
        beside.push(format!("the law stiffens by itself (b = {})", record.tissue.stiffening_b));
    }
    if b > record.tissue.stiffening_b {
        let measured = STIFFENED.iter().find(|(of, to_b, _)| shipped && *of == nodes && b <= *to_b);
        beside.push(match measured {
            Some((.., rms_pct)) => {
                format!("with its stiffening (b = {b}) up to {rms_pct} % rms off finite elements that stiffen too")
            }
            None => format!("its stiffening (b = {b}) was never compared with finite elements on this patch"),
        });
    }
    if scene.probe.friction > 0.0 {
        let mu = scene.probe.friction;
        let dragged = DRAGGED
            .iter()
            .find(|(of, _)| shipped && *of == nodes)
            .map_or(String::new(), |(_, pct)| format!("a short drag is within {pct} % of mu N of Cattaneo and Mindlin's law, "));
        beside.push(format!(
            "with its friction (mu = {mu}) {dragged}the press itself is not known: our finite elements slide freely"
        ));
    }
    beside
}

/// Differences between a scene and the conditions of its patch's fit, the tip first.
fn differs(scene: &Scene, session: &Session, record: &FitRecord) -> Vec<String> {
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
    if session.patch.model().rim_nodes.is_empty() && tissue.elastic_inclusions() != record.tissue.inclusion {
        let what = if record.tissue.inclusion.is_empty() { "without its inclusions" } else { "with other inclusions" };
        differs.push(format!("calibrated {what}"));
    }
    let (aside_m, deepest_m) = reach_m(scene, session, record);
    if aside_m > record.judged.disc_radius_m * (1.0 + SAME) {
        differs.push(format!("judged within {:.1} mm of the centre only", record.judged.disc_radius_m * 1e3));
    }
    if deepest_m > record.judged.to_m * (1.0 + SAME) {
        differs.push(format!("judged to {:.2} mm deep only", record.judged.to_m * 1e3));
    }
    differs
}

/// Largest distance of the scene's presses from the centre of the fit, across the press, and their
/// largest depth [m].
fn reach_m(scene: &Scene, session: &Session, record: &FitRecord) -> (f64, f64) {
    let (axis, site_m) = (session.params.probe.axis, session.patch.site_m());
    let moved_m = match (&record.organ, scene.probe.site) {
        (Some(organ), Some(site_m)) => (Vector3::from(site_m) - Vector3::from(organ.site_m)).cast::<f32>(),
        _ => scene.probe.position_m.map_or(Vector3::zeros(), |[x, y]| Vector3::new(x as f32, y as f32, 0.0)),
    };
    let across_m = |offset_m: Vector3<f32>| f64::from((offset_m - axis * offset_m.dot(&axis)).norm());
    let (mut aside_m, mut deepest_m) = (across_m(moved_m), 0.0_f64);
    if let Drive::Depth { holds_m, .. } | Drive::Hand { holds_m, .. } = &scene.drive {
        deepest_m = holds_m.iter().copied().fold(0.0, f64::max);
    }
    for tip_m in &session.tips_m {
        let offset_m = Vector3::from(*tip_m) - site_m;
        let depth_m = -f64::from(offset_m.dot(&axis));
        if depth_m > 0.0 {
            (aside_m, deepest_m) = (aside_m.max(across_m(moved_m + offset_m)), deepest_m.max(depth_m));
        }
    }
    (aside_m, deepest_m)
}
