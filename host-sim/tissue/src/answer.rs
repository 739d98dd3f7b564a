//! Results of a converged finite-element solution, stored in a file.

use std::path::Path;

use serde::{Deserialize, Serialize};

mod surface_grid;

use crate::error::Error;
use crate::output::OutputFolder;
pub use crate::scene::Tip as AnswerProbe;
use crate::scene::{Inclusion, Scene};
pub use surface_grid::SurfaceGrid;

/// The block 80 x 80 x 40 mm, nu = 0.45, under a hemisphere of 8 mm.
const BLOCK: &str = include_str!("../../references/block.json");
/// Difference below which two places or two depths count as the same [m].
const SAME_M: f64 = 1e-7;

/// Forces and displacements of one tissue under one probe. Forces are divided by Young's modulus,
/// so that the answer applies to any modulus.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Answer {
    /// Tissue that was pressed.
    pub tissue: AnswerTissue,
    /// Probe that pressed the tissue.
    pub probe: AnswerProbe,
    /// Solution at every place and depth.
    pub holds: Vec<HoldAnswer>,
    /// Responses of discs that are glued to the surface and moved slightly, if they were solved.
    /// They do not depend on the probe.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub glued: Vec<GluedAnswer>,
}

/// Tissue that was pressed.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct AnswerTissue {
    /// Sides of the block [m]; top at z = 0, bottom fixed.
    pub block_m: Option<[f64; 3]>,
    /// Mesh file of a tissue that is not a block, as the scene names it.
    pub mesh: Option<String>,
    /// Poisson's ratio (1).
    pub poisson_ratio: f64,
    /// Stiffening exponent b (1).
    #[serde(default, skip_serializing_if = "is_zero")]
    pub stiffening_b: f64,
    /// Balls of another stiffness inside the tissue.
    pub inclusion: Vec<Inclusion>,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

/// The tissue in equilibrium under the probe at one place and depth.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct HoldAnswer {
    /// Place at which the tip first touches, on the rest surface [m].
    pub place_m: [f64; 3],
    /// Depth of the tip below that place [m].
    pub depth_m: f64,
    /// Force along the press over Young's modulus [m^2], positive out of the tissue.
    pub force_over_e_m2: f64,
    /// Displacement of the top surface around the place, if it was stored.
    pub surface: Option<SurfaceGrid>,
}

/// Response of a disc glued to the surface, to first order (`reference/glued.rs` of the fits).
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct GluedAnswer {
    /// Centre of the disc on the rest surface [m].
    pub place_m: [f64; 3],
    /// Radius of the disc [m].
    pub radius_m: f64,
    /// Direction of the disc's motion, a unit vector.
    pub direction: [f64; 3],
    /// Force along the displacement over Young's modulus, per displacement [m].
    pub stiffness_over_e_m: f64,
}

impl Answer {
    /// The shipped answer: block 80 x 80 x 40 mm, nu = 0.45, hemisphere R = 8 mm.
    ///
    /// # Panics
    /// Never in a released program: the tests read the shipped file.
    #[must_use]
    pub fn block() -> Self {
        serde_json::from_str(BLOCK).expect("the shipped answer is well-formed")
    }

    /// Reads an answer file and checks its values.
    ///
    /// # Errors
    /// The file cannot be read, or it is not a valid answer.
    pub fn load(path: &Path) -> Result<Self, Error> {
        let text = std::fs::read_to_string(path).map_err(|source| Error::Read { path: path.into(), source })?;
        let refuse = |cause: String| Error::Usage(format!("{}: {cause}: write it anew with palpate fit", path.display()));
        let answer: Self = serde_json::from_str(&text).map_err(|cause| refuse(cause.to_string()))?;
        for (n, hold) in answer.holds.iter().enumerate() {
            let positive = [hold.depth_m, hold.force_over_e_m2].iter().all(|v| v.is_finite() && *v > 0.0);
            if !positive || !hold.place_m.iter().all(|c| c.is_finite()) {
                return Err(refuse(format!("holds[{n}] has a depth, force or place that cannot be")));
            }
            if answer.hold(hold.place_m, hold.depth_m).is_some_and(|first| !std::ptr::eq(first, hold)) {
                return Err(refuse(format!("holds[{n}] is there twice")));
            }
        }
        for (n, disc) in answer.glued.iter().enumerate() {
            let positive = [disc.radius_m, disc.stiffness_over_e_m].iter().all(|v| v.is_finite() && *v > 0.0);
            let length = disc.direction.iter().map(|c| c * c).sum::<f64>().sqrt();
            if !positive || !disc.place_m.iter().all(|c| c.is_finite()) || (length - 1.0).is_nan() || (length - 1.0).abs() > 1e-6
            {
                return Err(refuse(format!("glued[{n}] has a radius, stiffness, place or direction that cannot be")));
            }
        }
        Ok(answer)
    }

    /// Writes the answer to the file `name` in a folder; equal answers give equal bytes.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn save(&self, folder: &OutputFolder, name: &str) -> Result<(), Error> {
        let mut text =
            serde_json::to_string(self).map_err(|cause| Error::Usage(format!("{name}: {cause}: check the scene's numbers")))?;
        // one hold per line, so that diffs are readable
        text = text.replace("{\"place_m\"", "\n{\"place_m\"");
        text.push('\n');
        folder.write(name, text.as_bytes())
    }

    /// Whether the answer is for a scene's tissue and probe, whatever the modulus, place and depth.
    /// No answer is for a scene with gravity.
    #[must_use]
    pub fn is_for(&self, scene: &Scene) -> bool {
        let (own, tissue) = (&self.tissue, &scene.tissue);
        own.block_m == tissue.block_m
            && own.mesh == tissue.mesh.as_ref().map(|path| path.display().to_string())
            && own.poisson_ratio == tissue.poisson_ratio
            && own.stiffening_b == tissue.stiffening_b
            && own.inclusion == tissue.inclusion
            && tissue.gravity_m_per_s2 == [0.0; 3]
            && self.probe == scene.probe.tip()
            && scene.probe.tilt_deg == [0.0; 3]
    }

    /// The hold at a place and depth, if it was solved.
    #[must_use]
    pub fn hold(&self, place_m: [f64; 3], depth_m: f64) -> Option<&HoldAnswer> {
        let same = |a: f64, b: f64| (a - b).abs() < SAME_M;
        self.holds.iter().find(|h| same(h.depth_m, depth_m) && (0..3).all(|k| same(h.place_m[k], place_m[k])))
    }
}
