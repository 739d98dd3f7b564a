//! The command `palpate chart`.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::chart::peers::{self, Peers, StandardPress};
use crate::chart::{Reference, Run, Scope, Task, figures, fronts, measure, moving_fronts, rows};
use crate::methods::{Block, Method};
use crate::study::{Findings, Study, Table, start};
use palpate_sim::command::options::chart::{ChartArgs, ChartOptions};
use palpate_sim::command::progress::Progress;
use palpate_sim::error::Error;
use palpate_tissue::Error as TissueError;
use palpate_tissue::machine;
use palpate_tissue::output::OutputFolder;

/// Conditions that all methods share, conditions in which they differ, and origin of the cycle
/// estimates.
const TERMS: [&str; 3] = [
    "contact: the same foundation points and law for all but implicit and compliance, which have unilateral contact at the nodes",
    "mass floor and damping: the same for all but implicit (true masses) and compliance (no masses)",
    "m4f_cycles are estimates: of ours from instruction counts, of the others from counted floating-point operations",
];

/// All methods at the same press.
pub(super) struct Chart {
    options: ChartOptions,
    scope: Scope,
    peers: Option<Peers>,
}

/// Rows of some cases. The times of a tick are passed on unchanged.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Rows {
    /// Processor on which the ticks were timed.
    processor: String,
    runs: Vec<Run>,
}

pub(super) fn run(args: &ChartArgs) -> Result<(), Error> {
    if args.press {
        let folder = OutputFolder::open(&args.out)?;
        StandardPress::new()?.write(&folder)?;
        println!("wrote {}: press.json", folder.publish()?.display());
        return Ok(());
    }
    start(Chart::of(&args.options)?, &args.cases, &args.out)
}

impl Chart {
    fn of(options: &ChartOptions) -> Result<Self, Error> {
        let mut scope = if options.quick { Scope::quick(options.moving) } else { Scope::full(options.moving) };
        scope.tasks.retain(|task| wants(options, task));
        if scope.tasks.is_empty() {
            let why = "--kpa and --nodes leave no row: give moduli and numbers of nodes that the chart has, 3.5 and 57 for one";
            return Err(TissueError::Usage(why.into()).into());
        }
        let peers = options.with.as_deref().map(Peers::load).transpose()?;
        Ok(Self { options: options.clone(), scope, peers })
    }
}

impl Study for Chart {
    type Row = Rows;

    fn cases(&self) -> u64 {
        self.groups().count() as u64
    }

    fn run(&self, cases: Range<u64>) -> Result<Vec<(u64, Rows)>, Error> {
        let runs = self.measure(cases.start as usize..cases.end as usize)?;
        Ok(vec![(cases.start, Rows { processor: machine::processor(), runs })])
    }

    fn findings(&self, parts: Vec<Rows>) -> Result<Findings, Error> {
        let mut runs = Vec::new();
        let processor = parts.first().map_or(String::new(), |part| part.processor.clone());
        for part in parts {
            if part.processor != processor {
                let why =
                    format!("cases were timed on {processor} and on {}: run all cases on one kind of processor", part.processor);
                return Err(TissueError::Usage(why).into());
            }
            runs.extend(part.runs);
        }
        let (fronts, moving_fronts) = (fronts(&runs), moving_fronts(&runs));
        let timed = || fronts.iter().filter(|point| point.cost == "tick_us");
        let ours = timed().filter(|point| point.method.starts_with("palpate")).count();
        let survived = runs.iter().filter(|run| run.survived().is_some()).count();
        let shown = fronts.iter().map(|point| point.cost == "tick_us").collect::<Vec<_>>();
        let about = format!(
            "rows that no other beats in both cost and error, from cheap to accurate; times are of {}; {}",
            processor,
            machine::build()
        );
        let mut findings = Findings {
            headline: format!(
                "{survived} of {} rows survive the press to 8 mm; {ours} of the {} rows that no other beats in both tick time and error are ours",
                runs.len(),
                timed().count()
            ),
            tables: vec![
                Table::of("fronts", &fronts)?.about(about).only(shown),
                Table::of("moving_fronts", &moving_fronts)?
                    .about("rows that no other beats in tick time, held and moving error together"),
                rows("chart", &runs).only(|_| false),
            ],
            figures: figures(&runs, &processor),
            notes: TERMS.map(str::to_owned).into(),
            ..Findings::default()
        };
        findings.fact("rows", runs.len());
        findings.fact("survived", survived);
        if moving_fronts.is_empty() {
            findings.tables.remove(1);
        }
        if let Some(peers) = &self.peers {
            peers::add(&mut findings, peers, &runs, self.options.moving)?;
        }
        Ok(findings)
    }
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
        let steps = Progress::new(total as u64, "chart");
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
}
