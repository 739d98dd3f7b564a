//! Scene files: what is pressed, with what, and how. SI units, every key named with its unit; an
//! unknown key is an error.

mod change;
mod check;
mod drive;
mod error;
mod params;
mod relaxation;
mod shape;

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

pub use crate::mesh::LengthUnit;
pub use change::Change;
pub use drive::Drive;
pub use error::{CHARTED_METHODS, SceneError};
pub use relaxation::RelaxationScene;
use shape::TipKeys;
pub use shape::{Shape, Tip, level};

/// The device's tick [s].
pub const TICK_S: f64 = 1e-3;

/// In place of a patch file: the scene's formulas alone, even where a calibrated patch ships.
pub const NO_PATCH: &str = "none";

/// The presets, by name.
pub const PRESETS: [(&str, &str); 10] = [
    ("block", include_str!("../../scenes/block.toml")),
    ("block-deep", include_str!("../../scenes/block-deep.toml")),
    ("block-20kpa", include_str!("../../scenes/block-20kpa.toml")),
    ("liver", include_str!("../../scenes/liver.toml")),
    ("nodule", include_str!("../../scenes/nodule.toml")),
    ("abdomen", include_str!("../../scenes/abdomen.toml")),
    ("foot", include_str!("../../scenes/foot.toml")),
    ("organ-liver", include_str!("../../scenes/organ-liver.toml")),
    ("beef", include_str!("../../scenes/beef.toml")),
    ("pig-liver", include_str!("../../scenes/pig-liver.toml")),
];

/// A scene.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// The preset or file it came from, for messages.
    #[serde(skip)]
    pub file: String,
    /// Its TOML as read, with the keys in it that the command line changed.
    #[serde(skip)]
    pub text: String,
    /// Shown in tables and pictures.
    pub name: String,
    /// Tissue that is pressed.
    pub tissue: TissueScene,
    /// Probe that presses it.
    pub probe: ProbeScene,
    /// Motion of the probe.
    pub drive: Drive,
    /// Method that computes the force.
    #[serde(default)]
    pub solver: Solver,
}

/// The tissue: a block or an organ made here, or a mesh from a file.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct TissueScene {
    /// Sides of the block [m]; top at z = 0, bottom fixed.
    pub block_m: Option<[f64; 3]>,
    /// An organ of [`crate::organ`] by its name; its underside and its bones are fixed.
    pub organ: Option<String>,
    /// Regions of the organ that have another stiffness than the rest.
    #[serde(default)]
    pub region: Vec<RegionScene>,
    /// Nodes of the block's mesh; of an organ's, about.
    pub nodes: Option<usize>,
    /// Mesh file, relative to the scene file (to the working directory for a preset); its underside
    /// is fixed.
    pub mesh: Option<PathBuf>,
    /// Unit of the mesh file's coordinates.
    pub length_unit: Option<LengthUnit>,
    /// Young's modulus [Pa]. Contact follows from it: of an organ in layers, give that of the
    /// tissue touched. With relaxation it is the instantaneous one, and may be left out where the
    /// long-term one is given.
    #[serde(default = "relaxation::not_given")]
    pub youngs_modulus_pa: f64,
    /// Young's modulus after a hold without end [Pa], in place of the instantaneous one.
    pub long_term_modulus_pa: Option<f64>,
    /// Poisson's ratio (1).
    pub poisson_ratio: f64,
    /// Density [kg/m^3].
    pub density_kg_per_m3: f64,
    /// Mass-proportional damping [1/s].
    #[serde(default = "default_damping")]
    pub node_damping_per_s: f64,
    /// Gravity [m/s^2]; zero means that the rest shape is the shape under gravity.
    #[serde(default)]
    pub gravity_m_per_s2: [f64; 3],
    /// Stiffer or softer balls inside.
    #[serde(default)]
    pub inclusion: Vec<Inclusion>,
    /// Stiffening exponent b (1): the tangent modulus grows exponentially with the energy of the
    /// strain. Zero leaves it out; silicone has 0.1 to 0.4, liver 12 to 22.
    #[serde(default)]
    pub stiffening_b: f64,
    /// How forces fade while the tissue is held: up to three terms.
    #[serde(default)]
    pub relaxation: Vec<RelaxationScene>,
}

fn default_damping() -> f64 {
    f64::from(palpate::Params::default().node_damping_per_s)
}

/// A ball of another stiffness.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Inclusion {
    /// Centre [m].
    pub center_m: [f64; 3],
    /// Radius [m].
    pub radius_m: f64,
    /// Stiffness as a multiple of the tissue's.
    pub stiffness_ratio: f64,
}

impl Inclusion {
    /// Whether a point [m] is in it.
    #[must_use]
    pub fn holds(&self, at_m: [f64; 3]) -> bool {
        (0..3).map(|k| (at_m[k] - self.center_m[k]).powi(2)).sum::<f64>() <= self.radius_m * self.radius_m
    }
}

/// A region of an organ.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct RegionScene {
    /// As the organ calls it.
    pub name: String,
    /// Young's modulus [Pa]: the long-term one where the tissue's is given so.
    pub youngs_modulus_pa: f64,
}

/// The probe.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(try_from = "ProbeKeys")]
pub struct ProbeScene {
    /// Shape.
    pub shape: Shape,
    /// Radius [m].
    pub radius_m: f64,
    /// Where on the block's top [m].
    pub position_m: Option<[f64; 2]>,
    /// Where on a mesh or an organ [m]: the nearest surface point is pressed, along its normal.
    pub site: Option<[f64; 3]>,
    /// Coulomb's coefficient of friction on the tissue (1); zero slides freely.
    pub friction: f64,
}

/// The keys of a probe in a scene file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ProbeKeys {
    shape: shape::Name,
    radius_m: Option<f64>,
    length_m: Option<f64>,
    semi_axes_m: Option<[f64; 3]>,
    along: Option<[f64; 3]>,
    position_m: Option<[f64; 2]>,
    site: Option<[f64; 3]>,
    #[serde(default)]
    friction: f64,
}

impl TryFrom<ProbeKeys> for ProbeScene {
    type Error = String;

    fn try_from(keys: ProbeKeys) -> Result<Self, String> {
        let ProbeKeys { shape, radius_m, length_m, semi_axes_m, along, position_m, site, friction } = keys;
        let tip: Tip = TipKeys { shape, radius_m, length_m, semi_axes_m, along }.try_into()?;
        Ok(Self { shape: tip.shape, radius_m: tip.radius_m, position_m, site, friction })
    }
}

impl ProbeScene {
    /// Shape and radius.
    #[must_use]
    pub fn tip(&self) -> Tip {
        Tip { shape: self.shape, radius_m: self.radius_m }
    }
}

/// Method and its input.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields, default)]
pub struct Solver {
    /// Method that computes the forces.
    pub method: Method,
    /// Packed patch to press instead of building one; "none" keeps even a shipped one away.
    pub patch: Option<PathBuf>,
    /// Largest force error by floored masses while the probe moves at the drive's speed: root mean
    /// square over the ramp, of its largest force [%]; the mesh's own error comes on top. `press`,
    /// `pack` and `plan` choose their substeps by it. Without this key `press` and `plan` aim at 5,
    /// and a press that cannot keep it runs with a warning. `loop` chooses by taps of its own.
    pub moving_error_pct: Option<f64>,
}

impl Default for Solver {
    fn default() -> Self {
        Self { method: Method::Palpate, patch: None, moving_error_pct: None }
    }
}

/// Methods that run on the core.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// The product: all terms of its tick.
    Palpate,
    /// Springs, masses and contact only: the papers' plain model.
    Springs,
}

impl Method {
    /// As in scene files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Palpate => "palpate",
            Self::Springs => "springs",
        }
    }
}

impl Scene {
    /// Reads a preset by name or a scene file by path.
    ///
    /// # Errors
    /// Unknown name, unreadable file, bad TOML, unknown key, impossible value: with the place.
    pub fn load(name_or_path: &str) -> Result<Self, SceneError> {
        if let Some((_, text)) = PRESETS.iter().find(|(name, _)| *name == name_or_path) {
            return Self::parse(name_or_path, text);
        }
        let path = Path::new(name_or_path);
        let looks_like_path = path.extension().is_some() || path.components().count() > 1;
        if !looks_like_path && !path.exists() {
            return Err(SceneError::unknown_name(name_or_path));
        }
        let text = std::fs::read_to_string(path).map_err(|source| SceneError::Read { path: path.into(), source })?;
        let mut scene = Self::parse(name_or_path, &text)?;
        scene.resolve_paths_of(name_or_path);
        Ok(scene)
    }

    /// Reads the text of a scene; `file` names it in errors.
    ///
    /// # Errors
    /// As [`Self::load`].
    pub fn parse(file: &str, text: &str) -> Result<Self, SceneError> {
        let mut scene: Self = toml::from_str(text).map_err(|e| SceneError::of_toml(file, text, &e))?;
        scene.file = file.into();
        scene.text = text.into();
        scene.take_modulus(file, text)?;
        scene.check()?;
        Ok(scene)
    }

    /// Files that the scene names besides itself: mesh, patch, trace.
    #[must_use]
    pub fn files(&self) -> Vec<&Path> {
        let patch = self.solver.patch.as_deref().filter(|p| p.as_os_str() != NO_PATCH);
        let trace = if let Drive::Trace { trace, .. } = &self.drive { Some(trace.as_path()) } else { None };
        self.tissue.mesh.as_deref().into_iter().chain(patch).chain(trace).collect()
    }

    /// Paths in a scene file are relative to it, those of a preset to the working folder.
    fn resolve_paths_of(&mut self, name_or_path: &str) {
        let preset = PRESETS.iter().any(|(name, _)| *name == name_or_path);
        let Some(folder) = Path::new(name_or_path).parent().filter(|_| !preset) else { return };
        let mut resolve = |path: &mut PathBuf| *path = folder.join(&*path);
        self.tissue.mesh.as_mut().map(&mut resolve);
        self.solver.patch.as_mut().filter(|p| p.as_os_str() != NO_PATCH).map(&mut resolve);
        if let Drive::Trace { trace, .. } = &mut self.drive {
            resolve(trace);
        }
    }
}
