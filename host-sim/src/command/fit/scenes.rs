//! `palpate fit --scenes`: every scene of a folder fitted and evaluated for every board, in one
//! table.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::ops::Range;
use std::path::{Path, PathBuf};

use palpate_tissue::Error as TissueError;
use palpate_tissue::output::OutputFolder;
use palpate_tissue::trials::Trial;
use serde::{Deserialize, Serialize};

use super::super::Common;
use super::super::campaign::Campaign;
use super::super::scene_list::{Ended, SceneList, ends_all, named_as, why};
use super::super::verdict::Verdict;
use super::board::Load;
use super::{Fitted, Written};
use crate::command::options::fit::{FitArgs, FitOptions};
use crate::error::Error;

/// The campaign of the fits of a folder's scenes for some boards.
pub(in super::super) struct FitScenes {
    fit: FitOptions,
    boards: Vec<String>,
    scenes: SceneList,
    /// Folder of the folder of all fits.
    out: PathBuf,
}

/// A row of the table.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(in super::super) struct Row {
    /// Name of the scene file, without `.toml`.
    scene: String,
    board: Option<String>,
    ended: Ended,
    /// Reason why the fit missed the tolerance or failed, if it did.
    why: Option<String>,
    fit: Option<Fit>,
    trials: Vec<Trial>,
}

/// Fit of one scene.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Fit {
    /// Path of the patch, relative to the folder of all fits.
    patch: String,
    patch_crc32: u32,
    nodes: usize,
    rms_pct: f64,
    worst_pct: f64,
    from_m: f64,
    to_m: f64,
    /// Error of the finite elements themselves [%].
    reference_error_pct: Option<f64>,
    /// Cost of a tick on the board.
    load: Option<Load>,
}

/// Contents of `summary.json`.
#[derive(Serialize)]
struct Summary<'a> {
    fits: usize,
    kept: usize,
    missed: usize,
    failed: usize,
    /// Largest error over the scenes that have a patch.
    largest_rms_pct: Option<f64>,
    boards: &'a [String],
    fit: &'a FitOptions,
    rows: &'a [Row],
}

/// Folders below --out: one for the fits, with a folder per scene, and one for the table of all.
const FITS: &str = "fits";
const TABLE: &str = "table";

impl Campaign for FitScenes {
    type Row = Row;

    fn whole(&self, out: &Path) -> PathBuf {
        out.join(TABLE)
    }

    fn cases(&self) -> u64 {
        self.scenes.len() * self.boards.len().max(1) as u64
    }

    fn inputs(&self) -> BTreeMap<String, String> {
        self.scenes.checksums().clone()
    }

    fn run(&self, cases: Range<u64>) -> Result<Vec<(u64, Row)>, Error> {
        let boards = self.boards.len().max(1) as u64;
        let mut rows = Vec::new();
        for case in cases {
            let board = self.boards.get((case % boards) as usize);
            for (name, file) in self.scenes.files(case / boards..case / boards + 1) {
                rows.push((case, self.fit(name, &file, board)?));
            }
        }
        Ok(rows)
    }

    fn report(&self, folder: OutputFolder, rows: Vec<Row>, _all: bool) -> Result<(), Error> {
        let count = |ended: Ended| rows.iter().filter(|row| row.ended == ended).count();
        let [kept, missed, failed] = [Ended::Kept, Ended::Missed, Ended::Failed].map(count);
        let largest_rms_pct = rows.iter().filter_map(|row| Some(row.fit.as_ref()?.rms_pct)).reduce(f64::max);
        let boards = &self.boards[..];
        let summary = Summary { fits: rows.len(), kept, missed, failed, largest_rms_pct, boards, fit: &self.fit, rows: &rows };
        folder.write("fits.csv", csv(&rows)?.as_bytes())?;
        folder.write_summary(&summary)?;
        // one row per line, as in the shipped file
        let trials: Vec<String> =
            rows.iter().flat_map(|row| &row.trials).filter_map(|row| serde_json::to_string(row).ok()).collect();
        folder.write("trials.json", format!("[\n{}\n]\n", trials.join(",\n")).as_bytes())?;
        let verdict =
            Verdict::of(judge(&rows, missed, failed), || format!("all {} fits are within the tolerance", rows.len()))?.first();
        print(&rows);
        println!("\nwrote {}: fits.csv, summary.json, trials.json", folder.publish()?.display());
        verdict.last()
    }
}

fn judge(rows: &[Row], missed: usize, failed: usize) -> Result<(), Error> {
    let Some(first) = rows.iter().find(|row| row.ended != Ended::Kept) else { return Ok(()) };
    Err(TissueError::Check(format!(
        "of {} fits {failed} could not be made, {missed} miss the tolerance; the first: {}: {}",
        rows.len(),
        first.named(),
        first.why.as_deref().unwrap_or("-")
    ))
    .into())
}

impl Row {
    /// Name of the scene, and of the board if there is one.
    fn named(&self) -> String {
        self.board.as_ref().map_or_else(|| self.scene.clone(), |board| format!("{} on {board}", self.scene))
    }
}

impl FitScenes {
    pub(super) fn of(args: &FitArgs, scenes: &Path, out: &Path) -> Result<Self, Error> {
        let (fit, boards) = (args.options.clone(), args.board.clone());
        Ok(Self { fit, boards, scenes: SceneList::of(scenes)?, out: out.to_owned() })
    }

    /// Fits one scene for one board. An error is recorded in its row and does not end the other
    /// fits.
    fn fit(&self, name: &str, file: &str, board: Option<&String>) -> Result<Row, Error> {
        let below = board.map_or_else(|| name.to_owned(), |board| format!("{name}-{board}"));
        println!("\n{file}{}", board.map_or_else(String::new, |board| format!(" on {board}")));
        let out = self.out.join(FITS).join(&below);
        let args = FitArgs {
            common: Common::of(file, Some(out)),
            options: self.fit.clone(),
            board: board.cloned().into_iter().collect(),
            scenes: None,
            cases: Default::default(),
        };
        let row = |ended, why, fit, trials| Row { scene: name.to_owned(), board: board.cloned(), ended, why, fit, trials };
        Ok(match args.fit_scene() {
            Ok(Fitted { patch, trials, missed }) => {
                let ended = if missed.is_some() { Ended::Missed } else { Ended::Kept };
                let fit = patch.map(|Written { name, record, load, .. }| Fit {
                    patch: format!("{below}/{name}"),
                    patch_crc32: record.patch_crc32,
                    nodes: record.nodes,
                    rms_pct: record.judged.rms_pct,
                    worst_pct: record.judged.worst_pct,
                    from_m: record.judged.from_m,
                    to_m: record.judged.to_m,
                    reference_error_pct: record.reference_error_pct,
                    load,
                });
                row(ended, missed.map(|missed| named_as(&missed, name, file)), fit, trials)
            }
            Err(error) if ends_all(&error) => return Err(error),
            Err(error) => {
                println!("could not be fitted: {error}");
                row(Ended::Failed, Some(why(&error, name, file)), None, Vec::new())
            }
        })
    }
}

fn csv(rows: &[Row]) -> Result<String, Error> {
    let write = |e: csv::Error| TissueError::Write { path: "fits.csv".into(), source: std::io::Error::other(e) };
    let mut csv = csv::Writer::from_writer(Vec::new());
    let header = [
        "scene",
        "board",
        "ended",
        "nodes",
        "rms_pct",
        "worst_pct",
        "judged_from_m",
        "judged_to_m",
        "finite_elements_error_pct",
        "substeps",
        "cost_per_tick",
        "budget_per_tick",
        "unit",
        "patch",
        "patch_crc32",
        "why",
    ];
    csv.write_record(header).map_err(write)?;
    for row in rows {
        let number = |of: fn(&Fit) -> Option<f64>| row.fit.as_ref().and_then(of).map_or(String::new(), |n| n.to_string());
        let load = |of: fn(&Load) -> String| row.fit.as_ref().and_then(|fit| fit.load.as_ref()).map_or(String::new(), of);
        let text = |of: fn(&Fit) -> String| row.fit.as_ref().map_or(String::new(), of);
        csv.write_record([
            row.scene.clone(),
            row.board.clone().unwrap_or_default(),
            row.ended.name().to_owned(),
            text(|fit| fit.nodes.to_string()),
            number(|fit| Some(fit.rms_pct)),
            number(|fit| Some(fit.worst_pct)),
            number(|fit| Some(fit.from_m)),
            number(|fit| Some(fit.to_m)),
            number(|fit| fit.reference_error_pct),
            load(|load| load.substeps.to_string()),
            load(|load| load.units.to_string()),
            load(|load| load.budget.to_string()),
            load(|load| load.unit.clone()),
            text(|fit| fit.patch.clone()),
            text(|fit| format!("{:08x}", fit.patch_crc32)),
            row.why.clone().unwrap_or_default(),
        ])
        .map_err(write)?;
    }
    let bytes = csv.into_inner().map_err(|e| TissueError::Write { path: "fits.csv".into(), source: e.into_error() })?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

fn print(rows: &[Row]) {
    println!(
        "\n{:<24} {:<7} {:>5} {:>7} {:>8} {:>9} {:>6}  why",
        "scene", "ended", "nodes", "rms %", "worst %", "elements %", "load %"
    );
    for row in rows {
        let mut line = format!("{:<24} {:<7}", row.named(), row.ended.name());
        let _infallible = match &row.fit {
            Some(fit) => {
                let elements = fit.reference_error_pct.map_or("-".into(), |pct| format!("{pct:.2}"));
                let load = fit.load.as_ref().map_or("-".into(), |load| format!("{:.0}", load.pct()));
                write!(line, " {:>5} {:>7.2} {:>+8.2} {elements:>9} {load:>6}", fit.nodes, fit.rms_pct, fit.worst_pct)
            }
            None => write!(line, " {:>5} {:>7} {:>8} {:>9} {:>6}", "-", "-", "-", "-", "-"),
        };
        println!("{line}  {}", row.why.as_deref().unwrap_or(""));
    }
    println!(
        "\nforce errors at places and depths that the fit never saw; elements: how far the finite elements themselves may be off; load: estimated cost of a tick, of what it may cost on the board"
    );
}
