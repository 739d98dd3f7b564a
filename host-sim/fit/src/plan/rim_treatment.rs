//! Boundary condition at the cut edge of a patch. Rim springs are the product's; the cheaper
//! alternatives are tried as well, so that a plan never pays for springs that it does not need.

use palpate::Params;
use serde::Serialize;

use super::candidate::Weighed;
use crate::far_field::{FarField, RimSprings, springs};
use crate::statics::{Solver, Statics, Vector};
use palpate_tissue::patch::Patch;
use palpate_tissue::tissue::Tissue;

/// Treatment of the rim of a patch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum RimTreatment {
    /// One block per rim node and one per rim edge, fitted to the outside.
    RimSprings,
    /// Blocks on the rim nodes only, fitted to the outside: springs to the ground (Winkler's
    /// bedding).
    Bedded,
    /// The rim is fixed, as in the papers.
    Fixed,
    /// There is no rim, because the model is the whole block.
    Whole,
}

impl RimTreatment {
    /// Name in tables and charts.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::RimSprings => "rim springs",
            Self::Bedded => "springs to ground",
            Self::Fixed => "fixed edge",
            Self::Whole => "whole block",
        }
    }

    /// Tissue and rim springs of a patch with this rim treatment.
    #[must_use]
    pub fn applied(self, weighed: &Weighed) -> (Tissue, Option<RimSprings>) {
        let tissue = weighed.tissue().clone();
        let Some(far) = &weighed.far else { return (tissue, None) };
        match self {
            Self::RimSprings => (tissue, Some(far.springs.clone())),
            Self::Bedded => (tissue, Some(bedding(far))),
            Self::Fixed => {
                let mut anchors = [tissue.anchors.as_slice(), &far.cut.rim].concat();
                anchors.sort_unstable();
                anchors.dedup();
                (Tissue { anchors, ..tissue }, None)
            }
            Self::Whole => (tissue, None),
        }
    }

    /// Error of the shear stiffness of a disc as wide as the probe, glued to the site, that is due
    /// to the rim treatment alone [%]. The reference is a patch with the same unfitted springs and
    /// the exact condensed outside. Presses do not show this error. `None` if it cannot be solved;
    /// zero for a whole block.
    #[must_use]
    pub fn shear_error_pct(self, weighed: &Weighed) -> Option<f64> {
        let Some(far) = &weighed.far else { return Some(0.0) };
        let free = free(far, weighed, &weighed.params)?;
        let rim: Vec<usize> = far.cut.rim.iter().map(|n| *n as usize).collect();
        let own = match self {
            Self::RimSprings => free.with_rim(&rim, &springs::dense(&far.springs)),
            Self::Bedded => free.with_rim(&rim, &springs::dense(&bedding(far))),
            Self::Fixed => free.with_fixed(&rim),
            Self::Whole => return Some(0.0),
        };
        let exact = free.with_rim(&rim, &far.exact_m);
        let sheared = |statics: &Statics| {
            let across = palpate_tissue::organ::tangents(weighed.placed.axis)[0];
            let disc_m = f64::from(weighed.params.probe.radius_m);
            let site_m = Vector::from(far.cut.patch.site_m);
            Some(Solver::of(statics)?.glued(statics, site_m, disc_m, across.into()).ok()?.stiffness_m)
        };
        Some(100.0 * (sheared(&own)? / sheared(&exact)? - 1.0))
    }
}

fn free(far: &FarField, weighed: &Weighed, params: &Params) -> Option<Statics> {
    let patch = Patch::build(&far.cut.patch, &weighed.material, None);
    Statics::of(&patch.model(), params).ok()
}

/// Blocks at single rim nodes only, fitted to the response of the outside to the same loads.
fn bedding(far: &FarField) -> RimSprings {
    let mut bare = far.cut.clone();
    bare.outside.rim_triangles.clear();
    springs::fit(&bare, &far.exact_m, &far.answers_per_m)
}
