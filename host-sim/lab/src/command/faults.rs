//! The command `palpate faults`.

use std::collections::BTreeSet;
use std::ops::Range;

use palpate_charts::{Bar, Bars, Figure, Form, ScaledAxis};
use palpate_loop::closed_loop::campaign::{Ground, LightPatch, Table as Kinds, campaign};
use palpate_loop::closed_loop::device::DeviceProfile;
use palpate_loop::closed_loop::faulty::Expected;
use palpate_loop::closed_loop::hand::HANDS;
use palpate_loop::closed_loop::soak::{Soak, soak};
use palpate_sim::command::options::faults::FaultsArgs;
use palpate_sim::command::progress::Progress;
use palpate_sim::error::Error;
use serde::{Deserialize, Serialize};

use super::{fault_adversary, fault_hands, fault_paths, fault_trade};
use crate::study::{Claim, Findings, Study, Table, start};

/// Largest distance of a node from its initial position after normal use [m].
const DRIFT_M: f32 = 1e-6;

/// The settings that determine the runs.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Options {
    runs: u64,
    seed: u64,
    /// Not recorded: this option cannot be combined with --shard.
    #[serde(skip)]
    soak_s: u32,
}

/// Faults on one device.
pub(super) struct Faults {
    options: Options,
    device: DeviceProfile,
    light: LightPatch,
}

/// Results for one kind of fault.
#[derive(Serialize)]
struct Kind {
    id: &'static str,
    fault: &'static str,
    must: &'static str,
    allowed_ticks: Option<u32>,
    runs: u64,
    injected: u64,
    faulted: u64,
    latest_reaction_ticks: Option<u32>,
    peak_force_n: f32,
    invariants_broken: u64,
    reactions_wrong: u64,
    ended_in: String,
}

/// Results for all kinds of fault that require the same reaction.
#[derive(Serialize)]
struct Reaction {
    what_has_to_follow: &'static str,
    kinds: usize,
    runs: u64,
    injected: u64,
    latest_reaction_ticks: Option<u32>,
    allowed_ticks: Option<u32>,
    reactions_wrong: u64,
    invariants_broken: u64,
}

pub(super) fn run(args: &FaultsArgs) -> Result<(), Error> {
    let (seed, shards, out, quick) = (args.seed, &args.shards, &args.out, args.quick);
    if let Some(paths) = args.paths {
        let paths = if quick { paths.min(fault_paths::QUICK) } else { paths };
        return start::<fault_paths::Paths>(fault_paths::Options { paths, seed }, shards, out);
    }
    if let Some(hands) = args.hands {
        let hands = if quick { hands.min(fault_hands::QUICK) } else { hands };
        return start::<fault_hands::YieldingHands>(fault_hands::Options { hands, seed, quick }, shards, out);
    }
    if args.adversary {
        let rounds = args.rounds.unwrap_or(if quick { fault_adversary::QUICK_ROUNDS } else { fault_adversary::ROUNDS });
        return start::<fault_adversary::Search>(fault_adversary::Options { seed, rounds, again: args.genes }, shards, out);
    }
    if args.trade {
        let runs = if quick { fault_trade::QUICK_RUNS } else { fault_trade::RUNS };
        return start::<fault_trade::Trade>(fault_trade::Options { runs, seed }, shards, out);
    }
    let runs = args.runs.unwrap_or(if quick { 6_000 } else { 100_000 });
    start::<Faults>(Options { runs, seed, soak_s: args.soak_s }, shards, out)
}

impl Study for Faults {
    const ID: &'static str = "faults";
    type Options = Options;
    type Row = Kinds;

    fn load(options: Options) -> Result<Self, Error> {
        Ok(Self { options, device: DeviceProfile::load("touch")?, light: LightPatch::load()? })
    }

    fn options(&self) -> &Options {
        &self.options
    }

    fn cases(&self) -> u64 {
        self.options.runs
    }

    fn run(&self, cases: Range<u64>) -> Result<Vec<Kinds>, Error> {
        let progress = Progress::new(cases.end - cases.start, "runs");
        let table = campaign(&Ground::new(&self.device, &self.light), cases, self.options.seed, |n| progress.inc(n))?;
        progress.finish();
        Ok(vec![table])
    }

    fn findings(&self, parts: Vec<Kinds>) -> Result<Findings, Error> {
        let mut table = Kinds::default();
        parts.iter().for_each(|part| table.add(part));
        let kinds: Vec<Kind> = kinds(&table);
        let failed = kinds.iter().map(|row| row.invariants_broken + row.reactions_wrong > 0);
        let failed: Vec<bool> = failed.collect();
        let numbers: BTreeSet<u8> = table.rows.iter().flat_map(|row| row.faults.keys().copied()).collect();
        let peak_n = kinds.iter().map(|row| row.peak_force_n).fold(0.0, f32::max);
        let first = table.examples().first().map_or(String::new(), |first| format!("; the first: {first}"));
        let mut findings = Findings {
            headline: format!("strongest force {peak_n:.3} N"),
            claims: vec![Claim::promise(
                format!("runs with {} kinds of fault whose reaction is wrong or late, or that break an invariant", kinds.len()),
                "none",
                format!("{} of {}{first}", table.bad(), self.options.runs),
                table.bad() == 0,
            )],
            tables: vec![
                Table::of("reactions", &reactions(&table))?
                    .about("latest: ticks of 1 ms to no force or a falling one, in the slowest run; allowed: the most for that kind"),
                Table::of("faults", &kinds)?.only(failed),
            ],
            figures: vec![self.figure(&table)],
            ..Findings::default()
        };
        if findings.tables[1].is_cut() {
            findings.notes.extend(fault_paths::fault_names(numbers).into_iter().filter(|_| table.bad() > 0));
        }
        findings.fact("seed", self.options.seed);
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
        if self.options.soak_s == 0 {
            return Ok(None);
        }
        let ticks = u64::from(self.options.soak_s) * 1000;
        let progress = Progress::new(ticks, "ticks of normal use");
        let soaked = soak(&Ground::new(&self.device, &self.light), self.options.soak_s.into(), |n| progress.inc(n))?;
        progress.finish();
        Ok(Some(soaked))
    }

    fn judge_soak(&self, findings: &mut Findings, soaked: &Soak) {
        let trip = soaked.trips.first().map_or(String::new(), |(hand, what, fault)| format!("; the first: {hand} {what}, {fault}"));
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
                self.options.runs,
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

fn kinds(table: &Kinds) -> Vec<Kind> {
    let of = table.kinds().map(|(kind, row)| Kind {
        id: kind.id,
        fault: kind.name,
        must: must(&kind.expected),
        allowed_ticks: allowed(&kind.expected),
        runs: row.runs,
        injected: row.injected,
        faulted: row.detected,
        latest_reaction_ticks: row.latest_ticks(),
        peak_force_n: row.peak_n,
        invariants_broken: row.broken,
        reactions_wrong: row.wrong,
        ended_in: row.ends(),
    });
    of.collect()
}

fn reactions(table: &Kinds) -> Vec<Reaction> {
    let kinds = kinds(table);
    let of = |(must, what_has_to_follow): (&str, &'static str)| {
        let of: Vec<&Kind> = kinds.iter().filter(|kind| kind.must == must).collect();
        let slowest = of.iter().filter_map(|kind| Some((kind.latest_reaction_ticks?, kind.allowed_ticks))).max();
        let sum = |count: fn(&Kind) -> u64| of.iter().map(|kind| count(kind)).sum();
        Reaction {
            what_has_to_follow,
            kinds: of.len(),
            runs: sum(|kind| kind.runs),
            injected: sum(|kind| kind.injected),
            latest_reaction_ticks: slowest.map(|s| s.0),
            allowed_ticks: slowest.and_then(|s| s.1),
            reactions_wrong: sum(|kind| kind.reactions_wrong),
            invariants_broken: sum(|kind| kind.invariants_broken),
        }
    };
    FOLLOWS.map(of).into_iter().filter(|reaction| reaction.kinds > 0).collect()
}
