//! Compares the model with raw measurements that others made, and with closed forms of contact. For
//! each data set it reports the fitted quantities, the predicted quantities, and the same
//! prediction without the term under test.
//!
//! A row is accepted if every figure is within its measured range and at least one of them leaves
//! its range when the term is switched off: a test that passes with and without the term says
//! nothing about the term.

mod beef;
mod bench;
mod drag;
mod liver;
mod retreat;
mod silicone;
mod uniform;

use std::borrow::Cow;

use palpate_charts as charts;
use serde::{Deserialize, Serialize};

use crate::Error;
use crate::study::{Table, number};

/// One figure of a row.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Figure {
    /// Quantity and unit.
    pub what: String,
    /// Smallest and largest value that is accepted.
    pub accepted: [f64; 2],
    /// Value computed by the product; NaN if it has none.
    #[serde(with = "number")]
    pub ours: f64,
    /// Value computed by the product without the term.
    #[serde(with = "number")]
    pub without_term: f64,
}

impl Figure {
    /// Whether the product's value is accepted.
    pub fn holds(&self) -> bool {
        self.accepts(self.ours)
    }

    /// Whether the value without the term is outside the accepted range.
    pub fn needs_term(&self) -> bool {
        !self.accepts(self.without_term)
    }

    /// Share of the accepted range that the product's value has used up (1): an error is best at
    /// zero, any other figure at the middle of its range.
    fn used(&self) -> f64 {
        match self.accepted {
            [0.0, high] => self.ours / high,
            [low, high] => ((self.ours - low.midpoint(high)) / (0.5 * (high - low))).abs(),
        }
    }

    // NaN is not accepted
    fn accepts(&self, value: f64) -> bool {
        self.accepted[0] <= value && value <= self.accepted[1]
    }
}

/// One row of the table "against reality".
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Short name of the test, such as "T1".
    pub test: Cow<'static, str>,
    /// Name of the data set.
    pub data: String,
    /// Source of the data.
    pub source: Cow<'static, str>,
    /// Term that is tested.
    pub term: Cow<'static, str>,
    /// Quantities that were fitted, and the data to which they were fitted.
    pub fitted: String,
    /// Quantities that were predicted.
    pub predicted: String,
    /// Figures on which acceptance depends.
    pub figures: Vec<Figure>,
}

impl Row {
    /// Whether every figure is accepted and at least one would not be without the term.
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
    /// Whether the points were measured rather than computed.
    pub measured: bool,
}

/// The picture of a data set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Picture {
    /// File name without its extension.
    pub name: String,
    /// First line of the heading.
    pub title: String,
    /// Second line of the heading.
    pub below: String,
    /// Quantity and unit of each axis.
    pub axes: [Cow<'static, str>; 2],
    /// Measured values, those of the product, and those of the product without the term.
    pub curves: Vec<Curve>,
}

/// Rows and pictures of a test.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Rows of the table.
    pub rows: Vec<Row>,
    /// One picture per data set.
    pub pictures: Vec<Picture>,
}

impl Picture {
    /// The picture as a chart.
    pub fn figure(&self) -> charts::Figure {
        let series = self.curves.iter().map(|curve| {
            let line = charts::Series::curve(curve.name.replace(',', ";"), curve.points.iter().copied());
            if curve.measured { line.marked() } else { line }
        });
        let [x, y] = self.axes.each_ref().map(|title| charts::ScaledAxis::linear(title.as_ref()));
        charts::Figure::plot(&self.name, &self.title, &self.below, charts::Plot::new(x, y, series.collect()))
    }
}

/// The table "against reality": the figure of each test that is nearest to a bound.
pub fn nearest(outcomes: &[Outcome]) -> Table {
    fn of_test(outcome: &Outcome) -> Option<(&Row, &Figure)> {
        let figures = outcome.rows.iter().flat_map(|row| row.figures.iter().map(move |figure| (row, figure)));
        figures.max_by(|(_, a), (_, b)| a.used().total_cmp(&b.used()))
    }
    Table::rows("against_reality", outcomes.iter().filter_map(of_test))
        .col("test", |(row, _)| row.test.to_string())
        .col("data", |(row, _)| row.data.clone())
        .col("figure nearest to its bound", |(_, figure)| figure.what.clone())
        .col("accepted", |(_, figure)| format!("{} to {}", figure.accepted[0], figure.accepted[1]))
        .col("ours", |(_, figure)| format!("{:.3}", figure.ours))
        .col("without the term", |(row, figure)| format!("{:.3} ({})", figure.without_term, row.term))
        .all()
}

/// A test: its short name, its description in a progress line, and its function.
pub type Test = (&'static str, &'static str, fn() -> Result<Outcome, Error>);

/// Every test, in the order of the table.
pub const TESTS: [Test; 5] = [
    ("T1", "beef, indented and held", beef::run),
    ("T2", "pig liver, indented", liver::run),
    ("T3", "silicones, squeezed between plates", silicone::run),
    ("T4", "the closed form of a half-space that relaxes, pressed and released", retreat::run),
    ("T5", "the closed forms of friction, and a glued disc of finite elements", drag::run),
];
