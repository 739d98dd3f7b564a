//! Our calibrated patch with its contact parameters tuned for the moving press by a search, as
//! those of the other engines are.
//!
//! The shipped patches have the contact dashpot that keeps the loop with a hand passive at one
//! substep per tick. With two or more substeps the masses need a lower floor, and a dashpot of a
//! whole substep is best for a fast probe. The search covered 3.5 and 20 kPa, 130, 410 and 1020
//! nodes, 1 to 32 substeps, dashpots of 0 to 1 substeps, and node damping of 0 to 80 /s. The
//! shipped node damping was best or within a tenth of the best.

use super::Peer;
use crate::chart::run::Run;
use crate::chart::{Reference, Task, measure};
use crate::error::Error;
use crate::methods::{Block, Method};

/// Number of nodes of the patch that the search found best.
const NODES: usize = 410;
/// Contact dashpot of that patch [substeps].
const CONTACT_DAMPING: f32 = 1.0;
/// Numbers of parts into which its substeps are split: two is best at 3.5 kPa, four at 20 kPa.
const REFINEMENTS: [u16; 2] = [2, 4];

/// Runs this patch at every stiffness that occurs both in `peers` and in `runs`.
pub fn searched(peers: &[Peer], runs: &[Run], reference: &Reference) -> Result<Vec<Run>, Error> {
    let mut moduli: Vec<f64> = peers.iter().map(|p| p.youngs_modulus_pa).collect();
    moduli.retain(|pa| runs.iter().any(|run| run.task.youngs_modulus_pa == *pa));
    moduli.sort_by(f64::total_cmp);
    moduli.dedup();
    let mut found = Vec::new();
    for youngs_modulus_pa in moduli {
        let Some(block) = Block::calibrated(NODES, youngs_modulus_pa) else { continue };
        let block = Block { contact_damping: Some(CONTACT_DAMPING), ..block };
        let task = |refinement| Task { method: Method::Calibrated, nodes: NODES, youngs_modulus_pa, refinement };
        found.extend(measure(&REFINEMENTS.map(task), &block, reference, true)?);
    }
    Ok(found)
}
