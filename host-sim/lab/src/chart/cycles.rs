//! Estimated cost of a tick on a Cortex-M4F.
//!
//! For our methods the estimate is the model of [`palpate_tissue::budget`], which rests on exact
//! instruction counts. For other methods it is the number of floating-point operations counted in
//! their sources times [`CYCLES_PER_FLOP`], plus the core's own figures for nodes and contact where
//! the method runs on the core. None of these methods was run on a board.

use crate::methods::{Block, Corotational, Meshless, Method, NeoHookean, Xpbd};
use palpate_tissue::budget::{CostModel, triangles_in_reach};
use palpate_tissue::patch::{Material, Patch};

/// Cycles per floating-point operation including its loads and stores, from our own tet kernel (291
/// cycles for about 100 operations).
pub const CYCLES_PER_FLOP: f64 = 2.9;
/// Cycles of a whole tick of the image with a law, the haptic cycle and the board's own part
/// included: 38 us at 168 MHz, as `palpate emulate` estimates it.
const LAW_CYCLES: f64 = 6400.0;
/// Operations to convert a node's position and force between the core and a method.
const KICK_FLOPS: f64 = 12.0;

/// Operations of the damper and of one correction per spring; a root or a division counts as ten.
const DAMPER_FLOPS: f64 = 45.0;
const CORRECTION_FLOPS: f64 = 50.0;

/// Estimated cycles of a tick on a Cortex-M4F at 168 MHz; `solver_flops` is the count of
/// [`crate::methods::RunningMethod::solver_flops`].
pub fn m4f_cycles(method: Method, block: &Block, substeps: u16, solver_flops: f64) -> Option<f64> {
    let machine = CostModel::named("m4f-168")?;
    let patch = Patch::build(&block.tissue, &Material::default(), None);
    let model = patch.wide_model();
    let touched = triangles_in_reach(&model, patch.site_m().into(), block.params.probe.reach_m());
    let bare = |springs: bool| palpate::Model { springs: if springs { model.springs } else { &[] }, tets: &[], ..model };
    let size = block.size();
    let (tets, edges, nodes, steps) = (size.tets as f64, size.edges as f64, size.nodes as f64, f64::from(substeps));
    let on_core = |flops: f64| {
        let core = machine.cost(&bare(false), touched, substeps).units;
        core + steps * CYCLES_PER_FLOP * (flops + nodes * KICK_FLOPS)
    };
    Some(match method {
        Method::Springs => machine.cost(&bare(true), touched, substeps).units,
        Method::VolumePreserved | Method::LocalCompression => {
            let passes = if method == Method::VolumePreserved { DAMPER_FLOPS + 2.0 * CORRECTION_FLOPS } else { CORRECTION_FLOPS };
            machine.cost(&bare(true), touched, substeps).units + steps * CYCLES_PER_FLOP * edges * passes
        }
        Method::SpringsVolumeTet | Method::SpringsVolumeNodal | Method::Palpate | Method::Calibrated => {
            machine.cost(&model, touched, substeps).units
        }
        Method::Law => LAW_CYCLES,
        Method::Corotational => on_core(tets * Corotational::FLOPS_PER_TET),
        Method::NeoHookean => on_core(tets * NeoHookean::FLOPS_PER_TET),
        Method::NeoHookeanNodal => on_core(tets * (NeoHookean::FLOPS_PER_TET + NeoHookean::FLOPS_NODAL)),
        Method::Meshless => {
            let parts = Meshless::new(block).ok()?.parts() as f64;
            on_core(tets * Meshless::FLOPS_PER_CELL + parts * Meshless::FLOPS_PER_PART)
        }
        Method::Xpbd => on_core(edges * Xpbd::FLOPS[0] + tets * Xpbd::FLOPS[1]),
        Method::Implicit => CYCLES_PER_FLOP * (solver_flops + steps * (tets * Corotational::FLOPS_PER_TET + nodes * 30.0)),
        Method::Compliance => CYCLES_PER_FLOP * solver_flops,
    })
}
