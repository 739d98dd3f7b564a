//! The table "against reality" as Markdown, one line per test.

use super::{Figure, Row};

/// Head of the table. Each test is represented by the figure that is closest to a bound of its
/// accepted range.
pub const HEAD: &str =
    "| test | data | figure nearest to its bound | accepted | ours | without the term |\n|---|---|---|---|---|---|\n";

impl Figure {
    /// Share of the accepted range that the product's value has used up (1): an error is best at
    /// zero, any other figure at the middle of its range.
    #[must_use]
    pub fn used(&self) -> f64 {
        match self.accepted {
            [0.0, high] => self.ours / high,
            [low, high] => ((self.ours - low.midpoint(high)) / (0.5 * (high - low))).abs(),
        }
    }
}

impl Row {
    /// The figure closest to a bound of its accepted range.
    #[must_use]
    pub fn nearest(&self) -> Option<&Figure> {
        self.figures.iter().max_by(|a, b| a.used().total_cmp(&b.used()))
    }
}

/// One line of the table for each test in `rows`.
#[must_use]
pub fn lines(rows: &[Row]) -> Vec<String> {
    let tests = rows.chunk_by(|a, b| a.test == b.test);
    let nearest = |of_test: &[Row]| {
        let figures = of_test.iter().filter_map(|row| Some((row, row.nearest()?)));
        figures.max_by(|(_, a), (_, b)| a.used().total_cmp(&b.used())).map(|(row, figure)| line(row, figure))
    };
    tests.filter_map(nearest).collect()
}

fn line(row: &Row, figure: &Figure) -> String {
    let [low, high] = figure.accepted;
    let (what, ours, without, term) = (&figure.what, figure.ours, figure.without_term, &row.term);
    format!("| {} | {} | {what} | {low} to {high} | {ours:.3} | {without:.3} ({term}) |\n", row.test, row.data)
}
