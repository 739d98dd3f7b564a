//! The command `palpate faults --hands`.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::fault_paths::name_faults;
use crate::faults::paths::PathGround;
use crate::faults::yielding::{Hands, HandsRow, HandsTable, Worst};
use palpate_sim::command::campaign::Campaign;
use palpate_sim::command::progress::Progress;
use palpate_sim::command::verdict::Verdict;
use palpate_sim::error::Error;
use palpate_tissue::Error as TissueError;
use palpate_tissue::output::OutputFolder;

/// Largest number of runs with `--quick`.
pub(super) const QUICK: u64 = 400;

/// Contents of `summary.json`.
#[derive(Serialize)]
struct Summary<'a> {
    runs: u64,
    seed: u64,
    rows: BTreeMap<&'a str, Row>,
    broken: &'a [String],
    /// The worst runs by each measure.
    worst: &'a BTreeMap<Cow<'static, str>, Vec<Worst>>,
}

/// Figures of a row.
#[derive(Serialize)]
struct Row {
    runs: u64,
    contacts: u64,
    contacts_over_10_uj: u64,
    contacts_over_100_uj: u64,
    contacts_over_1_mj: u64,
    worst_mj: f64,
    worst_share_of_bound: f64,
    felt_share: f64,
    lost_pct: f64,
    unflagged_lost_ticks: u64,
    runs_over_50_mn: u64,
    runs_over_100_mn: u64,
    strongest_vibration_mn: f64,
    /// Number of runs with a fault, by the number of the first fault.
    faults: BTreeMap<u8, u64>,
}

impl Row {
    fn of(row: &HandsRow) -> Self {
        let ([over_10_uj, over_100_uj, over_1_mj], [over_50_mn, over_100_mn]) = (row.over, row.shaking);
        Self {
            runs: row.runs,
            contacts: row.contacts,
            contacts_over_10_uj: over_10_uj,
            contacts_over_100_uj: over_100_uj,
            contacts_over_1_mj: over_1_mj,
            worst_mj: row.worst_j * 1e3,
            worst_share_of_bound: row.share,
            felt_share: row.felt(),
            lost_pct: row.lost() * 100.0,
            unflagged_lost_ticks: row.unflagged_ticks,
            runs_over_50_mn: over_50_mn,
            runs_over_100_mn: over_100_mn,
            strongest_vibration_mn: row.shake_n * 1e3,
            faults: row.faults.clone(),
        }
    }
}

/// The settings that determine the runs.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Options {
    pub hands: u64,
    pub seed: u64,
    pub quick: bool,
}

/// The campaign of yielding hands.
pub(super) struct YieldingHands {
    options: Options,
    ground: PathGround,
}

impl YieldingHands {
    fn hands(&self) -> Hands<'_> {
        Hands::new(&self.ground, self.options.hands, self.options.seed, self.options.quick)
    }
}

impl Campaign for YieldingHands {
    type Options = Options;
    type Counts = HandsTable;
    const COMMAND: &'static str = "faults --hands";

    fn load(options: Options) -> Result<Self, Error> {
        Ok(Self { options, ground: PathGround::load()? })
    }

    fn options(&self) -> &Options {
        &self.options
    }

    fn cases(&self) -> u64 {
        self.hands().cases()
    }

    fn run(&self, cases: Range<u64>) -> Result<HandsTable, Error> {
        let progress = Progress::new(cases.end - cases.start, "runs");
        let table = self.hands().run(cases, |_| (), |n| progress.inc(n))?;
        progress.finish();
        Ok(table)
    }

    fn add(table: &mut HandsTable, next: HandsTable) {
        table.add(next);
    }

    fn report(&self, folder: OutputFolder, table: HandsTable, all: bool) -> Result<(), Error> {
        let broken = table.broken();
        let runs: u64 = table.rows.values().map(|row| row.runs).sum();
        folder.write("hands.csv", csv(&table)?.as_bytes())?;
        let rows = table.rows.iter().map(|(name, row)| (name.as_ref(), Row::of(row))).collect();
        folder.write_summary(&Summary { runs, seed: self.options.seed, rows, broken: &broken, worst: &table.worst })?;
        let verdict = Verdict::of(judge(&broken), || {
            let worst_j = table.rows.values().map(|row| row.worst_j).fold(0.0, f64::max);
            format!("{runs} runs of yielding hands keep what is promised; at most {:.3} mJ was given", worst_j * 1e3)
        })?
        .first();
        print(&table, all);
        println!("\nwrote {}: summary.json, hands.csv", folder.publish()?.display());
        verdict.last()
    }
}

fn judge(broken: &[String]) -> Result<(), Error> {
    match broken {
        [] => Ok(()),
        [first, ..] => Err(TissueError::Check(format!("{} promises do not hold; the first: {first}", broken.len())).into()),
    }
}

fn csv(table: &HandsTable) -> Result<String, Error> {
    let unwritable = |source: csv::Error| TissueError::Write { path: "hands.csv".into(), source: std::io::Error::other(source) };
    let mut csv = csv::Writer::from_writer(Vec::new());
    let head = "hands,runs,contacts,contacts_over_10_uj,contacts_over_100_uj,contacts_over_1_mj,worst_mj,worst_share_of_bound,felt_share,lost_pct,unflagged_lost_ticks,runs_over_50_mn,runs_over_100_mn,strongest_vibration_mn,faults";
    csv.write_record(head.split(',')).map_err(unwritable)?;
    for (name, row) in &table.rows {
        let Row { faults, .. } = Row::of(row);
        let numbers = format!(
            "{},{},{},{},{},{},{},{},{},{},{},{},{}",
            row.runs,
            row.contacts,
            row.over[0],
            row.over[1],
            row.over[2],
            row.worst_j * 1e3,
            row.share,
            row.felt(),
            row.lost() * 100.0,
            row.unflagged_ticks,
            row.shaking[0],
            row.shaking[1],
            row.shake_n * 1e3
        );
        let record = [name.as_ref()].into_iter().chain(numbers.split(','));
        csv.write_record(record.chain([counted(&faults).as_str()])).map_err(unwritable)?;
    }
    let bytes = csv.into_inner().map_err(|e| TissueError::Write { path: "hands.csv".into(), source: e.into_error() })?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

fn counted(faults: &BTreeMap<u8, u64>) -> String {
    faults.iter().fold(String::new(), |mut text, (fault, runs)| {
        // writing to a string cannot fail
        let _ = write!(text, "{}{fault}:{runs}", if text.is_empty() { "" } else { " " });
        text
    })
}

fn print(table: &HandsTable, all: bool) {
    println!(
        "{:<28} {:>6} {:>8} {:>18} {:>9} {:>8} {:>6} {:>7} {:>5} {:>9}  faults",
        "hands", "runs", "contacts", ">.01 / .1 / 1 mJ", "worst mJ", "of bound", "felt", "lost %", "dark", "shaking"
    );
    for (name, row) in &table.rows {
        println!(
            "{name:<28} {:>6} {:>8} {:>18} {:>9.4} {:>8.4} {:>6.3} {:>7.3} {:>5} {:>9}  {}",
            row.runs,
            row.contacts,
            row.over.map(|n| n.to_string()).join(" / "),
            row.worst_j * 1e3,
            row.share,
            row.felt(),
            row.lost() * 100.0,
            row.unflagged_ticks,
            row.shaking.map(|n| n.to_string()).join(" / "),
            counted(&row.faults)
        );
    }
    name_faults(table.rows.values().flat_map(|row| row.faults.keys().copied()).collect::<BTreeSet<u8>>());
    println!(
        "\nrows: random devices by delay and lag together; each shipped device; a minute of each motion on each shipped device; a fixed family of light hands on stiff tissue"
    );
    println!("worst: the most energy given since an instant without contact, from true positions, and its share of the bound");
    println!(
        "felt: of the impulse of the patch's push. lost: ticks with less than half of it for over 20 ms; dark: without a flag"
    );
    println!("shaking: runs of slow motions with over 50 / 100 mN above 15 Hz. faults: runs, by the number of the first fault");
    for (measure, runs) in &table.worst {
        for Worst { number, words, .. } in runs.iter().take(if all { usize::MAX } else { 1 }) {
            println!("worst by {measure}: run {number}: {words}");
        }
    }
    table.broken().iter().for_each(|broken| println!("does not hold: {broken}"));
}
