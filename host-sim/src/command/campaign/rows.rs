//! The file of a range of cases: a line that identifies the campaign, its rows as CSV, and a
//! checksum of both. Lines that are no CSV begin with `#`.
//!
//! A column is a field of a row, `task.nodes` a field in a field. A list is one cell, as JSON, and
//! so is a text that JSON would read as something else.

use std::collections::BTreeMap;
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};

use palpate_tissue::{Error as TissueError, machine};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::fingerprint::{checksum, program};
use crate::error::Error;
use crate::provenance;

/// Name of the file.
pub const FILE: &str = "rows.csv";
/// Column of the number of a row's first case.
const CASE: &str = "case";

/// Identifies a campaign, and the range of its cases that a file holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Heading {
    /// Version of the program.
    pub version: String,
    /// Checksum of the program's file.
    pub program: String,
    /// Arguments that determine all cases.
    pub command_line: Vec<String>,
    /// Checksum of each file or scene that the cases use.
    pub inputs: BTreeMap<String, String>,
    /// Number of cases of the whole campaign.
    pub of: u64,
    /// Cases in this file.
    pub cases: Range<u64>,
    /// Processor that ran them, and how many of its cores were available.
    pub processor: String,
    /// See `processor`.
    pub cores: usize,
}

impl Heading {
    /// Heading of cases that this process runs.
    pub fn new(inputs: BTreeMap<String, String>, of: u64, cases: Range<u64>) -> Result<Self, Error> {
        let (version, command_line) = (env!("CARGO_PKG_VERSION").into(), provenance::command_line());
        let (processor, cores) = (machine::processor(), machine::cores());
        Ok(Self { version, program: program()?, command_line, inputs, of, cases, processor, cores })
    }

    /// First difference that keeps two files from being of one campaign, as "its X is A, not B".
    fn differs(&self, other: &Self) -> Option<String> {
        let of_campaign = |heading: &Self| {
            let Self { version, program, command_line, inputs, of, .. } = heading;
            let inputs = inputs.iter().map(|(name, sum)| (format!("{name} (checksum)"), sum.clone()));
            let named = [
                ("version", version.clone()),
                ("command line", command_line.join(" ")),
                ("number of cases", of.to_string()),
                ("program (checksum)", program.clone()),
            ];
            named.map(|(name, value)| (name.to_owned(), value)).into_iter().chain(inputs).collect::<Vec<_>>()
        };
        let (own, theirs) = (of_campaign(self), of_campaign(other));
        let differ = own.iter().zip(&theirs).find(|(own, theirs)| own != theirs);
        let said = differ.map(|((name, own), (_, theirs))| format!("its {name} is {own}, not {theirs}"));
        said.or_else(|| (own.len() != theirs.len()).then(|| "it has other inputs".to_owned()))
    }
}

/// A file of rows.
#[derive(Clone, Debug)]
pub struct Part {
    /// Identifies the campaign and the range.
    pub heading: Heading,
    path: PathBuf,
    csv: String,
}

/// Text of a file with these rows, each with the number of its first case.
pub fn text<R: Serialize + DeserializeOwned>(heading: &Heading, rows: &[(u64, R)]) -> Result<String, Error> {
    let unwritable = |why: &dyn std::fmt::Display| {
        Error::from(TissueError::Write { path: FILE.into(), source: io::Error::other(why.to_string()) })
    };
    let line = serde_json::to_string(heading).map_err(|why| unwritable(&why))?;
    let csv = csv_of(rows).map_err(|why| unwritable(&why))?;
    let again = Part { heading: heading.clone(), path: FILE.into(), csv: csv.clone() }.rows::<R>()?;
    // JSON cannot represent every number: an error here is better than a wrong result after the
    // merge
    if csv_of(&again).map_err(|why| unwritable(&why))? != csv {
        return Err(unwritable(&"the rows cannot be read as they were"));
    }
    let lines = format!("# {line}\n{csv}");
    Ok(format!("{lines}# crc64 {}\n", checksum(lines.as_bytes())))
}

impl Part {
    /// Reads a file of rows.
    pub fn read(path: &Path) -> Result<Self, TissueError> {
        let refuse =
            |why: &str| TissueError::Usage(format!("{}: {why}: take its folder away and run its cases again", path.display()));
        let bytes = std::fs::read(path).map_err(|source| TissueError::Read { path: path.into(), source })?;
        let damaged = || refuse("cut short or damaged");
        let text = String::from_utf8(bytes).map_err(|_| damaged())?;
        let (lines, sum) = text.rsplit_once("# crc64 ").ok_or_else(damaged)?;
        if sum.strip_suffix('\n') != Some(&checksum(lines.as_bytes())) {
            return Err(damaged());
        }
        let (heading, csv) = lines.split_once('\n').ok_or_else(damaged)?;
        let heading = heading.strip_prefix("# ").and_then(|heading| serde_json::from_str(heading).ok());
        let heading = heading.ok_or_else(|| refuse("not the rows of this version of palpate"))?;
        Ok(Self { heading, path: path.into(), csv: csv.to_owned() })
    }

    /// Reads the rows, each with the number of its first case.
    pub fn rows<R: DeserializeOwned>(&self) -> Result<Vec<(u64, R)>, Error> {
        let refuse = |why: &dyn std::fmt::Display| {
            TissueError::Usage(format!("{}: a row cannot be read: {why}: run its cases again", self.path.display()))
        };
        let mut reader = csv::Reader::from_reader(self.csv.as_bytes());
        let columns = reader.headers().map_err(|why| refuse(&why))?.clone();
        let mut rows = Vec::new();
        for record in reader.records() {
            let record = record.map_err(|why| refuse(&why))?;
            let mut fields = Map::new();
            for (column, cell) in columns.iter().zip(&record).filter(|(_, cell)| !cell.is_empty()) {
                put(&mut fields, column, cell);
            }
            let case = fields.remove(CASE).and_then(|case| case.as_u64()).ok_or_else(|| refuse(&"it has no number"))?;
            rows.push((case, serde_json::from_value(fields.into()).map_err(|why| refuse(&why))?));
        }
        Ok(rows)
    }
}

/// Reads the rows of every folder, and checks that they are all cases of one campaign. Returns them
/// in the order of the cases. Each folder is that of a range, or contains such folders.
pub fn complete(folders: &[PathBuf]) -> Result<Vec<Part>, TissueError> {
    let mut parts = files(folders)?.iter().map(|path| Part::read(path)).collect::<Result<Vec<_>, _>>()?;
    parts.sort_by_key(|part| part.heading.cases.start);
    let Some(Part { heading: first, path: beside, .. }) = parts.first() else { return Ok(parts) };
    let (mut next, mut missing) = (0, Vec::new());
    for (n, part) in parts.iter().enumerate() {
        let (path, cases) = (part.path.display(), &part.heading.cases);
        if let Some(difference) = part.heading.differs(first) {
            let why = format!("{path}: {difference} as in {}: merge each with its own", beside.display());
            return Err(TissueError::Usage(why));
        }
        if let Some(before) = parts[..n].last().filter(|_| cases.start < next) {
            let (other, others) = (before.path.display(), &before.heading.cases);
            return Err(TissueError::Usage(format!(
                "cases are there twice: {others:?} in {other}, {cases:?} in {path}: give one"
            )));
        }
        missing.push(next..cases.start);
        next = cases.end;
    }
    missing.push(next..first.of);
    let missing: Vec<String> = missing.iter().filter(|gap| !gap.is_empty()).map(|gap| format!("--cases {gap:?}")).collect();
    if missing.is_empty() {
        return Ok(parts);
    }
    Err(TissueError::Usage(format!(
        "of {} cases some are missing: run the command again with {}",
        first.of,
        missing.join(", then ")
    )))
}

/// The file of every range in these folders or one level below them. A hidden folder is left out: a
/// run is still writing it, or was killed.
fn files(folders: &[PathBuf]) -> Result<Vec<PathBuf>, TissueError> {
    let mut files = Vec::new();
    for folder in folders {
        let refuse = |source| TissueError::Read { path: folder.clone(), source };
        let before = files.len();
        files.extend(Some(folder.join(FILE)).filter(|file| file.exists()));
        for entry in std::fs::read_dir(folder).map_err(refuse)? {
            let entry = entry.map_err(refuse)?;
            let file = entry.path().join(FILE);
            if file.exists() && !entry.file_name().as_encoded_bytes().starts_with(b".") {
                files.push(file);
            }
        }
        if files.len() == before {
            let why = format!("{}: there is no {FILE} in it or in a folder in it", folder.display());
            return Err(TissueError::Usage(format!("{why}: give the --out of a command with --cases")));
        }
    }
    files.sort();
    Ok(files)
}

fn csv_of<R: Serialize>(rows: &[(u64, R)]) -> io::Result<String> {
    let mut columns = vec![CASE.to_owned()];
    let mut records = Vec::new();
    for (case, row) in rows {
        let mut cells = vec![(CASE.to_owned(), case.to_string())];
        flatten("", serde_json::to_value(row)?, &mut cells);
        columns.extend(
            cells.iter().filter(|(column, _)| !columns.contains(column)).map(|(column, _)| column.clone()).collect::<Vec<_>>(),
        );
        records.push(cells);
    }
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(&columns)?;
    for cells in records {
        let cells: BTreeMap<String, String> = cells.into_iter().collect();
        writer.write_record(columns.iter().map(|column| cells.get(column).map_or("", String::as_str)))?;
    }
    let bytes = writer.into_inner().map_err(csv::IntoInnerError::into_error)?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// Adds the columns and cells of a value.
fn flatten(column: &str, value: Value, cells: &mut Vec<(String, String)>) {
    match value {
        Value::Object(fields) if !fields.is_empty() && fields.keys().all(|name| is_field(name)) => {
            let below = if column.is_empty() { String::new() } else { format!("{column}.") };
            fields.into_iter().for_each(|(name, value)| flatten(&format!("{below}{name}"), value, cells));
        }
        Value::String(text) if !text.is_empty() && serde_json::from_str::<Value>(&text).is_err() => {
            cells.push((column.to_owned(), text));
        }
        other => cells.push((column.to_owned(), other.to_string())),
    }
}

/// Whether a key names a field, rather than an entry of a map, each of which would be a column.
fn is_field(key: &str) -> bool {
    key.starts_with(|c: char| c.is_ascii_alphabetic()) && key.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

fn put(fields: &mut Map<String, Value>, column: &str, cell: &str) {
    match column.split_once('.') {
        Some((name, below)) => {
            let inner = fields.entry(name).or_insert_with(|| Map::new().into());
            inner.as_object_mut().into_iter().for_each(|inner| put(inner, below, cell));
        }
        None => {
            let value = serde_json::from_str(cell).unwrap_or_else(|_| cell.into());
            fields.insert(column.to_owned(), value);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    struct Row {
        name: String,
        press: Option<Press>,
        counts: BTreeMap<u8, u64>,
    }

    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    struct Press {
        force_n: f64,
        depths_m: Vec<f64>,
    }

    fn row(name: &str, force_n: Option<f64>) -> Row {
        let press = force_n.map(|force_n| Press { force_n, depths_m: vec![0.1 + 0.2, 1e-300] });
        Row { name: name.into(), press, counts: BTreeMap::from([(3, 7)]) }
    }

    fn heading(cases: Range<u64>) -> Heading {
        let inputs = BTreeMap::from([("scene".to_owned(), "00aa".to_owned())]);
        let (version, program, processor) = ("0.1.0".into(), "00bb".into(), "Z80".into());
        let command_line = vec!["faults".into(), "--seed=1".into()];
        Heading { version, program, command_line, inputs, of: 10, cases, processor, cores: 1 }
    }

    /// Folder of files of rows.
    struct Shelf(tempfile::TempDir);

    impl Shelf {
        fn new(ranges: &[(u64, u64)]) -> Self {
            let shelf = Self(tempfile::tempdir().unwrap());
            ranges.iter().for_each(|(first, end)| shelf.put(&heading(*first..*end)));
            shelf
        }

        fn file(&self, cases: &Range<u64>) -> PathBuf {
            self.0.path().join(format!("cases-{}-{}", cases.start, cases.end)).join(FILE)
        }

        fn put(&self, heading: &Heading) {
            let file = self.file(&heading.cases);
            std::fs::create_dir_all(file.parent().unwrap()).unwrap();
            let rows: Vec<(u64, Row)> = heading.cases.clone().map(|n| (n, row("press", None))).collect();
            std::fs::write(file, text(heading, &rows).unwrap()).unwrap();
        }

        #[track_caller]
        fn refused(&self, says: &[&str]) {
            let line = complete(&[self.0.path().to_owned()]).unwrap_err().to_string();
            assert!(!line.contains('\n'), "{line}");
            says.iter().for_each(|words| assert!(line.contains(words), "not a word of `{words}`: {line}"));
        }
    }

    #[test]
    fn fields_of_fields_are_columns_and_are_read_as_they_were() {
        let names = ["a, \"b\"\nc", "", "1.50", "null", "# crc64 "];
        let rows: Vec<(u64, Row)> = names.iter().zip(5..).map(|(name, n)| (n, row(name, (n != 6).then_some(-0.0)))).collect();
        let text = text(&heading(5..10), &rows).unwrap();
        assert!(text.contains("\ncase,counts,name,press.depths_m,press.force_n,press\n"), "{text}");
        assert!(text.contains("\n7,\"{\"\"3\"\":7}\",\"\"\"1.50\"\"\",\"[0.30000000000000004,1e-300]\",-0.0,\n"), "{text}");
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(FILE), text).unwrap();
        assert_eq!(
            complete(&[folder.path().into()]).unwrap_err().to_string(),
            "of 10 cases some are missing: run the command again with --cases 0..5"
        );
        assert_eq!(Part::read(&folder.path().join(FILE)).unwrap().rows::<Row>().unwrap(), rows);
    }

    #[test]
    fn a_number_that_would_be_read_as_another_is_not_written() {
        let said = text(&heading(0..1), &[(0, row("nan", Some(f64::NAN)))]).unwrap_err().to_string();
        assert!(said.contains("a row cannot be read: invalid type: null, expected f64"), "{said}");
    }

    #[test]
    fn ranges_are_whole_in_any_order_and_folder() {
        let (shelf, other) = (Shelf::new(&[(7, 10), (0, 2)]), Shelf::new(&[(2, 7)]));
        shelf.refused(&["of 10 cases some are missing: run the command again with --cases 2..7"]);
        let parts = complete(&[shelf.0.path().into(), other.file(&(2..7)).parent().unwrap().into()]).unwrap();
        let cases: Vec<u64> = parts.iter().flat_map(|part| part.rows::<Row>().unwrap()).map(|(n, _)| n).collect();
        assert_eq!(cases, (0..10).collect::<Vec<_>>());
        // what a killed run left is hidden
        std::fs::rename(shelf.file(&(7..10)).parent().unwrap(), shelf.0.path().join(".cases-7-10.draft")).unwrap();
        shelf.refused(&["--cases 2..10"]);
    }

    #[test]
    fn gaps_overlaps_and_other_campaigns_are_named() {
        Shelf::new(&[(1, 2), (4, 5)]).refused(&["with --cases 0..1, then --cases 2..4, then --cases 5..10"]);
        Shelf::new(&[(0, 6), (5, 10)]).refused(&["cases are there twice: 0..6 in ", "cases-0-6", ", 5..10 in ", "give one"]);
        let odd = |change: fn(&mut Heading), says: &str| {
            let shelf = Shelf::new(&[(0, 5)]);
            let mut odd = heading(5..10);
            change(&mut odd);
            shelf.put(&odd);
            shelf.refused(&["cases-5-10/rows.csv: ", says, "cases-0-5/rows.csv: merge each with its own"]);
        };
        odd(|h| h.version = "0.0.9".into(), "its version is 0.0.9, not 0.1.0 as in ");
        odd(|h| h.program = "00cc".into(), "its program (checksum) is 00cc, not 00bb");
        odd(
            |h| h.command_line = vec!["faults".into(), "--seed=2".into()],
            "its command line is faults --seed=2, not faults --seed=1 as in ",
        );
        odd(|h| h.of = 11, "its number of cases is 11, not 10");
        odd(|h| h.inputs = BTreeMap::from([("scene".into(), "00dd".into())]), "its scene (checksum) is 00dd, not 00aa");
        odd(|h| h.inputs = BTreeMap::new(), "it has other inputs");
    }

    #[test]
    fn a_damaged_file_is_named() {
        let shelf = Shelf::new(&[(0, 5), (5, 10)]);
        let file = shelf.file(&(5..10));
        let whole = std::fs::read(&file).unwrap();
        let damaged = |bytes: &[u8]| {
            std::fs::write(&file, bytes).unwrap();
            shelf.refused(&["cases-5-10/rows.csv: cut short or damaged: take its folder away and run its cases again"]);
        };
        (0..whole.len()).for_each(|length| damaged(&whole[..length]));
        damaged(&[&whole[..], b"\n"].concat());
        for place in 0..whole.len() {
            let mut changed = whole.clone();
            changed[place] ^= 1;
            damaged(&changed);
        }
    }

    #[test]
    fn folders_without_rows() {
        let refused = |folder: &Path| complete(&[folder.to_owned()]).unwrap_err().to_string();
        let shelf = Shelf::new(&[]);
        assert!(refused(shelf.0.path()).contains("there is no rows.csv in it or in a folder in it: give the --out"));
        assert!(refused(&shelf.0.path().join("absent")).contains("absent"));
    }
}
