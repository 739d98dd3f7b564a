//! The record beside a patch file: the conditions of its fit, and the measured errors.
//!
//! The record of `block-410.patch` is `block-410.patch.json`. The patch file, which a board loads,
//! is not changed by it. The record contains the checksum of its patch, so that it cannot be
//! mistaken for the record of another.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use crc::{CRC_32_ISO_HDLC, Crc};
use serde::{Deserialize, Serialize};

use crate::answer::{AnswerProbe, AnswerTissue};
use crate::error::Error;
use crate::output::{OutputFolder, RECORD_SUFFIX};
use crate::scene::{Scene, Up};

/// Scene that a patch was fitted to, and its measured error.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct FitRecord {
    /// Checksum of the patch file.
    pub patch_crc32: u32,
    /// Name of the scene.
    pub scene: String,
    /// Number of nodes of the patch.
    pub nodes: usize,
    /// Tissue that the patch was fitted to.
    pub tissue: AnswerTissue,
    /// Organ or mesh that the patch is a piece of.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub organ: Option<OrganRecord>,
    /// Tip that the patch was fitted to.
    pub probe: AnswerProbe,
    /// Number of places around the centre at which the patch was fitted.
    pub fitted_places: u32,
    /// Presses of the fit that did not count in its last round, because the patch has no static
    /// equilibrium there.
    #[serde(default, skip_serializing_if = "is_none")]
    pub lost_fit_presses: usize,
    /// Depths at which the patch was fitted [m], rising.
    pub fitted_depths_m: Vec<f64>,
    /// Error at places that were not in the fit.
    pub judged: Judged,
    /// Additional error while the probe moves.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub moving: Option<Moving>,
    /// Error of the finite elements themselves [%], if known; the other errors include it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference_error_pct: Option<f64>,
    /// Whether the fit was made with `--quick`.
    #[serde(default, skip_serializing_if = "is_false")]
    pub quick: bool,
}

/// Makes a scene press a packed patch. If the record beside the patch names no organ, the scene's
/// organ and mesh are left out, since the patch need not be a piece of them.
pub fn press_packed(scene: &mut Scene, patch: &Path) {
    if FitRecord::of_file(patch).is_none_or(|record| record.organ.is_none()) {
        (scene.tissue.organ, scene.tissue.mesh) = (None, None);
    }
    scene.solver.patch = Some(patch.to_owned());
}

/// Organ or mesh that a patch is a piece of.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct OrganRecord {
    /// Name of the organ, or of the mesh file without its folder.
    pub name: String,
    /// Checksum of the mesh file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mesh_crc32: Option<u32>,
    /// Axis of the mesh file that points up, if the scene names one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub up: Option<Up>,
    /// Site of the scene's press [m].
    pub site_m: [f64; 3],
    /// Regions of the organ: name, and Young's modulus over the tissue's (1).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub regions: Vec<(String, f64)>,
}

/// Relative difference below which ratios count as equal (1).
const SAME: f64 = 1e-6;

impl OrganRecord {
    /// The organ or mesh of a scene; `None` for a block.
    #[must_use]
    pub fn of(scene: &Scene) -> Option<Self> {
        let tissue = &scene.tissue;
        let (name, mesh_crc32) = match (&tissue.mesh, &tissue.organ) {
            (Some(path), _) => {
                let bytes = std::fs::read(path).ok()?;
                let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                (name, Some(Crc::<u32>::new(&CRC_32_ISO_HDLC).checksum(&bytes)))
            }
            (None, Some(organ)) => (organ.clone(), None),
            (None, None) => return None,
        };
        let ratio = |pascal: f64| pascal / tissue.youngs_modulus_pa;
        let regions = tissue.region.iter().map(|region| (region.name.clone(), ratio(region.youngs_modulus_pa)));
        Some(Self { name, mesh_crc32, up: tissue.up, site_m: scene.probe.site.unwrap_or_default(), regions: regions.collect() })
    }

    /// The key in which a scene with this organ differs from `fitted`, and the fitted value. A site
    /// differs beyond the judged disc around the fitted one [m].
    #[must_use]
    pub fn first_difference(&self, fitted: &Self, disc_radius_m: f64) -> Option<(&'static str, String)> {
        let key = if self.mesh_crc32.is_some() { "tissue.mesh" } else { "tissue.organ" };
        if self.name != fitted.name {
            return Some((key, fitted.name.clone()));
        }
        if self.mesh_crc32 != fitted.mesh_crc32 {
            return Some((key, format!("another file of the name {}", fitted.name)));
        }
        if self.up.unwrap_or_default() != fitted.up.unwrap_or_default() {
            return Some(("tissue.up", format!("{:?}", fitted.up.unwrap_or_default())));
        }
        let squares = self.site_m.iter().zip(fitted.site_m).map(|(own, of)| (own - of).powi(2));
        if squares.sum::<f64>().sqrt() > disc_radius_m {
            return Some(("probe.site", format!("{:?} and {disc_radius_m} m around it", fitted.site_m)));
        }
        let same = |(own, of): (&(String, f64), &(String, f64))| own.0 == of.0 && (own.1 / of.1 - 1.0).abs() < SAME;
        if self.regions.len() != fitted.regions.len() || !self.regions.iter().zip(&fitted.regions).all(same) {
            return Some(("tissue.region", format!("stiffness ratios {:?}", fitted.regions)));
        }
        None
    }
}

/// Force errors at unseen places.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Judged {
    /// Root mean square over places and depths [%].
    pub rms_pct: f64,
    /// Largest error, with its sign [%].
    pub worst_pct: f64,
    /// Shallowest press [m].
    pub from_m: f64,
    /// Deepest press [m].
    pub to_m: f64,
    /// Number of places.
    pub places: usize,
    /// Presses at these places that could not be judged: the patch does not come to rest there.
    #[serde(default, alias = "lost_places", skip_serializing_if = "is_none")]
    pub lost_presses: usize,
    /// Largest distance of the places from the centre [m].
    pub disc_radius_m: f64,
    /// Error of the force added by the inclusions, if that was fitted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bump: Option<JudgedPart>,
    /// Error of the stiffness of discs glued to the surface, pressed and sheared, if they were
    /// fitted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub glued: Option<JudgedPart>,
    /// Error of the surface under the deepest centred press, if that was fitted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface: Option<JudgedSurface>,
}

impl Judged {
    /// Describes the errors in a sentence.
    #[must_use]
    pub fn sentence(&self) -> String {
        let lost = match self.lost_presses {
            0 => String::new(),
            1 => "; one press could not be judged, the patch does not come to rest there".to_owned(),
            lost => format!("; {lost} presses could not be judged, the patch does not come to rest there"),
        };
        let bump = self.bump.map_or(String::new(), |bump| {
            format!("; the force that its inclusions add {:.1} % rms off, {:+.1} % at worst", bump.rms_pct, bump.worst_pct)
        });
        let glued = self.glued.map_or(String::new(), |glued| {
            format!("; glued discs {:.1} % rms off, {:+.1} % at worst", glued.rms_pct, glued.worst_pct)
        });
        let surface = self.surface.map_or(String::new(), |surface| {
            format!("; the surface {:.3} mm off on average {:.2} mm deep", surface.mean_m * 1e3, surface.depth_m * 1e3)
        });
        format!(
            "{:.1} % rms off, {:+.1} % at worst, at {} places that the fit did not see, {:.2} to {:.2} mm deep{bump}{glued}{surface}{lost}",
            self.rms_pct,
            self.worst_pct,
            self.places,
            self.from_m * 1e3,
            self.to_m * 1e3
        )
    }
}

/// Errors of a quantity other than the force: of the force added by inclusions, relative to its
/// highest value at that depth, or of the stiffness of glued discs.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct JudgedPart {
    /// Root mean square [%].
    pub rms_pct: f64,
    /// Largest error, with its sign [%].
    pub worst_pct: f64,
}

/// Distance between the deformed surfaces of patch and finite elements, at the nodes.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct JudgedSurface {
    /// Depth of the press [m].
    pub depth_m: f64,
    /// Mean distance over the nodes around the press [m].
    pub mean_m: f64,
    /// Largest distance [m].
    pub most_m: f64,
}

fn is_none(count: &usize) -> bool {
    *count == 0
}

// serde gives a reference
#[allow(clippy::trivially_copy_pass_by_ref)]
fn is_false(flag: &bool) -> bool {
    !*flag
}

/// Force error that floored masses cause under a moving probe.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Moving {
    /// Largest speed of the motions that were tried [m/s].
    pub speed_m_per_s: f64,
    /// Root mean square over the worst motion, relative to its largest force [%].
    pub rms_pct: f64,
    /// Name of that motion, if more than a ramp was tried.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motion: Option<String>,
}

impl FitRecord {
    /// Path of the record of a patch file.
    #[must_use]
    pub fn path(patch: &Path) -> PathBuf {
        let mut name = OsString::from(patch);
        name.push(RECORD_SUFFIX);
        name.into()
    }

    /// Describes the fit and its errors in a sentence, for a reader who has only the patch.
    #[must_use]
    pub fn sentence(&self) -> String {
        format!(
            "calibrated to finite elements of scene {} at {} places: {}{}",
            self.scene,
            self.fitted_places,
            self.judged.sentence(),
            self.quickly()
        )
    }

    /// Remark on a fit that was made with `--quick`, for its reader.
    #[must_use]
    pub fn quickly(&self) -> &'static str {
        if self.quick { "; fitted with --quick, with fewer presses and rounds than without it" } else { "" }
    }

    /// Writes the record beside the patch file `name`.
    ///
    /// # Errors
    /// The disk is full.
    pub fn write(&self, folder: &OutputFolder, name: &str) -> Result<(), Error> {
        folder.write_json(&format!("{name}{RECORD_SUFFIX}"), self)
    }

    /// Reads the record of a patch file; `None` if there is none, if it cannot be read, or if it
    /// belongs to another patch.
    #[must_use]
    pub fn of_file(patch: &Path) -> Option<Self> {
        let record = Self::read(patch)?.ok()?;
        (checksum(&std::fs::read(patch).ok()?)? == record.patch_crc32).then_some(record)
    }

    /// Reason for which the record beside a patch file cannot be read; `None` if it can be read, or
    /// if there is none. Without its record a patch would press as one that was never fitted, and
    /// with inclusions that are not the scene's.
    #[must_use]
    pub fn unreadable(patch: &Path) -> Option<serde_json::Error> {
        Self::read(patch)?.err()
    }

    fn read(patch: &Path) -> Option<serde_json::Result<Self>> {
        Some(serde_json::from_str(&std::fs::read_to_string(Self::path(patch)).ok()?))
    }
}

/// Checksum stored in a patch file; `None` if the file is too short to have one.
#[must_use]
pub fn checksum(patch: &[u8]) -> Option<u32> {
    palpate::PatchFile::checksum(patch)
}
