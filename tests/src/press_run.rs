//! Runs of `press`, with their results read back.

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::palpate_command::{Desk, Outcome, palpate, repository};

/// A block small enough that a run takes a tenth of a second.
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

/// A text with one part in place of another, which must be there exactly once.
///
/// # Panics
/// It does not occur exactly once, so the test would be void.
#[must_use]
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
    /// Reads CSV.
    ///
    /// # Panics
    /// The file is missing, a cell is no number, a row has another length than the header.
    #[must_use]
    pub fn read(path: &Path) -> Self {
        let text = std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let mut lines = text.lines();
        let header: Vec<String> = lines.next().unwrap_or_default().split(',').map(str::to_owned).collect();
        let number = |cell: &str| cell.parse().unwrap_or_else(|e| panic!("{}: `{cell}`: {e}", path.display()));
        let rows: Vec<Vec<f64>> = lines.map(|line| line.split(',').map(number).collect()).collect();
        assert!(rows.iter().all(|r| r.len() == header.len()), "{}: a row is longer or shorter than the header", path.display());
        Self { header, rows }
    }

    /// A column by name.
    ///
    /// # Panics
    /// There is no such column.
    #[must_use]
    pub fn column(&self, name: &str) -> Vec<f64> {
        let at = self.header.iter().position(|h| h == name).unwrap_or_else(|| panic!("no column {name} in {:?}", self.header));
        self.rows.iter().map(|r| r[at]).collect()
    }
}

/// A finished press.
#[derive(Debug)]
pub struct PressRun {
    /// Machine on which it ran.
    pub desk: Desk,
    /// Output folder.
    pub out: PathBuf,
    /// Exit code and output of the command.
    pub outcome: Outcome,
    /// `summary.json`.
    pub summary: Value,
    /// `trace.csv`.
    pub trace: Table,
}

/// A hold of `summary.json`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hold {
    /// Target as in the scene: depth or hand place [m], or force [N].
    pub target: f64,
    /// Depth that was reached [m].
    pub depth_m: f64,
    /// Force along the press [N].
    pub force_n: f64,
    /// Smallest tet volume over its rest volume (1).
    pub min_j: f64,
}

/// Presses the text of a scene file and reads the results. `scratch` is
/// `env!("CARGO_TARGET_TMPDIR")`.
///
/// # Panics
/// It did not exit with 0, or a file is missing.
#[must_use]
pub fn press(scratch: &str, scene: &str) -> PressRun {
    press_at(scratch, Desk::default(), scene, &[])
}

/// Like [`press`], on a desk that holds the files that the scene names, with more options.
///
/// # Panics
/// Panics of [`press`].
#[must_use]
pub fn press_at(scratch: &str, desk: Desk, scene: &str, options: &[&str]) -> PressRun {
    desk.put("scene.toml", scene);
    let outcome = palpate(scratch, desk.folder(), &[&["press", "--scene", "scene.toml", "--out", "out"], options].concat());
    PressRun::read(desk, outcome)
}

/// Presses a preset from the repository's root, where its mesh is found.
///
/// # Panics
/// Panics of [`press`].
#[must_use]
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
        let summary = serde_json::from_str(&json).expect("the summary is JSON");
        let trace = Table::read(&out.join("trace.csv"));
        Self { desk, out, outcome, summary, trace }
    }

    /// A number of the summary by its path, such as `/report/mass_g`.
    ///
    /// # Panics
    /// It is not there or no number.
    #[must_use]
    pub fn number(&self, path: &str) -> f64 {
        self.summary.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("no number {path} in {}", self.summary))
    }

    /// The holds.
    ///
    /// # Panics
    /// One lacks a number.
    #[must_use]
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

    /// Forces of the holds [N].
    #[must_use]
    pub fn forces_n(&self) -> Vec<f64> {
        self.holds().iter().map(|h| h.force_n).collect()
    }

    /// `surface_<k>.csv`.
    #[must_use]
    pub fn surface(&self, k: usize) -> Table {
        Table::read(&self.out.join(format!("surface_{k}.csv")))
    }
}
