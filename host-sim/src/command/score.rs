//! The command `palpate score`.

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use super::verdict::Verdict;
use crate::error::Error;
use crate::provenance;
use palpate_charts::{self as charts, PersonValue};
use palpate_lab::score::{Analysis, Evaluation, Phase, Weights, evaluate, read, table_1};
use palpate_tissue::Error as TissueError;
use palpate_tissue::output::OutputFolder;

#[derive(Args, Clone, Debug)]
pub(super) struct ScoreArgs {
    /// Marks as CSV with the header group,phase,intern,chief,associate,attending; phase is before
    /// or after, and marks are between 0 and 10.
    #[arg(value_name = "FILE", required_unless_present = "table_1", conflicts_with = "table_1")]
    file: Option<PathBuf>,
    /// Weights of chief, associate chief and attending physician, each above zero, with sum 1
    /// [default: 0.45,0.35,0.20].
    #[arg(long, value_name = "W,W,W", conflicts_with = "table_1", allow_hyphen_values = true)]
    weights: Option<String>,
    /// Instead of a file, check the equation against the 40 values printed in Table 1 of paper 004.
    #[arg(long = "table-1")]
    table_1: bool,
    /// Output folder, created if missing; a finished run replaces an earlier result in it.
    #[arg(long, value_name = "FOLDER", default_value = "out/score")]
    out: PathBuf,
}

/// Contents of `summary.json`.
#[derive(Serialize)]
struct Summary<'a> {
    source: &'a str,
    weights: Weights,
    test: &'static str,
    #[serde(flatten)]
    found: &'a Analysis,
    #[serde(skip_serializing_if = "Option::is_none")]
    table_1: Option<&'a table_1::Check>,
}

const TEST: &str = "permutation test of the difference of means, two-sided";

impl ScoreArgs {
    pub(super) fn run(&self) -> Result<(), Error> {
        let weights = self.weights.as_deref().map_or(Ok(Weights::PAPER), Weights::parse)?;
        if let Some(file) = &self.file {
            // the file is read and checked completely before the folder is changed
            let values = evaluate(&read(file)?, &weights);
            let source = file.display().to_string();
            let found = self.write(&source, weights, &values, None)?;
            let verdict = Verdict::ok(format!("{} evaluations of {source} weighed and compared", values.len())).first();
            print_found(&found);
            self.say_where();
            return verdict.last();
        }
        let check = table_1::Check::run(&weights);
        self.write("paper 004, Table 1", weights, &table_1::evaluations(), Some(&check))?;
        let broken = check.claims().into_iter().find(|(_, holds)| !holds);
        let held = broken.map_or(Ok(()), |(claim, _)| Err(TissueError::Check(format!("Table 1: {claim}"))));
        let verdict = Verdict::of(held, || "the equation gives what Table 1 prints".into())?.first();
        print_check(&check);
        self.say_where();
        verdict.last()
    }

    fn say_where(&self) {
        println!("\nwrote {}: summary.json, scores.csv, scores.svg, scores.png", self.out.display());
    }

    fn write(
        &self,
        source: &str,
        weights: Weights,
        values: &[Evaluation],
        check: Option<&table_1::Check>,
    ) -> Result<Analysis, Error> {
        let folder = OutputFolder::open(&self.out)?.made_by(provenance::of(None));
        let found = Analysis::of(values);
        let [chief, associate, attending] = weights.shares();
        let below = format!("bars are means; weights {chief}, {associate}, {attending}; {source}");
        let drawn: Vec<PersonValue> = values.iter().map(drawn).collect();
        charts::before_after(folder.draft(), "scores", &below, &drawn)?;
        folder.write("scores.csv", csv(values).as_bytes())?;
        folder.write_summary(&Summary { source, weights, test: TEST, found: &found, table_1: check })?;
        folder.publish()?;
        Ok(found)
    }
}

fn drawn(one: &Evaluation) -> PersonValue<'_> {
    let phase = match one.phase {
        Phase::Before => charts::Phase::Before,
        Phase::After => charts::Phase::After,
    };
    PersonValue { group: &one.group, person: &one.intern, phase, value: one.value }
}

/// The table as CSV. Labels may contain commas and quotes, so they are quoted as in the input.
fn csv(values: &[Evaluation]) -> String {
    let cell = |label: &str| {
        let plain = !label.contains([',', '"', '\n', '\r', '#']);
        if plain { label.to_owned() } else { format!("\"{}\"", label.replace('"', "\"\"")) }
    };
    let mut text = String::from("group,phase,intern,value\n");
    for v in values {
        // rounded to the digits above the rounding error of a sum of three products
        let value = (v.value * 1e12).round() / 1e12;
        text.push_str(&format!("{},{},{},{value}\n", cell(&v.group), v.phase.name(), cell(&v.intern)));
    }
    text
}

fn print_found(found: &Analysis) {
    println!("scores of (14), from 0 to 1; change is after less before");
    println!("{:<12} {:<7} {:>6} {:>6} {:>6} {:>6} {:>6}", "group", "phase", "count", "mean", "sd", "min", "max");
    let rows = found.cells.iter().map(|c| (&c.group, c.phase.name(), c.spread));
    for (group, phase, s) in rows.chain(found.changes.iter().map(|c| (&c.group, "change", c.spread))) {
        let sd = s.sd.map_or("-".into(), |sd| format!("{sd:.3}"));
        println!("{group:<12} {phase:<7} {:>6} {:>6.3} {sd:>6} {:>6.3} {:>6.3}", s.count, s.mean, s.min, s.max);
    }
    for c in &found.contrasts {
        let deals = if c.test.exact { "all" } else { "drawn" };
        let (what, first, second, p) = (c.what, &c.first, &c.second, c.test.p);
        println!(
            "{what}: {first} - {second} = {:+.3}, permutation test p = {} ({} deals, {deals})",
            c.difference,
            short(p),
            c.test.deals
        );
    }
    if !found.contrasts.is_empty() {
        println!("p: how often chance alone makes groups that are alike differ as much; below 0.05, chance rarely does");
    }
}

fn print_check(check: &table_1::Check) {
    println!(
        "{:<6} {:<7} {:>6} {:>6} {:>6} {:>6} {:>6} {:>17}",
        "group", "phase", "count", "mean", "sd", "min", "max", "given by (14)"
    );
    for c in &check.columns {
        let s = &c.spread;
        let (phase, sd, given) = (c.phase.name(), s.sd.unwrap_or_default(), format!("{} of {}", c.attainable, s.count));
        println!("{:<6} {phase:<7} {:>6} {:>6.3} {sd:>6.3} {:>6.3} {:>6.3} {given:>17}", c.group, s.count, s.mean, s.min, s.max);
    }
    let ((before, p_before), (after, p_after)) = (check.before, check.after);
    println!("\ngroup 1 - 2: before {before:+.3} (p = {}), after {after:+.3} (p = {}); {TEST}", short(p_before), short(p_after));
    println!("after, group 1 is above group 2 in {:.0} % of the pairs", 100.0 * check.pairs_above_after);
    for (claim, holds) in check.claims() {
        println!("{} {claim}", if holds { "holds    " } else { "DOES NOT:" });
    }
}

/// Formats with three decimals, or with two significant digits if the three decimals would be zero.
fn short(p: f64) -> String {
    if p >= 1e-3 { format!("{p:.3}") } else { format!("{p:.1e}") }
}
