//! A table of flat rows: CSV with one column per field, and aligned columns when printed.

use palpate_sim::error::Error;
use palpate_tissue::Error as TissueError;
use serde::Serialize;

/// Rows of the same type as text.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Name of the CSV file without its extension.
    pub name: String,
    about: String,
    header: Vec<String>,
    rows: Vec<Vec<String>>,
    /// Whether each row is printed without `--all`.
    shown: Vec<bool>,
    /// Whether each column is printed.
    printed: Vec<bool>,
    /// Whether the cells are printed as they are, without rounding.
    verbatim: bool,
    /// Whether it is only written as CSV.
    quiet: bool,
}

impl Table {
    /// Table of all rows, each a struct of numbers and texts whose fields name the columns.
    pub fn of<R: Serialize>(name: impl Into<String>, rows: &[R]) -> Result<Self, Error> {
        let name = name.into();
        let unwritable = |why: &dyn std::fmt::Display| {
            Error::from(TissueError::Write { path: format!("{name}.csv").into(), source: std::io::Error::other(why.to_string()) })
        };
        let mut writer = csv::Writer::from_writer(Vec::new());
        rows.iter().try_for_each(|row| writer.serialize(row)).map_err(|why| unwritable(&why))?;
        let bytes = writer.into_inner().map_err(|why| unwritable(&why))?;
        let mut reader = csv::Reader::from_reader(bytes.as_slice());
        let cells = |record: &csv::StringRecord| record.iter().map(str::to_owned).collect::<Vec<_>>();
        let header = cells(reader.headers().map_err(|why| unwritable(&why))?);
        let rows = reader.records().map(|record| record.as_ref().map(cells).map_err(|why| unwritable(why)));
        let rows = rows.collect::<Result<Vec<_>, _>>()?;
        let (shown, printed) = (vec![true; rows.len()], vec![true; header.len()]);
        Ok(Self { name, about: String::new(), shown, header, rows, printed, verbatim: false, quiet: false })
    }

    /// Table of values of these rows, which [`Columns::col`] names.
    pub fn rows<R>(name: impl Into<String>, rows: impl IntoIterator<Item = R>) -> Columns<R> {
        let rows: Vec<R> = rows.into_iter().collect();
        let (shown, cells) = (vec![true; rows.len()], vec![Vec::new(); rows.len()]);
        let (name, about, header, printed) = (name.into(), String::new(), Vec::new(), Vec::new());
        Columns { rows, table: Self { name, about, shown, header, rows: cells, printed, verbatim: false, quiet: false } }
    }

    /// Hides all but these rows, unless `--all` is given.
    pub fn only(self, shown: impl IntoIterator<Item = bool>) -> Self {
        Self { shown: shown.into_iter().collect(), ..self }
    }

    /// Prints only these columns.
    pub fn columns(mut self, printed: &[&str]) -> Self {
        self.printed = self.header.iter().map(|name| printed.contains(&name.as_str())).collect();
        self
    }

    /// Puts a line above the header.
    pub fn about(self, about: impl Into<String>) -> Self {
        Self { about: about.into(), ..self }
    }

    /// Prints the cells as they are, without rounding.
    pub fn verbatim(self) -> Self {
        Self { verbatim: true, ..self }
    }

    /// Keeps the table off the terminal and the report: it is only written as CSV.
    pub fn quiet(self) -> Self {
        Self { quiet: true, ..self }
    }

    /// Whether it is only written as CSV.
    pub fn is_quiet(&self) -> bool {
        self.quiet
    }

    /// Text above the header.
    pub fn heading(&self) -> &str {
        &self.about
    }

    /// Whether some rows are printed only with `--all`.
    pub fn is_cut(&self) -> bool {
        self.shown.contains(&false)
    }

    /// The table as CSV.
    pub fn csv(&self) -> String {
        let mut writer = csv::Writer::from_writer(Vec::new());
        // writing to memory cannot fail, and all rows have the length of the header
        std::iter::once(&self.header).chain(&self.rows).for_each(|row| drop(writer.write_record(row)));
        writer.into_inner().map_or(String::new(), |bytes| String::from_utf8_lossy(&bytes).into_owned())
    }

    /// The table as Markdown.
    pub fn markdown(&self) -> String {
        let (header, rows) = self.chosen(true);
        let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
        let rule = format!("|{}\n", "---|".repeat(header.len()));
        [line(&header), rule].into_iter().chain(rows.iter().map(|row| line(row))).collect()
    }

    /// The table with aligned columns and numbers of four digits, or nothing if no row is printed.
    pub fn print(&self, all: bool) -> String {
        let (header, rows) = self.chosen(all);
        if rows.is_empty() {
            return String::new();
        }
        let wide = |n: usize| rows.iter().chain([&header]).map(|row| row[n].chars().count()).max().unwrap_or(0);
        let widths: Vec<usize> = (0..header.len()).map(wide).collect();
        let numeric: Vec<bool> = (0..header.len()).map(|n| rows.iter().all(|row| is_number(&row[n]))).collect();
        let line = |row: &Vec<String>| {
            let cell = |n: usize| match numeric[n] {
                true => format!("{:>1$}", row[n], widths[n]),
                false => format!("{:<1$}", row[n], widths[n]),
            };
            (0..row.len()).map(cell).collect::<Vec<_>>().join("  ").trim_end().to_owned()
        };
        let about = Some(self.about.clone()).filter(|about| !about.is_empty());
        about.into_iter().chain(std::iter::once(&header).chain(&rows).map(line)).collect::<Vec<_>>().join("\n") + "\n"
    }

    /// Header and rows of the printed columns, with numbers of four digits.
    fn chosen(&self, all: bool) -> (Vec<String>, Vec<Vec<String>>) {
        let chosen: Vec<usize> = (0..self.header.len()).filter(|n| self.printed[*n]).collect();
        let cell = |cell: &String| if self.verbatim { cell.clone() } else { short(cell) };
        let pick = |row: &Vec<String>| chosen.iter().map(|n| cell(&row[*n])).collect::<Vec<_>>();
        let rows = self.rows.iter().zip(&self.shown).filter(|(_, shown)| all || **shown);
        (pick(&self.header), rows.map(|(row, _)| pick(row)).collect())
    }
}

/// A table to which columns are added.
pub struct Columns<R> {
    rows: Vec<R>,
    table: Table,
}

impl<R> Columns<R> {
    /// Adds a column.
    pub fn col<V: Cell>(self, name: &str, of: impl Fn(&R) -> V) -> Self {
        self.with(name, of, true)
    }

    /// Adds a column that is in the CSV only.
    pub fn csv<V: Cell>(self, name: &str, of: impl Fn(&R) -> V) -> Self {
        self.with(name, of, false)
    }

    /// The table, of which only these rows are printed without `--all`.
    pub fn only(self, shown: impl Fn(&R) -> bool) -> Table {
        Table { shown: self.rows.iter().map(shown).collect(), ..self.table }
    }

    /// The table.
    pub fn all(self) -> Table {
        self.table
    }

    fn with<V: Cell>(mut self, name: &str, of: impl Fn(&R) -> V, printed: bool) -> Self {
        self.table.header.push(name.to_owned());
        self.table.printed.push(printed);
        self.table.rows.iter_mut().zip(&self.rows).for_each(|(cells, row)| cells.push(of(row).text()));
        self
    }
}

/// A value in a cell.
pub trait Cell {
    /// The value as text, with all digits; nothing if it is not there or was not measured.
    fn text(&self) -> String;
}

macro_rules! cells {
    ($($value:ty),*) => {
        $(impl Cell for $value {
            fn text(&self) -> String {
                self.to_string()
            }
        })*
    };
}
cells!(bool, u8, u16, u32, u64, usize, &str, String);

impl Cell for f64 {
    fn text(&self) -> String {
        if self.is_finite() { format!("{self:?}") } else { String::new() }
    }
}

impl Cell for f32 {
    fn text(&self) -> String {
        if self.is_finite() { format!("{self:?}") } else { String::new() }
    }
}

impl<V: Cell> Cell for Option<V> {
    fn text(&self) -> String {
        self.as_ref().map_or(String::new(), Cell::text)
    }
}

fn is_number(cell: &str) -> bool {
    cell.is_empty() || cell.parse::<f64>().is_ok()
}

/// A number with a fraction, rounded to four digits; any other text as it is.
pub(super) fn short(cell: &str) -> String {
    let Some(value) = cell.parse::<f64>().ok().filter(|v| v.is_finite() && cell.contains(['.', 'e'])) else {
        return cell.to_owned();
    };
    if value == 0.0 {
        return "0".into();
    }
    if !(1e-4..1e7).contains(&value.abs()) {
        return format!("{value:.3e}");
    }
    let decimals = (3 - value.abs().log10().floor() as i32).clamp(0, 7) as usize;
    let text = format!("{value:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Serialize)]
    struct Row {
        name: &'static str,
        force_n: f64,
        depth_m: Option<f64>,
        count: u64,
    }

    #[test]
    fn rows_are_csv_and_aligned() {
        let rows = [
            Row { name: "a, b", force_n: 1.234_567, depth_m: None, count: 12 },
            Row { name: "c", force_n: 1e-9, depth_m: Some(100.0), count: 7 },
        ];
        let table = Table::of("t", &rows).unwrap();
        assert_eq!(table.csv(), "name,force_n,depth_m,count\n\"a, b\",1.234567,,12\nc,1e-9,100.0,7\n");
        let printed = table.print(true);
        assert_eq!(printed, "name   force_n  depth_m  count\na, b     1.235              12\nc     1.000e-9      100      7\n");
        let cut = table.clone().only([false, true]).columns(&["count"]);
        assert_eq!((cut.print(false).as_str(), cut.is_cut()), ("count\n    7\n", true));
        assert_eq!(table.only([false, false]).print(false), "");
    }
}
