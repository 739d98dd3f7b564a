//! Compares the model with raw measurements that others made, and with closed forms of contact. For
//! each data set it shows what is fitted, what is predicted, and what the same prediction is
//! without the term that is tested.
//!
//! A row is accepted if every figure lies where it was measured, and if at least one of them lies
//! elsewhere without the term: a test that passes either way says nothing about the term.

mod beef;
mod bench;
mod drag;
mod liver;
mod prony_fit;
mod retreat;
mod silicone;
mod stiffening_fit;
pub mod table;
mod uniform;

use std::borrow::Cow;

use palpate_tissue::shard::exact::or_null;
use serde::{Deserialize, Serialize};

use crate::Error;
pub use prony_fit::{PronyFit, fit as fit_prony};

/// One figure of a row.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Figure {
    /// Quantity and unit.
    pub what: String,
    /// Smallest and largest value that is accepted.
    pub accepted: [f64; 2],
    /// Value of the product; NaN if it has none.
    #[serde(deserialize_with = "or_null")]
    pub ours: f64,
    /// Value of the product without the term.
    #[serde(deserialize_with = "or_null")]
    pub without_term: f64,
}

impl Figure {
    /// Whether the product's value is accepted.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.accepts(self.ours)
    }

    /// Whether it is not accepted without the term.
    #[must_use]
    pub fn needs_term(&self) -> bool {
        !self.accepts(self.without_term)
    }

    // NaN is not accepted
    fn accepts(&self, value: f64) -> bool {
        self.accepted[0] <= value && value <= self.accepted[1]
    }
}

/// One row of the table "against reality".
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Short name.
    pub test: Cow<'static, str>,
    /// Data set.
    pub data: String,
    /// Source of the data.
    pub source: Cow<'static, str>,
    /// Term that is tested.
    pub term: Cow<'static, str>,
    /// Quantities that were fitted, and to what.
    pub fitted: String,
    /// Quantities that were predicted.
    pub predicted: String,
    /// Figures that decide.
    pub figures: Vec<Figure>,
}

impl Row {
    /// Every figure is accepted, and without the term not every one would be.
    #[must_use]
    pub fn accepted(&self) -> bool {
        self.figures.iter().all(Figure::holds) && self.figures.iter().any(Figure::needs_term)
    }
}

/// A curve of a picture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Curve {
    /// Name in the legend and in the CSV.
    pub name: String,
    /// Points in the units of the axes.
    pub points: Vec<(f64, f64)>,
    /// Measured, not computed.
    pub measured: bool,
}

/// The picture of a data set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Picture {
    /// File name without ending.
    pub name: String,
    /// First line.
    pub title: String,
    /// Second line.
    pub below: String,
    /// Quantity and unit of each axis.
    pub axes: [Cow<'static, str>; 2],
    /// Measured values, ours, and ours without the term.
    pub curves: Vec<Curve>,
}

/// Result of a test.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Rows of the table.
    pub rows: Vec<Row>,
    /// A picture of each data set.
    pub pictures: Vec<Picture>,
}

/// A test: its short name, one sentence for a progress line, and its function.
pub type Test = (&'static str, &'static str, fn() -> Result<Outcome, Error>);

/// Every test, in the order of the table.
pub const TESTS: [Test; 5] = [
    ("T1", "beef, indented and held", beef::run),
    ("T2", "pig liver, indented", liver::run),
    ("T3", "silicones, squeezed between plates", silicone::run),
    ("T4", "the closed form of a half-space that relaxes, pressed and released", retreat::run),
    ("T5", "the closed forms of friction, and a glued disc of finite elements", drag::run),
];
