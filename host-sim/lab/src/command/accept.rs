//! The command `palpate accept`.

use std::ops::Range;

use palpate_sim::command::options::accept::AcceptOptions;
use palpate_sim::command::progress::Progress;
use palpate_sim::error::Error;

use crate::accept::{Figure, Outcome, Picture, Row, TESTS, Test, nearest};
use crate::study::{Claim, Findings, Study, Table};

/// The selected tests, each of which is a case.
pub(super) struct Accept {
    tests: Vec<Test>,
}

impl Accept {
    pub(super) fn of(options: &AcceptOptions) -> Self {
        let asked = |name: &str| options.tests.is_empty() || options.tests.iter().any(|asked| asked == name);
        Self { tests: TESTS.into_iter().filter(|(name, ..)| asked(name)).collect() }
    }
}

impl Study for Accept {
    type Row = Outcome;

    fn cases(&self) -> u64 {
        self.tests.len() as u64
    }

    fn run(&self, cases: Range<u64>) -> Result<Vec<(u64, Outcome)>, Error> {
        let status = Progress::start();
        let run = |case: u64| {
            let (name, what, test) = self.tests[case as usize];
            status.say(format!("{name}: against {what}"));
            Ok((case, test()?))
        };
        cases.map(run).collect()
    }

    fn findings(&self, outcomes: Vec<Outcome>) -> Result<Findings, Error> {
        let rows: Vec<&Row> = outcomes.iter().flat_map(|outcome| &outcome.rows).collect();
        let figures: Vec<(&Row, &Figure)> = rows.iter().flat_map(|row| row.figures.iter().map(|figure| (*row, figure))).collect();
        let count = figures.len();
        let figures = Table::rows("accept", figures)
            .csv("test", |(row, _)| row.test.to_string())
            .col("data", |(row, _)| row.data.clone())
            .csv("term", |(row, _)| row.term.to_string())
            .csv("fitted", |(row, _)| row.fitted.clone())
            .csv("predicted", |(row, _)| row.predicted.clone())
            .col("figure", |(_, figure)| figure.what.clone())
            .col("low", |(_, figure)| figure.accepted[0])
            .col("high", |(_, figure)| figure.accepted[1])
            .col("ours", |(_, figure)| figure.ours)
            .col("without_term", |(_, figure)| figure.without_term)
            .col("holds", |(_, figure)| figure.holds())
            .col("needs_term", |(_, figure)| figure.needs_term())
            .only(|(row, _)| !row.accepted());
        Ok(Findings {
            headline: format!("{} data sets, {} figures", rows.len(), count),
            claims: rows.iter().map(|row| claim(row)).collect(),
            tables: vec![figures, nearest(&outcomes).verbatim()],
            plotted: outcomes.iter().flat_map(|outcome| &outcome.pictures).map(Picture::figure).collect(),
            notes: self.tests.iter().map(|(name, what, _)| format!("{name}: against {what}")).collect(),
            ..Findings::default()
        })
    }
}

fn claim(row: &Row) -> Claim {
    let outside = row.figures.iter().find(|figure| !figure.holds()).map(|figure| {
        let [low, high] = figure.accepted;
        format!("{}: {:.3}, where {low} to {high} is accepted", figure.what, figure.ours)
    });
    let found = match outside {
        Some(outside) => outside,
        None if row.accepted() => format!("{} figures in their ranges", row.figures.len()),
        None => format!("everything holds without {} as well, so it shows nothing", row.term),
    };
    let bound = format!("every figure in its range, but not without {}", row.term);
    Claim::promise(format!("{} {}", row.test, row.data), bound, found, row.accepted())
}
