//! Presses a patch at places around its own site, to evaluate its forces.

use palpate::Params;

use crate::statics::{Balance, CLEAR_M, Solver, Statics, Unbalanced, Vector};
use palpate_tissue::patch::Patch;

/// A patch in static equilibrium, ready to be pressed.
#[derive(Debug)]
pub struct PressedPatch {
    /// Static model of the patch.
    pub statics: Statics,
    /// Solver for the equilibrium of the patch.
    pub solver: Solver,
    /// Site of the patch [m].
    pub site_m: Vector,
    rest: Balance,
}

/// Error of a press that could not even begin.
pub(crate) const NOT_BEGUN: Unbalanced = Unbalanced { depth_mm: 0.0, steps: 0 };

impl PressedPatch {
    /// Brings a patch to rest under a probe that does not touch it yet.
    ///
    /// # Errors
    /// Fails if the patch has no equilibrium.
    pub fn of(patch: &Patch, params: &Params) -> Result<Self, Unbalanced> {
        // places are pressed in parallel; a single factorisation is too small to be parallelised
        faer::set_global_parallelism(faer::Par::Seq);
        let statics = Statics::of(&patch.model(), params).map_err(|_| NOT_BEGUN)?;
        let solver = Solver::of(&statics).ok_or(NOT_BEGUN)?;
        let site_m: Vector = patch.site_m().cast();
        let rest = solver.rest(&statics, site_m, CLEAR_M)?;
        Ok(Self { statics, solver, site_m, rest })
    }

    /// Presses at an offset from the site [m] to ascending depths [m]; returns the result of `of`
    /// for each depth and its equilibrium.
    ///
    /// # Errors
    /// Fails if a press has no equilibrium.
    pub fn press<T>(
        &self,
        offset_m: Vector,
        depths_m: impl IntoIterator<Item = f64>,
        of: impl FnMut(f64, &Balance) -> T,
    ) -> Result<Vec<T>, Unbalanced> {
        let (found, lost) = self.press_while_balanced(offset_m, depths_m, of);
        lost.map_or(Ok(found), Err)
    }

    /// Like [`Self::press`], but if a press has no equilibrium, also returns the results of the
    /// shallower ones.
    pub fn press_while_balanced<T>(
        &self,
        offset_m: Vector,
        depths_m: impl IntoIterator<Item = f64>,
        mut of: impl FnMut(f64, &Balance) -> T,
    ) -> (Vec<T>, Option<Unbalanced>) {
        let (place_m, axis) = (self.site_m + offset_m, self.statics.axis());
        let mut here = self.rest.with_tip(place_m + axis * CLEAR_M);
        let mut found = Vec::new();
        for depth_m in depths_m {
            match self.solver.press(&self.statics, &here, place_m - axis * depth_m, depth_m) {
                Ok(next) => here = next,
                Err(unbalanced) => return (found, Some(unbalanced)),
            }
            found.push(of(depth_m, &here));
        }
        (found, None)
    }
}

/// Relative error of a force [%].
#[must_use]
pub(crate) fn error_pct(found: f64, wanted: f64) -> f64 {
    100.0 * (found / wanted - 1.0)
}

/// Root mean square of the errors; zero for an empty list.
#[must_use]
pub(crate) fn rms(errors: &[f64]) -> f64 {
    (errors.iter().map(|e| e * e).sum::<f64>() / errors.len().max(1) as f64).sqrt()
}

/// The error with the largest magnitude, with its sign; zero for an empty list.
#[must_use]
pub(crate) fn worst(errors: &[f64]) -> f64 {
    errors.iter().copied().fold(0.0, larger)
}

/// The error with the larger magnitude, with its sign.
#[must_use]
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if b.abs() > a.abs() { b } else { a }
}
