//! The command `palpate faults`.

use std::collections::BTreeSet;
use std::ops::Range;

use crate::faults::campaign::{Ground, LightPatch, Row, Table as Kinds, campaign};
use crate::faults::faulty::{Expected, FaultType};
use crate::faults::soak::{Soak, soak};
use palpate_charts::{Bar, Bars, Figure, Form, ScaledAxis};
use palpate_loop::closed_loop::device::DeviceProfile;
use palpate_loop::closed_loop::hand::HANDS;
use palpate_sim::command::options::faults::FaultsArgs;
use palpate_sim::command::progress::Progress;
use palpate_sim::error::Error;
use palpate_tissue::Error as TissueError;
use serde::{Deserialize, Serialize};

use super::{fault_adversary, fault_hands, fault_paths, fault_trade};
use crate::study::{Claim, Findings, Study, Table, start};

/// Largest distance of a node from its initial position after normal use [m].
const DRIFT_M: f32 = 1e-6;

/// Faults on one device.
struct Faults {
    runs: u64,
    seed: u64,
    soak_s: u32,
    device: DeviceProfile,
    light: LightPatch,
}

/// Runs with one kind of fault among adjacent cases.
#[derive(Serialize, Deserialize)]
struct OfKind {
    /// Position among the kinds of fault.
    kind: usize,
    row: Row,
}

pub(super) fn run(args: &FaultsArgs) -> Result<(), Error> {
    let (seed, cases, out, quick) = (args.seed, &args.cases, &args.out, args.quick);
    if let Some(paths) = args.paths {
        let paths = if quick { paths.min(fault_paths::QUICK) } else { paths };
        return start(fault_paths::Paths::of(paths, seed)?, cases, out);
    }
    if let Some(hands) = args.hands {
        let hands = if quick { hands.min(fault_hands::QUICK) } else { hands };
        return start(fault_hands::YieldingHands::of(hands, seed, quick)?, cases, out);
    }
    if args.adversary {
        let rounds = args.rounds.unwrap_or(if quick { fault_adversary::QUICK_ROUNDS } else { fault_adversary::ROUNDS });
        let again = args.genes.as_deref().map(str::parse).transpose().map_err(TissueError::Usage)?;
        return start(fault_adversary::Search::of(seed, rounds, again)?, cases, out);
    }
    if args.trade {
        let runs = if quick { fault_trade::QUICK_RUNS } else { fault_trade::RUNS };
        return start(fault_trade::Trade::of(runs, seed)?, cases, out);
    }
    let runs = args.runs.unwrap_or(if quick { 6_000 } else { 100_000 });
    let (device, light) = (DeviceProfile::load("touch")?, LightPatch::load()?);
    start(Faults { runs, seed, soak_s: args.soak_s, device, light }, cases, out)
}

impl Study for Faults {
    type Row = OfKind;

    fn cases(&self) -> u64 {
        self.runs
    }

    fn run(&self, cases: Range<u64>) -> Result<Vec<(u64, OfKind)>, Error> {
        let progress = Progress::new(cases.end - cases.start, "runs");
        let table = campaign(&Ground::new(&self.device, &self.light), cases.clone(), self.seed, |n| progress.inc(n))?;
        progress.finish();
        let of_kind = |(kind, row): (usize, Row)| (cases.start, OfKind { kind, row });
        Ok(table.rows.into_iter().enumerate().filter(|(_, row)| row.runs > 0).map(of_kind).collect())
    }

    fn findings(&self, parts: Vec<OfKind>) -> Result<Findings, Error> {
        let mut table = Kinds::default();
        for OfKind { kind, row } in &parts {
            table.rows.get_mut(*kind).into_iter().for_each(|of_all| of_all.add(row));
        }
        let numbers: BTreeSet<u8> = table.rows.iter().flat_map(|row| row.faults.keys().copied()).collect();
        let peak_n = table.rows.iter().map(|row| row.peak_n).fold(0.0, f32::max);
        let first = table.examples().first().map_or(String::new(), |first| format!("; the first: {first}"));
        let mut findings = Findings {
            headline: format!("strongest force {peak_n:.3} N"),
            claims: vec![Claim::promise(
                format!(
                    "runs with {} kinds of fault whose reaction is wrong or late, or that break an invariant",
                    table.rows.len()
                ),
                "none",
                format!("{} of {}{first}", table.bad(), self.runs),
                table.bad() == 0,
            )],
            tables: vec![
                reactions(&table).about("latest: ticks of 1 ms to no force or a falling one; allowed: the most for that kind"),
                kinds(&table),
            ],
            figures: vec![self.figure(&table)],
            ..Findings::default()
        };
        if table.bad() > 0 {
            findings.notes = fault_paths::fault_names(numbers);
        }
        findings.fact("seed", self.seed);
        findings.fact("hands", HANDS.len());
        if let Some(soaked) = self.soak()? {
            self.judge_soak(&mut findings, &soaked);
        }
        Ok(findings)
    }
}

impl Faults {
    /// Runs normal use, if it was requested.
    fn soak(&self) -> Result<Option<Soak>, Error> {
        if self.soak_s == 0 {
            return Ok(None);
        }
        let ticks = u64::from(self.soak_s) * 1000;
        let progress = Progress::new(ticks, "ticks of normal use");
        let soaked = soak(&Ground::new(&self.device, &self.light), self.soak_s.into(), |n| progress.inc(n))?;
        progress.finish();
        Ok(Some(soaked))
    }

    fn judge_soak(&self, findings: &mut Findings, soaked: &Soak) {
        let trip =
            soaked.trips.first().map_or(String::new(), |(hand, what, fault)| format!("; the first: {hand} {what}, {fault}"));
        let broken = soaked.broken.first().map_or(String::new(), |b| format!("; the first: {} {}", b.id, b.what));
        let use_s = soaked.ticks as f64 * 1e-3;
        let none = |name: &str, count: usize, first: String| Claim::promise(name, "none", format!("{count}{first}"), count == 0);
        findings.claims.extend([
            none(&format!("trips in {use_s:.0} s of normal use, {} touches", soaked.uses), soaked.trips.len(), trip),
            none("invariants that normal use broke", soaked.broken.len(), broken),
            none("denormal numbers after normal use", soaked.denormals, String::new()),
            // written so that NaN fails
            Claim::promise(
                "distance of a node from its place after normal use",
                format!("at most {DRIFT_M:e} m"),
                format!("{:.1e} m", soaked.drift_m),
                soaked.drift_m <= DRIFT_M,
            ),
        ]);
        findings.fact("soak_s", use_s);
        findings.fact("soak_uses", soaked.uses);
        findings.fact("soak_peak_force_n", soaked.peak_n);
    }

    fn figure(&self, table: &Kinds) -> Figure {
        let bars = table.kinds().filter_map(|(kind, row)| {
            let [fastest, median, slowest] = row.reaction_span_ticks()?.map(f64::from);
            Some(Bar {
                name: kind.name.to_owned(),
                kind: String::new(),
                span: [fastest, slowest],
                whiskers: None,
                mark: Some(median),
                allowed: allowed(&kind.expected).map(f64::from),
                text: String::new(),
            })
        });
        Figure {
            name: "faults".into(),
            title: "From a fault to no force, or to a falling one".into(),
            below: format!(
                "{} runs in {} hands; bar: fastest to slowest, dot: median, stroke: time allowed; none: not always recognised",
                self.runs,
                HANDS.len()
            ),
            form: Form::Bars(Bars { axis: ScaledAxis::log("ms to the reaction"), bars: bars.collect() }),
        }
    }
}

/// Longest reaction time allowed [ticks]; `None` if no reaction is required.
fn allowed(expected: &Expected) -> Option<u32> {
    match *expected {
        Expected::Fault(_, ticks) | Expected::Ramp(ticks) | Expected::Degraded(ticks) => Some(ticks),
        Expected::Ridden | Expected::Bounded(_) | Expected::Nothing => None,
    }
}

/// Name of the reaction that is required.
fn must(expected: &Expected) -> &'static str {
    match expected {
        Expected::Fault(..) => "fault",
        Expected::Ramp(_) => "ramp",
        Expected::Degraded(_) => "weaken",
        Expected::Ridden => "go on",
        Expected::Bounded(_) => "bounded",
        Expected::Nothing => "nothing",
    }
}

/// Names and descriptions of the reactions that can be required.
const FOLLOWS: [(&str, &str); 6] = [
    ("fault", "a numbered fault, zero force"),
    ("ramp", "the force fades to zero"),
    ("weaken", "a weaker force"),
    ("go on", "nothing: it is ridden out"),
    ("bounded", "the force stays within its limits"),
    ("nothing", "nothing: it is no fault"),
];

type Kind<'a> = (&'static FaultType, &'a Row);

fn kinds(table: &Kinds) -> Table {
    Table::rows("faults", table.kinds())
        .col("id", |(kind, _): &Kind| kind.id)
        .col("fault", |(kind, _)| kind.name)
        .col("must", |(kind, _)| must(&kind.expected))
        .col("allowed_ticks", |(kind, _)| allowed(&kind.expected))
        .col("runs", |(_, row)| row.runs)
        .col("injected", |(_, row)| row.injected)
        .col("faulted", |(_, row)| row.detected)
        .col("latest_reaction_ticks", |(_, row)| row.latest_ticks())
        .col("peak_force_n", |(_, row)| row.peak_n)
        .col("invariants_broken", |(_, row)| row.broken)
        .col("reactions_wrong", |(_, row)| row.wrong)
        .col("ended_in", |(_, row)| row.ends())
        .only(|(_, row)| row.broken + row.wrong > 0)
}

/// A row per required reaction, over all kinds of fault that require it.
fn reactions(table: &Kinds) -> Table {
    let of = |(name, words): (&str, &'static str)| {
        (words, table.kinds().filter(|(kind, _)| must(&kind.expected) == name).collect::<Vec<Kind>>())
    };
    let slowest =
        |kinds: &[Kind]| kinds.iter().filter_map(|(kind, row)| Some((row.latest_ticks()?, allowed(&kind.expected)))).max();
    let sum = |kinds: &[Kind], count: fn(&Row) -> u64| kinds.iter().map(|(_, row)| count(row)).sum::<u64>();
    Table::rows("reactions", FOLLOWS.map(of).into_iter().filter(|(_, kinds)| !kinds.is_empty()))
        .col("what_has_to_follow", |(words, _)| *words)
        .col("kinds", |(_, kinds)| kinds.len())
        .col("runs", |(_, kinds)| sum(kinds, |row| row.runs))
        .col("injected", |(_, kinds)| sum(kinds, |row| row.injected))
        .col("latest_reaction_ticks", |(_, kinds)| slowest(kinds).map(|s| s.0))
        .col("allowed_ticks", |(_, kinds)| slowest(kinds).and_then(|s| s.1))
        .col("reactions_wrong", |(_, kinds)| sum(kinds, |row| row.wrong))
        .col("invariants_broken", |(_, kinds)| sum(kinds, |row| row.broken))
        .all()
}
