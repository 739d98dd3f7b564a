//! The record beside a calibrated patch: the conditions of its fit, and its errors.

use palpate_fit::calibrate::accuracy::{Accuracy, DISC_RADII, PLACES};
use palpate_fit::calibrate::targets::DEPTHS_RADII;
use palpate_tissue::Error;
use palpate_tissue::answer::Answer;
use palpate_tissue::fit_record::{FitRecord, Judged, checksum};
use palpate_tissue::output::OutputFolder;
use palpate_tissue::scene::Scene;
use palpate_tissue::session::packed;

/// Error of the shipped finite-element answer: the results on its three meshes agree to this [%].
const REFERENCE_ERROR_PCT: f64 = 0.3;

/// Writes the record of the patch file `name`; `lost_fit_presses` is the number of presses that did
/// not count in the last round of its fit.
pub(super) fn write(
    folder: &OutputFolder,
    name: &str,
    bytes: &[u8],
    scene: &Scene,
    answer: &Answer,
    accuracy: &Accuracy,
    lost_fit_presses: usize,
) -> Result<(), Error> {
    let Some(patch_crc32) = checksum(bytes) else { return Ok(()) };
    let (patch, _) = packed::unpack(bytes)?;
    let radius_m = scene.probe.radius_m;
    // the errors over the disc of places, at all of its depths
    let disc: Vec<_> = accuracy.forces.iter().filter(|f| f.disc_rms_pct.is_some()).collect();
    let depths_mm: Vec<f64> = disc.iter().map(|f| f.depth_mm).collect();
    let (rms_pct, worst_pct) = accuracy.disc_pct(&depths_mm);
    let record = FitRecord {
        patch_crc32,
        scene: scene.name.clone(),
        nodes: patch.model().nodes.len(),
        tissue: answer.tissue.clone(),
        organ: None,
        probe: answer.probe,
        fitted_places: patch.fitted_places(),
        lost_fit_presses,
        fitted_depths_m: DEPTHS_RADII.iter().map(|depth| depth * radius_m).collect(),
        judged: Judged {
            rms_pct,
            worst_pct,
            from_m: depths_mm.first().copied().map_or(0.0, metres),
            to_m: depths_mm.last().copied().map_or(0.0, metres),
            places: PLACES,
            lost_presses: 0,
            disc_radius_m: DISC_RADII * radius_m,
            bump: None,
            glued: None,
            surface: None,
        },
        moving: None,
        reference_error_pct: (*answer == Answer::block()).then_some(REFERENCE_ERROR_PCT),
    };
    record.write(folder, name)
}

/// Converts millimetres to metres, without the rounding of the radius in single precision.
fn metres(mm: f64) -> f64 {
    (mm * 1e4).round() / 1e7
}
