//! The command `palpate faults --hands`.

use std::collections::BTreeSet;
use std::ops::Range;

use crate::faults::paths::PathGround;
use crate::faults::yielding::{Hands, HandsTable};
use palpate_sim::command::progress::Progress;
use palpate_sim::error::Error;

use super::fault_paths::{counted, fault_names};
use crate::study::{Claim, Findings, Study, Table};

/// Largest number of runs with `--quick`.
pub(super) const QUICK: u64 = 400;

/// Yielding hands.
pub(super) struct YieldingHands {
    hands: u64,
    seed: u64,
    quick: bool,
    ground: PathGround,
}

impl YieldingHands {
    pub(super) fn of(hands: u64, seed: u64, quick: bool) -> Result<Self, Error> {
        Ok(Self { hands, seed, quick, ground: PathGround::load()? })
    }

    fn hands(&self) -> Hands<'_> {
        Hands::new(&self.ground, self.hands, self.seed, self.quick)
    }
}

impl Study for YieldingHands {
    type Row = HandsTable;

    fn cases(&self) -> u64 {
        self.hands().cases()
    }

    fn run(&self, cases: Range<u64>) -> Result<Vec<(u64, HandsTable)>, Error> {
        let progress = Progress::new(cases.end - cases.start, "runs");
        let table = self.hands().run(cases.clone(), |_| (), |n| progress.inc(n))?;
        progress.finish();
        Ok(vec![(cases.start, table)])
    }

    fn findings(&self, parts: Vec<HandsTable>) -> Result<Findings, Error> {
        let mut table = HandsTable::default();
        parts.into_iter().for_each(|part| table.add(part));
        let hands = Table::rows("hands", &table.rows)
            .col("hands", |(name, _)| name.to_string())
            .col("runs", |(_, row)| row.runs)
            .col("contacts", |(_, row)| row.contacts)
            .col("contacts_over_10_uj", |(_, row)| row.over[0])
            .col("contacts_over_100_uj", |(_, row)| row.over[1])
            .col("contacts_over_1_mj", |(_, row)| row.over[2])
            .col("worst_mj", |(_, row)| row.worst_j * 1e3)
            .col("worst_share_of_bound", |(_, row)| row.share)
            .col("felt_share", |(_, row)| row.felt())
            .col("lost_pct", |(_, row)| row.lost() * 100.0)
            .col("lost_unowed_pct", |(_, row)| row.lost_unowed() * 100.0)
            .col("unflagged_lost_ticks", |(_, row)| row.unflagged_ticks)
            .col("runs_over_50_mn", |(_, row)| row.shaking[0])
            .col("runs_over_100_mn", |(_, row)| row.shaking[1])
            .col("strongest_vibration_mn", |(_, row)| row.shake_n * 1e3)
            .col("faults", |(_, row)| counted(&row.faults))
            .all();
        let worst = table.worst.iter().flat_map(|(measure, runs)| runs.iter().enumerate().map(move |(n, run)| (measure, n, run)));
        let worst = Table::rows("worst_hands", worst)
            .col("measure", |(measure, ..)| measure.to_string())
            .col("run", |(.., run)| run.number)
            .col("value", |(.., run)| run.value)
            .col("words", |(.., run)| run.words.clone())
            .only(|(_, n, _)| *n == 0);
        let broken = table.broken();
        let runs: u64 = table.rows.values().map(|row| row.runs).sum();
        let worst_mj = table.rows.values().map(|row| row.worst_j * 1e3).fold(0.0, f64::max);
        let found = broken.first().map_or(format!("all, in {runs} runs; at most {worst_mj:.3} mJ was given"), |first| {
            format!("{} do not hold, the first: {first}", broken.len())
        });
        let numbers: BTreeSet<u8> = table.rows.values().flat_map(|row| row.faults.keys().copied()).collect();
        let mut findings = Findings {
            claims: vec![Claim::promise("promises of energy, felt force and stillness", "all", found, broken.is_empty())],
            tables: vec![
                hands.about(
                    "random devices by delay and lag together; each shipped device; a minute of each motion on each; light hands on stiff tissue",
                ),
                worst,
            ],
            notes: fault_names(numbers),
            ..Findings::default()
        };
        findings.notes.extend([
            "worst: the most energy given since an instant without contact, from true positions, and its share of the bound"
                .into(),
            "felt: of the impulse of the patch's push. lost: ticks with less than half of it for over 20 ms".into(),
            "over mN: runs of slow motions with more above 15 Hz. faults: runs, by the number of the first fault".into(),
        ]);
        findings.notes.extend(broken.iter().map(|broken| format!("does not hold: {broken}")));
        findings.fact("runs", runs);
        findings.fact("seed", self.seed);
        findings.fact("broken", broken);
        Ok(findings)
    }
}
