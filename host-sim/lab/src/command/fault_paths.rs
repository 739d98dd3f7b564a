//! The command `palpate faults --paths`.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::ops::Range;

use crate::faults::paths::{KINDS, PathGround, PathRow, PathTable, paths};
use palpate::Fault;
use palpate_sim::command::progress::Progress;
use palpate_sim::error::Error;

use crate::study::{Claim, Findings, Study, Table};

/// Largest number of paths with `--quick`.
pub(super) const QUICK: u64 = 4_000;
/// Number of bad paths that are printed.
const PRINTED: usize = 10;

/// Random paths of the probe.
pub(super) struct Paths {
    paths: u64,
    seed: u64,
    ground: PathGround,
}

impl Paths {
    pub(super) fn of(paths: u64, seed: u64) -> Result<Self, Error> {
        Ok(Self { paths, seed, ground: PathGround::load()? })
    }
}

impl Study for Paths {
    type Row = PathTable;

    fn cases(&self) -> u64 {
        self.paths
    }

    fn run(&self, cases: Range<u64>) -> Result<Vec<(u64, PathTable)>, Error> {
        let progress = Progress::new(cases.end - cases.start, "paths");
        let table = paths(&self.ground, cases.clone(), self.seed, |n| progress.inc(n))?;
        progress.finish();
        Ok(vec![(cases.start, table)])
    }

    fn findings(&self, parts: Vec<PathTable>) -> Result<Findings, Error> {
        let mut table = PathTable::default();
        parts.iter().for_each(|part| table.add(part));
        let total = table.total();
        let kinds = KINDS.iter().zip(&table.rows).map(|((_, name), row)| (*name, row)).chain([("all", &total)]);
        let kinds = Table::rows("paths", kinds)
            .col("kind", |(name, _): &(&'static str, &PathRow)| *name)
            .col("paths", |(_, row)| row.runs)
            .col("ticks", |(_, row)| row.ticks)
            .col("ticks_with_force", |(_, row)| row.ticks_with_force)
            .col("outside_m", |(_, row)| row.outside_m)
            .col("outside_ticks", |(_, row)| row.outside_ticks)
            .col("into_tissue_n", |(_, row)| row.into_n)
            .col("chatter_turns", |(_, row)| row.chatter_turns)
            .col("created_mj", |(_, row)| row.created_j * 1e3)
            .col("creating", |(_, row)| row.creating)
            .col("by_hand", |(_, row)| row.by_hand)
            .col("created_by_hand_mj", |(_, row)| row.created_by_hand_j * 1e3)
            .col("creating_by_hand", |(_, row)| row.creating_by_hand)
            .col("peak_force_n", |(_, row)| row.peak_n)
            .col("broken", |(_, row)| counted(&row.broken))
            .col("honest_faults", |(_, row)| counted(&row.honest_faults))
            .col("faults", |(_, row)| counted(&row.faults))
            .only(|(name, row)| *name == "all" || row.broke() > 0 || !row.honest_faults.is_empty());
        let patches = Table::rows("path_patches", &table.patches)
            .col("patch", |(patch, _)| patch.to_string())
            .col("paths", |(_, row)| row.runs)
            .col("by_hand", |(_, row)| row.by_hand)
            .col("creating_by_hand", |(_, row)| row.creating_by_hand)
            .all();
        let honest: u64 = total.honest_faults.values().sum();
        let promise = |name, found: u64| Claim::promise(name, "none", format!("{found} of {} paths", self.paths), found == 0);
        let mut findings = Findings {
            claims: vec![
                promise("paths that break an invariant", total.broke()),
                promise("motion that a hand can make and that ends in a fault", honest),
            ],
            headline: format!("strongest force {:.3} N", total.peak_n),
            tables: vec![
                kinds,
                patches.about("paths on each patch and tip, those that a hand can make, and those of these over 0.01 mJ"),
            ],
            notes: fault_names(total.faults.keys().copied()),
            ..Findings::default()
        };
        findings.notes.extend([
            "outside: farthest that the sensed tip was outside the tissue with a force, and ticks in a row over 1 mm (5 allowed)"
                .into(),
            "into: largest force into the tissue. chatter: turns in a row of a force that swung at rest (under 10 allowed)"
                .into(),
            "created: by the worst contact, from true positions. creating: paths over 0.01 mJ. by hand: to 1.5 m/s and 200 m/s^2"
                .into(),
        ]);
        findings.notes.extend(table.examples.iter().take(PRINTED).map(|bad| format!("bad: {bad}")));
        findings.fact("seed", self.seed);
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
