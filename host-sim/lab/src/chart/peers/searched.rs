//! Our calibrated patch with its contact parameters searched for the moving press, as those of the
//! peers are.
//!
//! The shipped patches have the dashpot that keeps the loop passive with a hand at one substep.
//! With two or more the masses need less floor, and a dashpot of a whole substep is best for a fast
//! probe. Tried at 3.5 and 20 kPa: 130, 410 and 1020 nodes, 1 to 32 substeps, dashpots of 0 to 1
//! substeps, node damping of 0 to 80 /s. The shipped node damping was best or within a tenth of the
//! best.

use super::Peer;
use crate::chart::run::Run;
use crate::chart::{Reference, Task, measure};
use crate::error::Error;
use crate::methods::{Block, Method};

/// Nodes of the patch found by the search.
const NODES: usize = 410;
/// Contact dashpot of that patch [substeps].
const CONTACT_DAMPING: f32 = 1.0;
/// Factors by which its substeps are split: two is best at 3.5 kPa, four at 20 kPa.
const REFINEMENTS: [u16; 2] = [2, 4];

/// Runs the patch of the search at every stiffness that the peers have and `runs` has too.
///
/// # Errors
/// A method that cannot be built.
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
