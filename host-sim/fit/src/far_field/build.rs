//! Makes a patch with its far field from a whole organ, with stiffnesses from formulas only;
//! [`crate::calibrate`] fits the patch afterwards.

use faer::Mat;
use palpate::Params;
use thiserror::Error;

use super::RimSprings;
use super::condense::condense;
use super::springs::{self, rim_answers};
use super::{Cut, CutError, Sizes};
use crate::statics::{Statics, Unbalanced};
use palpate_tissue::patch::{Material, Patch};
use palpate_tissue::tissue::Tissue;

/// Radius around the site within which surface nodes are loaded to find the response of the rim
/// [probe radii].
const LOADED_RADII: f64 = 1.5;

/// Reason why no patch with a far field could be made.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum FarFieldError {
    /// The patch cannot be cut out of the organ.
    #[error(transparent)]
    Cut(#[from] CutError),
    /// The outside cannot be condensed.
    #[error(
        "the outside of the patch cannot be condensed: part of it is fixed nowhere, or {tets} elements need more memory than there is: take larger elements"
    )]
    Outside {
        /// Number of elements of the outside.
        tets: usize,
    },
    /// The patch cannot be built.
    #[error("the patch cannot be built: {0}")]
    Build(#[from] palpate::BuildError),
    /// The stiffness of the patch with its far field is not positive definite at rest.
    #[error("the patch with its far field is not stiff at rest: {0}")]
    Loose(#[from] Unbalanced),
}

/// Far field of a patch, which replaces the rest of the organ.
#[derive(Clone, Debug)]
pub struct FarField {
    /// Patch and outside, as they were cut.
    pub cut: Cut,
    /// Stiffness of the outside over E [m], shape [3 rim nodes][3 rim nodes].
    pub exact_m: Mat<f64>,
    /// Rim displacements under unit forces on the surface [1/m], shape [3 rim nodes][loads].
    pub answers_per_m: Mat<f64>,
    /// Rim springs that the tick evaluates.
    pub springs: RimSprings,
}

impl FarField {
    /// Cuts a patch out of a whole organ and fits its rim springs.
    ///
    /// # Errors
    /// See [`FarFieldError`].
    pub fn of(whole: &Tissue, sizes: &Sizes, material: &Material, params: &Params) -> Result<Self, FarFieldError> {
        let cut = Cut::of(whole, sizes)?;
        let patch = Patch::build(&cut.patch, material, None);
        let free = Statics::of(&patch.model(), params)?;
        let tets = cut.outside.mesh.tets.len();
        let exact_m = condense(&cut.outside, material.poisson_ratio).ok_or(FarFieldError::Outside { tets })?;
        let reach_m = LOADED_RADII * f64::from(params.probe.radius_m);
        let answers_per_m = rim_answers(&free, &cut, &exact_m, reach_m)?;
        let springs = springs::fit(&cut, &exact_m, &answers_per_m);
        Ok(Self { cut, exact_m, answers_per_m, springs })
    }

    /// The uncalibrated patch with its rim springs.
    #[must_use]
    pub fn patch(&self, material: &Material) -> Patch {
        let mut patch = Patch::build(&self.cut.patch, material, None);
        patch.set_rim(&self.springs);
        patch
    }
}
