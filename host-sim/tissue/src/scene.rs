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
///
/// The list at the end of the docs of a key (range, default, source) is a row of the page
/// `host-sim/book/src/scene-reference.md`. Tests hold each range and default against the parser.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// The preset or file it came from, for messages.
    #[serde(skip)]
    pub file: String,
    /// TOML of the scene as read, with the keys in it that the command line changed.
    #[serde(skip)]
    pub text: String,
    /// Name of the scene in tables, pictures and file names.
    ///
    /// * range: one line of text without slashes
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
    /// Sides of a block along x, y and z [m]; its top is at z = 0, its bottom is fixed. One of
    /// `block_m`, `organ` and `mesh` is given, or a patch.
    ///
    /// * range: 0.001 to 2
    /// * source: 0.08, 0.08, 0.04 in the presets, the block of the reference answers
    pub block_m: Option<[f64; 3]>,
    /// An organ of our own shape by its name: `liver`, `gallbladder`, `abdomen` or `foot`. Its
    /// underside and its bones are fixed.
    pub organ: Option<String>,
    /// Regions of the organ that have another stiffness than the rest, one table each.
    #[serde(default)]
    pub region: Vec<RegionScene>,
    /// Nodes of the mesh of a block, exactly; of an organ or a surface file, about.
    ///
    /// * range: 30 to 5000 of a block, 100 to 5000 of an organ or a surface
    /// * default: 410 of a block, 600 of an organ or a surface
    pub nodes: Option<usize>,
    /// Mesh or surface file (`.msh`, `.vtu`, `.vtk`, `.stl`, `.obj`), relative to the scene file;
    /// for a preset, to the working directory. Its underside is fixed.
    pub mesh: Option<PathBuf>,
    /// Unit of the coordinates in the mesh file: `"m"`, `"cm"`, `"mm"`, `"um"`, or the length of
    /// one unit in metres. Required with `mesh`.
    pub length_unit: Option<LengthUnit>,
    /// Young's modulus [Pa]. Contact follows from it: of an organ in layers, give that of the
    /// tissue touched. With relaxation it is the instantaneous one, and may be left out where the
    /// long-term one is given.
    ///
    /// * range: 1 to 1e9
    /// * source: 3500 in `block`, porcine liver at small strain (paper 000, its reference 12);
    ///   20000 in `block-20kpa`, fitted to a foot by paper 004
    /// * default: none; it or `long_term_modulus_pa` is required
    #[serde(default = "relaxation::not_given")]
    pub youngs_modulus_pa: f64,
    /// Young's modulus after a hold without end [Pa], in place of `youngs_modulus_pa`.
    ///
    /// * range: 1 to 1e9
    pub long_term_modulus_pa: Option<f64>,
    /// Poisson's ratio (1). Above about 0.49 the tissue locks under the probe.
    ///
    /// * range: 0.25 to 0.4999
    /// * source: 0.45 in the presets, chosen, not measured
    pub poisson_ratio: f64,
    /// Density of the tissue [kg/m^3].
    ///
    /// * range: 1 to 30000
    /// * source: 1060 in the presets, liver (paper 000, its reference 2)
    pub density_kg_per_m3: f64,
    /// Mass-proportional damping [1/s]: the share of its velocity that a node loses per second.
    ///
    /// * range: 0 to 999.9
    /// * default: 40
    /// * source: critical for the slowest shear mode of an organ 80 to 100 mm high (DECISIONS.md)
    #[serde(default = "default_damping")]
    pub node_damping_per_s: f64,
    /// Gravity along x, y and z [m/s^2]; zero means that the rest shape is the shape under gravity.
    ///
    /// * range: -100 to 100
    /// * default: 0, 0, 0
    #[serde(default)]
    pub gravity_m_per_s2: [f64; 3],
    /// Stiffer or softer balls inside, one table each.
    #[serde(default)]
    pub inclusion: Vec<Inclusion>,
    /// Stiffening exponent b (1): the tangent modulus grows exponentially with the energy of the
    /// strain. Zero leaves it out. Boards leave the term out.
    ///
    /// * range: 0 to 100
    /// * default: 0
    /// * source: 0 to 0.23 for silicone (`accept` T3), 8.5 and 6.5 for pig liver of an assumed
    ///   thickness (T2)
    #[serde(default)]
    pub stiffening_b: f64,
    /// Fading of forces while the tissue is held: up to three terms, one table each.
    #[serde(default)]
    pub relaxation: Vec<RelaxationScene>,
}

impl TissueScene {
    /// The largest stiffening exponent of the tissue, its regions and its balls (1), and its key.
    #[must_use]
    pub fn most_stiffening(&self) -> (String, f64) {
        let regions = self.region.iter().map(|region| region.stiffening_b).enumerate().map(|(n, b)| ("region", n, b));
        let balls = self.inclusion.iter().map(|ball| ball.stiffening_b).enumerate().map(|(n, b)| ("inclusion", n, b));
        let own = ("tissue.stiffening_b".to_owned(), self.stiffening_b);
        regions.chain(balls).fold(own, |most, (table, n, b)| match b {
            Some(b) if b > most.1 => (format!("tissue.{table}[{n}].stiffening_b"), b),
            _ => most,
        })
    }

    /// The largest stiffening exponent of the tissue, its regions and its balls (1).
    #[must_use]
    pub fn most_stiffening_b(&self) -> f64 {
        self.most_stiffening().1
    }

    /// The balls without exponents of their own.
    #[must_use]
    pub fn elastic_inclusions(&self) -> Vec<Inclusion> {
        self.inclusion.iter().map(Inclusion::elastic).collect()
    }
}

fn default_damping() -> f64 {
    f64::from(palpate::Params::default().node_damping_per_s)
}

/// A ball of another stiffness inside the tissue: a nodule. Any number.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Inclusion {
    /// Centre of the ball [m], in the frame of the tissue. Some of the ball must lie in the tissue.
    pub center_m: [f64; 3],
    /// Radius of the ball [m], which may not hold the whole tissue.
    ///
    /// * range: above 0
    pub radius_m: f64,
    /// Stiffness of the ball over that of the tissue (1).
    ///
    /// * range: above 0
    pub stiffness_ratio: f64,
    /// Stiffening exponent b of the ball (1).
    ///
    /// * range: 0 to 100
    /// * default: that of the tissue around
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stiffening_b: Option<f64>,
}

impl Inclusion {
    /// The ball without an exponent of its own: what a patch is fitted with.
    #[must_use]
    pub fn elastic(&self) -> Self {
        Self { stiffening_b: None, ..*self }
    }

    /// Whether a point [m] is in it.
    #[must_use]
    pub fn holds(&self, at_m: [f64; 3]) -> bool {
        (0..3).map(|k| (at_m[k] - self.center_m[k]).powi(2)).sum::<f64>() <= self.radius_m * self.radius_m
    }
}

/// A region of an organ that is stiffer or softer than the rest. Any number.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct RegionScene {
    /// Name of the region: `skin`, `fat`, `muscle` or `viscera` of the abdomen; `skin`, `fat pad`
    /// or `deep tissue` of the foot.
    pub name: String,
    /// Young's modulus of the region [Pa]: the long-term one where that of the tissue is a
    /// long-term one.
    ///
    /// * range: 1 to 1e9
    /// * source: beside each value in `abdomen-press.toml` and `foot-press.toml`
    pub youngs_modulus_pa: f64,
    /// Stiffening exponent b of the region (1).
    ///
    /// * range: 0 to 100
    /// * default: that of the tissue
    pub stiffening_b: Option<f64>,
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

/// Probe that presses the tissue.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ProbeKeys {
    /// Shape of the tip.
    shape: shape::Name,
    /// Radius of the tip [m]; an ellipsoid has `semi_axes_m` in its place.
    ///
    /// * range: above 0 to 1
    /// * source: 0.008 in the presets, a fingertip
    radius_m: Option<f64>,
    /// Length of a capsule's segment, without its rounded ends [m].
    ///
    /// * range: 0 to 1
    length_m: Option<f64>,
    /// Semi-axes a, b, c of an ellipsoid [m]: a along `along`, c along the press.
    ///
    /// * range: above 0, two of them at most a factor of 4 apart
    semi_axes_m: Option<[f64; 3]>,
    /// Direction of the long side of a capsule or an ellipsoid (1); its length does not count.
    along: Option<[f64; 3]>,
    /// Place of the press on the top of a block, x and y [m].
    ///
    /// * range: within the block's top
    /// * default: 0, 0
    position_m: Option<[f64; 2]>,
    /// Place of the press on a mesh or an organ [m]: the nearest surface point is pressed, along
    /// its normal. Required with `mesh` and `organ`.
    site: Option<[f64; 3]>,
    /// Coulomb's coefficient of friction between probe and tissue (1); zero slides freely.
    ///
    /// * range: 0 to 5
    /// * default: 0
    /// * source: 0.46 +- 0.15 in `abdomen` and `foot`, untreated skin in vivo (Zhang and Mak 1999)
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
    ///
    /// * default: palpate
    pub method: Method,
    /// Patch file to press instead of building one; `"none"` keeps even a shipped one away.
    ///
    /// * default: the shipped patch that fits the scene, if one does
    pub patch: Option<PathBuf>,
    /// Largest force error by floored masses while the probe moves at the drive's speed: root mean
    /// square over the ramp, of its largest force [%]; the mesh's own error comes on top. `press`,
    /// `pack` and `plan` choose their substeps by it. Without this key `press` and `plan` aim at 5,
    /// and a press that cannot keep it runs with a warning. `loop` chooses by taps of its own.
    ///
    /// * range: above 0 to 100
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
    /// Name in scene files.
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
    /// Errors of [`Self::load`].
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
