//! `palpate chart`.

mod peer_report;

use std::path::PathBuf;

use clap::Args;

use super::progress::Steps;
use crate::error::Error;
use palpate_lab::chart::peers::{Peers, StandardPress};
use palpate_lab::chart::{
    MovingPoint, Reference, Run, Scope, Summary, Task, TermErrors, draw, measure, term_errors, write, write_term_errors,
};
use palpate_lab::methods::{Block, Method};
use palpate_tissue::Error as TissueError;
use palpate_tissue::output::OutputFolder;

/// Nodes and Young's modulus [Pa] of the block on which the terms are measured.
const NODES: usize = 410;
const QUICK_NODES: usize = 130;
const TERMS_PA: f64 = 20e3;

#[derive(Args, Clone, Debug)]
pub(super) struct ChartArgs {
    /// Only the two smallest meshes at 3.5 kPa: under a minute.
    #[arg(long)]
    quick: bool,
    /// Also measure the force while the probe moves, against finite elements with true masses, and
    /// try shorter substeps: three times the rows, and 100 kPa besides.
    #[arg(long)]
    moving: bool,
    /// Also measure every method in tissue that relaxes, stiffens and rubs; the others have no such
    /// terms, and their errors say what that costs.
    #[arg(long)]
    terms: bool,
    /// Only this Young's modulus, of those of the chart [kPa].
    #[arg(long, value_name = "KPA")]
    kpa: Option<f64>,
    /// Only these numbers of nodes, of those of the chart.
    #[arg(long, value_name = "N", value_delimiter = ',')]
    nodes: Vec<usize>,
    /// Also draw and compare what engines of other people did at this press: the peers.csv that
    /// host-sim/lab/peers/run.py wrote.
    #[arg(long, value_name = "FILE")]
    with: Option<PathBuf>,
    /// Only write press.json, what engines of other people must know to do the same press; see
    /// host-sim/lab/peers.
    #[arg(long, conflicts_with_all = ["quick", "moving", "terms", "with"])]
    press: bool,
    /// Output folder, made if it is not there; replaces an earlier result in it when the run is
    /// done.
    #[arg(long, value_name = "FOLDER", default_value = "out/chart")]
    out: PathBuf,
}

impl ChartArgs {
    pub(super) fn run(&self) -> Result<(), Error> {
        let peers = self.with.as_deref().map(Peers::load).transpose()?;
        let mut scope = if self.quick { Scope::quick(self.moving) } else { Scope::full(self.moving) };
        scope.tasks.retain(|task| self.wants(task));
        if scope.tasks.is_empty() {
            let why = "--kpa and --nodes leave no row: give moduli and numbers of nodes that the chart has, 3.5 and 57 for one";
            return Err(TissueError::Usage(why.into()).into());
        }
        let folder = OutputFolder::open(&self.out)?;
        if self.press {
            StandardPress::new()?.write(&folder)?;
            println!("wrote {}: press.json", folder.publish()?.display());
            return Ok(());
        }
        let runs = run_all(&scope)?;
        let summary = Summary::of(&runs);
        write(&folder, &runs, &summary)?;
        draw(&folder, &runs)?;
        print_table(&runs);
        print_fronts(&summary);
        if let Some(peers) = &peers {
            peer_report::add(&folder, peers, &runs, self.moving)?;
        }
        if self.terms {
            let errors = terms(if self.quick { QUICK_NODES } else { NODES })?;
            write_term_errors(&folder, &errors)?;
            print_terms(&errors);
        }
        println!("\nwrote {}: summary.json, chart.csv, pictures as SVG and PNG", folder.publish()?.display());
        Ok(())
    }
}

impl ChartArgs {
    fn wants(&self, task: &Task) -> bool {
        let modulus = self.kpa.is_none_or(|kpa| (task.youngs_modulus_pa * 1e-3 - kpa).abs() < 1e-9);
        modulus && (self.nodes.is_empty() || self.nodes.contains(&task.nodes))
    }
}

/// Every method in tissue with terms, on the block of 20 kPa.
fn terms(nodes: usize) -> Result<Vec<TermErrors>, Error> {
    let steps = Steps::new("terms", Method::ALL.len());
    let mut found = Vec::new();
    for (n, method) in Method::ALL.into_iter().enumerate() {
        steps.show(n, Method::ALL.len(), method.name());
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

fn print_terms(errors: &[TermErrors]) {
    println!(
        "\nerror where the tissue relaxes, stiffens, rubs; ours with these terms, the others have none\n{:<22} {:>5} {:>6} {:>12} {:>12} {:>14} {:>12}",
        "method", "nodes", "terms", "held 1 s %", "held 10 s %", "b 10, 6 mm %", "sideways %"
    );
    let said = |pct: Option<f64>| pct.map_or("diverges".into(), |pct| format!("{pct:+.1}"));
    for row in errors {
        let ([one, ten], has) = (row.held_pct.map(said), if row.has_terms { "with" } else { "none" });
        let (deep, sideways) = (said(row.stiffening_pct), said(row.sideways_pct));
        println!("{:<22} {:>5} {has:>6} {one:>12} {ten:>12} {deep:>14} {sideways:>12}", row.method, row.nodes);
    }
}

fn run_all(scope: &Scope) -> Result<Vec<Run>, Error> {
    let reference = Reference::block();
    let steps = Steps::new("chart", scope.tasks.len());
    let mut block: Option<Block> = None;
    let mut runs = Vec::with_capacity(scope.tasks.len());
    let same_but_split =
        |a: &Task, b: &Task| (a.method, a.nodes, a.youngs_modulus_pa) == (b.method, b.nodes, b.youngs_modulus_pa);
    let mut done = 0;
    for tasks in scope.tasks.chunk_by(same_but_split) {
        let Some(&task) = tasks.first() else { continue };
        steps.show(done, scope.tasks.len(), &format!("{} {} nodes", task.method.name(), task.nodes));
        done += tasks.len();
        if task.method == Method::Calibrated {
            // its patch brings its own mesh
            if let Some(own) = Block::calibrated(task.nodes, task.youngs_modulus_pa) {
                runs.extend(measure(tasks, &own, &reference, scope.moving)?);
            }
            continue;
        }
        let same = |b: &Block| b.size().nodes == task.nodes && f64::from(b.params.youngs_modulus_pa) == task.youngs_modulus_pa;
        let block = match block.take().filter(same) {
            Some(kept) => block.insert(kept),
            None => block.insert(Block::standard(task.nodes, task.youngs_modulus_pa)?),
        };
        runs.extend(measure(tasks, block, &reference, scope.moving)?);
    }
    steps.finish();
    Ok(runs)
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

fn print_fronts(summary: &Summary) {
    println!("\nmachine: {}; {}", summary.machine, summary.build);
    for front in &summary.fronts {
        let points: Vec<String> = front.points.iter().map(|p| format!("{} {} x{}", p.method, p.nodes, p.substeps)).collect();
        println!("front of {} over {} at {} kPa: {}", front.error, front.cost, front.youngs_modulus_pa * 1e-3, points.join(", "));
    }
    for front in &summary.moving_fronts {
        println!(
            "\nfront of tick time, held and moving error together at {} kPa: nothing is as good in all three",
            front.youngs_modulus_pa * 1e-3
        );
        println!("{:<22} {:>5} {:>5} {:>9} {:>7} {:>8}", "method", "nodes", "steps", "us/tick", "held %", "moving %");
        for MovingPoint { method, nodes, substeps, tick_us, held_rms_pct, moving_rms_pct } in &front.points {
            println!("{method:<22} {nodes:>5} {substeps:>5} {tick_us:>9.1} {held_rms_pct:>7.1} {moving_rms_pct:>8.1}");
        }
    }
}
