//! Cuts a patch out of the tissue of a scene: whole organ, cut and rim springs, before the fit.

use palpate::Params;

use super::whole::whole;
use super::{FarField, Sizes};
use palpate_tissue::error::Error;
use palpate_tissue::patch::{Material, Patch};
use palpate_tissue::scene::{Drive, Scene};
use palpate_tissue::tissue::Placed;

/// Smallest and largest allowed radius of a patch [probe radii].
const RADII: [f64; 2] = [1.25, 4.0];
/// Maximum number of nodes within the fine radius.
const MOST_FINE_NODES: f64 = 1000.0;

/// Depth of the deepest hold of a scene whose drive has given depths [m].
pub(crate) fn deepest_hold_m(scene: &Scene) -> Option<f64> {
    match &scene.drive {
        Drive::Depth { holds_m, .. } | Drive::Hand { holds_m, .. } => holds_m.iter().copied().reduce(f64::max),
        _ => None,
    }
}

/// Choices for making a patch from a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recipe {
    /// Sizes of the patch and of its elements.
    pub sizes: Sizes,
    /// Number of foundation points per triangle: 4, 9 or, except for boards, 16.
    pub points_per_triangle: usize,
}

impl Recipe {
    /// A patch of `radius_m` with elements of `fine_m` under a probe of `probe_radius_m`.
    #[must_use]
    pub fn new(radius_m: f64, fine_m: f64, probe_radius_m: f64) -> Self {
        Self {
            sizes: Sizes { radius_m, fine_m, fine_radius_m: probe_radius_m, growth: 0.45 },
            points_per_triangle: if fine_m > 0.4 * probe_radius_m { 9 } else { 4 },
        }
    }
}

/// The whole organ of a scene and the far field around a patch of it: all that is needed before the
/// fit.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// Mesh of the whole organ, with site and axis.
    pub placed: Placed,
    /// Far field of the patch: the cut and the rim springs.
    pub far: FarField,
    /// Constants of the material.
    pub material: Material,
    /// Parameters of the scene.
    pub params: Params,
}

impl Prepared {
    /// Meshes the organ, cuts the patch out and condenses the outside.
    ///
    /// # Errors
    /// Fails if scene, sizes or organ do not permit it.
    pub fn of(scene: &Scene, recipe: &Recipe) -> Result<Self, Error> {
        if scene.tissue.gravity_m_per_s2 != [0.0; 3] {
            return Ok(scene.bad(
                "tissue.gravity_m_per_s2",
                "is not zero: a far field carries no weight, take the shape under gravity as the rest shape",
            )?);
        }
        refuse_odd(scene, &recipe.sizes)?;
        refuse_too_fine(scene, &recipe.sizes)?;
        let placed = whole(scene, &[], &recipe.sizes)?;
        let params = scene.params(placed.axis);
        let material = Material {
            poisson_ratio: scene.tissue.poisson_ratio,
            points_per_triangle: recipe.points_per_triangle,
            ..Material::default()
        };
        let far = FarField::of(&placed.tissue, &recipe.sizes, &material, &params)
            .map_err(|cause| Error::Usage(format!("{}: {cause}", scene.file)))?;
        Ok(Self { placed, far, material, params })
    }

    /// The uncalibrated patch with its rim springs.
    #[must_use]
    pub fn patch(&self) -> Patch {
        self.far.patch(&self.material)
    }
}

/// Refuses a radius outside its range. A patch that is narrower than the spread of the contact is
/// wrong, however it is fitted; a much wider one costs as much as a whole organ.
pub(crate) fn refuse_odd(scene: &Scene, sizes: &Sizes) -> Result<(), Error> {
    let probe_m = scene.probe.radius_m;
    let [least_m, most_m] = RADII.map(|radii| radii * probe_m);
    // a small tolerance for rounding in products of decimal numbers
    if !((1.0 - 1e-9) * least_m..=(1.0 + 1e-9) * most_m).contains(&sizes.radius_m) {
        return Err(Error::Usage(format!(
            "{}: a patch of {} m around a probe of {probe_m} m: give a radius of {least_m:.4} to {most_m:.4} m",
            scene.file, sizes.radius_m
        )));
    }
    if !(sizes.fine_m.is_finite() && sizes.fine_m > 0.0) {
        return Err(Error::Usage(format!("{}: elements of {} m: give a length above zero", scene.file, sizes.fine_m)));
    }
    Ok(())
}

/// Refuses elements so small that meshing would take minutes; such a mesh is also too large for any
/// board.
fn refuse_too_fine(scene: &Scene, sizes: &Sizes) -> Result<(), Error> {
    // estimate for regular tets in half a ball, with sqrt(2) nodes per cube of the edge length
    let half_ball_m3 = 2.0 / 3.0 * std::f64::consts::PI * sizes.fine_radius_m.min(sizes.radius_m).powi(3);
    let nodes = half_ball_m3 * std::f64::consts::SQRT_2 / sizes.fine_m.powi(3);
    if nodes <= MOST_FINE_NODES {
        return Ok(());
    }
    let least_m = sizes.fine_m * (nodes / MOST_FINE_NODES).cbrt();
    Err(Error::Usage(format!(
        "{}: elements of {} m put about {nodes:.0} nodes under the probe alone: give at least {least_m:.5} m",
        scene.file, sizes.fine_m
    )))
}
