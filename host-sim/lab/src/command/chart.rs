//! The command `palpate chart`.

mod peer_report;

use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::chart::peers::{Peers, StandardPress};
use crate::chart::{
    FrontPoint, MovingPoint, Reference, Run, Scope, Summary, Task, TermErrors, draw, measure, term_errors, write,
    write_term_errors,
};
use crate::methods::{Block, Method};
use palpate_sim::command::campaign::Campaign;
use palpate_sim::command::options::chart::{ChartArgs, ChartOptions};
use palpate_sim::command::progress::Steps;
use palpate_sim::command::verdict::Verdict;
use palpate_sim::error::Error;
use palpate_tissue::Error as TissueError;
use palpate_tissue::output::OutputFolder;

/// Nodes and Young's modulus [Pa] of the block on which the terms are measured.
const NODES: usize = 410;
const QUICK_NODES: usize = 130;
const TERMS_PA: f64 = 20e3;

/// The campaign of all methods at the same press.
pub(super) struct Chart {
    options: ChartOptions,
    scope: Scope,
    peers: Option<Peers>,
}

/// Rows of some cases. The times of a tick are passed on unchanged.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Rows {
    runs: Vec<Run>,
    terms: Vec<TermErrors>,
}

pub(super) fn run(args: &ChartArgs) -> Result<(), Error> {
    if args.press {
        let folder = OutputFolder::open(&args.out)?;
        StandardPress::new()?.write(&folder)?;
        println!("wrote {}: press.json", folder.publish()?.display());
        return Ok(());
    }
    Chart::start(args.options.clone(), &args.shards, &args.out)
}

impl Campaign for Chart {
    type Options = ChartOptions;
    type Counts = Rows;
    const COMMAND: &'static str = "chart";

    fn load(options: ChartOptions) -> Result<Self, Error> {
        let mut scope = if options.quick { Scope::quick(options.moving) } else { Scope::full(options.moving) };
        scope.tasks.retain(|task| wants(&options, task));
        if scope.tasks.is_empty() {
            let why = "--kpa and --nodes leave no row: give moduli and numbers of nodes that the chart has, 3.5 and 57 for one";
            return Err(TissueError::Usage(why.into()).into());
        }
        let peers = options.with.as_deref().map(Peers::load).transpose()?;
        Ok(Self { options, scope, peers })
    }

    fn options(&self) -> &ChartOptions {
        &self.options
    }

    fn cases(&self) -> u64 {
        let of_terms = if self.options.terms { Method::ALL.len() } else { 0 };
        (self.groups().count() + of_terms) as u64
    }

    fn run(&self, cases: Range<u64>) -> Result<Rows, Error> {
        // the numbers of the cases count the groups of rows first, then the terms
        let (first, end, groups) = (cases.start as usize, cases.end as usize, self.groups().count());
        let runs = self.measure(first.min(groups)..end.min(groups))?;
        let terms = self.terms(first.saturating_sub(groups)..end.saturating_sub(groups))?;
        Ok(Rows { runs, terms })
    }

    fn add(rows: &mut Rows, next: Rows) {
        rows.runs.extend(next.runs);
        rows.terms.extend(next.terms);
    }

    fn report(&self, folder: OutputFolder, Rows { runs, terms }: Rows, all: bool) -> Result<(), Error> {
        let summary = Summary::of(&runs, &self.options.processor);
        write(&folder, &runs, &summary)?;
        draw(&folder, &runs, &self.options.processor)?;
        let verdict = Verdict::ok(in_words(&summary)).first();
        if all {
            print_table(&runs);
        }
        print_fronts(&summary, all);
        if !all {
            println!(
                "\n--all prints a row per method, size and stiffness, and the same tables over estimated cycles of a Cortex-M4F"
            );
        }
        if let Some(peers) = &self.peers {
            peer_report::add(&folder, peers, &runs, self.options.moving)?;
        }
        if self.options.terms {
            write_term_errors(&folder, &terms)?;
            print_terms(&terms);
        }
        println!("\nwrote {}: summary.json, chart.csv, pictures as SVG and PNG", folder.publish()?.display());
        verdict.last()
    }
}

/// Says how many methods survived, and how many points of the front belong to our models.
fn in_words(summary: &Summary) -> String {
    let points = || summary.fronts.iter().filter(|front| front.cost == "tick_us").flat_map(|front| &front.points);
    let ours = points().filter(|point| point.method.starts_with("palpate")).count();
    format!(
        "{} of {} rows survive the press to 8 mm; {ours} of the {} rows that no other beats in both tick time and error are ours",
        summary.survived,
        summary.rows,
        points().count()
    )
}

/// Whether a row is among the requested ones.
fn wants(options: &ChartOptions, task: &Task) -> bool {
    let modulus = options.kpa.is_none_or(|kpa| (task.youngs_modulus_pa * 1e-3 - kpa).abs() < 1e-9);
    modulus && (options.nodes.is_empty() || options.nodes.contains(&task.nodes))
}

impl Chart {
    /// Groups of rows that share a method, a mesh and a stiffness, and thus the search for the
    /// substeps: each group is a case.
    fn groups(&self) -> impl Iterator<Item = &[Task]> {
        let key = |task: &Task| (task.method, task.nodes, task.youngs_modulus_pa);
        self.scope.tasks.chunk_by(move |a, b| key(a) == key(b))
    }

    fn measure(&self, groups: Range<usize>) -> Result<Vec<Run>, Error> {
        let chosen: Vec<&[Task]> = self.groups().skip(groups.start).take(groups.len()).collect();
        let total: usize = chosen.iter().map(|tasks| tasks.len()).sum();
        let reference = Reference::block();
        let steps = Steps::new("chart", total);
        let mut block: Option<Block> = None;
        let mut runs = Vec::with_capacity(total);
        let mut done = 0;
        for tasks in chosen {
            let Some(&task) = tasks.first() else { continue };
            steps.show(done, total, &format!("{} {} nodes", task.method.name(), task.nodes));
            done += tasks.len();
            if task.method == Method::Calibrated {
                // a calibrated patch has its own mesh
                if let Some(own) = Block::calibrated(task.nodes, task.youngs_modulus_pa) {
                    runs.extend(measure(tasks, &own, &reference, self.scope.moving)?);
                }
                continue;
            }
            let same =
                |b: &Block| b.size().nodes == task.nodes && f64::from(b.params.youngs_modulus_pa) == task.youngs_modulus_pa;
            let block = match block.take().filter(same) {
                Some(kept) => block.insert(kept),
                None => block.insert(Block::standard(task.nodes, task.youngs_modulus_pa)?),
            };
            runs.extend(measure(tasks, block, &reference, self.scope.moving)?);
        }
        steps.finish();
        Ok(runs)
    }

    /// Measures the methods with these numbers in tissue with terms, on the block of 20 kPa.
    fn terms(&self, methods: Range<usize>) -> Result<Vec<TermErrors>, Error> {
        let nodes = if self.options.quick { QUICK_NODES } else { NODES };
        let steps = Steps::new("terms", methods.len());
        let mut found = Vec::new();
        for (n, method) in Method::ALL.into_iter().skip(methods.start).take(methods.len()).enumerate() {
            steps.show(n, methods.len(), method.name());
            let block = match method {
                Method::Calibrated => Block::calibrated(nodes, TERMS_PA),
                _ => Some(Block::standard(nodes, TERMS_PA)?),
            };
            if let Some(block) = block {
                found.extend(term_errors(method, &block)?);
            }
        }
        steps.finish();
        Ok(found)
    }
}

fn print_terms(errors: &[TermErrors]) {
    println!(
        "\nerror where the tissue relaxes, stiffens, rubs; ours with these terms, the others have none\n{:<22} {:>5} {:>6} {:>12} {:>12} {:>14} {:>12}",
        "method", "nodes", "terms", "held 1 s %", "held 10 s %", "b 10, 6 mm %", "sideways %"
    );
    let said = |pct: Option<f64>| pct.map_or("diverges".into(), |pct| format!("{pct:+.1}"));
    for row in errors {
        let ([one, ten], has) = (row.held_pct.map(said), if row.has_terms { "with" } else { "none" });
        let (deep, sideways) = (said(row.stiffening_pct), said(row.sideways_pct));
        println!("{:<22} {:>5} {has:>6} {one:>12} {ten:>12} {deep:>14} {sideways:>12}", row.method.name(), row.nodes);
    }
}

fn print_table(runs: &[Run]) {
    println!(
        "{:<22} {:>5} {:>5} {:>5} {:>9} {:>8} {:>30} {:>6} {:>8} {:>8} {:>6} {:>8}",
        "method",
        "nodes",
        "kPa",
        "steps",
        "us/tick",
        "x spring",
        "force error % 1/2/4/8 mm",
        "RMS %",
        "u2 mm",
        "u4 mm",
        "min J",
        "moving %"
    );
    for run in runs {
        let task = run.task;
        print!("{:<22} {:>5} {:>5}", task.method.name(), task.nodes, task.youngs_modulus_pa * 1e-3);
        let Ok(m) = &run.outcome else {
            println!("   {}", run.verdict());
            continue;
        };
        let or_dash = |v: Option<f64>, digits: usize| v.map_or("-".into(), |v| format!("{v:.digits$}"));
        let signed = |v: Option<f64>| v.map_or("-".into(), |v| format!("{v:+.1}"));
        let [u2, u4] = m.accuracy.surface_error_mm;
        let errors = m.accuracy.force_error_pct.map(signed).join(" ");
        let (us, springs, rms) = (m.time.min_us, m.time.times_springs, or_dash(m.accuracy.rms_pct(), 1));
        print!(" {:>5} {us:>9.1} {springs:>8.1} {errors:>30} {rms:>6}", m.substeps);
        let moving = match m.moving {
            Some(Err(_)) => "diverges".into(),
            _ => or_dash(m.moving_rms_pct(), 1),
        };
        print!(" {:>8} {:>8} {:>6.2} {moving:>8}", or_dash(u2, 3), or_dash(u4, 3), m.trial.min_j);
        println!("{}", m.trial.failure.map_or(String::new(), |f| format!("  {f}")));
    }
}

/// Name of a cost or an error of a front, in words.
fn meaning(name: &str) -> &str {
    match name {
        "tick_us" => "the time of a tick on this machine [us]",
        "m4f_cycles" => "the cycles of a tick on a Cortex-M4F, by estimate",
        "force_rms_pct" => "the error of the held force [% rms]",
        "surface_mm" => "the error of the surface [mm]",
        "moving_rms_pct" => "the error of the force while the probe moves [% rms]",
        other => other,
    }
}

/// Prints tables of errors against tick time, and with `all` also against estimated cycles.
fn print_fronts(summary: &Summary, all: bool) {
    println!("times are of {}; {}", summary.machine, summary.build);
    println!(
        "each table: the rows that no other beats in both cost and error, from cheap to accurate; the first, of the force, matters most"
    );
    for front in summary.fronts.iter().filter(|front| all || front.cost != "m4f_cycles") {
        println!("\nat {} kPa: {}, against {}", front.youngs_modulus_pa * 1e-3, meaning(front.cost), meaning(front.error));
        println!("{:<22} {:>5} {:>8} {:>14} {:>14}", "method", "nodes", "substeps", front.cost, front.error);
        for FrontPoint { method, nodes, substeps, cost, error } in &front.points {
            println!("{method:<22} {nodes:>5} {substeps:>8} {cost:>14.1} {error:>14.3}");
        }
    }
    for front in &summary.moving_fronts {
        println!(
            "\nat {} kPa: tick time, held and moving error together; no other row is as good in all three",
            front.youngs_modulus_pa * 1e-3
        );
        println!("{:<22} {:>5} {:>5} {:>9} {:>7} {:>8}", "method", "nodes", "steps", "us/tick", "held %", "moving %");
        for MovingPoint { method, nodes, substeps, tick_us, held_rms_pct, moving_rms_pct } in &front.points {
            println!("{method:<22} {nodes:>5} {substeps:>5} {tick_us:>9.1} {held_rms_pct:>7.1} {moving_rms_pct:>8.1}");
        }
    }
}
