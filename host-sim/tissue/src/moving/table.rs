//! Stored table of force over Young's modulus against time.

use std::fmt::Write as _;

use crate::truth_error::TruthError;

const COLUMNS: &str = "t_s,depth_m,across_m,force_x_over_e_m2,force_y_over_e_m2,force_normal_over_e_m2";
/// Digits after the point of the written forces [m^2].
const DIGITS: usize = 4;

/// Tip and force at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Time since the tip passed the rest surface [s].
    pub t_s: f64,
    /// Depth of the tip [m].
    pub depth_m: f64,
    /// Displacement of the tip across the press, along x [m].
    pub across_m: f64,
    /// Force on the probe over Young's modulus: along x, along y, along the press [m^2].
    pub force_over_e_m2: [f64; 3],
}

/// Force against time at a fixed spacing.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Rows, in the order of time.
    pub rows: Vec<Row>,
}

impl Table {
    /// Version of the file format.
    pub const VERSION: u32 = 1;

    /// Force on the probe over Young's modulus at a time [m^2], linear between rows.
    #[must_use]
    pub fn force_over_e_m2(&self, t_s: f64) -> [f64; 3] {
        self.at(t_s).force_over_e_m2
    }

    /// Tip and force at a time, linear between rows; beyond the ends, the nearest row.
    #[must_use]
    pub fn at(&self, t_s: f64) -> Row {
        let next = self.rows.partition_point(|row| row.t_s < t_s);
        match (next.checked_sub(1).and_then(|n| self.rows.get(n)), self.rows.get(next)) {
            (Some(low), Some(high)) => {
                let share = (t_s - low.t_s) / (high.t_s - low.t_s);
                let between = |low: f64, high: f64| low + (high - low) * share;
                Row {
                    t_s,
                    depth_m: between(low.depth_m, high.depth_m),
                    across_m: between(low.across_m, high.across_m),
                    force_over_e_m2: [0, 1, 2].map(|k| between(low.force_over_e_m2[k], high.force_over_e_m2[k])),
                }
            }
            (None, Some(only)) | (Some(only), None) => *only,
            (None, None) => Row { t_s, depth_m: 0.0, across_m: 0.0, force_over_e_m2: [0.0; 3] },
        }
    }

    /// Writes the file: header lines, columns, rows.
    #[must_use]
    pub fn to_csv(&self, header: &[String]) -> String {
        let mut text: String = header.iter().fold(String::new(), |text, line| text + "# " + line + "\n");
        text += COLUMNS;
        text.push('\n');
        for Row { t_s, depth_m, across_m, force_over_e_m2: [x, y, normal] } in &self.rows {
            // writing to a string cannot fail
            let _ = writeln!(text, "{t_s:.5},{depth_m:.6},{across_m:.6},{x:.DIGITS$e},{y:.DIGITS$e},{normal:.DIGITS$e}");
        }
        text
    }

    /// Reads the text of a file; `file` names it in errors.
    ///
    /// # Errors
    /// [`TruthError::Table`]: the first line that is wrong.
    pub fn parse(file: &str, text: &str) -> Result<Self, TruthError> {
        let wrong = |line: usize, why: &'static str| TruthError::Table { file: file.to_owned(), line: line + 1, why };
        let version = format!("# version = {},", Self::VERSION);
        if !text.starts_with(&version) {
            return Err(wrong(0, "is of another version: compute it anew with the example moving_truths"));
        }
        let mut lines = text.lines().enumerate().filter(|(_, line)| !line.starts_with('#'));
        match lines.next() {
            Some((_, COLUMNS)) => {}
            Some((n, _)) => return Err(wrong(n, "names other columns: compute it anew with the example moving_truths")),
            None => return Err(wrong(0, "has no columns: compute it anew with the example moving_truths")),
        }
        let mut rows: Vec<Row> = Vec::new();
        for (n, line) in lines {
            let values: Result<Vec<f64>, _> = line.split(',').map(str::parse).collect();
            let values = values.map_err(|_| wrong(n, "holds something that is no number"))?;
            let &[t_s, depth_m, across_m, x, y, normal] = values.as_slice() else {
                return Err(wrong(n, "must hold six numbers"));
            };
            if !values.iter().all(|value| value.is_finite()) || rows.last().is_some_and(|last| last.t_s >= t_s) {
                return Err(wrong(n, "must hold finite numbers, and time must rise"));
            }
            rows.push(Row { t_s, depth_m, across_m, force_over_e_m2: [x, y, normal] });
        }
        if rows.is_empty() { Err(wrong(0, "has no rows")) } else { Ok(Self { rows }) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(t_s: f64, normal: f64) -> Row {
        Row { t_s, depth_m: 0.04 * t_s, across_m: 0.0, force_over_e_m2: [0.0, 0.0, normal] }
    }

    #[test]
    fn a_table_is_read_as_it_was_written() {
        let table = Table { rows: vec![row(0.0, 0.0), row(0.001, 3.25e-6), row(0.002, 5.5e-6)] };
        let text = table.to_csv(&["version = 1, truth = test".to_owned()]);
        let read = Table::parse("test", &text).unwrap();
        assert_eq!(read, table);
        assert!((read.force_over_e_m2(0.0015)[2] - 4.375e-6).abs() < 1e-12);
        assert_eq!(read.force_over_e_m2(1.0), table.rows[2].force_over_e_m2);
    }

    #[test]
    fn damage_is_named_by_its_line() {
        let table = Table { rows: vec![row(0.0, 0.0), row(0.001, 3.25e-6)] };
        let text = table.to_csv(&["version = 1, truth = test".to_owned()]);
        let line = |text: &str| match Table::parse("test", text) {
            Err(TruthError::Table { line, .. }) => line,
            other => panic!("{other:?}"),
        };
        assert_eq!(line(&text.replace("version = 1", "version = 9")), 1);
        assert_eq!(line(&text.replace("depth_m", "depth_mm")), 2);
        assert_eq!(line(&text.replace("3.2500", "3.2x")), 4);
        assert_eq!(line(&text.replace("0.00100,", "0.00000,")), 4);
    }
}
