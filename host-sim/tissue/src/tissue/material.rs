//! Material of a scene's tissue at every point: regions of an organ, and balls in it.

use super::{blended, ratio_of};
use crate::mesh::TetMesh;
use crate::organ::Organ;
use crate::scene::{Inclusion, Scene, SceneError};

/// Stiffness over the scene's Young's modulus.
#[derive(Clone, Debug)]
pub struct Layout {
    organ: Option<Organ>,
    /// Region and its stiffness over the scene's; regions that are not named have the scene's.
    by_region: Vec<(u32, f64)>,
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
            }
        }
        Ok(Self { organ, by_region, inclusions: tissue.inclusion.clone() })
    }

    /// Ratio at a point [m]: that of the region, times that of the ball there.
    #[must_use]
    pub fn ratio_at(&self, at_m: [f64; 3]) -> f64 {
        let ball = self.inclusions.iter().rev().find(|ball| ball.holds(at_m)).map_or(1.0, |ball| ball.stiffness_ratio);
        self.region_at(at_m) * ball
    }

    /// Whether it is the same everywhere.
    #[must_use]
    pub fn is_uniform(&self) -> bool {
        self.by_region.is_empty() && self.inclusions.is_empty()
    }

    /// Stiffness of a tet, averaged over it.
    #[must_use]
    pub fn of_tet(&self, mesh: &TetMesh, tet: &[u32; 4]) -> f64 {
        if self.by_region.is_empty() { ratio_of(mesh, tet, &self.inclusions) } else { blended(mesh, tet, |x| self.ratio_at(x)) }
    }

    fn region_at(&self, at_m: [f64; 3]) -> f64 {
        let Some(organ) = self.organ.as_ref().filter(|_| !self.by_region.is_empty()) else { return 1.0 };
        let id = organ.region_at(at_m);
        self.by_region.iter().find(|(region, _)| *region == id).map_or(1.0, |(_, ratio)| *ratio)
    }
}
