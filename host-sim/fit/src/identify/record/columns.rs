//! Columns of a table by their names and units, in several languages.

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
            "crosshead",
            "weg",
            "standardweg",
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
    ("force", &["force", "load", "kraft", "standardkraft", "normalkraft", "last", "effort", "charge", "fuerza", "carga"]),
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

/// Units of time, length and force, with their size in SI. Case matters: mN is not MN.
const UNITS: [(&str, &str, f64); 25] = [
    ("time", "s", 1.0),
    ("time", "sec", 1.0),
    ("time", "ms", 1e-3),
    ("time", "us", 1e-6),
    ("time", "µs", 1e-6),
    ("time", "μs", 1e-6),
    ("time", "min", 60.0),
    ("time", "minutes", 60.0),
    ("time", "h", 3600.0),
    ("depth", "m", 1.0),
    ("depth", "cm", 1e-2),
    ("depth", "mm", 1e-3),
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
    ("force", "gf", 9.806_65e-3),
    ("force", "g", 9.806_65e-3),
    ("force", "lbf", 4.448_222),
];

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
        'é' | 'è' | 'ê' | 'É' => 'e',
        'á' | 'à' | 'â' | 'ä' => 'a',
        'ó' | 'ô' | 'ö' => 'o',
        'í' | 'î' => 'i',
        'ú' | 'û' | 'ü' => 'u',
        c => c,
    };
    text.chars().map(flat).collect()
}

/// Quantity and unit of a heading: words and one unit, in any order and punctuation.
fn heading(text: &str) -> (Option<&'static str>, Option<(&'static str, f64)>) {
    let text = plain(text);
    let words: Vec<&str> = text.split(|c: char| !c.is_alphanumeric() && c != 'µ' && c != 'μ').filter(|w| !w.is_empty()).collect();
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
        UNITS.iter().find(|(of, unit, _)| unit == word && quantity.is_none_or(|(_, q)| q == *of)).map(|(of, _, si)| (*of, *si))
    });
    (quantity.map(|(_, q)| q), unit)
}

/// Reads a number; a comma is its decimal mark if it cannot be anything else.
fn number(cell: &str, comma: bool) -> Option<f64> {
    let cell = cell.trim().trim_matches('"').trim();
    let value: f64 = if comma { cell.replace(',', ".").parse().ok()? } else { cell.parse().ok()? };
    value.is_finite().then_some(value)
}

impl Table {
    /// Reads the text of a file.
    ///
    /// # Errors
    /// One sentence on what cannot be read, where, and the remedy.
    pub fn read(name: &str, text: &str) -> Result<Self, String> {
        let bad = |what: String| format!("{name}: {what}");
        let text = text.trim_start_matches('\u{feff}');
        let lines = || text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty() && !line.starts_with('#'));
        let (first, header) = lines().next().ok_or_else(|| bad("the file is empty: give a table with a row of names".into()))?;
        let mark = [';', '\t', ','].into_iter().find(|mark| header.contains(*mark)).ok_or_else(|| {
            bad(format!(
                "line {}: one column, \"{}\": separate time, depth and force by commas, semicolons or tabs",
                first + 1,
                header.trim()
            ))
        })?;
        let names: Vec<&str> = header.split(mark).map(|cell| cell.trim().trim_matches('"')).collect();
        let mut found: [Option<(usize, f64)>; 6] = [None; 6];
        // some machines write the units in a row of their own
        let below: Option<Vec<&str>> =
            lines().nth(1).map(|(_, line)| line.split(mark).map(|c| c.trim().trim_matches('"')).collect());
        let below = below.filter(|cells| cells.iter().all(|cell| number(cell, true).is_none()));
        for (n, text) in names.iter().enumerate() {
            let (Some(quantity), unit) = heading(text) else { continue };
            let under = || below.as_ref().and_then(|cells| heading(cells.get(n)?).1).filter(|(of, _)| *of == quantity);
            let si = match (quantity, unit.or_else(under)) {
                ("test", _) => 1.0,
                ("time", None) if !text.contains(['(', '[', '/']) => 1.0,
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
        let rows = || lines().skip(1 + usize::from(below.is_some()));
        let comma = mark != ',' && rows().any(|(_, line)| line.contains(','));
        if comma {
            table.notes.push(format!("{name}: commas are read as decimal marks"));
        }
        for (n, line) in rows() {
            let cells: Vec<&str> = line.split(mark).collect();
            if cells.len() > names.len() && mark == ',' {
                return Err(bad(format!(
                    "line {}: {} cells under {} names: decimal commas cannot be told from separators; separate by semicolons, or write points",
                    n + 1,
                    cells.len(),
                    names.len()
                )));
            }
            let cell = |(k, si): (usize, f64)| {
                let cell = cells.get(k).copied().unwrap_or("");
                let value = number(cell, comma).ok_or_else(|| {
                    bad(format!("line {}: \"{}\" under \"{}\" is no number: leave the row out", n + 1, cell.trim(), names[k]))
                })?;
                Ok::<f64, String>(value * si)
            };
            let row = [cell(time)?, cell(depth)?, cell(force)?];
            let aside = along.map(|(slide, friction)| Ok::<_, String>([cell(slide)?, cell(friction)?])).transpose()?;
            let of = test.map_or("", |(k, _)| cells.get(k).map_or("", |cell| cell.trim()));
            let of = if of.is_empty() { name.to_owned() } else { format!("{name}, test {of}") };
            let n = table.tests.iter().position(|(test, _)| *test == of).unwrap_or_else(|| {
                table.tests.push((of, Vec::new()));
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
