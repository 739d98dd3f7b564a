//! Scene of paper 004: an organ with layers, and a finger that presses it with given forces.

use serde::Deserialize;

use palpate_tissue::exact;
use palpate_tissue::scene::SceneError;

/// Presets, as pairs of name and text.
pub const PRESETS: [(&str, &str); 2] = [
    ("abdomen-press", include_str!("../../../../scenes/abdomen-press.toml")),
    ("foot-press", include_str!("../../../../scenes/foot-press.toml")),
];

/// A scene of paper 004.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PressScene {
    /// Preset from which the scene was read, for messages.
    #[serde(skip)]
    pub file: String,
    /// Name in tables and pictures.
    pub name: String,
    /// Name of a shape of [`palpate_tissue::organ`].
    pub organ: String,
    /// Poisson's ratio (1) of all layers.
    pub poisson_ratio: f64,
    /// Density [kg/m^3] of all layers.
    pub density_kg_per_m3: f64,
    /// Layers and their stiffness.
    pub region: Vec<RegionScene>,
    /// Finger that presses the organ.
    pub finger: FingerScene,
    /// Sizes of the elements.
    pub mesh: MeshScene,
}

/// A layer of an organ.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RegionScene {
    /// Name of a region of `organ`.
    pub name: String,
    /// Young's modulus [Pa].
    pub youngs_modulus_pa: f64,
}

/// A hemisphere on a cylinder, which approaches along a ray.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FingerScene {
    /// Radius of the hemisphere [m].
    pub radius_m: f64,
    /// Starting point of the ray [m].
    pub from_m: [f64; 3],
    /// Direction in which the finger moves and presses; the vector may have any length.
    pub direction: [f64; 3],
    /// Forces of the pictures in ascending order [N].
    pub forces_n: Vec<f64>,
}

/// Sizes of a mesh that is finest around the site.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeshScene {
    /// Distance from the site within which elements have their smallest size [m].
    pub fine_radius_m: f64,
    /// Edge length of the cubes of the lattice there [m].
    pub spacing_m: f64,
    /// Growth of the cubes per distance outside that radius (1).
    pub growth: f64,
}

impl PressScene {
    /// Reads the text of a preset; `file` names it in errors.
    pub fn parse(file: &str, text: &str) -> Result<Self, SceneError> {
        let scene = exact::from_toml(text).map_err(|e| SceneError::of_toml(file, text, &e))?;
        Ok(Self { file: file.into(), ..scene })
    }

    /// Error about the value of a key.
    pub(super) fn bad(&self, key: &str, why: &str) -> SceneError {
        SceneError::value(&self.file, key, why)
    }
}
