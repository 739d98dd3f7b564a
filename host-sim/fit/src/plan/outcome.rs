//! Result of a search, with an explanation if it found no model.

use palpate::Terms;

use super::candidate::Candidate;
use super::judged_candidate::JudgedCandidate;
use super::rim_treatment::RimTreatment;
use palpate_tissue::budget::CostModel;
use palpate_tissue::error::Error;

/// Result of a search.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// The smallest model that meets the tolerance within the budget.
    pub chosen: Option<JudgedCandidate>,
    /// The next smaller model, which fails the tolerance.
    pub smaller: Option<JudgedCandidate>,
    /// The next larger model, which meets the tolerance or exceeds the budget.
    pub larger: Option<JudgedCandidate>,
    /// All trials, in the order in which they were fitted.
    pub trials: Vec<JudgedCandidate>,
    /// Candidates that could not be fitted, pressed or run, with their rim treatment and terms.
    pub unfitted: Vec<(Candidate, RimTreatment, Terms)>,
    /// If no model was chosen: the cheapest one that meets the tolerance on a faster board.
    pub elsewhere: Option<JudgedCandidate>,
    /// If no model was chosen: the most accurate one for this board.
    pub tightest: Option<JudgedCandidate>,
}

impl Outcome {
    /// Returns the chosen model.
    ///
    /// # Errors
    /// Fails if no model was chosen; the message names a board that would be fast enough, and the
    /// tolerance that this board reaches.
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
            // rounded up, so that the figure can be used as a tolerance
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
