//! Reads the table of other engines' results, `peers.csv`. A table is refused unless it is complete
//! and was measured with this press.

use std::path::Path;

use super::press::StandardPress;
use crate::chart::{DEPTHS_M, Reference, moving};
use crate::error::Error;
use palpate_tissue::Error as TissueError;

/// Version of the table format.
const VERSION: &str = "1";
/// Columns before those of the forces and errors, and the single column after them.
const FIRST: [&str; 12] = [
    "engine",
    "version",
    "model",
    "settings",
    "mesh",
    "nodes",
    "tets",
    "youngs_modulus_pa",
    "substeps",
    "survives_8mm",
    "tick_min_us",
    "tick_median_us",
];
const LAST: &str = "force_read";
/// Largest accepted difference between the held error in a row and the one that follows from the
/// forces in it [%].
const SAME_PCT: f64 = 0.05;

/// Why a table of peers is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
enum PeerError {
    /// The first lines do not state a version that can be read.
    #[error("is no table of peers of version {VERSION}: write it with host-sim/lab/peers/run.py")]
    Version,
    /// The table was measured with a different press.
    #[error(
        "was measured at press {found}, this chart's is {wanted}: give run.py the press.json of `palpate chart --press`, and measure again"
    )]
    Scene { found: String, wanted: String },
    /// A column is missing, unknown or in the wrong place; the columns are counted from 1.
    #[error("column {at} is {found}, not {wanted}: write it with host-sim/lab/peers/run.py")]
    Column { at: usize, found: String, wanted: String },
    /// A value in a row cannot be read or is implausible; the lines are counted from 1.
    #[error("line {line}: {column} is {found:?}, not {wanted}: measure that row again")]
    Value { line: u64, column: String, found: String, wanted: String },
    /// The file is not text, or not a table.
    #[error("{0}: write it with host-sim/lab/peers/run.py")]
    Table(String),
    /// The table has no rows.
    #[error("has no rows: let host-sim/lab/peers/run.py finish one engine")]
    Empty,
}

/// Row of the table: an engine with one setting on one mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Peer {
    /// Name of the engine.
    pub engine: String,
    /// Version of the engine.
    pub version: String,
    /// Model of the tissue and kind of step.
    pub model: String,
    /// Name of the mesh, as in press.json.
    pub mesh: String,
    /// Number of nodes.
    pub nodes: usize,
    /// Number of tets.
    pub tets: usize,
    /// Young's modulus [Pa].
    pub youngs_modulus_pa: f64,
    /// Steps in a millisecond.
    pub substeps: u16,
    /// "yes", or how the deepest press fails.
    pub survives: String,
    /// Processor time of a tick in the fastest batch [us].
    pub tick_min_us: f64,
    /// Processor time of a tick in the median batch [us].
    pub tick_median_us: f64,
    /// Root mean square of the force errors in the holds that were reached [%].
    pub held_rms_pct: f64,
    /// Error in each ramp and in the tap, relative to the largest force in it [%]; `None` where the
    /// engine diverged.
    pub moving_pct: [Option<f64>; moving::SPEEDS_MM_PER_S.len()],
    /// Quantity of the engine from which the force was read.
    pub force_read: String,
}

impl Peer {
    /// Engine and model, separated by a space.
    pub fn name(&self) -> String {
        format!("{} {}", self.engine, self.model)
    }

    /// Root mean square error over the ramps and the tap [%]; `None` unless the engine survived all
    /// of them.
    pub fn moving_rms_pct(&self) -> Option<f64> {
        let mut sum = 0.0;
        for pct in self.moving_pct {
            sum += pct?.powi(2);
        }
        Some((sum / self.moving_pct.len() as f64).sqrt())
    }

    /// Whether the engine survived the deepest press.
    pub fn survived(&self) -> bool {
        self.survives == "yes"
    }
}

/// A table with the facts stated in its first lines.
#[derive(Clone, Debug, PartialEq)]
pub struct Peers {
    /// Processor on which the table was measured.
    pub machine: String,
    /// Day of the measurement.
    pub date: String,
    /// Rows in the order of the file.
    pub rows: Vec<Peer>,
}

impl Peers {
    /// Reads a table that was measured with the standard press.
    pub fn load(file: &Path) -> Result<Self, Error> {
        let text = std::fs::read_to_string(file).map_err(|source| TissueError::Read { path: file.into(), source })?;
        let hash = StandardPress::new()?.hash()?;
        Self::parse(&text, &hash).map_err(|wrong| TissueError::Usage(format!("{}: {wrong}", file.display())).into())
    }

    /// Reads the text of a table, which must have been measured with the press of this checksum.
    fn parse(text: &str, hash: &str) -> Result<Self, PeerError> {
        let said = |key: &str| {
            let lines = text.lines().take_while(|line| line.starts_with('#'));
            lines
                .filter_map(|line| line.trim_start_matches('#').split_once('='))
                .find_map(|(name, value)| (name.trim() == key).then(|| value.trim().to_owned()))
        };
        if said("peers").as_deref() != Some(VERSION) {
            return Err(PeerError::Version);
        }
        let found = said("scene").unwrap_or_else(|| "unnamed".into());
        if found != hash {
            return Err(PeerError::Scene { found, wanted: hash.into() });
        }
        let wrong = |cause: csv::Error| PeerError::Table(cause.to_string());
        let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes());
        let columns = columns();
        let header = reader.headers().map_err(wrong)?.clone();
        for at in 0..header.len().max(columns.len()) {
            let (found, wanted) = (header.get(at), columns.get(at).map(String::as_str));
            if found != wanted {
                let quoted = |name: Option<&str>| name.map_or("none".into(), |name| format!("{name:?}"));
                return Err(PeerError::Column { at: at + 1, found: quoted(found), wanted: quoted(wanted) });
            }
        }
        let mut rows = Vec::new();
        for record in reader.records() {
            let record = record.map_err(wrong)?;
            rows.push(
                Cells { line: record.position().map_or(0, csv::Position::line), columns: &columns, record: &record }.peer()?,
            );
        }
        if rows.is_empty() {
            return Err(PeerError::Empty);
        }
        let or_unnamed = |key| said(key).unwrap_or_else(|| "not named".into());
        Ok(Self { machine: or_unnamed("machine"), date: or_unnamed("date"), rows })
    }
}

/// Names of all columns, in order.
pub fn columns() -> Vec<String> {
    let mut names = FIRST.map(String::from).to_vec();
    names.extend(DEPTHS_M.map(|d| format!("force_{}mm_n", d * 1e3)));
    names.push("held_rms_pct".into());
    names.extend(moving::SPEEDS_MM_PER_S.map(|v| format!("moving_{v}_mm_per_s_pct")));
    names.push(LAST.into());
    names
}

struct Cells<'a> {
    line: u64,
    columns: &'a [String],
    record: &'a csv::StringRecord,
}

impl Cells<'_> {
    fn text(&self, column: &str) -> &str {
        let at = self.columns.iter().position(|name| name == column);
        at.and_then(|at| self.record.get(at)).unwrap_or_default().trim()
    }

    fn wrong(&self, column: &str, wanted: &str) -> PeerError {
        PeerError::Value { line: self.line, column: column.into(), found: self.text(column).into(), wanted: wanted.into() }
    }

    fn word(&self, column: &str) -> Result<String, PeerError> {
        match self.text(column) {
            "" => Err(self.wrong(column, "a name")),
            word => Ok(word.into()),
        }
    }

    fn positive(&self, column: &str) -> Result<f64, PeerError> {
        let value = self.text(column).parse().ok().filter(|v: &f64| v.is_finite() && *v > 0.0);
        value.ok_or_else(|| self.wrong(column, "a finite number above 0"))
    }

    /// A positive value, or `None` if the cell is empty.
    fn perhaps(&self, column: &str) -> Result<Option<f64>, PeerError> {
        if self.text(column).is_empty() { Ok(None) } else { self.positive(column).map(Some) }
    }

    fn count(&self, column: &str) -> Result<usize, PeerError> {
        self.text(column).parse().ok().filter(|n| *n > 0).ok_or_else(|| self.wrong(column, "a whole number above 0"))
    }

    fn peer(&self) -> Result<Peer, PeerError> {
        let youngs_modulus_pa = self.positive("youngs_modulus_pa")?;
        let held_rms_pct = self.positive("held_rms_pct")?;
        let of_forces = self.held_rms_pct(youngs_modulus_pa)?;
        if (held_rms_pct - of_forces).abs() > SAME_PCT {
            return Err(self.wrong("held_rms_pct", &format!("the {of_forces:.2} that its forces make against the reference")));
        }
        let mut moving_pct = [None; moving::SPEEDS_MM_PER_S.len()];
        for (pct, speed) in moving_pct.iter_mut().zip(moving::SPEEDS_MM_PER_S) {
            *pct = self.perhaps(&format!("moving_{speed}_mm_per_s_pct"))?;
        }
        let substeps = self.count("substeps")?;
        Ok(Peer {
            engine: self.word("engine")?,
            version: self.word("version")?,
            model: self.word("model")?,
            mesh: self.word("mesh")?,
            nodes: self.count("nodes")?,
            tets: self.count("tets")?,
            youngs_modulus_pa,
            substeps: u16::try_from(substeps).map_err(|_| self.wrong("substeps", "at most 65535"))?,
            survives: self.word("survives_8mm")?,
            tick_min_us: self.positive("tick_min_us")?,
            tick_median_us: self.positive("tick_median_us")?,
            held_rms_pct,
            moving_pct,
            force_read: self.word(LAST)?,
        })
    }

    /// Recomputes the held error of the row from its forces.
    fn held_rms_pct(&self, youngs_modulus_pa: f64) -> Result<f64, PeerError> {
        let reference = Reference::block();
        let mut squares = Vec::new();
        for depth_m in DEPTHS_M {
            let column = format!("force_{}mm_n", depth_m * 1e3);
            let text = self.text(&column);
            if text.is_empty() {
                continue;
            }
            // a force of the wrong sign is accepted: it merely gives a large error
            let force_n = text.parse().ok().filter(|v: &f64| v.is_finite());
            let force_n = force_n.ok_or_else(|| self.wrong(&column, "a finite number"))?;
            let truth_m2 = reference.force_over_e_m2(depth_m);
            squares.extend(truth_m2.map(|truth| ((force_n / youngs_modulus_pa / truth - 1.0) * 100.0).powi(2)));
        }
        if squares.is_empty() {
            return Err(self.wrong("force_1mm_n", "the force of a hold"));
        }
        Ok((squares.iter().sum::<f64>() / squares.len() as f64).sqrt())
    }
}
