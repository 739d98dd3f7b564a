//! Every number of the haptic loop says where it comes from: the doc comment of a numeric constant
//! below `core/src/haptic` has a sentence that begins with `Source:`.

use std::path::{Path, PathBuf};

use palpate_tests::palpate_command::repository;

/// Number of constants whose source is unknown, `Source: none`. It may only fall.
const WITHOUT: usize = 22;

/// A numeric constant of the haptic loop.
struct Constant {
    /// File, line and name.
    at: String,
    /// Its doc comment, in one line.
    doc: String,
    /// Whether it can act on a force while the loop runs, or only in a measurement before that.
    in_force_path: bool,
}

impl Constant {
    /// Text of the sentence that names the source.
    fn source(&self) -> Option<&str> {
        self.doc.split_once("Source: ").map(|(_, source)| source)
    }
}

#[test]
fn every_number_of_the_haptic_loop_names_its_source() {
    let constants: Vec<Constant> = files().iter().flat_map(|path| constants(path)).collect();
    let without = |constant: &&Constant| constant.source().is_some_and(|source| source.starts_with("none"));
    let unknown: Vec<&str> = constants.iter().filter(without).map(|constant| constant.at.as_str()).collect();
    let forces = constants.iter().filter(|constant| constant.in_force_path).count();
    println!("{} constants, {forces} in the force path, {} without a source: {unknown:?}", constants.len(), unknown.len());
    let silent: Vec<&str> = constants.iter().filter(|c| c.source().is_none()).map(|c| c.at.as_str()).collect();
    assert!(silent.is_empty(), "say where these numbers come from, in a sentence that begins with `Source:`: {silent:?}");
    assert!(unknown.len() <= WITHOUT, "more than {WITHOUT} numbers without a source: {unknown:?}");
    assert!(constants.len() > 60, "{} constants: the search misses some", constants.len());
}

#[test]
fn a_constant_is_found_with_its_own_docs_and_without_those_of_tests() {
    let text = "/// None.\nconst NONE: f32 = 0.0;\n/// One.\n/// Source: chosen; it.\n#[rustfmt::skip]\n\
                pub(super) const ONE: [f32; 2] = [1.0, 2.0];\nconst NAME: &str = \"2\";\n    \
                pub const ALL: Self = Self { a: 1.0 };\n/// A function.\nfn f() {}\n\
                static RANGES: [Range; 1] = [\n    (\"x\", 0.0, 1.0),\n];\nconst OTHER: f32 = ONE;\n\
                #[cfg(test)]\nmod tests {\n    const IN_TESTS: f32 = 2.0;\n}\n";
    let found = constants_in("a.rs", text);
    let names: Vec<&str> = found.iter().map(|constant| constant.at.as_str()).collect();
    assert_eq!(names, ["a.rs:6: ONE", "a.rs:8: ALL", "a.rs:11: RANGES"]);
    assert_eq!(found[0].source(), Some("chosen; it."));
    assert!(found[1].source().is_none() && found[2].doc.is_empty());
}

/// Sources of the haptic loop, except files of tests.
fn files() -> Vec<PathBuf> {
    let mut folders = vec![repository().join("core/src/haptic")];
    let mut files = vec![repository().join("core/src/haptic.rs")];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") && !path.ends_with("tests.rs") {
                files.push(path);
            }
        }
    }
    files.sort();
    files
}

fn constants(path: &Path) -> Vec<Constant> {
    let name = path.strip_prefix(repository()).unwrap().display().to_string();
    constants_in(&name, &std::fs::read_to_string(path).unwrap())
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
        found.push(Constant {
            at: format!("{file}:{}: {name}", n + 1),
            doc: doc.join(" "),
            in_force_path: !(file.contains("haptic/commission") || file.ends_with("ceiling.rs") && is_of_the_press(name)),
        });
    }
    found
}

/// Whether a constant of `ceiling.rs` belongs to the press that measures a patch before the loop
/// starts.
fn is_of_the_press(name: &str) -> bool {
    ["PER_TICK_M", "ABOVE_M", "STEP_M", "STEP_SHARE", "REST_TICKS", "KEEP"].contains(&name)
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
