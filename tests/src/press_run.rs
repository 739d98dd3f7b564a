//! Runs of `press` and their results, read back from the files.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use serde_json::Value;

use crate::palpate_command::{Desk, Outcome, palpate, repository};

/// Scene of a block small enough that a run takes a tenth of a second.
pub const SMALL_BLOCK: &str = r#"name = "small"
[tissue]
block_m = [0.08, 0.08, 0.04]
youngs_modulus_pa = 3500.0
poisson_ratio = 0.45
density_kg_per_m3 = 1060.0
nodes = 129
[probe]
shape = "hemisphere"
radius_m = 0.008
position_m = [0.0, 0.0]
[drive]
kind = "depth"
holds_m = [0.001, 0.002, 0.004]
ramp_m_per_s = 0.04
hold_s = 0.3
"#;

/// Replaces a part of a text that occurs exactly once.
///
/// # Panics
/// Panics if the part does not occur exactly once, because the test would then check nothing.
pub fn edited(text: &str, from: &str, to: &str) -> String {
    assert_eq!(text.matches(from).count(), 1, "`{from}` in:\n{text}");
    text.replace(from, to)
}

/// A table of numbers with named columns.
#[derive(Clone, Debug)]
pub struct Table {
    /// Names of the columns.
    pub header: Vec<String>,
    /// Numbers, shape \[rows\]\[columns\].
    pub rows: Vec<Vec<f64>>,
}

impl Table {
    /// Reads a CSV file.
    ///
    /// # Panics
    /// Panics if the file is missing, a cell is not a number, or a row has more or fewer cells than
    /// the header.
    pub fn read(path: &Path) -> Self {
        let text = std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let mut lines = text.lines();
        let header: Vec<String> = lines.next().unwrap_or_default().split(',').map(str::to_owned).collect();
        let number = |cell: &str| cell.parse().unwrap_or_else(|e| panic!("{}: `{cell}`: {e}", path.display()));
        let rows: Vec<Vec<f64>> = lines.map(|line| line.split(',').map(number).collect()).collect();
        assert!(rows.iter().all(|r| r.len() == header.len()), "{}: a row is longer or shorter than the header", path.display());
        Self { header, rows }
    }

    /// Values of a column, by its name.
    ///
    /// # Panics
    /// Panics if there is no such column.
    pub fn column(&self, name: &str) -> Vec<f64> {
        let at = self.header.iter().position(|h| h == name).unwrap_or_else(|| panic!("no column {name} in {:?}", self.header));
        self.rows.iter().map(|r| r[at]).collect()
    }
}

/// Results of a finished press.
#[derive(Debug)]
pub struct PressRun {
    /// Folder in which the command ran; dropped with the run.
    _desk: Option<Desk>,
    /// Folder in which the run left its result.
    pub out: PathBuf,
    /// Exit code and output of the command.
    pub outcome: Outcome,
    /// Contents of `summary.json`.
    pub summary: Value,
    /// Contents of `trace.csv`.
    pub trace: Table,
    /// Contents of `surface_<k>.csv`, one per hold.
    surfaces: Vec<Table>,
}

/// A hold of `summary.json`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hold {
    /// Target as in the scene: depth or hand position [m], or force [N].
    pub target: f64,
    /// Depth reached [m].
    pub depth_m: f64,
    /// Force along the direction of the press [N].
    pub force_n: f64,
    /// Smallest ratio of a tet's volume to its rest volume (1).
    pub min_j: f64,
}

/// Runs `press` on the text of a scene file and reads the results. `scratch` is
/// `env!("CARGO_TARGET_TMPDIR")`.
///
/// # Panics
/// Panics if `press` does not exit with 0 or a file is missing.
pub fn press(scratch: &str, scene: &str) -> PressRun {
    press_at(scratch, Desk::default(), scene, &[])
}

/// The press of [`SMALL_BLOCK`], which many tests compare with: run once in each test program. Its
/// tables stay, its folder is deleted.
///
/// # Panics
/// Panics as [`press`] does.
pub fn small_block(scratch: &str) -> &'static PressRun {
    static RUN: OnceLock<PressRun> = OnceLock::new();
    RUN.get_or_init(|| PressRun { _desk: None, ..press(scratch, SMALL_BLOCK) })
}

/// Like [`press`], with more options and in a folder that holds the files that the scene names.
///
/// # Panics
/// Panics as [`press`] does.
pub fn press_at(scratch: &str, desk: Desk, scene: &str, options: &[&str]) -> PressRun {
    desk.put("scene.toml", scene);
    let outcome = palpate(scratch, desk.folder(), &[&["press", "--scene", "scene.toml", "--out", "out"], options].concat());
    PressRun::read(desk, outcome)
}

/// Presses a preset from the repository's root, where the path of its mesh is valid.
///
/// # Panics
/// Panics as [`press`] does.
pub fn press_preset(scratch: &str, name: &str) -> PressRun {
    let desk = Desk::default();
    let out = desk.folder().join("out");
    let outcome = palpate(scratch, repository(), &["press", "--scene", name, "--out", &out.to_string_lossy()]);
    PressRun::read(desk, outcome)
}

impl PressRun {
    fn read(desk: Desk, outcome: Outcome) -> Self {
        assert_eq!(outcome.code, Some(0), "{outcome:?}");
        let out = desk.folder().join("out");
        let json = std::fs::read_to_string(out.join("summary.json")).expect("press writes a summary");
        let summary: Value = serde_json::from_str(&json).expect("the summary is JSON");
        let trace = Table::read(&out.join("trace.csv"));
        let holds = summary["holds"].as_array().map_or(0, Vec::len);
        let surfaces = (0..holds).map(|k| Table::read(&out.join(format!("surface_{k}.csv")))).collect();
        Self { _desk: Some(desk), out, outcome, summary, trace, surfaces }
    }

    /// A number in the summary, by its path, such as `/report/mass_g`.
    ///
    /// # Panics
    /// Panics if the number is missing or not a number.
    pub fn number(&self, path: &str) -> f64 {
        self.summary.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("no number {path} in {}", self.summary))
    }

    /// Holds listed in the summary.
    ///
    /// # Panics
    /// Panics if a hold lacks a number.
    pub fn holds(&self) -> Vec<Hold> {
        let holds = self.summary["holds"].as_array().expect("holds is a list");
        let number = |h: &Value, key: &str| h[key].as_f64().unwrap_or_else(|| panic!("{key} of {h}"));
        let hold = |h| Hold {
            target: number(h, "target"),
            depth_m: number(h, "depth_m"),
            force_n: number(h, "force_n"),
            min_j: number(h, "min_j"),
        };
        holds.iter().map(hold).collect()
    }

    /// Forces at the holds [N].
    pub fn forces_n(&self) -> Vec<f64> {
        self.holds().iter().map(|h| h.force_n).collect()
    }

    /// Table `surface_<k>.csv` of hold `k`.
    pub fn surface(&self, k: usize) -> &Table {
        &self.surfaces[k]
    }
}
