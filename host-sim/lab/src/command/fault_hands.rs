//! The command `palpate faults --hands`.

use std::collections::BTreeSet;
use std::ops::Range;

use palpate_loop::closed_loop::paths::PathGround;
use palpate_loop::closed_loop::yielding::{Hands, HandsRow, HandsTable};
use palpate_sim::command::progress::Progress;
use palpate_sim::error::Error;
use serde::{Deserialize, Serialize};

use super::fault_paths::{counted, fault_names};
use crate::study::{Claim, Findings, Study, Table};

/// Largest number of runs with `--quick`.
pub(super) const QUICK: u64 = 400;

/// The settings that determine the runs.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Options {
    pub hands: u64,
    pub seed: u64,
    pub quick: bool,
}

/// Yielding hands.
pub(super) struct YieldingHands {
    options: Options,
    ground: PathGround,
}

impl YieldingHands {
    fn hands(&self) -> Hands<'_> {
        Hands::new(&self.ground, self.options.hands, self.options.seed, self.options.quick)
    }
}

/// Figures of a group of hands.
#[derive(Serialize)]
struct Row<'a> {
    hands: &'a str,
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
    faults: String,
}

impl<'a> Row<'a> {
    fn of(hands: &'a str, row: &HandsRow) -> Self {
        let ([over_10_uj, over_100_uj, over_1_mj], [over_50_mn, over_100_mn]) = (row.over, row.shaking);
        Self {
            hands,
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
            faults: counted(&row.faults),
        }
    }
}

/// One of the worst runs by a measure.
#[derive(Serialize)]
struct WorstRow<'a> {
    measure: &'a str,
    run: u64,
    value: f64,
    words: &'a str,
}

impl Study for YieldingHands {
    const ID: &'static str = "faults --hands";
    type Options = Options;
    type Row = HandsTable;

    fn load(options: Options) -> Result<Self, Error> {
        Ok(Self { options, ground: PathGround::load()? })
    }

    fn options(&self) -> &Options {
        &self.options
    }

    fn cases(&self) -> u64 {
        self.hands().cases()
    }

    fn run(&self, cases: Range<u64>) -> Result<Vec<HandsTable>, Error> {
        let progress = Progress::new(cases.end - cases.start, "runs");
        let table = self.hands().run(cases, |_| (), |n| progress.inc(n))?;
        progress.finish();
        Ok(vec![table])
    }

    fn findings(&self, parts: Vec<HandsTable>) -> Result<Findings, Error> {
        let mut table = HandsTable::default();
        parts.into_iter().for_each(|part| table.add(part));
        let rows: Vec<Row> = table.rows.iter().map(|(name, row)| Row::of(name, row)).collect();
        let mut worst = Vec::new();
        for (measure, runs) in &table.worst {
            worst.extend(runs.iter().map(|w| WorstRow { measure, run: w.number, value: w.value, words: &w.words }));
        }
        let mut last = "";
        let first = worst.iter().map(|row| std::mem::replace(&mut last, row.measure) != row.measure).collect::<Vec<_>>();
        let broken = table.broken();
        let runs: u64 = rows.iter().map(|row| row.runs).sum();
        let worst_mj = rows.iter().map(|row| row.worst_mj).fold(0.0, f64::max);
        let found = broken.first().map_or(format!("all, in {runs} runs; at most {worst_mj:.3} mJ was given"), |first| {
            format!("{} do not hold, the first: {first}", broken.len())
        });
        let numbers: BTreeSet<u8> = table.rows.values().flat_map(|row| row.faults.keys().copied()).collect();
        let mut findings = Findings {
            claims: vec![Claim::promise("promises of energy, felt force and stillness", "all", found, broken.is_empty())],
            tables: vec![
                Table::of("hands", &rows)?.about(
                    "random devices by delay and lag together; each shipped device; a minute of each motion on each; light hands on stiff tissue",
                ),
                Table::of("worst_hands", &worst)?.only(first),
            ],
            notes: fault_names(numbers),
            ..Findings::default()
        };
        findings.notes.extend([
            "worst: the most energy given since an instant without contact, from true positions, and its share of the bound".into(),
            "felt: of the impulse of the patch's push. lost: ticks with less than half of it for over 20 ms".into(),
            "over mN: runs of slow motions with more above 15 Hz. faults: runs, by the number of the first fault".into(),
        ]);
        findings.notes.extend(broken.iter().map(|broken| format!("does not hold: {broken}")));
        findings.fact("runs", runs);
        findings.fact("seed", self.options.seed);
        findings.fact("broken", broken);
        Ok(findings)
    }
}
