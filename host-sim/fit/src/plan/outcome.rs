//! Result of a search, and the explanation if it found nothing.

use palpate::Terms;

use super::candidate::Candidate;
use super::judged_candidate::JudgedCandidate;
use super::rim_treatment::RimTreatment;
use palpate_tissue::budget::CostModel;
use palpate_tissue::error::Error;

/// Result of a search.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// The smallest model that keeps the tolerance within the budget.
    pub chosen: Option<JudgedCandidate>,
    /// The next smaller model, which misses the tolerance.
    pub smaller: Option<JudgedCandidate>,
    /// The next larger model, which keeps the tolerance or exceeds the budget.
    pub larger: Option<JudgedCandidate>,
    /// Everything that was fitted, in that order.
    pub trials: Vec<JudgedCandidate>,
    /// Candidates that could not be fitted, pressed or run at all, with their edge and terms.
    pub unfitted: Vec<(Candidate, RimTreatment, Terms)>,
    /// If nothing was found: the cheapest that keeps the tolerance on a faster board.
    pub elsewhere: Option<JudgedCandidate>,
    /// If nothing was found: the best for this board.
    pub tightest: Option<JudgedCandidate>,
}

impl Outcome {
    /// The chosen one.
    ///
    /// # Errors
    /// There is none: names a board that would be fast enough, and the tolerance that this one
    /// keeps.
    pub fn check(&self, machine: &CostModel, tolerance_pct: f64) -> Result<&JudgedCandidate, Error> {
        if let Some(chosen) = &self.chosen {
            return Ok(chosen);
        }
        let faster = match &self.elsewhere {
            Some(trial) => {
                let cycles = machine.unit;
                let takes = format!("{} nodes do, in {:.0} {cycles} a tick", trial.counts.nodes, trial.units);
                match trial.slowest_board() {
                    Some(board) => format!("{takes}: {} runs them", board.name),
                    None => format!("{takes}: no named board runs them"),
                }
            }
            None => "no model that was tried does on any board".into(),
        };
        let looser = match &self.tightest {
            // rounded up, so that it can be used as a tolerance
            Some(trial) => format!("{} keeps {:.1} %", machine.name, (trial.keeps_pct * 10.0).ceil() / 10.0),
            None => format!("nothing that was tried runs on {}", machine.name),
        };
        Err(Error::Check(format!(
            "no model keeps {tolerance_pct} % within the {:.0} {} and the memory of {}; {faster}; {looser}",
            machine.budget(),
            machine.unit,
            machine.name
        )))
    }
}
