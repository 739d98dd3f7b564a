//! The command `palpate faults --paths`.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::ops::Range;

use palpate::Fault;
use serde::{Deserialize, Serialize};

use crate::faults::paths::{KINDS, PatchRow, PathGround, PathRow, PathTable, paths};
use palpate_sim::command::campaign::Campaign;
use palpate_sim::command::progress::Progress;
use palpate_sim::command::verdict::Verdict;
use palpate_sim::error::Error;
use palpate_tissue::Error as TissueError;
use palpate_tissue::output::OutputFolder;

/// Largest number of paths with `--quick`.
pub(super) const QUICK: u64 = 4_000;
/// Number of bad paths that are printed.
const PRINTED: usize = 10;

/// Contents of `summary.json`.
#[derive(Serialize)]
struct Summary<'a> {
    paths: u64,
    seed: u64,
    ticks: u64,
    ticks_with_force: u64,
    /// Number of runs that broke each invariant.
    invariants_broken: BTreeMap<Cow<'static, str>, u64>,
    /// Number of runs that each fault ended, by the number of the fault, with the tip no faster
    /// than 1.5 m/s.
    faults_on_honest_motion: BTreeMap<u8, u64>,
    /// Number of runs that each fault ended, by the number of the fault, at any speed.
    faults: BTreeMap<u8, u64>,
    outside_with_force_m: f64,
    outside_with_force_ticks: u32,
    force_into_tissue_n: f64,
    chatter_turns: u32,
    energy_created_mj: f64,
    runs_that_create_energy: u64,
    /// Runs with motion that a hand can make; the next two fields refer to these runs.
    runs_by_hand: u64,
    energy_created_by_hand_mj: f64,
    runs_by_hand_that_create_energy: u64,
    peak_force_n: f32,
    patches: &'a BTreeMap<Cow<'static, str>, PatchRow>,
    bad: &'a [String],
    creating: &'a [String],
}

/// The settings that determine the paths.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Options {
    pub paths: u64,
    pub seed: u64,
}

/// The campaign of paths.
pub(super) struct Paths {
    options: Options,
    ground: PathGround,
}

impl Campaign for Paths {
    type Options = Options;
    type Counts = PathTable;
    const COMMAND: &'static str = "faults --paths";

    fn load(options: Options) -> Result<Self, Error> {
        Ok(Self { options, ground: PathGround::load()? })
    }

    fn options(&self) -> &Options {
        &self.options
    }

    fn cases(&self) -> u64 {
        self.options.paths
    }

    fn run(&self, cases: Range<u64>) -> Result<PathTable, Error> {
        let progress = Progress::new(cases.end - cases.start, "paths");
        let table = paths(&self.ground, cases, self.options.seed, |n| progress.inc(n))?;
        progress.finish();
        Ok(table)
    }

    fn add(table: &mut PathTable, next: PathTable) {
        table.add(&next);
    }

    fn report(&self, folder: OutputFolder, table: PathTable, all: bool) -> Result<(), Error> {
        let total = table.total();
        folder.write("paths.csv", csv(&table).as_bytes())?;
        folder.write_summary(&Summary {
            paths: self.options.paths,
            seed: self.options.seed,
            ticks: total.ticks,
            ticks_with_force: total.ticks_with_force,
            invariants_broken: total.broken.clone(),
            faults_on_honest_motion: total.honest_faults.clone(),
            faults: total.faults.clone(),
            outside_with_force_m: total.outside_m,
            outside_with_force_ticks: total.outside_ticks,
            force_into_tissue_n: total.into_n,
            chatter_turns: total.chatter_turns,
            energy_created_mj: total.created_j * 1e3,
            runs_that_create_energy: total.creating,
            runs_by_hand: total.by_hand,
            energy_created_by_hand_mj: total.created_by_hand_j * 1e3,
            runs_by_hand_that_create_energy: total.creating_by_hand,
            peak_force_n: total.peak_n,
            patches: &table.patches,
            bad: &table.examples,
            creating: &table.creating,
        })?;
        let verdict = Verdict::of(judge(&table, &total), || {
            format!(
                "{} paths broke no invariant, and none of motion that a hand can make ended in a fault; strongest force {:.3} N",
                self.options.paths, total.peak_n
            )
        })?
        .first();
        print(&table, &total, all);
        println!("\nwrote {}: summary.json, paths.csv", folder.publish()?.display());
        verdict.last()
    }
}

fn judge(table: &PathTable, total: &PathRow) -> Result<(), Error> {
    let honest: u64 = total.honest_faults.values().sum();
    match total.broke() + honest {
        0 => Ok(()),
        _ => Err(TissueError::Check(format!(
            "{} paths broke an invariant, {honest} of honest motion ended in a fault; the first: {}",
            total.broke(),
            table.examples.first().map_or("", String::as_str)
        ))
        .into()),
    }
}

/// Prints the descriptions of faults that a table gives by number.
pub(super) fn name_faults(numbers: impl IntoIterator<Item = u8>) {
    for number in numbers {
        if let Some(fault) = Fault::ALL.into_iter().find(|fault| *fault as u8 == number) {
            println!("{fault}");
        }
    }
}

fn counted<K: std::fmt::Display>(counts: &BTreeMap<K, u64>) -> String {
    counts.iter().map(|(key, count)| format!("{key}:{count}")).collect::<Vec<_>>().join(" ")
}

fn csv(table: &PathTable) -> String {
    let mut text = String::from(
        "kind,paths,ticks,ticks_with_force,outside_m,outside_ticks,into_tissue_n,chatter_turns,created_mj,creating,by_hand,created_by_hand_mj,creating_by_hand,peak_force_n,broken,honest_faults,faults\n",
    );
    for ((_, name), row) in KINDS.iter().zip(&table.rows) {
        let PathRow { runs, ticks, ticks_with_force, outside_m, outside_ticks, into_n, chatter_turns, creating, peak_n, .. } =
            row;
        // writing to a string cannot fail
        let _ = writeln!(
            text,
            "{name},{runs},{ticks},{ticks_with_force},{outside_m},{outside_ticks},{into_n},{chatter_turns},{},{creating},{},{},{},{peak_n},{},{},{}",
            row.created_j * 1e3,
            row.by_hand,
            row.created_by_hand_j * 1e3,
            row.creating_by_hand,
            counted(&row.broken),
            counted(&row.honest_faults),
            counted(&row.faults)
        );
    }
    text
}

fn print(table: &PathTable, total: &PathRow, all: bool) {
    println!(
        "{:<16} {:>7} {:>11} {:>11} {:>8} {:>6} {:>7} {:>7} {:>10} {:>7}  broken; faults of honest motion; all faults",
        "path", "paths", "ticks", "with force", "out mm", "ticks", "in N", "chatter", "created mJ", "peak N"
    );
    let names = KINDS.iter().map(|(_, name)| *name).chain(["all"]);
    for (name, row) in names.zip(table.rows.iter().chain([total])) {
        let failed = row.broke() > 0 || !row.honest_faults.is_empty();
        if !all && !failed && name != "all" {
            continue;
        }
        println!(
            "{name:<16} {:>7} {:>11} {:>11} {:>8.3} {:>6} {:>7.3} {:>7} {:>10.5} {:>7.3}  {}; {}; {}",
            row.runs,
            row.ticks,
            row.ticks_with_force,
            row.outside_m * 1e3,
            row.outside_ticks,
            row.into_n,
            row.chatter_turns,
            row.created_j * 1e3,
            row.peak_n,
            counted(&row.broken),
            counted(&row.honest_faults),
            counted(&row.faults)
        );
    }
    name_faults(total.faults.keys().copied());
    println!("\nout: farthest that the sensed tip was outside the tissue with a force, and ticks in a row over 1 mm (5 allowed)");
    println!("in: largest force into the tissue. chatter: turns in a row of a force that swung at rest (under 10 allowed)");
    println!("created: by the worst contact, from true positions; {} paths over 0.01 mJ", total.creating);
    println!(
        "of the {} paths that a hand can make (to 1.5 m/s and 200 m/s^2) {} are over 0.01 mJ, the worst {:.3} mJ",
        total.by_hand,
        total.creating_by_hand,
        total.created_by_hand_j * 1e3
    );
    println!("paths on each patch and tip, those of them that a hand can make, and those of these over 0.01 mJ:");
    for (label, PatchRow { runs, by_hand, creating_by_hand }) in &table.patches {
        println!("  {label:<36} {runs:>7} {by_hand:>7} {creating_by_hand:>4}");
    }
    for bad in table.examples.iter().take(PRINTED) {
        println!("bad: {bad}");
    }
}
