//! Bound on the cost of a tick, from the sizes of a patch: the board's own estimate, independent of
//! the figures in the file.
//!
//! Cycles per item are instruction counts from the emulator times the Cortex-M4F's documented cycle
//! table, **not hardware cycles**; `palpate pack` plans with the same figures. The host packs to 65
//! % of a tick; a board refuses from 75 % on, so that no patch is refused because of rounding, and
//! a quarter of the tick remains for the haptic cycle, the link and interrupts.

use palpate::{BuildError, PatchFile};

/// Parameter of [`BuildError::OutOfRange`] for a patch that costs too much.
pub const COST: &str = "cycles per tick of the patch";

/// Cycles of a Cortex-M4F per item and substep.
const SPRING: f32 = 80.0;
/// Added per spring if the mass floor acts on the motion relative to neighbours.
const NEIGHBOUR: f32 = 70.0;
/// Added per node in that case, for the smooth fields.
const SMOOTH: f32 = 110.0;
/// Added per node if there are smooth fields, but no sum over neighbours.
const FIELD: f32 = 34.0;
const TET: f32 = 215.0;
const NODE: f32 = 130.0;
/// Added per node of tissue with relaxation, and per node and term of it.
const RELAXING: f32 = 50.0;
const TERM: f32 = 30.0;
/// Added per triangle that the probe presses, if the probe has friction.
const RUBBED: f32 = 240.0;
const RIM_NODE: f32 = 75.0;
const RIM_EDGE: f32 = 99.0;
/// A triangle that the probe presses, with four foundation points.
const TOUCHED: f32 = 840.0;
/// Each further foundation point on such a triangle.
const EXTRA_POINT: f32 = 160.0;
/// A triangle in the broad phase of contact, per tick.
const PASSED: f32 = 61.0;
/// Constant part, per tick.
const TICK: f32 = 2_300.0;

/// Cycles that a board has for the patch in each tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Budget {
    /// Largest accepted cost per tick [cycles].
    pub cycles: f32,
}

/// Share of a tick that a patch may take.
const LOAD: f32 = 0.75;

impl Budget {
    /// A Cortex-M4F at 168 MHz.
    pub const M4F_168: Self = Self { cycles: LOAD * 168e3 };
    /// A Cortex-M7 at 480 MHz, by the M4F's cycle table, since none is public for the M7. Dual
    /// issue can only make the M7 faster.
    pub const M7_480: Self = Self { cycles: LOAD * 480e3 };

    /// Refuses a patch whose costliest tick, with this many triangles under the probe, exceeds the
    /// budget; returns its cycles otherwise.
    ///
    /// # Errors
    /// [`BuildError::OutOfRange`] with [`COST`].
    pub fn check(&self, file: &PatchFile<'_>, touched: usize) -> Result<f32, BuildError> {
        let cycles = cycles(file, touched);
        BuildError::within(COST, cycles, 0.0, self.cycles).map(|()| cycles)
    }
}

/// Cycles per tick with this many triangles under the probe.
#[must_use]
pub fn cycles(file: &PatchFile<'_>, touched: usize) -> f32 {
    let model = &file.model;
    let of = |count: usize, each: f32| count as f32 * each;
    let points = model.points_per_triangle().saturating_sub(4);
    let terms = &file.params.terms;
    let (spring, node) = match (terms.relative_mass, terms.smooth_mass) {
        (true, _) => (SPRING + NEIGHBOUR, NODE + SMOOTH),
        (false, true) => (SPRING, NODE + FIELD),
        (false, false) => (SPRING, NODE),
    };
    let terms = file.params.relaxation.iter().filter(|term| term.share > 0.0).count();
    let node = node + if terms > 0 { RELAXING + of(terms, TERM) } else { 0.0 };
    let rubbed = if file.params.friction > 0.0 { RUBBED } else { 0.0 };
    let substep = of(model.springs.len(), spring)
        + of(model.tets.len(), TET)
        + of(model.nodes.len(), node)
        + of(model.rim_nodes.len(), RIM_NODE)
        + of(model.rim_edges.len(), RIM_EDGE)
        + of(touched, TOUCHED + of(points, EXTRA_POINT) + rubbed);
    TICK + of(model.triangles.len(), PASSED) + f32::from(file.params.substeps) * substep
}

#[cfg(test)]
mod tests;
