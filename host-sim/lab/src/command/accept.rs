//! The command `palpate accept`.

use std::ops::Range;

use palpate_sim::command::options::accept::AcceptOptions;
use palpate_sim::command::progress::Status;
use palpate_sim::error::Error;
use serde::Serialize;

use crate::accept::{Figure, Outcome, Picture, Row, TESTS, Test, nearest};
use crate::study::{Claim, Findings, Study, Table};

/// The selected tests, each of which is a case.
pub(super) struct Accept {
    options: AcceptOptions,
    tests: Vec<Test>,
}

/// One figure of a data set.
#[derive(Serialize)]
struct FigureRow<'a> {
    test: &'a str,
    data: &'a str,
    term: &'a str,
    fitted: &'a str,
    predicted: &'a str,
    figure: &'a str,
    low: f64,
    high: f64,
    ours: f64,
    without_term: f64,
    holds: bool,
    needs_term: bool,
}

impl<'a> FigureRow<'a> {
    fn of(row: &'a Row, figure: &'a Figure) -> Self {
        let [low, high] = figure.accepted;
        Self {
            test: &row.test,
            data: &row.data,
            term: &row.term,
            fitted: &row.fitted,
            predicted: &row.predicted,
            figure: &figure.what,
            low,
            high,
            ours: figure.ours,
            without_term: figure.without_term,
            holds: figure.holds(),
            needs_term: figure.needs_term(),
        }
    }
}

impl Study for Accept {
    const ID: &'static str = "accept";
    type Options = AcceptOptions;
    type Row = Outcome;

    fn load(options: AcceptOptions) -> Result<Self, Error> {
        let asked = |name: &str| options.tests.is_empty() || options.tests.iter().any(|asked| asked == name);
        Ok(Self { tests: TESTS.into_iter().filter(|(name, ..)| asked(name)).collect(), options })
    }

    fn options(&self) -> &AcceptOptions {
        &self.options
    }

    fn cases(&self) -> u64 {
        self.tests.len() as u64
    }

    fn run(&self, cases: Range<u64>) -> Result<Vec<Outcome>, Error> {
        let status = Status::start();
        let run = |(name, what, test): &Test| {
            status.say(format!("{name}: against {what}"));
            Ok(test()?)
        };
        self.tests[cases.start as usize..cases.end as usize].iter().map(run).collect()
    }

    fn findings(&self, outcomes: Vec<Outcome>) -> Result<Findings, Error> {
        let rows: Vec<&Row> = outcomes.iter().flat_map(|outcome| &outcome.rows).collect();
        let figures: Vec<(&Row, FigureRow)> =
            rows.iter().flat_map(|row| row.figures.iter().map(|figure| (*row, FigureRow::of(row, figure)))).collect();
        let refused = figures.iter().map(|(row, _)| !row.accepted()).collect::<Vec<_>>();
        let figures: Vec<FigureRow> = figures.into_iter().map(|(_, figure)| figure).collect();
        Ok(Findings {
            headline: format!("{} data sets, {} figures", rows.len(), figures.len()),
            claims: rows.iter().map(|row| claim(row)).collect(),
            tables: vec![
                Table::of("accept", &figures)?.only(refused).columns(&[
                    "data",
                    "figure",
                    "low",
                    "high",
                    "ours",
                    "without_term",
                    "holds",
                    "needs_term",
                ]),
                Table::of("against_reality", &nearest(&outcomes))?.verbatim(),
            ],
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
    let name = format!("{} {}: {} as measured, with {}", row.test, row.data, row.predicted, row.term);
    Claim::promise(name, "in every range, and in not all of them without the term", found, row.accepted())
}
