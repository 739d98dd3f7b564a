//! Scene files: the tissue that is pressed, the probe and its motion. Values are in SI units, which
//! most keys name (`youngs_modulus_pa`). An unknown key is an error.

mod change;
mod check;
mod drive;
mod error;
mod params;
mod relaxation;
mod shape;

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::exact;
pub use crate::mesh::{LengthUnit, Up};
pub use change::Change;
pub use check::ORGAN_NODES;
pub use drive::Drive;
pub use error::{CHARTED_METHODS, SceneError};
pub use relaxation::RelaxationScene;
use shape::TipKeys;
pub use shape::{Shape, Tip, level};

/// The device's tick [s].
pub const TICK_S: f64 = 1e-3;

/// Value of `solver.patch` that builds the patch from the scene by formulas, even if a calibrated
/// patch that fits the scene is shipped.
pub const NO_PATCH: &str = "none";

/// Scenes that come with the program: name and text.
pub const PRESETS: [(&str, &str); 9] = [
    ("block", include_str!("../../scenes/block.toml")),
    ("block-deep", include_str!("../../scenes/block-deep.toml")),
    ("block-20kpa", include_str!("../../scenes/block-20kpa.toml")),
    ("nodule", include_str!("../../scenes/nodule.toml")),
    ("abdomen", include_str!("../../scenes/abdomen.toml")),
    ("foot", include_str!("../../scenes/foot.toml")),
    ("organ-liver", include_str!("../../scenes/organ-liver.toml")),
    ("beef", include_str!("../../scenes/beef.toml")),
    ("pig-liver", include_str!("../../scenes/pig-liver.toml")),
];

/// A press of a tissue, as a scene file describes it.
///
/// The list at the end of a key's documentation (range, default, source) becomes a row of the page
/// `host-sim/book/src/scene-reference.md`. Tests check each range and default against the parser.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Preset or file from which the scene was read, for messages.
    #[serde(skip)]
    pub file: String,
    /// TOML text of the scene as read, with the changes from the command line.
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

/// Tissue: a block or an organ built by Palpate, or a mesh from a file.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct TissueScene {
    /// Sides of a block along x, y and z [m]; its top is at z = 0, its bottom is fixed. One of
    /// `block_m`, `organ` and `mesh` is required, unless `solver.patch` names a patch.
    ///
    /// * range: 0.001 to 2
    /// * source: 0.08, 0.08, 0.04 in the presets, the block of the reference answers
    pub block_m: Option<[f64; 3]>,
    /// Name of a built-in organ: `liver`, `gallbladder`, `abdomen` or `foot`. Its underside and its
    /// bones are fixed.
    pub organ: Option<String>,
    /// Regions of the organ that have another stiffness than the rest, one table each.
    #[serde(default)]
    pub region: Vec<RegionScene>,
    /// Number of nodes of the mesh: exact for a block, approximate for an organ or a surface file.
    ///
    /// * range: 30 to 5000 of a block, 100 to 5000 of an organ or a surface
    /// * default: 410 of a block, or as many as its proportions need; 600 of an organ or a surface
    pub nodes: Option<usize>,
    /// Mesh or surface file (`.msh`, `.vtu`, `.vtk`, `.stl`, `.obj`), relative to the scene file;
    /// for a preset, to the working directory. Its underside is fixed.
    pub mesh: Option<PathBuf>,
    /// Unit of the coordinates in the mesh file: `"m"`, `"cm"`, `"mm"`, `"um"`, or the length of
    /// one unit in metres. Required with `mesh`.
    pub length_unit: Option<LengthUnit>,
    /// Axis of the mesh file that points up in the scene, along z: `"x"`, `"-x"`, `"y"`, `"-y"`,
    /// `"z"` or `"-z"`. Site and inclusions are in the turned frame; with `"y"`, the file's z, x, y
    /// are its x, y, z.
    ///
    /// * default: z
    pub up: Option<Up>,
    /// Young's modulus [Pa]. It also sets the stiffness of the contact: for an organ in layers,
    /// give the modulus of the layer that the probe touches. With relaxation it is the
    /// instantaneous modulus, and may be left out if the long-term modulus is given.
    ///
    /// * range: 1 to 1e9
    /// * source: 3500 in `block`, porcine liver at small strain (paper 000, its reference 12);
    ///   20000 in `block-20kpa`, fitted to a foot by paper 004
    /// * default: none; it or `long_term_modulus_pa` is required
    #[serde(default = "relaxation::not_given")]
    pub youngs_modulus_pa: f64,
    /// Young's modulus that remains after an infinitely long hold [Pa], given in place of
    /// `youngs_modulus_pa`.
    ///
    /// * range: 1 to 1e9
    pub long_term_modulus_pa: Option<f64>,
    /// Poisson's ratio (1). Above about 0.49 the elements lock under the probe.
    ///
    /// * range: 0.25 to 0.4999
    /// * source: 0.45 in the presets, chosen, not measured
    pub poisson_ratio: f64,
    /// Density of the tissue [kg/m^3].
    ///
    /// * range: 1 to 30000
    /// * source: 1060 in the presets, liver (paper 000, its reference 2)
    pub density_kg_per_m3: f64,
    /// Mass-proportional damping [1/s]: the rate at which the velocity of a free node decays.
    ///
    /// * range: 0 to 999.9
    /// * default: 40
    /// * source: critical damping of the slowest shear mode of an organ 80 to 100 mm high
    ///   (DECISIONS.md)
    #[serde(default = "default_damping")]
    pub node_damping_per_s: f64,
    /// Gravitational acceleration along x, y and z [m/s^2]; zero means that the rest shape is
    /// already the shape under gravity.
    ///
    /// * range: -100 to 100
    /// * default: 0, 0, 0
    #[serde(default)]
    pub gravity_m_per_s2: [f64; 3],
    /// Balls of another stiffness inside the tissue, one table each.
    #[serde(default)]
    pub inclusion: Vec<Inclusion>,
    /// Stiffening exponent b (1): the tangent modulus grows exponentially with the strain energy.
    /// Zero switches the term off. Boards do not have it.
    ///
    /// * range: 0 to 100
    /// * default: 0
    /// * source: 0 to 0.22 for silicone (`accept` T3), 7.9 and 5.9 for pig liver of an assumed
    ///   thickness (T2)
    #[serde(default)]
    pub stiffening_b: f64,
    /// Relaxation, the fading of forces while the tissue is held: up to three terms, one table
    /// each.
    #[serde(default)]
    pub relaxation: Vec<RelaxationScene>,
}

impl TissueScene {
    /// Key and value of the largest stiffening exponent among the tissue, its regions and its balls
    /// (1).
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

    /// Largest stiffening exponent among the tissue, its regions and its balls (1).
    #[must_use]
    pub fn most_stiffening_b(&self) -> f64 {
        self.most_stiffening().1
    }

    /// The tissue without stiffening, for fits: a patch that is fitted without it serves any
    /// exponent.
    #[must_use]
    pub fn elastic(&self) -> Self {
        let region = self.region.iter().map(|region| RegionScene { stiffening_b: None, ..region.clone() }).collect();
        Self { stiffening_b: 0.0, region, inclusion: self.elastic_inclusions(), ..self.clone() }
    }

    /// The balls without stiffening exponents of their own.
    #[must_use]
    pub fn elastic_inclusions(&self) -> Vec<Inclusion> {
        self.inclusion.iter().map(Inclusion::elastic).collect()
    }
}

fn default_damping() -> f64 {
    f64::from(palpate::Params::default().node_damping_per_s)
}

/// A nodule: a ball of another stiffness inside the tissue. Any number of them may be given.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Inclusion {
    /// Centre of the ball [m], in the frame of the tissue. Part of the ball must lie in the tissue.
    pub center_m: [f64; 3],
    /// Radius of the ball [m]. The ball must not contain the whole tissue.
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
    /// * default: that of the surrounding tissue
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stiffening_b: Option<f64>,
}

impl Inclusion {
    /// The ball without a stiffening exponent of its own, for fits, which leave stiffening out.
    #[must_use]
    pub fn elastic(&self) -> Self {
        Self { stiffening_b: None, ..*self }
    }

    /// Whether a point [m] lies inside the ball.
    #[must_use]
    pub fn holds(&self, at_m: [f64; 3]) -> bool {
        (0..3).map(|k| (at_m[k] - self.center_m[k]).powi(2)).sum::<f64>() <= self.radius_m * self.radius_m
    }
}

/// A region of an organ that is stiffer or softer than the rest. Any number of them may be given.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct RegionScene {
    /// Name of the region: `skin`, `fat`, `muscle` or `viscera` of the abdomen; `skin`, `fat pad`
    /// or `deep tissue` of the foot.
    pub name: String,
    /// Young's modulus of the region [Pa]: the long-term one if the tissue's modulus is given as
    /// the long-term one, else the instantaneous one.
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

/// Probe of a scene, with the place of the press.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(try_from = "ProbeKeys")]
pub struct ProbeScene {
    /// Shape of the tip, with its other dimensions.
    pub shape: Shape,
    /// Radius of the tip [m]; for an ellipsoid, its semi-axis along the press.
    pub radius_m: f64,
    /// Tilt of the tip for the whole press, as a rotation about x, y and z [degrees].
    pub tilt_deg: [f64; 3],
    /// Place of the press on the top of a block, x and y [m].
    pub position_m: Option<[f64; 2]>,
    /// Place of the press on a mesh or an organ [m]: the nearest surface point is pressed, along
    /// its normal.
    pub site: Option<[f64; 3]>,
    /// Coulomb's coefficient of friction between probe and tissue (1); at zero the probe slides
    /// freely.
    pub friction: f64,
}

/// Probe that presses the tissue.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ProbeKeys {
    /// Shape of the tip.
    shape: shape::Name,
    /// Radius of the tip [m]; for an ellipsoid, give `semi_axes_m` instead.
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
    /// Direction of the long side of a capsule or an ellipsoid (1); its length is ignored.
    along: Option<[f64; 3]>,
    /// Tilt of the tip for the whole press, as a rotation vector [degrees]: its direction is the
    /// axis, its length the angle, so that [0, 15, 0] turns the tip by 15 degrees about y. The tip
    /// still moves along the press, and its deepest point has the depth.
    ///
    /// * range: an angle of at most 45
    /// * default: 0, 0, 0
    #[serde(default)]
    tilt_deg: [f64; 3],
    /// Place of the press on the top of a block, x and y [m].
    ///
    /// * range: within the block's top
    /// * default: 0, 0
    position_m: Option<[f64; 2]>,
    /// Place of the press on a mesh or an organ [m]: the nearest surface point is pressed, along
    /// its normal. Required with `mesh` and `organ`.
    site: Option<[f64; 3]>,
    /// Coulomb's coefficient of friction between probe and tissue (1); at zero the probe slides
    /// freely.
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
        let ProbeKeys { shape, radius_m, length_m, semi_axes_m, along, tilt_deg, position_m, site, friction } = keys;
        let tip: Tip = TipKeys { shape, radius_m, length_m, semi_axes_m, along }.try_into()?;
        Ok(Self { shape: tip.shape, radius_m: tip.radius_m, tilt_deg, position_m, site, friction })
    }
}

impl ProbeScene {
    /// Shape and radius of the tip.
    #[must_use]
    pub fn tip(&self) -> Tip {
        Tip { shape: self.shape, radius_m: self.radius_m }
    }

    /// Whether a tilt changes what the tip presses: not that of a ball.
    #[must_use]
    pub fn is_tilted(&self) -> bool {
        self.tilt_deg != [0.0; 3] && !matches!(self.shape, Shape::Hemisphere | Shape::Sphere)
    }

    /// Orientation of the tip: the quaternion x, y, z, w of its tilt.
    #[must_use]
    pub fn orientation(&self) -> [f64; 4] {
        let half = self.tilt_deg.map(|degrees| 0.5 * degrees.to_radians());
        let angle = half.iter().map(|part| part * part).sum::<f64>().sqrt();
        let share = if angle > 0.0 { angle.sin() / angle } else { 0.0 };
        let [x, y, z] = half.map(|part| part * share);
        [x, y, z, angle.cos()]
    }
}

/// Method that computes the force, and its input.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields, default)]
pub struct Solver {
    /// Method that computes the forces.
    ///
    /// * default: palpate
    pub method: Method,
    /// Patch file to press instead of a patch built from the scene; `"none"` builds one even if a
    /// shipped patch fits the scene.
    ///
    /// * default: the shipped patch that fits the scene, if there is one
    pub patch: Option<PathBuf>,
    /// Largest force error [%] that floored masses may cause while the probe moves at the drive's
    /// speed, on a board at 200 mm/s at least: the root mean square over the worst of the motions
    /// that the drive can make, relative to the largest force of that motion. The error of the mesh
    /// itself comes on top. `press`, `pack` and `fit` choose their substeps by this bound. Without
    /// this key `press` and `fit` aim at 5 %, and say what they reach. `loop` chooses its substeps
    /// by taps that it simulates.
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
    /// Palpate's own method, with all terms of the tick.
    Palpate,
    /// Springs, masses and contact only: the plain model of the papers.
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
    /// Fails if the name is unknown, or if the file is unreadable, is not valid TOML, or has an
    /// unknown key or an impossible value; the message names the place.
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
        let mut scene: Self = exact::from_toml(text).map_err(|e| SceneError::of_toml(file, text, &e))?;
        scene.file = file.into();
        scene.text = text.into();
        scene.take_modulus(file, text)?;
        scene.check()?;
        Ok(scene)
    }

    /// Files that the scene refers to: mesh, patch and trace.
    #[must_use]
    pub fn files(&self) -> Vec<&Path> {
        let patch = self.solver.patch.as_deref().filter(|p| p.as_os_str() != NO_PATCH);
        let trace = if let Drive::Trace { trace, .. } = &self.drive { Some(trace.as_path()) } else { None };
        self.tissue.mesh.as_deref().into_iter().chain(patch).chain(trace).collect()
    }

    /// Resolves relative paths: those in a scene file against its folder, those in a preset against
    /// the working directory.
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
