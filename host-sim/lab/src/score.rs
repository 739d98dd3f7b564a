//! Training score of paper 004, section 3.6: three physicians mark every intern before and after
//! the training, and their marks are combined into one value per intern.
//!
//! Equation (14): `y_i = sum_j x_ij / 10 * w_j`, with marks `x_ij` from 0 to 10 and weights of 0.45
//! for the chief, 0.35 for the associate chief and 0.20 for the attending physician. The paper
//! compares the groups by inspection; here a permutation test gives the probability that chance
//! alone explains a difference ([`statistics`]).

mod analysis;
mod error;
mod read;
pub mod statistics;
pub mod table_1;

pub use analysis::{Analysis, Cell, Change, Contrast};
pub use error::ScoreError;
pub use read::{Marks, parse, read};

use serde::Serialize;

/// Highest mark that a physician can give.
pub const FULL_MARK: f64 = 10.0;

/// Time at which marks were given.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Phase {
    /// Before the training.
    Before,
    /// After the training.
    After,
}

impl Phase {
    /// Both phases, in order.
    pub const ALL: [Self; 2] = [Self::Before, Self::After];

    /// Name in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Before => "before",
            Self::After => "after",
        }
    }
}

/// Share of each physician in the value: chief, associate chief, attending.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Weights([f64; 3]);

impl Weights {
    /// The weights of paper 004.
    pub const PAPER: Self = Self([0.45, 0.35, 0.20]);

    /// Creates weights from shares that are above zero and sum to 1.
    ///
    /// # Errors
    /// A share is not above zero, or the sum is not 1 within 1e-9.
    pub fn new(shares: [f64; 3]) -> Result<Self, ScoreError> {
        let sum: f64 = shares.iter().sum();
        let positive = shares.iter().all(|w| *w > 0.0);
        if positive && (sum - 1.0).abs() <= 1e-9 { Ok(Self(shares)) } else { Err(ScoreError::Weights { shares, sum }) }
    }

    /// Reads three numbers that are separated by commas.
    ///
    /// # Errors
    /// Fails if the text is not three numbers, and for the reasons of [`Self::new`].
    pub fn parse(text: &str) -> Result<Self, ScoreError> {
        let shares: Option<Vec<f64>> = text.split(',').map(|w| w.trim().parse().ok()).collect();
        let shares = shares.and_then(|s| s.try_into().ok());
        Self::new(shares.ok_or_else(|| ScoreError::WeightsUnread { text: text.into() })?)
    }

    /// Shares of the chief, the associate chief and the attending physician.
    #[must_use]
    pub fn shares(&self) -> [f64; 3] {
        self.0
    }

    /// Equation (14): the value, from 0 to 1, that follows from marks from 0 to 10.
    #[must_use]
    pub fn value(&self, marks: [f64; 3]) -> f64 {
        marks.iter().zip(self.0).map(|(x, w)| x / FULL_MARK * w).sum()
    }
}

/// The value of one intern in one phase.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Evaluation {
    /// Label of the group.
    pub group: String,
    /// Before or after the training.
    pub phase: Phase,
    /// Label of the intern, unique in the group.
    pub intern: String,
    /// Value `y_i`, from 0 to 1.
    pub value: f64,
}

/// Evaluates equation (14) for every row.
#[must_use]
pub fn evaluate(marks: &[Marks], weights: &Weights) -> Vec<Evaluation> {
    let one = |m: &Marks| Evaluation {
        group: m.group.clone(),
        phase: m.phase,
        intern: m.intern.clone(),
        value: weights.value(m.marks),
    };
    marks.iter().map(one).collect()
}
