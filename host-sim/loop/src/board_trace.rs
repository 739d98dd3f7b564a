//! Table of the records that a board sends: `palpate board` writes it, `palpate live --follow`
//! reads it.
//!
//! One row per record, in the device frame: the origin is the site of the patch, and z points out
//! of the tissue. A row is complete once its line has ended.

use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use palpate::{ClampFlags, Fault};

/// Ticks between two records.
pub const RECORD_TICKS: u32 = 2;

/// Column headings; a heading ends with the unit where the column has one.
pub const COLUMNS: [&str; 24] = [
    "tick",
    "mode",
    "fault",
    "x_m",
    "y_m",
    "z_m",
    "depth_m",
    "model_x_n",
    "model_y_n",
    "model_z_n",
    "applied_x_n",
    "applied_y_n",
    "applied_z_n",
    "outputs_on",
    "code_x",
    "code_y",
    "code_z",
    "active_nodes",
    "limiters",
    "patch_limiters",
    "energy_given_j",
    "tick_us",
    "patch_checksum",
    "youngs_modulus_pa",
];

/// Advice at the end of every error about a file that is not such a table.
const FIX: &str = "give the file of `palpate board arm --stream FILE.csv`, or of its --out";

/// Fields of a board's record that the window shows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Row {
    /// Number of control cycles begun; wraps around at 2^32.
    pub tick: u32,
    /// Number of the loop's mode.
    pub mode: u8,
    /// Number of the latched fault; 0 without a fault.
    pub fault: u8,
    /// Position of the tip [m].
    pub tip_m: [f32; 3],
    /// Depth of the tip [m].
    pub depth_m: f32,
    /// Force that the board's patch computed [N].
    pub model_n: [f32; 3],
    /// Force that the loop applied to the device [N].
    pub applied_n: [f32; 3],
    /// Whether the outputs to the motors are enabled.
    pub outputs_on: bool,
    /// Limiters that acted in loop and patch, as bits of `ClampFlags`.
    pub limiters: u8,
    /// Energy given to the hand in this contact [J].
    pub energy_given_j: f32,
    /// Duration of the tick [us]; `None` on a board without a clock to measure it.
    pub tick_us: Option<f32>,
    /// Checksum of the board's patch file; zero without a patch.
    pub patch_checksum: u32,
    /// Young's modulus of the board's patch [Pa].
    pub youngs_modulus_pa: f32,
}

impl Row {
    /// The latched fault in words, if there is one.
    #[must_use]
    pub fn fault_words(&self) -> Option<String> {
        let known = Fault::ALL.into_iter().find(|fault| *fault as u8 == self.fault);
        let words = known.map_or_else(|| format!("fault {} of another version of the firmware", self.fault), |f| f.to_string());
        (self.fault != 0).then_some(words)
    }

    /// Whether this limiter acted in the tick.
    #[must_use]
    pub fn limited_by(&self, limiter: ClampFlags) -> bool {
        self.limiters & limiter.bits() == limiter.bits()
    }
}

/// Length up to which the end of the first line is searched for [bytes].
const LONGEST_HEAD: u64 = 1 << 16;

/// Checks the first line of a file, and refuses a file that is not a table of a board's records. A
/// file that does not exist yet, or has no complete line yet, is accepted, since it may become one.
///
/// # Errors
/// Returns one line of text that names file and line, the reason and the fix.
pub fn check_head(path: &Path) -> Result<(), String> {
    let place = path.display();
    let unreadable = |why: &dyn std::fmt::Display| format!("{place}: cannot be read: {why}: {FIX}");
    if path.is_dir() {
        return Err(unreadable(&"it is a folder"));
    }
    let file = match std::fs::File::open(path) {
        Err(why) if why.kind() == std::io::ErrorKind::NotFound => return Ok(()),
        opened => opened.map_err(|why| unreadable(&why))?,
    };
    let mut line = Vec::new();
    BufReader::new(file.take(LONGEST_HEAD)).read_until(b'\n', &mut line).map_err(|why| unreadable(&why))?;
    match line.strip_suffix(b"\n") {
        Some(line) => Columns::of(&String::from_utf8_lossy(line)).map(drop).map_err(|why| format!("{place}:1: {why}")),
        None if line.len() as u64 == LONGEST_HEAD => Err(format!("{place}:1: no record of a board: no line ends: {FIX}")),
        None => Ok(()),
    }
}

/// Positions of the columns in the rows of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Columns {
    /// Positions of [`COLUMNS`] in a row of the file.
    at: [usize; COLUMNS.len()],
    /// Number of cells in every row.
    cells: usize,
}

impl Columns {
    /// Reads the first line of a file.
    ///
    /// # Errors
    /// A column is missing; the message says which, and how to fix it.
    pub fn of(line: &str) -> Result<Self, String> {
        let names: Vec<&str> = line.trim_end_matches('\r').split(',').collect();
        let mut at = [0; COLUMNS.len()];
        for (place, column) in at.iter_mut().zip(COLUMNS) {
            let found = names.iter().position(|name| *name == column);
            *place = found.ok_or_else(|| match names[..] {
                [only] if only.contains(';') => {
                    "cells separated by semicolons: save it with commas, and with points in numbers".into()
                }
                _ => format!("no record of a board: it has no column {column}: {FIX}"),
            })?;
        }
        Ok(Self { at, cells: names.len() })
    }

    /// Reads one of the rows after the first line.
    ///
    /// # Errors
    /// A cell is missing or is not a number; the message gives the reason and the fix.
    pub fn row(&self, line: &str) -> Result<Row, String> {
        let cells: Vec<&str> = line.trim_end_matches('\r').split(',').collect();
        if cells.len() != self.cells {
            return Err(format!("{} cells, and the first line has {}: {FIX}", cells.len(), self.cells));
        }
        let cell = |column: &str| {
            let place = COLUMNS.iter().position(|name| *name == column).and_then(|n| self.at.get(n));
            place.and_then(|place| cells.get(*place)).copied().unwrap_or_default()
        };
        let bad = |column: &str| format!("{column} is \"{}\", which it cannot be: {FIX}", cell(column));
        let real = |column: &str| {
            let number = cell(column).parse::<f32>().ok().filter(|number| number.is_finite());
            number.ok_or_else(|| bad(column))
        };
        let vector =
            |columns: [&str; 3]| -> Result<[f32; 3], String> { Ok([real(columns[0])?, real(columns[1])?, real(columns[2])?]) };
        let byte = |column: &str| cell(column).parse::<u8>().map_err(|_| bad(column));
        Ok(Row {
            tick: cell("tick").parse().map_err(|_| bad("tick"))?,
            mode: byte("mode")?,
            fault: byte("fault")?,
            tip_m: vector(["x_m", "y_m", "z_m"])?,
            depth_m: real("depth_m")?,
            model_n: vector(["model_x_n", "model_y_n", "model_z_n"])?,
            applied_n: vector(["applied_x_n", "applied_y_n", "applied_z_n"])?,
            outputs_on: byte("outputs_on")? != 0,
            limiters: byte("limiters")? | byte("patch_limiters")?,
            energy_given_j: real("energy_given_j")?,
            tick_us: if cell("tick_us").is_empty() { None } else { Some(real("tick_us")?) },
            patch_checksum: u32::from_str_radix(cell("patch_checksum"), 16).map_err(|_| bad("patch_checksum"))?,
            youngs_modulus_pa: real("youngs_modulus_pa")?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LINE: &str = "120,4,0,0.001,-0.002,-0.003,0.003,0.1,0.2,0.3,0.01,0.02,0.03,1,7,8,9,40,64,1,-0.0005,12.50,0badcafe,3500";

    #[test]
    fn each_cell_comes_from_its_column() {
        let row = Columns::of(&COLUMNS.join(",")).unwrap().row(LINE).unwrap();
        let expected = Row {
            tick: 120,
            mode: 4,
            fault: 0,
            tip_m: [0.001, -0.002, -0.003],
            depth_m: 0.003,
            model_n: [0.1, 0.2, 0.3],
            applied_n: [0.01, 0.02, 0.03],
            outputs_on: true,
            limiters: 65,
            energy_given_j: -0.0005,
            tick_us: Some(12.5),
            patch_checksum: 0x0bad_cafe,
            youngs_modulus_pa: 3500.0,
        };
        assert_eq!(row, expected);
        assert!(row.limited_by(ClampFlags::SPEED) && row.limited_by(ClampFlags::GAIN) && !row.limited_by(ClampFlags::DEPTH));
    }

    #[test]
    fn columns_may_be_in_any_order_and_more_than_are_known() {
        let mut names: Vec<&str> = COLUMNS.to_vec();
        let mut cells: Vec<&str> = LINE.split(',').collect();
        names.reverse();
        cells.reverse();
        names.insert(3, "later");
        cells.insert(3, "words");
        let columns = Columns::of(&format!("{}\r", names.join(","))).unwrap();
        let straight = Columns::of(&COLUMNS.join(",")).unwrap().row(LINE).unwrap();
        assert_eq!(columns.row(&format!("{}\r", cells.join(","))).unwrap(), straight);
    }

    #[test]
    fn another_table_is_refused_with_the_missing_column() {
        let why = Columns::of("t_s,probe_x_m,probe_y_m").unwrap_err();
        assert!(why.contains("no column tick: give the file of `palpate board arm --stream FILE.csv`"), "{why}");
    }

    #[test]
    fn a_cell_that_cannot_be_is_named() {
        let columns = Columns::of(&COLUMNS.join(",")).unwrap();
        for (from, to, says) in [
            ("0.02,0.03,1,", "0.02,NaN,1,", "applied_z_n is \"NaN\""),
            ("120,4,", "-1,4,", "tick is \"-1\""),
            ("120,4,", "120,400,", "mode is \"400\""),
            ("0badcafe", "badly", "patch_checksum is \"badly\""),
            (",3500", "", "23 cells, and the first line has 24"),
        ] {
            let why = columns.row(&LINE.replace(from, to)).unwrap_err();
            assert!(why.contains(says), "{why}");
        }
        let untimed = columns.row(&LINE.replace("12.50", "")).unwrap();
        assert_eq!(untimed.tick_us, None);
    }

    #[test]
    fn a_fault_is_told_in_words_also_one_of_another_version() {
        let of = |fault| Row { fault, ..Row::default() }.fault_words();
        assert_eq!(of(0), None);
        assert!(of(8).unwrap().starts_with("fault 8: the probe moved too fast"), "{:?}", of(8));
        assert_eq!(of(250).unwrap(), "fault 250 of another version of the firmware");
    }
}
