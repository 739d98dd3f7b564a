//! `palpate plan --scenes`: every scene of a folder planned for every board, in one table.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use palpate_tissue::Error as TissueError;
use palpate_tissue::fit_record::checksum;
use palpate_tissue::output::OutputFolder;
use palpate_tissue::shard::Heading;
use serde::{Deserialize, Serialize};

use super::super::Common;
use super::super::campaign::Campaign;
use super::super::scene_list::{Ended, SceneList, ends_all, why};
use super::super::verdict::Verdict;
use crate::command::options::pack::machine;
use crate::command::options::plan::PlanOptions;
use crate::error::Error;

/// The settings that determine the plans.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(in super::super) struct Options {
    #[serde(flatten)]
    pub plan: PlanOptions,
    pub boards: Vec<String>,
    /// Folder of the scenes and folder of their plans; neither affects the results.
    #[serde(skip)]
    pub scenes: PathBuf,
    #[serde(skip)]
    pub out: PathBuf,
}

/// The campaign of the plans of a folder's scenes for some boards.
pub(in super::super) struct PlanScenes {
    options: Options,
    scenes: SceneList,
}

/// A row of the table.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(in super::super) struct Row {
    /// Name of the scene file, without `.toml`.
    scene: String,
    board: String,
    ended: Ended,
    /// Reason why no model was found, if none was.
    why: Option<String>,
    plan: Option<Plan>,
}

/// The model that was chosen.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Plan {
    /// Path of the patch, relative to the folder of all plans.
    patch: String,
    patch_crc32: Option<u32>,
    nodes: usize,
    substeps: u16,
    /// Estimated cost of a tick, and its budget [units of the board].
    cost: f64,
    budget: f64,
    unit: String,
    rms_pct: f64,
    worst_pct: f64,
}

/// Contents of `summary.json`.
#[derive(Serialize)]
struct Summary<'a> {
    plans: usize,
    kept: usize,
    missed: usize,
    failed: usize,
    boards: &'a [String],
    plan: &'a PlanOptions,
    rows: &'a [Row],
}

/// Folders below --out: one for the plans, with a folder per scene and board, and one for the table
/// of all.
const PLANS: &str = "plans";
const TABLE: &str = "table";

impl Campaign for PlanScenes {
    type Options = Options;
    type Counts = Vec<Row>;
    const COMMAND: &'static str = "plan --scenes";

    fn load(options: Options) -> Result<Self, Error> {
        options.plan.check()?;
        for (n, board) in options.boards.iter().enumerate() {
            machine(board)?;
            if options.boards[..n].contains(board) {
                return Err(TissueError::Usage(format!("--board {board}: given twice: give each board once")).into());
            }
        }
        Ok(Self { scenes: SceneList::of(&options.scenes)?, options })
    }

    fn of_shards(options: Options, heading: &Heading) -> Result<Self, Error> {
        Ok(Self { scenes: SceneList::noted(&heading.inputs), options })
    }

    fn whole(out: &Path) -> PathBuf {
        out.join(TABLE)
    }

    fn options(&self) -> &Options {
        &self.options
    }

    fn cases(&self) -> u64 {
        self.scenes.len() * self.options.boards.len() as u64
    }

    fn inputs(&self) -> BTreeMap<String, String> {
        self.scenes.checksums().clone()
    }

    fn run(&self, cases: Range<u64>) -> Result<Vec<Row>, Error> {
        let boards = self.options.boards.len() as u64;
        let mut rows = Vec::new();
        for case in cases {
            let scene = case / boards;
            let board = &self.options.boards[(case % boards) as usize];
            for (name, file) in self.scenes.files(scene..scene + 1) {
                rows.push(self.plan(name, &file, board)?);
            }
        }
        Ok(rows)
    }

    fn add(rows: &mut Vec<Row>, next: Vec<Row>) {
        rows.extend(next);
    }

    fn report(&self, folder: OutputFolder, rows: Vec<Row>, _all: bool) -> Result<(), Error> {
        let count = |ended: Ended| rows.iter().filter(|row| row.ended == ended).count();
        let [kept, missed, failed] = [Ended::Kept, Ended::Missed, Ended::Failed].map(count);
        let (boards, plan) = (&self.options.boards[..], &self.options.plan);
        let summary = Summary { plans: rows.len(), kept, missed, failed, boards, plan, rows: &rows };
        folder.write("plans.csv", csv(&rows)?.as_bytes())?;
        folder.write_summary(&summary)?;
        let verdict =
            Verdict::of(judge(&rows, missed, failed), || format!("all {} plans keep the tolerance", rows.len()))?.first();
        print(&rows);
        println!("\nwrote {}: plans.csv, summary.json", folder.publish()?.display());
        verdict.last()
    }
}

fn judge(rows: &[Row], missed: usize, failed: usize) -> Result<(), Error> {
    let Some(first) = rows.iter().find(|row| row.ended != Ended::Kept) else { return Ok(()) };
    Err(TissueError::Check(format!(
        "of {} plans {failed} could not be made, {missed} found no model that keeps the tolerance; the first: {} on {}: {}",
        rows.len(),
        first.scene,
        first.board,
        first.why.as_deref().unwrap_or("-")
    ))
    .into())
}

impl PlanScenes {
    /// Plans one scene for one board. An error is recorded in its row and does not end the other
    /// plans.
    fn plan(&self, name: &str, file: &str, board: &str) -> Result<Row, Error> {
        println!("\n{file} on {board}");
        let machine = machine(board)?;
        let below = format!("{name}-{board}");
        let out = self.options.out.join(PLANS).join(&below);
        let row = |ended, why, plan| Row { scene: name.to_owned(), board: board.to_owned(), ended, why, plan };
        let found = self.options.plan.plan(&Common::of(file, None), machine, &out, false);
        let (outcome, patch) = match found {
            Ok(found) => found,
            Err(error) if ends_all(&error) => return Err(error),
            Err(error) => {
                println!("could not be planned: {error}");
                return Ok(row(Ended::Failed, Some(why(&error, name, file)), None));
            }
        };
        Ok(match outcome.check(machine, self.options.plan.tolerance_pct) {
            Err(missed) => row(Ended::Missed, Some(why(&missed.into(), name, file)), None),
            Ok(chosen) => {
                let patch = patch.unwrap_or_default();
                let plan = Plan {
                    patch_crc32: std::fs::read(out.join(&patch)).ok().and_then(|bytes| checksum(&bytes)),
                    patch: format!("{below}/{patch}"),
                    nodes: chosen.counts.nodes,
                    substeps: chosen.substeps,
                    cost: chosen.units,
                    budget: machine.budget(),
                    unit: machine.unit.to_owned(),
                    rms_pct: chosen.judged.rms_pct,
                    worst_pct: chosen.judged.worst_pct,
                };
                row(Ended::Kept, None, Some(plan))
            }
        })
    }
}

fn csv(rows: &[Row]) -> Result<String, Error> {
    let write = |e: csv::Error| TissueError::Write { path: "plans.csv".into(), source: std::io::Error::other(e) };
    let mut csv = csv::Writer::from_writer(Vec::new());
    let header = [
        "scene",
        "board",
        "ended",
        "nodes",
        "substeps",
        "cost_per_tick",
        "budget_per_tick",
        "unit",
        "rms_pct",
        "worst_pct",
        "patch",
        "patch_crc32",
        "why",
    ];
    csv.write_record(header).map_err(write)?;
    for row in rows {
        let text = |of: fn(&Plan) -> String| row.plan.as_ref().map_or(String::new(), of);
        csv.write_record([
            row.scene.clone(),
            row.board.clone(),
            row.ended.name().to_owned(),
            text(|plan| plan.nodes.to_string()),
            text(|plan| plan.substeps.to_string()),
            text(|plan| plan.cost.to_string()),
            text(|plan| plan.budget.to_string()),
            text(|plan| plan.unit.clone()),
            text(|plan| plan.rms_pct.to_string()),
            text(|plan| plan.worst_pct.to_string()),
            text(|plan| plan.patch.clone()),
            text(|plan| plan.patch_crc32.map_or(String::new(), |sum| format!("{sum:08x}"))),
            row.why.clone().unwrap_or_default(),
        ])
        .map_err(write)?;
    }
    let bytes = csv.into_inner().map_err(|e| TissueError::Write { path: "plans.csv".into(), source: e.into_error() })?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

fn print(rows: &[Row]) {
    println!(
        "\n{:<24} {:<8} {:<7} {:>5} {:>5} {:>8} {:>7} {:>8}  why",
        "scene", "board", "ended", "nodes", "steps", "load %", "rms %", "worst %"
    );
    for Row { scene, board, ended, why, plan } in rows {
        let ended = ended.name();
        let why = why.as_deref().unwrap_or("");
        match plan {
            Some(Plan { nodes, substeps, cost, budget, rms_pct, worst_pct, .. }) => println!(
                "{scene:<24} {board:<8} {ended:<7} {nodes:>5} {substeps:>5} {:>8.1} {rms_pct:>7.2} {worst_pct:>+8.2}  {why}",
                100.0 * cost / budget
            ),
            None => println!("{scene:<24} {board:<8} {ended:<7} {:>5} {:>5} {:>8} {:>7} {:>8}  {why}", "-", "-", "-", "-", "-"),
        }
    }
    println!("\nload: estimated cost of a tick, of what it may cost on the board; errors at places that no fit saw");
}
