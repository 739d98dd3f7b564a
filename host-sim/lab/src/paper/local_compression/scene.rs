//! Scene of paper 004: an organ with layers, and a finger that presses it with given forces.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use palpate_tissue::organ::Organ;
use palpate_tissue::scene::{LengthUnit, SceneError};

/// Presets, as pairs of name and text.
pub const PRESETS: [(&str, &str); 2] = [
    ("abdomen-press", include_str!("../../../../scenes/abdomen-press.toml")),
    ("foot-press", include_str!("../../../../scenes/foot-press.toml")),
];

/// Largest force of a scene [N]: the paper has ten groups of pressure in 0 .. 4 N.
pub const LARGEST_FORCE_N: f64 = 4.0;

/// A scene of paper 004.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PressScene {
    /// Preset or file from which the scene was read, for messages.
    #[serde(skip)]
    pub file: String,
    /// Name in tables and pictures.
    pub name: String,
    /// Name of a shape of [`palpate_tissue::organ`].
    pub organ: Option<String>,
    /// Mesh file whose tets have region numbers, instead of `organ`; relative to the scene file.
    pub mesh_file: Option<PathBuf>,
    /// Unit of the coordinates of the mesh file.
    pub length_unit: Option<LengthUnit>,
    /// Poisson's ratio (1) of all layers.
    pub poisson_ratio: f64,
    /// Density [kg/m^3] of all layers.
    pub density_kg_per_m3: f64,
    /// Layers and their stiffness.
    pub region: Vec<RegionScene>,
    /// Finger that presses the organ.
    pub finger: FingerScene,
    /// Sizes of the elements of `organ`; a mesh file has its own elements.
    pub mesh: Option<MeshScene>,
}

/// A layer of an organ or of a mesh file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RegionScene {
    /// Name of a region of `organ`.
    pub name: Option<String>,
    /// Region number in the mesh file, instead of `name`.
    pub number: Option<u32>,
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
    /// Reads a preset by name or a scene file by path.
    pub fn load(name_or_path: &str) -> Result<Self, SceneError> {
        if let Some((name, text)) = PRESETS.iter().find(|(name, _)| *name == name_or_path) {
            return Self::parse(name, text);
        }
        let path = Path::new(name_or_path);
        let read = |source| SceneError::ReadOther { path: path.into(), source, preset: PRESETS[0].0 };
        let mut scene = Self::parse(name_or_path, &std::fs::read_to_string(path).map_err(read)?)?;
        if let (Some(mesh), Some(folder)) = (&mut scene.mesh_file, path.parent()) {
            *mesh = folder.join(&*mesh);
        }
        Ok(scene)
    }

    /// Reads the text of a scene; `file` names it in errors.
    pub fn parse(file: &str, text: &str) -> Result<Self, SceneError> {
        let mut scene: Self = toml::from_str(text).map_err(|e| SceneError::of_toml(file, text, &e))?;
        scene.file = file.into();
        scene.check()?;
        Ok(scene)
    }

    /// Error about the value of a key.
    pub(super) fn bad(&self, key: &str, why: &str) -> SceneError {
        SceneError::value(&self.file, key, why)
    }

    fn check(&self) -> Result<(), SceneError> {
        if self.name.is_empty() || self.name.contains(|c: char| c.is_control() || c == '/' || c == '\\' || c == '|') {
            return Err(self.bad("name", "must be one line of text without slashes and bars, it names files: rename the scene"));
        }
        if ["block", "block-1", "block-2"].contains(&self.name.as_str()) {
            return Err(self.bad("name", "= is taken by the standard block's own files: rename the scene"));
        }
        let numbers = [
            ("poisson_ratio", self.poisson_ratio, 0.25, 0.49),
            ("density_kg_per_m3", self.density_kg_per_m3, 1.0, 3e4),
            ("finger.radius_m", self.finger.radius_m, 1e-3, 0.05),
        ];
        let mesh = self.mesh.iter().flat_map(|m| {
            [
                ("mesh.fine_radius_m", m.fine_radius_m, 1e-3, 0.2),
                ("mesh.spacing_m", m.spacing_m, 2e-3, 0.05),
                ("mesh.growth", m.growth, 0.0, 5.0),
            ]
        });
        for (key, value, low, high) in numbers.into_iter().chain(mesh) {
            if !(low..=high).contains(&value) {
                return Err(self.bad(key, &format!("= {value} is out of range: give {low} .. {high}")));
            }
        }
        self.check_source()?;
        self.check_regions()?;
        let finger = &self.finger;
        if !finger.from_m.iter().chain(&finger.direction).all(|c| c.is_finite()) || finger.direction == [0.0; 3] {
            return Err(self.bad("finger.direction", "and finger.from_m must be finite, the direction not zero: give a ray"));
        }
        if finger.forces_n.is_empty() {
            return Err(self.bad("finger.forces_n", "is empty: give at least one"));
        }
        let before = std::iter::once(&0.0).chain(&finger.forces_n);
        for (n, (&force, &before)) in finger.forces_n.iter().zip(before).enumerate() {
            if !(force > before && force <= LARGEST_FORCE_N) {
                let why = format!(
                    "= {force} must be above the one before and at most {LARGEST_FORCE_N}: give rising forces in newtons"
                );
                return Err(self.bad(&format!("finger.forces_n[{n}]"), &why));
            }
        }
        Ok(())
    }

    fn check_source(&self) -> Result<(), SceneError> {
        match (&self.organ, &self.mesh_file) {
            (Some(name), None) => {
                Organ::named(name).map_err(|cause| self.bad("organ:", &cause.to_string()))?;
                if self.mesh.is_none() {
                    return Err(
                        self.bad("mesh", "is missing: say how the organ is meshed, [mesh] with fine_radius_m, spacing_m, growth")
                    );
                }
                if self.length_unit.is_some() {
                    return Err(self.bad("length_unit", "belongs to mesh_file; organs are in metres: remove it"));
                }
            }
            (None, Some(_)) if self.length_unit.is_none() => {
                return Err(self.bad(
                    "length_unit",
                    "is missing: say \"m\", \"cm\", \"mm\", \"um\" or the number of metres of one unit of the mesh file",
                ));
            }
            (None, Some(_)) if self.mesh.is_some() => {
                return Err(self.bad("mesh", "belongs to an organ; a mesh file has its own elements: remove it"));
            }
            (None, Some(_)) => {}
            _ => return Err(self.bad("organ", "or mesh_file: give one of the two")),
        }
        Ok(())
    }

    fn check_regions(&self) -> Result<(), SceneError> {
        for (n, region) in self.region.iter().enumerate() {
            let e = region.youngs_modulus_pa;
            if !(1.0..=1e9).contains(&e) {
                return Err(self.bad(&format!("region[{n}].youngs_modulus_pa"), &format!("= {e} is out of range: give 1 .. 1e9")));
            }
            let named =
                if self.organ.is_some() { region.name.is_some() && region.number.is_none() } else { region.number.is_some() };
            if !named {
                let why = "needs the name of a region of the organ, or its number in the mesh file, not both";
                return Err(self.bad(&format!("region[{n}]"), why));
            }
        }
        Ok(())
    }
}
