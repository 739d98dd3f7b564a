//! Columns of a table by their names and units, in several languages.

use std::collections::HashMap;

/// Words that name a quantity, in English, German, French and Spanish.
const WORDS: [(&str, &[&str]); 4] = [
    ("time", &["time", "t", "zeit", "prufzeit", "temps", "tiempo"]),
    (
        "depth",
        &[
            "depth",
            "displacement",
            "indentation",
            "compression",
            "extension",
            "travel",
            "tiefe",
            "eindringtiefe",
            "position",
            "distance",
            "disp",
            "z",
            "crosshead",
            "weg",
            "standardweg",
            "traversenweg",
            "eindringung",
            "verschiebung",
            "profondeur",
            "deplacement",
            "enfoncement",
            "profundidad",
            "desplazamiento",
            "indentacion",
        ],
    ),
    (
        "force",
        &[
            "force",
            "fz",
            "load",
            "kraft",
            "standardkraft",
            "prufkraft",
            "normalkraft",
            "last",
            "effort",
            "charge",
            "fuerza",
            "carga",
        ],
    ),
    ("test", &["test", "specimen", "run", "versuch", "probe", "essai", "ensayo", "prueba"]),
];

/// Words that make a length or a force one along the surface.
const ALONG: [&str; 16] = [
    "lateral",
    "tangential",
    "shear",
    "friction",
    "slide",
    "sliding",
    "quer",
    "querweg",
    "querkraft",
    "reibkraft",
    "tangentialkraft",
    "tangentielle",
    "frottement",
    "glissement",
    "tangencial",
    "rozamiento",
];

/// Words of columns that are no measurement: what a machine was told, and times within a cycle.
const NOT_MEASURED: [&str; 7] = ["setpoint", "target", "command", "demand", "soll", "sollwert", "cycle"];

/// Units of time, length and force, with their size in SI. Case matters: mN is not MN.
const UNITS: [(&str, &str, f64); 31] = [
    ("time", "s", 1.0),
    ("time", "sec", 1.0),
    ("time", "seconds", 1.0),
    ("time", "sek", 1.0),
    ("time", "ms", 1e-3),
    ("time", "msec", 1e-3),
    ("time", "us", 1e-6),
    ("time", "µs", 1e-6),
    ("time", "μs", 1e-6),
    ("time", "min", 60.0),
    ("time", "minutes", 60.0),
    ("time", "h", 3600.0),
    ("depth", "m", 1.0),
    ("depth", "cm", 1e-2),
    ("depth", "mm", 1e-3),
    ("depth", "inch", 25.4e-3),
    ("depth", "nm", 1e-9),
    ("depth", "um", 1e-6),
    ("depth", "µm", 1e-6),
    ("depth", "μm", 1e-6),
    ("force", "N", 1.0),
    ("force", "n", 1.0),
    ("force", "mN", 1e-3),
    ("force", "mn", 1e-3),
    ("force", "uN", 1e-6),
    ("force", "µN", 1e-6),
    ("force", "kN", 1e3),
    ("force", "kgf", 9.806_65),
    ("force", "gf", 9.806_65e-3),
    ("force", "g", 9.806_65e-3),
    ("force", "lbf", 4.448_222),
];

/// Largest number of lines above the names.
const MOST_ABOVE: usize = 200;
/// Duration of a day [s].
const DAY_S: f64 = 86_400.0;
/// Separators of cells.
const MARKS: [u8; 3] = [b';', b'\t', b','];

/// The names that are known, for an error.
#[must_use]
pub fn known() -> String {
    let of = |(quantity, words): &(&str, &[&str])| format!("{quantity} ({})", words.join(", "));
    let units: Vec<&str> = UNITS.iter().map(|(_, unit, _)| *unit).collect();
    format!(
        "{}, with a unit of {}, such as depth_mm or Kraft [mN]; along the surface slide_mm and lateral_force_mN",
        WORDS.each_ref().map(of).join("; "),
        units.join(", ")
    )
}

/// A table of one or several tests.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Rows of time [s], depth [m] and force [N] of each test, with the test's name.
    pub tests: Vec<(String, Vec<[f64; 3]>)>,
    /// Positions [m] and forces [N] along the surface in the rows of each test; empty without both.
    pub along: Vec<Vec<[f64; 2]>>,
    /// Notes on how the table was read.
    pub notes: Vec<String>,
}

fn plain(text: &str) -> String {
    let flat = |c: char| match c {
        'é' | 'è' | 'ê' | 'É' | 'È' | 'Ê' => 'e',
        'á' | 'à' | 'â' | 'ä' | 'Á' | 'À' | 'Â' | 'Ä' => 'a',
        'ó' | 'ô' | 'ö' | 'Ó' | 'Ô' | 'Ö' => 'o',
        'í' | 'î' | 'Í' | 'Î' => 'i',
        'ú' | 'û' | 'ü' | 'Ú' | 'Û' | 'Ü' => 'u',
        c => c,
    };
    // accents may be characters of their own
    text.chars().filter(|c| !('\u{300}'..='\u{36f}').contains(c)).map(flat).collect()
}

/// Quantity and unit of a heading: words and one unit, in any order and punctuation.
fn heading(text: &str) -> (Option<&'static str>, Option<(&'static str, f64)>) {
    let text = plain(text);
    let words: Vec<&str> = text.split(|c: char| !c.is_alphanumeric() && c != 'µ' && c != 'μ').filter(|w| !w.is_empty()).collect();
    if words.iter().any(|word| NOT_MEASURED.contains(&word.to_lowercase().as_str())) {
        return (None, None);
    }
    let of_unit = |word: &&str| UNITS.iter().find(|(_, unit, _)| unit == word);
    if words.iter().any(|word| ALONG.contains(&word.to_lowercase().as_str()))
        && let Some((of, _, si)) = words.iter().rev().find_map(of_unit).filter(|(of, ..)| *of != "time")
    {
        let along = if *of == "depth" { "slide" } else { "friction" };
        return (Some(along), Some((along, *si)));
    }
    let named = |wanted: fn(&str) -> bool| {
        words.iter().enumerate().find_map(|(n, word)| {
            let word = word.to_lowercase();
            // a lone t is the time, and in "Kraft t" it is not
            let is = |(of, names): &&(&str, &[&str])| wanted(of) && names.contains(&word.as_str()) && (word.len() > 1 || n == 0);
            Some((n, WORDS.iter().find(is)?.0))
        })
    };
    // the time of a test is a time, and the temperature of a test (C) is nothing that is read
    let quantity = named(|of| of != "test").or_else(|| named(|of| of == "test").filter(|_| !text.contains(['(', '['])));
    let unit = words.iter().enumerate().filter(|(n, _)| quantity.is_none_or(|(q, _)| q != *n)).find_map(|(_, word)| {
        let of_quantity = |of: &str| quantity.is_none_or(|(_, q)| q == of);
        let exactly = UNITS.iter().find(|(of, unit, _)| unit == word && of_quantity(of));
        // all in capitals: MM and S are clear, and MN is not
        let lower = word.to_lowercase();
        let capitals = || UNITS.iter().find(|(of, unit, _)| *of != "force" && *unit == lower && of_quantity(of));
        exactly.or_else(capitals).map(|(of, _, si)| (*of, *si))
    });
    (quantity.map(|(_, q)| q), unit)
}

/// Whether a heading of the time names nothing else, such as a unit.
fn only_time(text: &str) -> bool {
    let known = |word: &str| ["total", "elapsed"].contains(&word) || [0, 3].iter().any(|k| WORDS[*k].1.contains(&word));
    plain(text).to_lowercase().split(|c: char| !c.is_alphanumeric()).all(|word| word.is_empty() || known(word))
}

/// Reads a number; a comma is its decimal mark if it cannot be anything else.
fn number(cell: &str, comma: bool) -> Option<f64> {
    let value: f64 = match comma && cell.contains(',') {
        // the last mark is the decimal one, and others group thousands
        true if cell.rfind('.') > cell.rfind(',') => cell.replace(',', "").parse().ok()?,
        true => cell.replace('.', "").replace(',', ".").parse().ok()?,
        false => cell.parse().ok()?,
    };
    value.is_finite().then_some(value)
}

/// Reads a time, also one of a clock in hours, minutes and seconds, with or without its date [s].
fn clock_s(cell: &str, comma: bool) -> Option<f64> {
    let of_day = cell.rsplit([' ', 'T']).next()?;
    of_day.contains(':').then(|| of_day.split(':').try_fold(0.0, |sum, part| Some(60.0 * sum + number(part, comma)?)))?
}

/// Number, mark and cells of the line that names at least some of time, depth and force; what is
/// above it is no part of the table. A comment may contain the names if no other line does.
fn header(text: &str, least: usize) -> Option<(usize, u8, Vec<String>)> {
    let named = |line: &str, mark: u8| {
        let names = cells(line, mark);
        let quantities: Vec<&str> = names.iter().filter_map(|name| heading(name).0).collect();
        (WORDS[..3].iter().filter(|(of, _)| quantities.contains(of)).count() >= least).then_some(names)
    };
    let lines = || text.lines().enumerate().take(MOST_ABOVE);
    let plain = lines().filter(|(_, line)| !line.starts_with('#'));
    let comments = lines().filter_map(|(n, line)| Some((n, line.strip_prefix('#')?)));
    plain.chain(comments).find_map(|(n, line)| MARKS.iter().find_map(|mark| Some((n, *mark, named(line, *mark)?))))
}

/// Cells of a line, without empty ones at its end.
fn cells(line: &str, mark: u8) -> Vec<String> {
    let mut cells: Vec<String> = match line.contains('"') {
        false => line.split(char::from(mark)).map(|cell| cell.trim().to_owned()).collect(),
        true => {
            let mut reader = csv::ReaderBuilder::new();
            reader.delimiter(mark).has_headers(false).flexible(true).trim(csv::Trim::All);
            let row = reader.from_reader(line.trim_start().as_bytes()).into_records().flatten().next();
            row.map_or_else(Vec::new, |row| row.iter().map(str::to_owned).collect())
        }
    };
    while cells.last().is_some_and(String::is_empty) {
        cells.pop();
    }
    cells
}

/// The text with line ends of one kind and without a byte order mark.
fn plain_lines(text: &str) -> String {
    text.trim_start_matches('\u{feff}').replace("\r\n", "\n").replace('\r', "\n")
}

impl Table {
    /// Whether a text has a row that names at least two quantities of a test.
    #[must_use]
    pub fn is_in(text: &str) -> bool {
        header(&plain_lines(text), 2).is_some()
    }

    /// Reads the text of a file.
    ///
    /// # Errors
    /// One sentence on what cannot be read, where, and the remedy.
    pub fn read(name: &str, text: &str) -> Result<Self, String> {
        let bad = |what: String| format!("{name}: {what}");
        let text = &plain_lines(text);
        let is_row = |(_, line): &(usize, &str)| !line.trim().is_empty() && !line.starts_with('#');
        let (first, line) = text
            .lines()
            .enumerate()
            .find(is_row)
            .ok_or_else(|| bad("the file is empty: give a table with a row of names".into()))?;
        // without a row of all names, the first row says what is missing
        let of_first = |mark: &u8| line.as_bytes().contains(mark).then(|| (first, *mark, cells(line, *mark)));
        let (first, mark, names) = header(text, 3).or_else(|| MARKS.iter().find_map(of_first)).ok_or_else(|| {
            bad(format!(
                "line {}: one column, \"{}\": separate time, depth and force by commas, semicolons or tabs",
                first + 1,
                line.trim()
            ))
        })?;
        let below = text.lines().enumerate().skip(first + 1).filter(is_row);
        if let Some((n, _)) = below.clone().find(|(_, line)| line.matches('"').count() % 2 == 1) {
            return Err(bad(format!("line {}: a quotation mark is not closed: remove it, or close it", n + 1)));
        }
        let mut rows: Vec<(usize, Vec<String>)> = below.map(|(n, line)| (n + 1, cells(line, mark))).collect();
        // some machines write the units in a row of their own
        let no_number = |(_, cells): &(usize, Vec<String>)| cells.iter().all(|cell| number(cell, true).is_none());
        let units = if rows.first().is_some_and(no_number) { rows.remove(0).1 } else { Vec::new() };
        let mut found: [Option<(usize, f64)>; 6] = [None; 6];
        for (n, text) in names.iter().enumerate() {
            let (Some(quantity), unit) = heading(text) else { continue };
            let under = || units.get(n).and_then(|cell| heading(cell).1).filter(|(of, _)| *of == quantity);
            let si = match (quantity, unit.or_else(under)) {
                ("test", _) => 1.0,
                ("time", None) if units.get(n).is_none_or(String::is_empty) && only_time(text) => 1.0,
                (_, Some((_, si))) => si,
                _ => {
                    return Err(bad(format!(
                        "column \"{text}\" has no unit that is known: name it {quantity}_{}, for example",
                        match quantity {
                            "time" => "s",
                            "depth" => "mm",
                            _ => "N",
                        }
                    )));
                }
            };
            let named = WORDS.iter().map(|(of, _)| *of).chain(["slide", "friction"]);
            let slot = &mut found[named.into_iter().position(|of| of == quantity).unwrap_or(0)];
            if slot.is_some() && quantity != "test" {
                return Err(bad(format!(
                    "two columns of {quantity}, the second is \"{text}\": rename the one that is not meant"
                )));
            }
            *slot = Some((n, si));
        }
        let [time, depth, force, test, slide, friction] = found;
        let missing: Vec<&str> = WORDS.iter().zip(&found).take(3).filter(|(_, f)| f.is_none()).map(|((of, _), _)| *of).collect();
        let (Some(time), Some(depth), Some(force)) = (time, depth, force) else {
            return Err(bad(format!(
                "no column of {} among \"{}\": known are {}",
                missing.join(" and "),
                names.join("\", \""),
                known()
            )));
        };
        let along = slide.zip(friction);
        let mut table = Self { tests: Vec::new(), along: Vec::new(), notes: Vec::new() };
        if let (Some((k, _)), None) = (slide.or(friction), along) {
            table.notes.push(format!("{name}: \"{}\" is left out: friction needs slide_mm and lateral_force_mN", names[k]));
        }
        let comma = rows.iter().flat_map(|(_, cells)| cells).any(|cell| cell.contains(','));
        if comma {
            table.notes.push(format!("{name}: commas are read as decimal marks"));
        }
        let mut known_tests: HashMap<String, usize> = HashMap::new();
        let (mut part, mut last_s, mut days_s) = (1, f64::MIN, 0.0);
        for (n, cells) in rows {
            // tests below each other repeat the names
            if cells == names {
                part += 1;
            }
            if cells == names || cells == units {
                continue;
            }
            if cells.len() > names.len() && mark == b',' {
                return Err(bad(format!(
                    "line {n}: {} cells under {} names: decimal commas cannot be told from separators; separate by semicolons, or write points",
                    cells.len(),
                    names.len()
                )));
            }
            let cell = |(k, si): (usize, f64)| {
                let cell = cells.get(k).map_or("", String::as_str);
                let clock = || (k == time.0).then(|| clock_s(cell, comma)).flatten();
                let value = number(cell, comma).map(|value| value * si).or_else(clock);
                value
                    .filter(|value| value.is_finite())
                    .ok_or_else(|| bad(format!("line {n}: \"{cell}\" under \"{}\" is no number: leave the row out", names[k])))
            };
            let mut row = [cell(time)?, cell(depth)?, cell(force)?];
            // a clock begins anew at midnight
            let of_clock = cells[time.0].contains(':');
            if of_clock && row[0] + days_s < last_s - 0.5 * DAY_S {
                days_s += DAY_S;
            }
            row[0] += if of_clock { days_s } else { 0.0 };
            last_s = row[0];
            let aside = along.map(|(slide, friction)| Ok::<_, String>([cell(slide)?, cell(friction)?])).transpose()?;
            let of = test.map_or("", |(k, _)| cells.get(k).map_or("", String::as_str));
            let of = if of.is_empty() { name.to_owned() } else { format!("{name}, test {of}") };
            let of = if part > 1 { format!("{of}, part {part}") } else { of };
            let n = *known_tests.entry(of).or_insert_with_key(|of| {
                table.tests.push((of.clone(), Vec::new()));
                table.along.push(Vec::new());
                table.tests.len() - 1
            });
            table.tests[n].1.push(row);
            table.along[n].extend(aside);
        }
        if table.tests.is_empty() {
            return Err(bad("no rows under the names: record a test first".into()));
        }
        Ok(table)
    }
}
