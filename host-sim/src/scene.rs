//! Scene files: what is pressed, with what, and how. SI units, every key named with its unit; an unknown key is an error.

mod error;

use std::path::{Path, PathBuf};

use serde::Deserialize;

pub use error::SceneError;

/// The presets, by name.
pub const PRESETS: [(&str, &str); 5] = [
    ("block", include_str!("../scenes/block.toml")),
    ("block-deep", include_str!("../scenes/block-deep.toml")),
    ("block-20kpa", include_str!("../scenes/block-20kpa.toml")),
    ("liver", include_str!("../scenes/liver.toml")),
    ("nodule", include_str!("../scenes/nodule.toml")),
];

/// A scene.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Shown in tables and pictures.
    pub name: String,
    /// What is pressed.
    pub tissue: TissueScene,
    /// With what.
    pub probe: ProbeScene,
    /// How.
    pub drive: Drive,
    /// By which method.
    #[serde(default)]
    pub solver: Solver,
}

/// The tissue: a block made here or a mesh from a file.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct TissueScene {
    /// Sides of the block [m]; top at z = 0, bottom fixed.
    pub block_m: Option<[f64; 3]>,
    /// Nodes of the block's mesh.
    pub nodes: Option<usize>,
    /// Mesh file, relative to the scene file (to the working directory for a preset); its underside is fixed.
    pub mesh: Option<PathBuf>,
    /// Unit of the mesh file's coordinates.
    pub length_unit: Option<LengthUnit>,
    /// Young's modulus [Pa].
    pub youngs_modulus_pa: f64,
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
}

fn default_damping() -> f64 {
    f64::from(palpate::Params::default().node_damping_per_s)
}

/// Unit of length of a mesh file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LengthUnit {
    /// Metres per unit of the file.
    pub metres: f64,
}

impl<'de> Deserialize<'de> for LengthUnit {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged)]
        enum Raw {
            Name(String),
            Metres(f64),
            Whole(i64),
        }
        let metres = match Raw::deserialize(deserializer)? {
            Raw::Name(name) if name == "m" => 1.0,
            Raw::Name(name) if name == "mm" => 1e-3,
            Raw::Metres(metres) => metres,
            Raw::Whole(metres) => metres as f64,
            Raw::Name(name) => {
                return Err(serde::de::Error::custom(format!(
                    "length_unit \"{name}\" is not \"m\", \"mm\" or a number of metres"
                )));
            }
        };
        if !(metres.is_finite() && metres > 0.0) {
            return Err(serde::de::Error::custom(format!("length_unit = {metres} m must be above zero and finite")));
        }
        Ok(Self { metres })
    }
}

/// A ball of another stiffness.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Inclusion {
    /// Centre [m].
    pub center_m: [f64; 3],
    /// Radius [m].
    pub radius_m: f64,
    /// Stiffness as a multiple of the tissue's.
    pub stiffness_ratio: f64,
}

/// Shape of the probe in a scene file.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub enum Shape {
    /// Cylinder with a half-sphere at its tip.
    Hemisphere,
    /// Full sphere.
    Sphere,
    /// Cylinder with a flat end.
    Flat,
}

/// The probe.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct ProbeScene {
    /// Shape.
    pub shape: Shape,
    /// Radius [m].
    pub radius_m: f64,
    /// Where on the block's top [m].
    pub position_m: Option<[f64; 2]>,
    /// Where on a mesh [m]: the nearest surface point is pressed, along its normal.
    pub site: Option<[f64; 3]>,
}

/// The press.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(tag = "kind", rename_all = "lowercase", deny_unknown_fields)]
pub enum Drive {
    /// The tip goes to each depth and waits there.
    Depth {
        /// Depths [m].
        holds_m: Vec<f64>,
        /// Speed between them [m/s].
        ramp_m_per_s: f64,
        /// Time at each [s].
        hold_s: f64,
    },
    /// A finger pushes with each force and waits.
    Force {
        /// Forces [N].
        holds_n: Vec<f64>,
        /// Fastest approach [m/s].
        ramp_m_per_s: f64,
        /// Time at each [s].
        hold_s: f64,
    },
    /// A compliant finger whose hand goes to each depth.
    Hand {
        /// Depths of the hand's target [m].
        holds_m: Vec<f64>,
        /// Speed of the target [m/s].
        ramp_m_per_s: f64,
        /// Time at each [s].
        hold_s: f64,
    },
    /// The tip repeats the probe columns of a `trace.csv`.
    Trace {
        /// The file, relative to the scene file.
        trace: PathBuf,
        /// Deepest press that the patch answers [m]. It decides the substeps, so a run has the recorded one's bits only with its limit
        /// (`report.depth_limit_mm` in its summary.json); without this key a quarter more than the trace's deepest, as for a press to a depth.
        #[serde(default)]
        depth_limit_m: Option<f64>,
    },
}

/// Method and its input.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields, default)]
pub struct Solver {
    /// Which method.
    pub method: Method,
    /// Packed patch to press instead of building one.
    pub patch: Option<PathBuf>,
}

impl Default for Solver {
    fn default() -> Self {
        Self { method: Method::Palpate, patch: None }
    }
}

/// Methods that run on the core.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// Everything.
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
        if let Some(folder) = path.parent() {
            scene.resolve_paths(folder);
        }
        Ok(scene)
    }

    /// Reads the text of a scene; `file` names it in errors.
    ///
    /// # Errors
    /// As [`Self::load`].
    pub fn parse(file: &str, text: &str) -> Result<Self, SceneError> {
        let scene: Self = toml::from_str(text).map_err(|e| SceneError::of_toml(file, text, &e))?;
        scene.check(file)?;
        Ok(scene)
    }

    fn resolve_paths(&mut self, folder: &Path) {
        let mut resolve = |path: &mut PathBuf| *path = folder.join(&*path);
        self.tissue.mesh.as_mut().map(&mut resolve);
        self.solver.patch.as_mut().map(&mut resolve);
        if let Drive::Trace { trace, .. } = &mut self.drive {
            resolve(trace);
        }
    }

    /// Checks what types cannot: the core's own ranges are checked when the patch is built.
    fn check(&self, file: &str) -> Result<(), SceneError> {
        let bad = |key: &str, why: &str| Err(SceneError::value(file, key, why));
        let tissue = &self.tissue;
        match (&tissue.block_m, &tissue.mesh, &self.solver.patch) {
            (Some(_), None, None) | (None, Some(_), None) => {}
            (_, None, Some(_)) => {}
            (Some(_), Some(_), _) => return bad("tissue", "has both block_m and mesh: keep one"),
            (None, None, None) => return bad("tissue", "has neither block_m nor mesh: give one"),
            (None, Some(_), Some(_)) => return bad("solver.patch", "replaces the mesh: remove one of the two"),
        }
        if tissue.block_m.is_some() && tissue.length_unit.is_some() {
            return bad("tissue.length_unit", "belongs to a mesh file; block_m is in metres: remove it");
        }
        if tissue.mesh.is_some() && tissue.length_unit.is_none() {
            return bad(
                "tissue.length_unit",
                "is missing: say \"m\", \"mm\" or the number of metres of one unit of the mesh file",
            );
        }
        if tissue.mesh.is_some() && tissue.nodes.is_some() {
            return bad("tissue.nodes", "belongs to a block; a mesh file has its own nodes: remove it");
        }
        if tissue.mesh.is_some() && self.probe.site.is_none() {
            return bad("probe.site", "is missing: a mesh needs the place to press, site = [x, y, z] in metres");
        }
        if tissue.mesh.is_none() && self.probe.site.is_some() {
            return bad("probe.site", "belongs to a mesh; a block has position_m = [x, y]");
        }
        if !(0.25..0.5).contains(&tissue.poisson_ratio) {
            let why = format!("= {} must be at least 0.25 (what springs alone have) and below 0.5", tissue.poisson_ratio);
            return bad("tissue.poisson_ratio", &why);
        }
        for (n, ball) in tissue.inclusion.iter().enumerate() {
            for (key, value) in [("radius_m", ball.radius_m), ("stiffness_ratio", ball.stiffness_ratio)] {
                if !(value.is_finite() && value > 0.0) {
                    return bad(&format!("tissue.inclusion[{n}].{key}"), &format!("= {value} must be above zero and finite"));
                }
            }
            if !ball.center_m.iter().all(|c| c.is_finite()) {
                return bad(&format!("tissue.inclusion[{n}].center_m"), "must be finite");
            }
        }
        let places = self.probe.position_m.iter().flatten().chain(self.probe.site.iter().flatten());
        if !places.copied().all(f64::is_finite) {
            return bad("probe", "position_m or site is not finite");
        }
        self.drive.check(file)
    }
}

impl Drive {
    fn check(&self, file: &str) -> Result<(), SceneError> {
        let (key, holds, ramp, hold_s) = match self {
            Self::Depth { holds_m, ramp_m_per_s, hold_s } | Self::Hand { holds_m, ramp_m_per_s, hold_s } => {
                ("drive.holds_m", holds_m, *ramp_m_per_s, *hold_s)
            }
            Self::Force { holds_n, ramp_m_per_s, hold_s } => ("drive.holds_n", holds_n, *ramp_m_per_s, *hold_s),
            Self::Trace { depth_limit_m, .. } => {
                return match depth_limit_m {
                    Some(limit_m) if !(limit_m.is_finite() && *limit_m > 0.0) => {
                        let why = format!("= {limit_m} must be above zero and finite");
                        Err(SceneError::value(file, "drive.depth_limit_m", &why))
                    }
                    _ => Ok(()),
                };
            }
        };
        let bad = |key: &str, why: String| Err(SceneError::value(file, key, &why));
        if holds.is_empty() {
            return bad(key, "is empty: give at least one".into());
        }
        if let Some((n, v)) = holds.iter().enumerate().find(|(_, v)| !(v.is_finite() && **v > 0.0)) {
            return bad(&format!("{key}[{n}]"), format!("= {v} must be above zero and finite"));
        }
        let fastest = f64::from(palpate::Limits::HIGHEST.max_speed_m_per_s);
        if !(ramp > 0.0 && ramp <= fastest) {
            return bad("drive.ramp_m_per_s", format!("= {ramp} must be above zero and at most {fastest}"));
        }
        if !((0.001..=60.0).contains(&hold_s)) {
            return bad("drive.hold_s", format!("= {hold_s} must be from 0.001 to 60"));
        }
        Ok(())
    }
}

impl Drive {
    /// What the holds aim at: depths [m], forces [N] or hand targets [m].
    #[must_use]
    pub fn targets(&self) -> &[f64] {
        match self {
            Self::Depth { holds_m, .. } | Self::Hand { holds_m, .. } => holds_m,
            Self::Force { holds_n, .. } => holds_n,
            Self::Trace { .. } => &[],
        }
    }
}
