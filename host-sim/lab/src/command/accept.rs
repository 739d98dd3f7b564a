//! The command `palpate accept`.

use std::ops::Range;

use serde::Serialize;

use crate::accept::{Outcome, Picture, Row, TESTS, Test, table};
use palpate_charts::{self as charts, LineSeries, Lines, Scale, ScaledAxis};
use palpate_sim::command::campaign::Campaign;
use palpate_sim::command::options::accept::{AcceptArgs, AcceptOptions};
use palpate_sim::command::progress::Status;
use palpate_sim::command::verdict::Verdict;
use palpate_sim::error::Error;
use palpate_tissue::Error as TissueError;
use palpate_tissue::output::OutputFolder;

/// The campaign of the selected tests, each of which is a case.
pub(super) struct Accept {
    options: AcceptOptions,
    tests: Vec<Test>,
}

/// Contents of `summary.json`.
#[derive(Serialize)]
struct Summary<'a> {
    accepted: bool,
    rows: Vec<RowSummary<'a>>,
}

#[derive(Serialize)]
struct RowSummary<'a> {
    accepted: bool,
    #[serde(flatten)]
    row: &'a Row,
}

pub(super) fn run(args: &AcceptArgs) -> Result<(), Error> {
    Accept::start(args.options.clone(), &args.shards, &args.out)
}

impl Campaign for Accept {
    type Options = AcceptOptions;
    type Counts = Vec<Outcome>;
    const COMMAND: &'static str = "accept";

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
        let (first, count) = (cases.start as usize, (cases.end - cases.start) as usize);
        let status = Status::start();
        let run = |(name, what, test): &Test| {
            status.say(format!("{name}: against {what}"));
            Ok(test()?)
        };
        self.tests.iter().skip(first).take(count).map(run).collect()
    }

    fn add(outcomes: &mut Vec<Outcome>, next: Vec<Outcome>) {
        outcomes.extend(next);
    }

    fn report(&self, folder: OutputFolder, outcomes: Vec<Outcome>, all: bool) -> Result<(), Error> {
        outcomes.iter().flat_map(|outcome| &outcome.pictures).try_for_each(|picture| draw(&folder, picture))?;
        let rows: Vec<Row> = outcomes.into_iter().flat_map(|outcome| outcome.rows).collect();
        let summary = Summary {
            accepted: rows.iter().all(Row::accepted),
            rows: rows.iter().map(|row| RowSummary { accepted: row.accepted(), row }).collect(),
        };
        folder.write_summary(&summary)?;
        folder.write("accept.csv", csv(&rows).as_bytes())?;
        folder.write("against_reality.md", (table::HEAD.to_owned() + &table::lines(&rows).concat()).as_bytes())?;
        let verdict = Verdict::of(judge(&rows), || in_words(&rows))?.first();
        self.tests.iter().for_each(|(name, what, _)| println!("{name}: against {what}"));
        rows.iter().filter(|row| all || !row.accepted()).for_each(print);
        if !all {
            println!("\naccepted: every figure is in its range, and without the term that is tested at least one is not;");
            println!("behind each data set stands the figure that came nearest to an end of its range, ours first");
            rows.iter().filter(|row| row.accepted()).for_each(print_nearest);
            println!("--all prints the figures of each");
        }
        let out = folder.publish()?;
        println!(
            "\nwrote {}: summary.json, accept.csv, against_reality.md, a CSV and a picture of every data set as SVG and PNG",
            out.display()
        );
        verdict.last()
    }
}

fn judge(rows: &[Row]) -> Result<(), Error> {
    match rows.iter().find(|row| !row.accepted()) {
        None => Ok(()),
        Some(row) => Err(TissueError::Check(format!("{} is not accepted: {}", row.test, refusal(row))).into()),
    }
}

fn in_words(rows: &[Row]) -> String {
    let figures: usize = rows.iter().map(|row| row.figures.len()).sum();
    format!("all {} data sets accepted: {figures} figures within the ranges that were fixed beforehand", rows.len())
}

/// Says why a row is not accepted.
fn refusal(row: &Row) -> String {
    match row.figures.iter().find(|figure| !figure.holds()) {
        Some(figure) => {
            let [low, high] = figure.accepted;
            format!("{}, {}: {:.3}, where {low} to {high} is accepted", row.data, figure.what, figure.ours)
        }
        None => format!("{}: everything holds without {} as well, so it shows nothing", row.data, row.term),
    }
}

/// Prints the figure of a row that is nearest to the end of its range.
fn print_nearest(row: &Row) {
    let nearest = row.nearest().map_or(String::new(), |figure| {
        let [low, high] = figure.accepted;
        format!("; {}: {:.3}, where {low:.3} to {high:.3} is accepted", figure.what, figure.ours)
    });
    println!("  accepted  {} {}: {} figures{nearest}", row.test, row.data, row.figures.len());
}

fn print(row: &Row) {
    println!("\n{} {}: {}", row.test, row.data, if row.accepted() { "accepted" } else { "NOT accepted" });
    println!("  fitted     {}", row.fitted);
    println!("  predicted  {}", row.predicted);
    let without = format!("without {}", row.term);
    println!("  {:<40} {:>16} {:>8} {without:>20}", "", "accepted", "ours");
    for figure in &row.figures {
        let [low, high] = figure.accepted;
        let mark = |good: bool| if good { ' ' } else { '!' };
        // a value that rounds to zero is not printed as -0.000
        let without_term = if figure.without_term.abs() < 5e-4 { 0.0 } else { figure.without_term };
        println!(
            "  {:<40} {:>16} {:>7.3}{} {:>19.3}{}",
            figure.what,
            format!("{low:.3} .. {high:.3}"),
            figure.ours,
            mark(figure.holds()),
            without_term,
            mark(!figure.needs_term())
        );
    }
}

/// The table as CSV, one row per figure. Texts contain commas, so they are quoted.
fn csv(rows: &[Row]) -> String {
    let mut text = String::from("test,data,term,figure,low,high,ours,without_term,holds,needs_term\n");
    for row in rows {
        for figure in &row.figures {
            let [low, high] = figure.accepted;
            text.push_str(&format!(
                "{},\"{}\",{},\"{}\",{low},{high},{},{},{},{}\n",
                row.test,
                row.data,
                row.term,
                figure.what,
                figure.ours,
                figure.without_term,
                figure.holds(),
                figure.needs_term()
            ));
        }
    }
    text
}

fn draw(folder: &OutputFolder, picture: &Picture) -> Result<(), Error> {
    let mut text = String::from("curve,x,y\n");
    for curve in &picture.curves {
        for (x, y) in &curve.points {
            text.push_str(&format!("{},{x},{y}\n", curve.name.replace(',', ";")));
        }
    }
    folder.write(&format!("{}.csv", picture.name), text.as_bytes())?;
    let series: Vec<LineSeries> = picture
        .curves
        .iter()
        .map(|curve| LineSeries { name: &curve.name, points: curve.points.clone(), joined: true, marked: curve.measured })
        .collect();
    let axis = |title| ScaledAxis { title, scale: Scale::Linear };
    let [x, y] = picture.axes.each_ref().map(|title| axis(title));
    let lines = Lines { title: &picture.title, below: &picture.below, x, y, series: &series, levels: &[] };
    Ok(charts::lines(folder.draft(), &picture.name, &lines)?)
}
