//! Cost of a rim treatment per tick: operations, bytes, time on this machine, and cycles on the
//! board.
//!
//! Cycles of treatments that are springs come from [`palpate_tissue::budget`]. Those of modes, low
//! rank and dense S are estimated from their operations, with 2.2 cycles per floating-point
//! operation and 2 per load or store; a factor that stays in registers counts as loaded once.

use super::timing::Times;
use super::{Setting, Size};
use crate::far_field::rim_method::RimMethod;
use crate::methods::{DenseRim, LowRankRim, ModeRim};
use palpate_tissue::budget::{CostModel, triangles_in_reach};
use palpate_tissue::patch::Patch;

const CYCLES_PER_FLOP: f64 = 2.2;
const CYCLES_PER_LOAD: f64 = 2.0;

/// Cost of a rim treatment, and of the whole tick with it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cost {
    /// Floating-point operations of the treatment per substep.
    pub rim_flops: usize,
    /// Bytes of constants that the treatment reads per substep.
    pub rim_bytes: usize,
    /// Time of a tick in the fastest batch on this machine [us]; `None` if the tick fails.
    pub tick_us: Option<f64>,
    /// Tick time relative to that with rim springs, from alternating batches (1).
    pub over_rim_springs: Option<f64>,
    /// Estimated cycles of the treatment per tick on a Cortex-M4F.
    pub rim_m4f_cycles: f64,
    /// Estimated cycles of the tick on a Cortex-M4F.
    pub tick_m4f_cycles: f64,
}

impl RimMethod {
    /// Floating-point operations per substep, and bytes of constants read per substep.
    #[must_use]
    pub fn work(self, rim_nodes: usize, rim_edges: usize) -> (usize, usize) {
        match self {
            Self::Fixed => (0, 0),
            // a symmetric block has six entries, to which a node index is added
            Self::Winkler => (18 * rim_nodes, 28 * rim_nodes),
            Self::Truncated | Self::RimSprings => (18 * rim_nodes + 36 * rim_edges, 28 * rim_nodes + 40 * rim_edges),
            Self::Modes(q) => ModeRim::cost(rim_nodes, q),
            Self::LowRank(q) => LowRankRim::cost(rim_nodes, q),
            Self::Dense => DenseRim::cost(rim_nodes),
        }
    }
}

/// Estimated cycles of a treatment per substep on a Cortex-M4F.
#[must_use]
pub fn m4f_rim_cycles(edge: RimMethod, rim_nodes: usize, rim_edges: usize) -> f64 {
    let machine = CostModel::named("m4f-168");
    let rim = |nodes: usize, edges: usize| machine.map_or(0.0, |m| m.rim(nodes, edges));
    let (flops, bytes) = edge.work(rim_nodes, rim_edges);
    let constants = bytes as f64 / 4.0;
    let freedoms = 3.0 * rim_nodes as f64;
    // loads and stores include, besides the constants, displacements or forces that are read and
    // forces or positions that are written
    let loads = match edge {
        RimMethod::Fixed => return 0.0,
        RimMethod::Winkler => return rim(rim_nodes, 0),
        RimMethod::Truncated | RimMethod::RimSprings => return rim(rim_nodes, rim_edges),
        RimMethod::Modes(_) | RimMethod::LowRank(_) => constants + 4.0 * freedoms,
        // the vector is too long for registers: one of its entries is loaded for every constant
        RimMethod::Dense => 2.0 * constants + 2.0 * freedoms,
    };
    CYCLES_PER_FLOP * flops as f64 + CYCLES_PER_LOAD * loads
}

impl Cost {
    pub(super) fn of(setting: &Setting, patch: &Patch, edge: RimMethod, size: Size, times: &Times) -> Self {
        let (rim_flops, rim_bytes) = edge.work(size.rim_nodes, size.rim_edges);
        let substeps = f64::from(setting.params.substeps);
        let rim_m4f_cycles = substeps * m4f_rim_cycles(edge, size.rim_nodes, size.rim_edges);
        let tick_us = times.of(edge);
        let over_rim_springs = tick_us.zip(times.of(RimMethod::RimSprings)).map(|(own, ours)| own / ours);
        let tick_m4f_cycles = bare_cycles(setting, patch) + rim_m4f_cycles;
        Self { rim_flops, rim_bytes, tick_us, over_rim_springs, rim_m4f_cycles, tick_m4f_cycles }
    }

    pub(super) fn whole(setting: &Setting, patch: &Patch, tick_us: Option<f64>) -> Self {
        let tick_m4f_cycles = bare_cycles(setting, patch);
        Self { rim_flops: 0, rim_bytes: 0, tick_us, over_rim_springs: None, rim_m4f_cycles: 0.0, tick_m4f_cycles }
    }
}

/// Estimated cycles per tick of a patch with nothing at its rim.
fn bare_cycles(setting: &Setting, patch: &Patch) -> f64 {
    let model = patch.model();
    let touched = triangles_in_reach(&model, patch.site_m().into(), setting.params.probe.reach_m());
    CostModel::named("m4f-168").map_or(0.0, |m| m.cost(&model, touched, setting.params.substeps).units)
}
