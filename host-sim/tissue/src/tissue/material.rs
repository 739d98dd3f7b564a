//! Material of a scene's tissue at every point, from the regions of an organ and the balls in it.

use super::{blended, ratio_of, steepness};
use crate::mesh::TetMesh;
use crate::organ::Organ;
use crate::scene::{Inclusion, Scene, SceneError};

/// Stiffness ratio and stiffening exponent at every point of the tissue.
#[derive(Clone, Debug)]
pub struct Layout {
    organ: Option<Organ>,
    /// Regions that the scene names, with their stiffness over that of the tissue. The other
    /// regions have the tissue's stiffness.
    by_region: Vec<(u32, f64)>,
    /// Regions with a stiffening exponent of their own, with that exponent.
    exponent_by_region: Vec<(u32, f64)>,
    stiffening_b: f64,
    inclusions: Vec<Inclusion>,
}

impl Layout {
    /// Reads the material of a scene.
    ///
    /// # Errors
    /// A region that the organ does not have, or that is given twice.
    pub fn of(scene: &Scene) -> Result<Self, SceneError> {
        let tissue = &scene.tissue;
        let named = tissue.organ.as_deref().map(Organ::named).transpose();
        let organ = named.map_err(|cause| SceneError::value(&scene.file, "tissue.organ:", &cause.to_string()))?;
        let mut by_region: Vec<(u32, f64)> = Vec::new();
        let mut exponent_by_region = Vec::new();
        if let Some(organ) = &organ {
            for (n, region) in tissue.region.iter().enumerate() {
                let key = format!("tissue.region[{n}].name");
                let Some(found) = organ.regions().iter().find(|r| r.name == region.name) else {
                    let known = organ.regions().iter().map(|r| r.name).collect::<Vec<_>>().join(", ");
                    let why = format!("= {:?} is no region of the {}: give one of {known}", region.name, organ.name());
                    return scene.bad(&key, &why);
                };
                if by_region.iter().any(|(id, _)| *id == found.id) {
                    return scene.bad(&key, &format!("= {:?} is there twice: remove one", region.name));
                }
                by_region.push((found.id, region.youngs_modulus_pa / tissue.youngs_modulus_pa));
                exponent_by_region.extend(region.stiffening_b.map(|b| (found.id, b)));
            }
        }
        let (stiffening_b, inclusions) = (tissue.stiffening_b, tissue.inclusion.clone());
        Ok(Self { organ, by_region, exponent_by_region, stiffening_b, inclusions })
    }

    /// Stiffness ratio at a point [m]: that of the region, times that of the ball there.
    #[must_use]
    pub fn ratio_at(&self, at_m: [f64; 3]) -> f64 {
        let ball = self.ball_at(at_m).map_or(1.0, |ball| ball.stiffness_ratio);
        self.of_region(&self.by_region, at_m).unwrap_or(1.0) * ball
    }

    /// Stiffening exponent at a point [m] (1): the exponent of the ball there if it has one, else
    /// that of the region, else that of the tissue.
    #[must_use]
    pub fn exponent_at(&self, at_m: [f64; 3]) -> f64 {
        let of_ball = self.ball_at(at_m).and_then(|ball| ball.stiffening_b);
        of_ball.or_else(|| self.of_region(&self.exponent_by_region, at_m)).unwrap_or(self.stiffening_b)
    }

    /// Steepness of every node of a mesh (1), for a patch whose exponent is `most_b`; empty if
    /// nothing stiffens or everything stiffens alike.
    #[must_use]
    pub fn steepness(&self, mesh: &TetMesh, most_b: f64) -> Vec<f32> {
        match self.is_uniform() || most_b == 0.0 {
            true => Vec::new(),
            false => steepness(mesh, |x| [self.ratio_at(x), self.exponent_at(x) / most_b]),
        }
    }

    fn ball_at(&self, at_m: [f64; 3]) -> Option<&Inclusion> {
        self.inclusions.iter().rev().find(|ball| ball.holds(at_m))
    }

    /// Whether the material is the same everywhere.
    #[must_use]
    pub fn is_uniform(&self) -> bool {
        self.by_region.is_empty() && self.inclusions.is_empty()
    }

    /// Stiffness ratio of a tet, averaged over its volume (1).
    #[must_use]
    pub fn of_tet(&self, mesh: &TetMesh, tet: &[u32; 4]) -> f64 {
        if self.by_region.is_empty() { ratio_of(mesh, tet, &self.inclusions) } else { blended(mesh, tet, |x| self.ratio_at(x)) }
    }

    fn of_region(&self, values: &[(u32, f64)], at_m: [f64; 3]) -> Option<f64> {
        let id = self.organ.as_ref().filter(|_| !values.is_empty())?.region_at(at_m);
        values.iter().find(|(region, _)| *region == id).map(|(_, value)| *value)
    }
}
