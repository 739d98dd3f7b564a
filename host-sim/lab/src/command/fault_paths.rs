//! The command `palpate faults --paths`.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::ops::Range;

use palpate::Fault;
use palpate_loop::closed_loop::paths::{KINDS, PatchRow, PathGround, PathRow, PathTable, paths};
use palpate_sim::command::progress::Progress;
use palpate_sim::error::Error;
use serde::{Deserialize, Serialize};

use crate::study::{Claim, Findings, Study, Table};

/// Largest number of paths with `--quick`.
pub(super) const QUICK: u64 = 4_000;
/// Number of bad paths that are printed.
const PRINTED: usize = 10;

/// The settings that determine the paths.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Options {
    pub paths: u64,
    pub seed: u64,
}

/// Random paths of the probe.
pub(super) struct Paths {
    options: Options,
    ground: PathGround,
}

/// Results for one kind of path.
#[derive(Serialize)]
struct Row {
    kind: &'static str,
    paths: u64,
    ticks: u64,
    ticks_with_force: u64,
    outside_m: f64,
    outside_ticks: u32,
    into_tissue_n: f64,
    chatter_turns: u32,
    created_mj: f64,
    creating: u64,
    by_hand: u64,
    created_by_hand_mj: f64,
    creating_by_hand: u64,
    peak_force_n: f32,
    /// Number of runs by broken invariant, and by fault.
    broken: String,
    honest_faults: String,
    faults: String,
}

impl Row {
    fn of(kind: &'static str, row: &PathRow) -> Self {
        Self {
            kind,
            paths: row.runs,
            ticks: row.ticks,
            ticks_with_force: row.ticks_with_force,
            outside_m: row.outside_m,
            outside_ticks: row.outside_ticks,
            into_tissue_n: row.into_n,
            chatter_turns: row.chatter_turns,
            created_mj: row.created_j * 1e3,
            creating: row.creating,
            by_hand: row.by_hand,
            created_by_hand_mj: row.created_by_hand_j * 1e3,
            creating_by_hand: row.creating_by_hand,
            peak_force_n: row.peak_n,
            broken: counted(&row.broken),
            honest_faults: counted(&row.honest_faults),
            faults: counted(&row.faults),
        }
    }
}

/// Runs on a patch under a tip.
#[derive(Serialize)]
struct OnPatch<'a> {
    patch: &'a str,
    paths: u64,
    by_hand: u64,
    creating_by_hand: u64,
}

impl Study for Paths {
    const ID: &'static str = "faults --paths";
    type Options = Options;
    type Row = PathTable;

    fn load(options: Options) -> Result<Self, Error> {
        Ok(Self { options, ground: PathGround::load()? })
    }

    fn options(&self) -> &Options {
        &self.options
    }

    fn cases(&self) -> u64 {
        self.options.paths
    }

    fn run(&self, cases: Range<u64>) -> Result<Vec<PathTable>, Error> {
        let progress = Progress::new(cases.end - cases.start, "paths");
        let table = paths(&self.ground, cases, self.options.seed, |n| progress.inc(n))?;
        progress.finish();
        Ok(vec![table])
    }

    fn findings(&self, parts: Vec<PathTable>) -> Result<Findings, Error> {
        let mut table = PathTable::default();
        parts.iter().for_each(|part| table.add(part));
        let total = table.total();
        let kinds = KINDS.iter().zip(&table.rows).map(|((_, name), row)| Row::of(name, row));
        let rows: Vec<Row> = kinds.chain([Row::of("all", &total)]).collect();
        let on_patch = |(patch, row): (_, &PatchRow)| {
            let PatchRow { runs: paths, by_hand, creating_by_hand } = *row;
            OnPatch { patch, paths, by_hand, creating_by_hand }
        };
        let patches: Vec<OnPatch> = table.patches.iter().map(|(patch, row)| on_patch((patch.as_ref(), row))).collect();
        let honest: u64 = total.honest_faults.values().sum();
        let promise = |name, found: u64| Claim::promise(name, "none", format!("{found} of {} paths", self.options.paths), found == 0);
        let shown = rows.iter().map(|row| row.kind == "all" || !row.broken.is_empty() || !row.honest_faults.is_empty());
        let mut findings = Findings {
            claims: vec![
                promise("paths that break an invariant", total.broke()),
                promise("motion that a hand can make and that ends in a fault", honest),
            ],
            headline: format!("strongest force {:.3} N", total.peak_n),
            tables: vec![
                Table::of("paths", &rows)?.only(shown.collect::<Vec<_>>()),
                Table::of("path_patches", &patches)?
                    .about("paths on each patch and tip, those that a hand can make, and those of these over 0.01 mJ"),
            ],
            notes: fault_names(total.faults.keys().copied()),
            ..Findings::default()
        };
        findings.notes.extend([
            "outside: farthest that the sensed tip was outside the tissue with a force, and ticks in a row over 1 mm (5 allowed)".into(),
            "into: largest force into the tissue. chatter: turns in a row of a force that swung at rest (under 10 allowed)".into(),
            "created: by the worst contact, from true positions. creating: paths over 0.01 mJ. by hand: to 1.5 m/s and 200 m/s^2".into(),
        ]);
        findings.notes.extend(table.examples.iter().take(PRINTED).map(|bad| format!("bad: {bad}")));
        findings.fact("seed", self.options.seed);
        findings.fact("bad", table.examples);
        findings.fact("creating", table.creating);
        Ok(findings)
    }
}

/// Descriptions of faults that a table gives by number.
pub(super) fn fault_names(numbers: impl IntoIterator<Item = u8>) -> Vec<String> {
    let of = |number| Fault::ALL.into_iter().find(|fault| *fault as u8 == number);
    numbers.into_iter().filter_map(of).map(|fault| fault.to_string()).collect()
}

/// Numbers of runs by key, as text.
pub(super) fn counted<K: Display>(counts: &BTreeMap<K, u64>) -> String {
    counts.iter().map(|(key, count)| format!("{key}:{count}")).collect::<Vec<_>>().join(" ")
}
