//! `palpate accept`.

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use crate::error::Error;
use palpate_charts::{self as charts, LineSeries, Lines, Scale, ScaledAxis};
use palpate_lab::accept::{Outcome, Picture, Row, TESTS};
use palpate_tissue::Error as TissueError;
use palpate_tissue::output::OutputFolder;

#[derive(Args, Clone, Debug)]
pub(super) struct AcceptArgs {
    /// Run these tests alone [default: all].
    #[arg(value_name = "TEST", value_parser = TESTS.map(|(name, ..)| name))]
    tests: Vec<String>,
    /// Output folder, made if it is not there; replaces an earlier result in it when the run is
    /// done.
    #[arg(long, value_name = "FOLDER", default_value = "out/accept")]
    out: PathBuf,
}

/// `summary.json`.
#[derive(Serialize)]
struct Summary<'a> {
    accepted: bool,
    machine: String,
    build: String,
    command: Vec<String>,
    rows: Vec<RowSummary<'a>>,
}

#[derive(Serialize)]
struct RowSummary<'a> {
    accepted: bool,
    #[serde(flatten)]
    row: &'a Row,
}

impl AcceptArgs {
    pub(super) fn run(&self) -> Result<(), Error> {
        let folder = OutputFolder::open(&self.out)?;
        let mut rows = Vec::new();
        for (name, what, test) in TESTS {
            if !self.tests.is_empty() && !self.tests.iter().any(|asked| asked == name) {
                continue;
            }
            println!("{name}: against {what}");
            let Outcome { rows: found, pictures } = test()?;
            for picture in &pictures {
                draw(&folder, picture)?;
            }
            rows.extend(found);
        }
        rows.iter().for_each(print);
        let summary = Summary {
            accepted: rows.iter().all(Row::accepted),
            machine: palpate_tissue::machine::processor(),
            build: palpate_tissue::machine::build(),
            command: std::env::args().collect(),
            rows: rows.iter().map(|row| RowSummary { accepted: row.accepted(), row }).collect(),
        };
        folder.write_json("summary.json", &summary)?;
        folder.write("accept.csv", csv(&rows).as_bytes())?;
        let out = folder.publish()?;
        println!("\nwrote {}: summary.json, accept.csv, a CSV and a picture of every data set as SVG and PNG", out.display());
        match rows.iter().find(|row| !row.accepted()) {
            None => Ok(()),
            Some(row) => Err(TissueError::Check(format!("{} is not accepted: {}", row.test, refusal(row))).into()),
        }
    }
}

/// Why a row is not accepted.
fn refusal(row: &Row) -> String {
    match row.figures.iter().find(|figure| !figure.holds()) {
        Some(figure) => {
            let [low, high] = figure.accepted;
            format!("{}, {}: {:.3}, {low} to {high} are accepted", row.data, figure.what, figure.ours)
        }
        None => format!("{}: everything holds without {} as well, so it shows nothing", row.data, row.term),
    }
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
        // rounding below zero is not shown as -0.000
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

/// One row a figure. Texts hold commas: they are quoted.
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
    let [x, y] = picture.axes.map(axis);
    let lines = Lines { title: &picture.title, below: &picture.below, x, y, series: &series, levels: &[] };
    Ok(charts::lines(folder.draft(), &picture.name, &lines)?)
}
