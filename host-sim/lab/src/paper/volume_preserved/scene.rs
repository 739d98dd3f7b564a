//! The scene of the hanging organs: organs, their joints and supports, the lifting stick, and the
//! points at which errors are measured. Values are in SI units. Only the shipped scene can be run,
//! because its finite elements are stored.

use serde::Deserialize;

use palpate_tissue::scene::SceneError;

/// Name of the scene.
const NAME: &str = "hanging-liver";
/// Text of the scene.
pub const TEXT: &str = include_str!("../../../../scenes/hanging-liver.toml");

/// Several organs, of which one is lifted.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HangingScene {
    /// Name of the scene in messages.
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

/// An organ of a built-in shape.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OrganScene {
    /// Name of the organ, which is also that of its built-in shape.
    pub shape: String,
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
    /// Reads the shipped scene.
    pub fn shipped() -> Result<Self, SceneError> {
        Self::parse(TEXT)
    }

    /// Reads the text of the scene.
    pub fn parse(text: &str) -> Result<Self, SceneError> {
        let scene = toml::from_str(text).map_err(|e| SceneError::of_toml(NAME, text, &e))?;
        Ok(Self { file: NAME.into(), ..scene })
    }
}
