//! The command `palpate faults`.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::{fault_adversary, fault_hands, fault_paths, fault_trade};
use crate::faults::campaign::{Ground, LightPatch, Table, campaign};
use crate::faults::faulty::Expected;
use crate::faults::soak::{Soak, soak};
use palpate_charts::{self as charts, ReactionBar, ReactionTimes};
use palpate_loop::closed_loop::device::DeviceProfile;
use palpate_loop::closed_loop::hand::HANDS;
use palpate_sim::command::campaign::Campaign;
use palpate_sim::command::options::faults::FaultsArgs;
use palpate_sim::command::progress::Progress;
use palpate_sim::command::verdict::Verdict;
use palpate_sim::error::Error;
use palpate_tissue::Error as TissueError;
use palpate_tissue::output::OutputFolder;

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

/// The campaign of faults on one device.
pub(super) struct Faults {
    options: Options,
    device: DeviceProfile,
    light: LightPatch,
}

/// Contents of `summary.json`.
#[derive(Serialize)]
struct Summary {
    runs: u64,
    seed: u64,
    kinds: usize,
    hands: usize,
    injected: u64,
    invariants_broken: u64,
    reactions_wrong: u64,
    latest_reaction_ticks: u32,
    peak_force_n: f32,
    #[serde(skip_serializing_if = "Option::is_none")]
    soak: Option<SoakSummary>,
}

#[derive(Serialize)]
struct SoakSummary {
    seconds: f64,
    uses: u64,
    trips: usize,
    invariants_broken: usize,
    drift_m: f32,
    denormals: usize,
    peak_force_n: f32,
}

impl Summary {
    fn in_words(&self) -> String {
        let soaked = self.soak.as_ref().map_or(String::new(), |s| format!("; {:.0} s of normal use without a trip", s.seconds));
        format!(
            "{} runs with {} kinds of fault: every reaction right and in time, no invariant broken; strongest force {:.3} N{soaked}",
            self.runs, self.kinds, self.peak_force_n
        )
    }
}

pub(super) fn run(args: &FaultsArgs) -> Result<(), Error> {
    let (seed, soak_s) = (args.seed, args.soak_s);
    if let Some(paths) = args.paths {
        let paths = if args.quick { paths.min(fault_paths::QUICK) } else { paths };
        return fault_paths::Paths::start(fault_paths::Options { paths, seed }, &args.shards, &args.out);
    }
    if let Some(hands) = args.hands {
        let hands = if args.quick { hands.min(fault_hands::QUICK) } else { hands };
        let options = fault_hands::Options { hands, seed, quick: args.quick };
        return fault_hands::YieldingHands::start(options, &args.shards, &args.out);
    }
    if args.adversary {
        let rounds = if args.quick { fault_adversary::QUICK_ROUNDS } else { fault_adversary::ROUNDS };
        return fault_adversary::search(&args.out, seed, args.rounds.unwrap_or(rounds), args.genes.as_deref());
    }
    if args.trade {
        let runs = if args.quick { fault_trade::QUICK_RUNS } else { fault_trade::RUNS };
        return fault_trade::run(&args.out, seed, runs);
    }
    let runs = args.runs.unwrap_or(if args.quick { 6_000 } else { 100_000 });
    Faults::start(Options { runs, seed, soak_s }, &args.shards, &args.out)
}

impl Campaign for Faults {
    type Options = Options;
    type Counts = Table;
    const COMMAND: &'static str = "faults";

    fn load(options: Options) -> Result<Self, Error> {
        Ok(Self { options, device: DeviceProfile::load("touch")?, light: LightPatch::load()? })
    }

    fn options(&self) -> &Options {
        &self.options
    }

    fn cases(&self) -> u64 {
        self.options.runs
    }

    fn run(&self, cases: Range<u64>) -> Result<Table, Error> {
        let progress = Progress::new(cases.end - cases.start, "runs");
        let table = campaign(&Ground::new(&self.device, &self.light), cases, self.options.seed, |n| progress.inc(n))?;
        progress.finish();
        Ok(table)
    }

    fn add(table: &mut Table, next: Table) {
        table.add(&next);
    }

    fn report(&self, folder: OutputFolder, table: Table, all: bool) -> Result<(), Error> {
        let soaked = self.soak()?;
        let summary = self.summary(&table, soaked.as_ref());
        folder.write("faults.csv", csv(&table).as_bytes())?;
        folder.write_summary(&summary)?;
        self.picture(&folder, &table)?;
        let verdict = Verdict::of(judge(&table, soaked.as_ref()), || summary.in_words())?.first();
        print(&table, &summary, all);
        println!("wrote {}: summary.json, faults.csv, faults.svg, faults.png", folder.publish()?.display());
        verdict.last()
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

    fn summary(&self, table: &Table, soaked: Option<&Soak>) -> Summary {
        let sum = |of: fn(&crate::faults::campaign::Row) -> u64| table.rows.iter().map(of).sum();
        Summary {
            runs: self.options.runs,
            seed: self.options.seed,
            kinds: table.rows.len(),
            hands: HANDS.len(),
            injected: sum(|r| r.injected),
            invariants_broken: sum(|r| r.broken),
            reactions_wrong: sum(|r| r.wrong),
            latest_reaction_ticks: table.rows.iter().filter_map(|r| r.latest_ticks()).max().unwrap_or_default(),
            peak_force_n: table.rows.iter().map(|r| r.peak_n).fold(0.0, f32::max),
            soak: soaked.map(|s| SoakSummary {
                seconds: s.ticks as f64 * 1e-3,
                uses: s.uses,
                trips: s.trips.len(),
                invariants_broken: s.broken.len(),
                drift_m: s.drift_m,
                denormals: s.denormals,
                peak_force_n: s.peak_n,
            }),
        }
    }

    fn picture(&self, folder: &OutputFolder, table: &Table) -> Result<(), Error> {
        let bars: Vec<ReactionBar> = table
            .kinds()
            .filter_map(|(kind, row)| {
                let ticks = row.reaction_span_ticks()?.map(f64::from);
                Some(ReactionBar { name: kind.name, ticks, allowed_ticks: allowed(&kind.expected).map(f64::from) })
            })
            .collect();
        let below = format!(
            "{} runs in {} hands; bar: fastest to slowest, dot: median, stroke: time allowed; none: not always recognised",
            self.options.runs,
            HANDS.len()
        );
        let title = "From a fault to no force, or to a falling one";
        charts::reaction_times(folder.draft(), "faults", &ReactionTimes { title, below: &below, bars: &bars })?;
        Ok(())
    }
}

/// Longest reaction time allowed [ticks]; `None` if no reaction is required.
fn allowed(expected: &Expected) -> Option<u32> {
    match *expected {
        Expected::Fault(_, ticks) | Expected::Ramp(ticks) | Expected::Degraded(ticks) => Some(ticks),
        Expected::Ridden | Expected::Bounded(_) | Expected::Nothing => None,
    }
}

fn must(expected: &Expected) -> &'static str {
    match expected {
        Expected::Fault(..) => "fault",
        Expected::Ridden => "go on",
        Expected::Bounded(_) => "bounded",
        Expected::Ramp(_) => "ramp",
        Expected::Degraded(_) => "weaken",
        Expected::Nothing => "nothing",
    }
}

fn csv(table: &Table) -> String {
    let mut text = String::from(
        "id,fault,must,allowed_ticks,runs,injected,faulted,latest_reaction_ticks,peak_force_n,invariants_broken,reactions_wrong,ended_in\n",
    );
    for (kind, row) in table.kinds() {
        let number = |n: Option<u32>| n.map_or(String::new(), |n| n.to_string());
        // writing to a string cannot fail
        let _ = writeln!(
            text,
            "{},\"{}\",{},{},{},{},{},{},{},{},{},{}",
            kind.id,
            kind.name,
            must(&kind.expected),
            number(allowed(&kind.expected)),
            row.runs,
            row.injected,
            row.detected,
            number(row.latest_ticks()),
            row.peak_n,
            row.broken,
            row.wrong,
            row.ends()
        );
    }
    text
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

/// Prints a row per required reaction, over all kinds of fault that require it.
fn print_by_reaction(table: &Table) {
    println!(
        "\nlatest: ticks of 1 ms from the fault to no force, or to a falling one, in the slowest run; allowed: the most for that kind of fault (-: no limit); wrong and broken runs: none may be"
    );
    println!(
        "{:<35} {:>5} {:>7} {:>9} {:>7} {:>8} {:>6} {:>7}",
        "what has to follow", "kinds", "runs", "injected", "latest", "allowed", "wrong", "broken"
    );
    for (follows, words) in FOLLOWS {
        let kinds: Vec<_> = table.kinds().filter(|(kind, _)| must(&kind.expected) == follows).collect();
        let rows: Vec<_> = kinds.iter().map(|(_, row)| *row).collect();
        if rows.is_empty() {
            continue;
        }
        let slowest = kinds.iter().filter_map(|(kind, row)| Some((row.latest_ticks()?, allowed(&kind.expected)))).max();
        let number = |ticks: Option<u32>| ticks.map_or("-".into(), |ticks| ticks.to_string());
        let (latest, allowed) = (number(slowest.map(|s| s.0)), number(slowest.and_then(|s| s.1)));
        println!(
            "{words:<35} {:>5} {:>7} {:>9} {latest:>7} {allowed:>8} {:>6} {:>7}",
            rows.len(),
            rows.iter().map(|row| row.runs).sum::<u64>(),
            rows.iter().map(|row| row.injected).sum::<u64>(),
            rows.iter().map(|row| row.wrong).sum::<u64>(),
            rows.iter().map(|row| row.broken).sum::<u64>()
        );
    }
}

fn print(table: &Table, summary: &Summary, all: bool) {
    print_by_reaction(table);
    print_kinds(table, all);
    if let Some(s) = &summary.soak {
        println!(
            "{:.0} s of normal use, {} touches: {} trips, {} invariants broken, patch back within {:.1e} m, {} denormal numbers",
            s.seconds, s.uses, s.trips, s.invariants_broken, s.drift_m, s.denormals
        );
    }
}

/// Prints a row per kind of fault, for all kinds or for those that failed.
fn print_kinds(table: &Table, all: bool) {
    let shown: Vec<_> = table.kinds().filter(|(_, row)| all || row.broken + row.wrong > 0).collect();
    if shown.is_empty() {
        println!("\n--all prints a row per kind of fault");
        return;
    }
    println!(
        "\n{:<11} {:<38} {:<8} {:>5} {:>5} {:>6} {:>6} {:>7} {:>7} {:>6} {:>5}  number of fault: runs",
        "id", "fault", "must", "runs", "came", "faults", "latest", "allowed", "peak N", "broken", "wrong"
    );
    let numbers: BTreeSet<u8> = shown.iter().flat_map(|(_, row)| row.faults.keys().copied()).collect();
    for (kind, row) in shown {
        let number = |ticks: Option<u32>| ticks.map_or("-".into(), |ticks| ticks.to_string());
        let (latest, allowed) = (number(row.latest_ticks()), number(allowed(&kind.expected)));
        println!(
            "{:<11} {:<38} {:<8} {:>5} {:>5} {:>6} {latest:>6} {allowed:>7} {:>7.3} {:>6} {:>5}  {}",
            kind.id,
            kind.name,
            must(&kind.expected),
            row.runs,
            row.injected,
            row.detected,
            row.peak_n,
            row.broken,
            row.wrong,
            row.ends()
        );
    }
    println!();
    fault_paths::name_faults(numbers);
    println!(
        "\nmust: what has to follow. came: runs in which the fault was injected; faults: those that ended in one; latest: ticks to no force, or to a falling one; allowed: the most that they may be (-: no limit)"
    );
    println!(
        "broken: an invariant of the loop; wrong: not what must follow, or too late. bounded: the loop may report a fault or not, and the invariants hold\n"
    );
}

fn judge(table: &Table, soaked: Option<&Soak>) -> Result<(), Error> {
    if table.bad() > 0 {
        let first = table.examples().first().copied().unwrap_or_default().to_owned();
        return Err(TissueError::Check(format!("{} of the runs went wrong; the first: {first}", table.bad())).into());
    }
    let Some(s) = soaked else { return Ok(()) };
    if let Some((hand, what, fault)) = s.trips.first() {
        return Err(
            TissueError::Check(format!("normal use tripped {} times; the first: {hand} {what}, {fault}", s.trips.len())).into()
        );
    }
    if let Some(broken) = s.broken.first() {
        return Err(TissueError::Check(format!("normal use broke {}: {}", broken.id, broken.what)).into());
    }
    // written so that NaN fails
    if !(s.drift_m <= DRIFT_M && s.denormals == 0) {
        return Err(TissueError::Check(format!(
            "after normal use the patch is {} m off, {} numbers are denormal",
            s.drift_m, s.denormals
        ))
        .into());
    }
    Ok(())
}
