//! Every number of the haptic loop says where it comes from: the doc comment of a numeric constant
//! below `core/src/haptic` has a sentence that begins with `Source:`.
//!
//! The numbers in the force path are counted: those with which the force of a device would change
//! while its profile stays the same. So these do not count: numbers of a measurement before the
//! loop runs, and bounds within which a profile or a setting is accepted. Numbers in expressions
//! count, except those of a formula.

use std::path::{Path, PathBuf};

use palpate_tests::palpate_command::{files_below, repository};

/// Largest number of constants in the force path.
const MOST: usize = 45;
/// Files of what is measured before the loop runs.
const MEASUREMENTS: [&str; 2] = ["haptic/commission", "haptic/press.rs"];
/// Bounds of a profile and of settings, which are checked before the loop runs.
const BOUNDS: [&str; 9] = [
    "account/settings.rs: RANGES",
    "cycle/settings.rs: RANGES",
    "damping.rs: RANGES",
    "device.rs: RANGES",
    "device.rs: MOST_LAG_S",
    "device.rs: MOST_FORCE_N",
    "limits.rs: SMALL",
    "limits.rs: LEAST",
    "limits.rs: HIGHEST",
];
/// Settings that no device has unless it asks for them: a device for examples, no damping and no
/// account.
const EXAMPLES: [&str; 3] = ["account/settings.rs: HIGHEST", "damping.rs: NONE", "device.rs: STYLUS"];
/// Numbers of a formula, which may stand in an expression, and where.
const FORMULAS: [(&str, &[&str]); 5] = [
    // the series of the exponential
    ("account.rs", &["0.25", "6.0", "24.0"]),
    // the slope of a power of three halves
    ("damping.rs", &["1.5"]),
    // the range of a tick
    ("damping.rs", &["1e-4", "1e-2", "1e-3"]),
    ("limits.rs", &["1e-4", "1e-2"]),
    // 1 kHz
    ("cycle/settings.rs", &["1e-3"]),
];

/// A numeric constant of the haptic loop.
struct Constant {
    /// File below `core/src/haptic`, line and name.
    file: String,
    line: usize,
    name: String,
    /// Its doc comment, in one line.
    doc: String,
}

impl Constant {
    /// Text of the sentence that names the source.
    fn source(&self) -> Option<&str> {
        self.doc.split_once("Source: ").map(|(_, source)| source)
    }

    fn named(&self) -> String {
        format!("{}: {}", self.file, self.name)
    }

    fn in_force_path(&self) -> bool {
        let named = self.named();
        let measured = MEASUREMENTS.iter().any(|file| self.path().contains(file));
        !measured && !BOUNDS.contains(&&*named) && !EXAMPLES.contains(&&*named)
    }

    fn path(&self) -> String {
        format!("haptic/{}", self.file)
    }
}

#[test]
fn every_number_of_the_haptic_loop_names_its_source() {
    let constants: Vec<Constant> = files().iter().flat_map(|path| constants(path)).collect();
    let expressions: Vec<String> = files().iter().flat_map(|path| in_expressions(path)).collect();
    let forces = constants.iter().filter(|constant| constant.in_force_path()).count() + expressions.len();
    println!("{} constants; in the force path {forces}, of these in expressions {expressions:?}", constants.len());
    let at = |c: &Constant| format!("core/src/haptic/{}:{}: {}", c.file, c.line, c.name);
    let without = |c: &&Constant| c.source().is_none_or(|source| source.starts_with("none"));
    let silent: Vec<String> = constants.iter().filter(without).map(at).collect();
    assert!(silent.is_empty(), "say where these numbers come from, in a sentence that begins with `Source:`: {silent:?}");
    assert!(forces <= MOST, "{forces} numbers in the force path, more than {MOST}");
    assert!(constants.len() > 60 && forces > 30, "{} constants: the search misses some", constants.len());
    for excepted in BOUNDS.iter().chain(&EXAMPLES) {
        assert!(constants.iter().any(|c| c.named() == **excepted), "{excepted} does not exist");
    }
}

#[test]
fn a_constant_is_found_with_its_own_docs_and_without_those_of_tests() {
    let text = "/// None.\nconst NONE: f32 = 0.0;\n/// One.\n/// Source: chosen; it.\n#[rustfmt::skip]\n\
                pub(super) const ONE: [f32; 2] = [1.0, 2.0];\nconst NAME: &str = \"2\";\n    \
                pub const ALL: Self = Self { a: 1.0 };\n/// A function.\nfn f() {}\n\
                static RANGES: [Range; 1] = [\n    (\"x\", 0.0, 1.0),\n];\nconst OTHER: f32 = ONE;\n\
                #[cfg(test)]\nmod tests {\n    const IN_TESTS: f32 = 2.0;\n}\n";
    let found = constants_in("a.rs", text);
    let names: Vec<(usize, &str)> = found.iter().map(|constant| (constant.line, constant.name.as_str())).collect();
    assert_eq!(names, [(6, "ONE"), (8, "ALL"), (11, "RANGES")]);
    assert_eq!(found[0].source(), Some("chosen; it."));
    assert!(found[1].source().is_none() && found[2].doc.is_empty());
    let text = "const A: f32 = 3.0;\nfn f() -> f32 {\n    // 4.0\n    2.0 * x.0 + 0.5 + 1e-3 * 1.5_f32\n}\n#[cfg(test)]\nfn t() { 7.0 }\n";
    assert_eq!(numbers_of("a.rs", text), ["a.rs:4: 1e-3", "a.rs:4: 1.5"]);
}

/// Sources of the haptic loop, except files of tests.
fn files() -> Vec<PathBuf> {
    let mut files = files_below(&["core/src/haptic"], ".rs");
    files.retain(|path| !path.ends_with("tests.rs"));
    files.push(repository().join("core/src/haptic.rs"));
    files
}

/// Name of a file below `core/src/haptic`.
fn below_haptic(path: &Path) -> String {
    let name = path.strip_prefix(repository().join("core/src")).unwrap().display().to_string();
    name.strip_prefix("haptic/").map_or(name.clone(), str::to_owned)
}

fn constants(path: &Path) -> Vec<Constant> {
    constants_in(&below_haptic(path), &std::fs::read_to_string(path).unwrap())
}

/// Numbers in the expressions of a file of the force path that are not those of a formula.
fn in_expressions(path: &Path) -> Vec<String> {
    let name = below_haptic(path);
    if MEASUREMENTS.iter().any(|file| format!("haptic/{name}").contains(file)) {
        return Vec::new();
    }
    let of_formula = |number: &String| {
        FORMULAS.iter().any(|(file, numbers)| *file == name && numbers.iter().any(|n| number.ends_with(&format!(": {n}"))))
    };
    let numbers = numbers_of(&name, &std::fs::read_to_string(path).unwrap());
    numbers.into_iter().filter(|number| !of_formula(number)).collect()
}

/// Floating-point numbers of a file outside constants, comments and tests, other than 0, 1/2, 1 and
/// 2.
fn numbers_of(file: &str, text: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut in_constant = false;
    for (n, line) in text.lines().enumerate().take_while(|(_, line)| line.trim() != "#[cfg(test)]") {
        let code = line.split("//").next().unwrap_or_default();
        in_constant |= declared(code).is_some();
        if !in_constant {
            let numbers = code.split(|c: char| !(c.is_alphanumeric() || c == '_' || c == '.' || c == '-'));
            let numbers = numbers.flat_map(whole_number).filter(|number| !["0.0", "0.5", "1.0", "2.0"].contains(number));
            found.extend(numbers.map(|number| format!("{file}:{}: {number}", n + 1)));
        }
        in_constant &= !code.trim_end().ends_with(';');
    }
    found
}

/// The floating-point number that a word is, without its suffix.
fn whole_number(word: &str) -> Option<&str> {
    let word = word.strip_prefix('-').unwrap_or(word).split('_').next()?;
    (word.starts_with(|c: char| c.is_ascii_digit()) && word.parse::<f32>().is_ok() && word.contains(['.', 'e'])).then_some(word)
}

/// Numeric constants of a file outside its tests: those whose value contains a number.
fn constants_in(file: &str, text: &str) -> Vec<Constant> {
    let lines: Vec<&str> = text.lines().collect();
    let own = lines.iter().position(|line| line.trim() == "#[cfg(test)]").unwrap_or(lines.len());
    let mut found = Vec::new();
    for (n, line) in lines[..own].iter().enumerate() {
        let Some(name) = declared(line) else { continue };
        let end = (n..own).find(|&m| lines[m].ends_with(';')).unwrap_or(n);
        let whole = lines[n..=end].join("\n");
        let value = whole.split_once(" =").map_or("", |(_, value)| value);
        if !is_numeric(value) {
            continue;
        }
        let above = lines[..n].iter().rev().take_while(|line| line.trim().starts_with("///") || line.trim().starts_with("#["));
        let mut doc: Vec<&str> = above.filter_map(|line| line.trim().strip_prefix("///")).map(str::trim).collect();
        doc.reverse();
        found.push(Constant { file: file.to_owned(), line: n + 1, name: name.to_owned(), doc: doc.join(" ") });
    }
    found
}

/// Name of the constant that a line declares.
fn declared(line: &str) -> Option<&str> {
    let mut words = line.split([' ', ':']).filter(|word| !word.is_empty()).skip_while(|word| word.starts_with("pub"));
    let kind = words.next()?;
    let name = words.next()?;
    let is_name = name.chars().all(|c| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_');
    (["const", "static"].contains(&kind) && is_name).then_some(name)
}

/// Whether a value contains a number of its own other than zero, outside names and texts.
fn is_numeric(value: &str) -> bool {
    let texts = value.split('"').step_by(2);
    let words = texts.flat_map(|text| text.split(|c: char| !(c.is_alphanumeric() || c == '_' || c == '.')));
    words.filter(|word| word.starts_with(|c: char| c.is_ascii_digit())).any(|word| {
        let digits = word.split(['e', 'f', 'u', 'i']).next().unwrap_or_default();
        digits.contains(|c: char| ('1'..='9').contains(&c))
    })
}
