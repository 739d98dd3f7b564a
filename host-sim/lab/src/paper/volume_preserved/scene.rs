//! The scene file of the hanging organs: organs, their joints and supports, the lifting stick, and
//! the points at which errors are measured. Values are in SI units; unknown keys are refused.

use std::path::PathBuf;

use serde::Deserialize;

use palpate_tissue::exact;
use palpate_tissue::scene::{LengthUnit, SceneError};

/// Name of the shipped scene.
pub const PRESET: &str = "hanging-liver";
const TEXT: &str = include_str!("../../../../scenes/hanging-liver.toml");

/// Several organs, of which one is lifted.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HangingScene {
    /// Preset or file from which the scene was read, for messages.
    #[serde(skip)]
    pub file: String,
    /// Name in tables and pictures.
    pub name: String,
    /// Gravity [m/s^2]; the rest shape is the one without gravity.
    pub gravity_m_per_s2: [f64; 3],
    /// Poisson's ratio of all organs (1).
    pub poisson_ratio: f64,
    /// Organs; in the model their stiffnesses are relative to the modulus of the first one.
    pub organ: Vec<OrganScene>,
    /// Connecting tissue that joins two of the organs.
    pub joint: JointScene,
    /// Surfaces that are fixed.
    pub fixed: Vec<FixedScene>,
    /// Attachment that is moved to lift an organ.
    pub attachment: Attachment,
    /// Named points at which errors are measured.
    pub landmark: Vec<Landmark>,
    /// Sampled points at which errors are measured.
    pub surface: SurfaceSample,
}

/// An organ: a built-in shape or a mesh file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OrganScene {
    /// Name of the organ, which is also that of its built-in shape.
    pub shape: String,
    /// Mesh file instead of the built-in shape, relative to the scene file; it is used at both
    /// resolutions.
    pub mesh: Option<PathBuf>,
    /// Unit of the mesh file's coordinates.
    pub length_unit: Option<LengthUnit>,
    /// Young's modulus [Pa].
    pub youngs_modulus_pa: f64,
    /// Density [kg/m^3].
    pub density_kg_per_m3: f64,
    /// Approximate number of tets at full and at sparse resolution.
    pub tets: [usize; 2],
}

/// Connecting tissue between two organs.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JointScene {
    /// Organ whose surface is joined.
    pub organ: String,
    /// Organ to whose surface `organ` is joined.
    pub onto: String,
    /// Lowest and highest corner of a box that contains the joined surface [m].
    pub box_m: [[f64; 3]; 2],
    /// Direction from which the outward normal of the joined surface deviates by at most 60
    /// degrees.
    pub facing: [f64; 3],
    /// Largest distance of joined points from the other surface at rest [m].
    pub reach_m: f64,
    /// Stiffness of the joint per area [Pa/m].
    pub stiffness_pa_per_m: f64,
}

/// A surface that is fixed.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FixedScene {
    /// Name of the organ to which it belongs.
    pub organ: String,
    /// Lowest and highest corner of a box that contains the fixed surface [m].
    pub box_m: [[f64; 3]; 2],
    /// Direction from which the outward normal of the fixed surface deviates by at most 60 degrees.
    pub facing: [f64; 3],
}

/// A stick that holds the nodes around a line, and its moves.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Attachment {
    /// Name of the organ to which it belongs.
    pub organ: String,
    /// One end of the line [m].
    pub from_m: [f64; 3],
    /// Other end of the line [m].
    pub to_m: [f64; 3],
    /// Distance from the line within which nodes move with the stick [m].
    pub radius_m: f64,
    /// Displacement of the line from rest at the end of each move [m].
    pub moves_m: Vec<[f64; 3]>,
    /// Names of the moves.
    pub names: Vec<String>,
}

/// A named point of the first organ.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Landmark {
    /// Name in tables and files.
    pub name: String,
    /// x and y of a landmark on the surface, at its highest point there [m].
    pub above_m: Option<[f64; 2]>,
    /// Position of a landmark inside the organ, instead of `above_m` [m].
    pub inside_m: Option<[f64; 3]>,
}

/// Sampled points of the first organ's upper surface, evenly spread over a rectangle.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SurfaceSample {
    /// x and y of the lower corner of the rectangle [m].
    pub low_m: [f64; 2],
    /// x and y of the opposite corner [m].
    pub high_m: [f64; 2],
    /// Number of points at full and at sparse resolution.
    pub points: [usize; 2],
}

impl HangingScene {
    /// Reads the preset or a file.
    pub fn load(name_or_path: &str) -> Result<Self, SceneError> {
        if name_or_path == PRESET {
            return Self::parse(PRESET, TEXT);
        }
        let path = PathBuf::from(name_or_path);
        let text = std::fs::read_to_string(&path).map_err(|source| SceneError::ReadOther {
            path: path.clone(),
            source,
            preset: PRESET,
        })?;
        let mut scene = Self::parse(name_or_path, &text)?;
        for mesh in scene.organ.iter_mut().filter_map(|organ| organ.mesh.as_mut()) {
            *mesh = path.parent().map_or(mesh.clone(), |folder| folder.join(&*mesh));
        }
        Ok(scene)
    }

    /// Reads the text of a scene; `file` names it in errors.
    pub fn parse(file: &str, text: &str) -> Result<Self, SceneError> {
        let mut scene: Self = exact::from_toml(text).map_err(|e| SceneError::of_toml(file, text, &e))?;
        scene.file = file.into();
        scene.check()?;
        Ok(scene)
    }

    fn check(&self) -> Result<(), SceneError> {
        let refuse = |key: &str, why: &str| Err(SceneError::value(&self.file, key, why));
        if self.organ.is_empty() {
            return refuse("organ", "is missing: give at least one [[organ]]");
        }
        for (n, organ) in self.organ.iter().enumerate() {
            let positive = [
                ("youngs_modulus_pa", organ.youngs_modulus_pa, 1.0, 1e9),
                ("density_kg_per_m3", organ.density_kg_per_m3, 1.0, 3e4),
            ];
            for (key, value, low, high) in positive {
                if !(low..=high).contains(&value) {
                    return refuse(&format!("organ[{n}].{key}"), &format!("= {value} is out of range: give {low} .. {high}"));
                }
            }
            if organ.tets.iter().any(|t| !(100..=40_000).contains(t)) {
                return refuse(&format!("organ[{n}].tets"), &format!("= {:?} is out of range: give 100 .. 40000", organ.tets));
            }
            if organ.mesh.is_some() != organ.length_unit.is_some() {
                return refuse(&format!("organ[{n}].length_unit"), "goes with mesh: give both or neither");
            }
        }
        self.check_numbers()?;
        self.check_names()?;
        if self.attachment.moves_m.is_empty() || self.attachment.moves_m.len() != self.attachment.names.len() {
            return refuse("attachment.names", "must name every entry of attachment.moves_m, of which there is at least one");
        }
        if let Some(n) = self.landmark.iter().position(|l| l.above_m.is_some() == l.inside_m.is_some()) {
            return refuse(&format!("landmark[{n}]"), "needs above_m or inside_m, one of the two");
        }
        let named = |name: &str| self.organ.iter().any(|o| o.shape == name);
        let mut others = self.fixed.iter().enumerate().map(|(n, f)| (format!("fixed[{n}].organ"), &f.organ)).collect::<Vec<_>>();
        others.push(("attachment.organ".into(), &self.attachment.organ));
        others.push(("joint.organ".into(), &self.joint.organ));
        others.push(("joint.onto".into(), &self.joint.onto));
        for (key, organ) in others {
            if !named(organ) {
                let known: Vec<&str> = self.organ.iter().map(|o| o.shape.as_str()).collect();
                return refuse(&key, &format!("= \"{organ}\" is no organ of the scene: give one of {}", known.join(", ")));
            }
        }
        if self.surface.points.contains(&0) {
            return refuse("surface.points", "must be above zero");
        }
        Ok(())
    }

    /// Checks that every position and direction is finite and of the size of a body.
    fn check_numbers(&self) -> Result<(), SceneError> {
        const FARTHEST_M: f64 = 2.0;
        let mut places: Vec<(String, &[f64])> = Vec::new();
        let stick = &self.attachment;
        places.push(("attachment.from_m".into(), &stick.from_m));
        places.push(("attachment.to_m".into(), &stick.to_m));
        stick.moves_m.iter().enumerate().for_each(|(n, m)| places.push((format!("attachment.moves_m[{n}]"), m)));
        for (n, f) in self.fixed.iter().enumerate() {
            f.box_m.iter().for_each(|c| places.push((format!("fixed[{n}].box_m"), c)));
            places.push((format!("fixed[{n}].facing"), &f.facing));
        }
        self.joint.box_m.iter().for_each(|c| places.push(("joint.box_m".into(), c)));
        places.push(("joint.facing".into(), &self.joint.facing));
        places.push(("surface.low_m".into(), &self.surface.low_m));
        places.push(("surface.high_m".into(), &self.surface.high_m));
        for (n, l) in self.landmark.iter().enumerate() {
            l.above_m.iter().for_each(|x| places.push((format!("landmark[{n}].above_m"), x)));
            l.inside_m.iter().for_each(|x| places.push((format!("landmark[{n}].inside_m"), x)));
        }
        for (key, value) in places {
            if !value.iter().all(|c| c.abs() <= FARTHEST_M) {
                let why = format!("= {value:?} must be finite and at most {FARTHEST_M} m: give metres");
                return Err(SceneError::value(&self.file, &key, &why));
            }
            if key.ends_with("facing") && value.iter().all(|c| *c == 0.0) {
                return Err(SceneError::value(&self.file, &key, "= 0 points nowhere: give a direction"));
            }
        }
        let ranges = [
            (
                "gravity_m_per_s2",
                self.gravity_m_per_s2.iter().fold(0.0_f64, |a, b| if b.is_nan() { *b } else { a.max(b.abs()) }),
                0.0,
                100.0,
            ),
            ("poisson_ratio", self.poisson_ratio, 0.3, 0.4995),
            ("joint.reach_m", self.joint.reach_m, 1e-7, 0.1),
            ("joint.stiffness_pa_per_m", self.joint.stiffness_pa_per_m, 1e3, 1e9),
            ("attachment.radius_m", self.attachment.radius_m, 1e-5, 0.2),
            ("surface.points", self.surface.points.iter().copied().max().unwrap_or(0) as f64, 1.0, 1e4),
        ];
        for (key, value, low, high) in ranges {
            if !(low..=high).contains(&value) {
                return Err(SceneError::value(&self.file, key, &format!("= {value} is out of range: give {low} .. {high}")));
            }
        }
        Ok(())
    }

    /// Checks that names are present and distinct, and can be parts of file names.
    fn check_names(&self) -> Result<(), SceneError> {
        let sets: [(&str, Vec<&str>); 3] = [
            ("organ.shape", self.organ.iter().map(|o| o.shape.as_str()).collect()),
            ("attachment.names", self.attachment.names.iter().map(String::as_str).collect()),
            ("landmark.name", self.landmark.iter().map(|l| l.name.as_str()).collect()),
        ];
        for (key, names) in sets {
            if names.is_empty() {
                return Err(SceneError::value(&self.file, key, "is missing: give at least one"));
            }
            for (n, name) in names.iter().enumerate() {
                if name.is_empty() || name.contains(|c: char| c.is_control() || c == '/' || c == '\\' || c == '|') {
                    return Err(SceneError::value(
                        &self.file,
                        key,
                        "must be one line of text without slashes and bars, it names files: rename it",
                    ));
                }
                if names[..n].contains(name) {
                    return Err(SceneError::value(&self.file, key, &format!("= \"{name}\" is there twice: rename one")));
                }
            }
        }
        if self.fixed.is_empty() {
            return Err(SceneError::value(&self.file, "fixed", "is missing: hold the organs somewhere, they would drift"));
        }
        if self.joint.organ == self.joint.onto {
            return Err(SceneError::value(&self.file, "joint.onto", "is joint.organ itself: give two organs that touch"));
        }
        Ok(())
    }
}
