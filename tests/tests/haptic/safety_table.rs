//! SAFETY.md: its hazard table is that of `tests/data/hazards.toml` and leaves out no monitor, no
//! shaper and no fault, and everything that it names exists: files, tests, faults, commands, and
//! third-party software in the versions that are built.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::path::Path;

use palpate::Fault;
use palpate_tests::palpate_command::{files_below, repository};

/// Rows of the table.
const DATA: &str = "tests/data/hazards.toml";
/// Texts of SAFETY.md between which the table stands.
const TABLE: [&str; 2] = ["| no. | hazard |", "\n## The energy bound\n"];
/// Largest number of words in a cell.
const MOST_WORDS: usize = 40;

#[derive(serde::Deserialize)]
struct Hazards {
    hazard: Vec<Hazard>,
}

/// A row of the table.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Hazard {
    hazard: String,
    cause: String,
    severity: String,
    control: String,
    /// Monitors and shapers that control it, by their types.
    #[serde(default)]
    rules: Vec<String>,
    /// Faults that it raises.
    #[serde(default)]
    faults: Vec<String>,
    remains: String,
    evidence: String,
    /// Facts that do not fit a cell, shown after the table.
    #[serde(default)]
    more: String,
}

impl Hazard {
    /// Cells of the row, after its number.
    fn cells(&self) -> [String; 7] {
        let rules = self.rules.iter().map(|rule| format!("`{rule}`"));
        let acts: Vec<String> = rules.chain(self.faults.iter().map(|fault| format!("`Fault::{fault}`"))).collect();
        let acts = if acts.is_empty() { "-".to_owned() } else { acts.join(", ") };
        let [hazard, cause, severity, control, remains, evidence] =
            [&self.hazard, &self.cause, &self.severity, &self.control, &self.remains, &self.evidence].map(Clone::clone);
        [hazard, cause, severity, control, acts, remains, evidence]
    }
}

fn hazards() -> Vec<Hazard> {
    toml::from_str::<Hazards>(&read(DATA)).unwrap_or_else(|e| panic!("{DATA}: {e}")).hazard
}

/// The table and what follows it, as SAFETY.md shows them.
fn table(hazards: &[Hazard]) -> String {
    let head = "hazard | cause | severity | control and where it is | monitor, shaper, fault | residual risk | evidence";
    let mut text = format!("| no. | {head} |\n|{}\n", "---|".repeat(8));
    for (n, hazard) in hazards.iter().enumerate() {
        writeln!(text, "| {} | {} |", n + 1, hazard.cells().join(" | ")).unwrap();
    }
    text += "\nIn addition:\n\n";
    for (n, hazard) in hazards.iter().enumerate().filter(|(_, hazard)| !hazard.more.is_empty()) {
        writeln!(text, "* Row {}: {}", n + 1, hazard.more).unwrap();
    }
    text
}

/// Types of the loop that are a monitor or a shaper.
fn monitors_and_shapers() -> BTreeSet<String> {
    let code = sources(&["core/src/haptic"]);
    let named = |part: &str| part.split([' ', '{']).next().unwrap_or_default().to_owned();
    ["impl Monitor for ", "impl Shaper for "].iter().flat_map(|text| code.split(text).skip(1)).map(named).collect()
}

fn read(path: impl AsRef<Path>) -> String {
    let path = repository().join(path);
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Cells of the tables below a heading, without table heads and rules.
fn rows(text: &str, heading: &str) -> Vec<Vec<String>> {
    let section = text.split(&format!("\n## {heading}\n")).nth(1).unwrap_or_else(|| panic!("no section {heading}"));
    let lines = section.split("\n## ").next().unwrap_or_default().lines().filter(|line| line.starts_with('|'));
    let cells = |line: &str| line.trim_matches('|').split(" | ").map(|cell| cell.trim().to_owned()).collect();
    lines.skip(2).map(cells).collect()
}

/// Texts between backquotes.
fn quoted(text: &str) -> impl Iterator<Item = &str> {
    text.split('`').skip(1).step_by(2)
}

/// All Rust sources below some folders.
fn sources(folders: &[&str]) -> String {
    files_below(folders, ".rs").iter().map(|path| std::fs::read_to_string(path).unwrap()).collect()
}

/// Returns an error message if the item named in backquotes does not exist.
fn missing(name: &str, code: &str) -> Option<String> {
    let words: Vec<&str> = name.split(' ').collect();
    let there = match words[..] {
        ["palpate", command, ..] => {
            let commands = read("host-sim/src/command.rs");
            let module = command.split('-').map(|part| part[..1].to_uppercase() + &part[1..]).collect::<String>();
            commands.contains(&format!("    {module}("))
        }
        ["./test"] => repository().join("test").is_file(),
        ["./test", option] => read("test").contains(option),
        [one] if one.starts_with("Fault::") => {
            let fault = &one["Fault::".len()..];
            Fault::ALL.iter().any(|f| format!("{f:?}") == fault)
        }
        [one] if one.contains('/') => repository().join(one).exists(),
        [one] if one.contains('.') || one.starts_with(char::is_uppercase) => {
            repository().join(one).exists() || code.contains(one)
        }
        [one] if one.contains('_') || one == "soak" => {
            let folders = ["tests/tests", "firmware/controller/tests", "core/tests", "host-sim/lab/tests"];
            let programs = folders.iter().flat_map(|folder| std::fs::read_dir(repository().join(folder)).unwrap().flatten());
            programs.into_iter().any(|program| program.path().join(format!("{one}.rs")).is_file())
                || code.contains(&format!("fn {one}("))
        }
        _ => true,
    };
    (!there).then(|| name.to_owned())
}

#[test]
fn every_file_test_fault_and_command_is_there() {
    let text = read("SAFETY.md");
    let code = sources(&["core", "firmware", "host-sim", "tests"]);
    let gone: Vec<String> = quoted(&text).filter_map(|name| missing(name, &code)).collect();
    assert!(gone.is_empty(), "SAFETY.md names what is not there: {gone:?}");
    for wrong in ["core/src/none.rs", "no_such_test", "Fault::Nothing", "palpate dance", "./test --dance"] {
        assert!(missing(wrong, &code).is_some(), "{wrong}");
    }
}

#[test]
fn the_hazard_table_is_that_of_its_data() {
    let text = read("SAFETY.md");
    let shown = text.find(TABLE[0]).zip(text.find(TABLE[1])).map(|(from, to)| &text[from..to]);
    assert!(
        shown == Some(&table(&hazards())),
        "SAFETY.md is out of date: cargo test --release -p palpate-tests --test haptic -- --ignored rewrite_the_hazards"
    );
    for said in ["no medical device", "not certified", "nothing here was run on hardware", "force is zero on any doubt"] {
        assert!(text.contains(said), "SAFETY.md does not say: {said}");
    }
    assert!(rows(&text, "Commands").len() >= 8);
}

#[test]
#[ignore = "writes the table"]
fn rewrite_the_hazards() {
    let text = read("SAFETY.md");
    let [from, to] = TABLE.map(|border| text.find(border).unwrap());
    std::fs::write(repository().join("SAFETY.md"), format!("{}{}{}", &text[..from], table(&hazards()), &text[to..])).unwrap();
}

#[test]
fn every_hazard_has_a_control_a_remainder_and_evidence() {
    let hazards = hazards();
    assert!(hazards.len() >= 30, "{}", hazards.len());
    for row in &hazards {
        let name = &row.hazard;
        assert!(["serious", "moderate", "minor"].contains(&row.severity.as_str()), "{name}: {}", row.severity);
        assert!([&row.cause, &row.control, &row.remains].iter().all(|cell| cell.len() > 8), "{name}");
        assert!(
            quoted(&row.control).next().is_some() && quoted(&row.evidence).next().is_some(),
            "{name}: name control and evidence"
        );
        for cell in row.cells() {
            let words = cell.split_whitespace().count();
            assert!(words <= MOST_WORDS, "{name}: {words} words in {cell:?}; `more` has room");
        }
    }
}

#[test]
fn every_monitor_every_shaper_and_every_fault_has_a_hazard_and_no_other_is_named() {
    let hazards = hazards();
    let named: BTreeSet<String> = hazards.iter().flat_map(|row| row.rules.clone()).collect();
    assert_eq!(named, monitors_and_shapers(), "rules of {DATA} and monitors and shapers of core/src/haptic");
    let faults: BTreeSet<String> = hazards.iter().flat_map(|row| row.faults.clone()).collect();
    assert_eq!(faults, Fault::ALL.iter().map(|fault| format!("{fault:?}")).collect(), "faults of {DATA} and `Fault::ALL`");
}

#[test]
fn the_list_of_rules_names_every_monitor_and_shaper_and_is_short() {
    let docs = read("core/src/haptic.rs");
    let is_rule = |line: &&str| line.strip_prefix("//! ").is_some_and(|text| text.starts_with(|c: char| c.is_ascii_digit()));
    let rules: Vec<&str> = docs.lines().filter(is_rule).collect();
    assert!((12..=17).contains(&rules.len()), "{} rules in the force path", rules.len());
    for name in monitors_and_shapers() {
        assert!(rules.iter().any(|rule| rule.contains(&format!("::{name}`"))), "{name} is not in the list of core/src/haptic.rs");
    }
}

#[test]
fn third_party_software_is_that_of_the_lock_file() {
    let text = read("SAFETY.md");
    let lock = read("Cargo.lock");
    let mut built: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for package in lock.split("[[package]]").skip(1) {
        let value = |key: &str| package.split(&format!("\n{key} = \"")).nth(1).and_then(|rest| rest.split('"').next()).unwrap();
        built.entry(value("name")).or_default().push(value("version"));
    }
    let mut listed = Vec::new();
    for (section, least) in [("Third-party software in the board's image", 20), ("Third-party software in the desktop's loop", 8)]
    {
        let software = rows(&text, section);
        assert!(software.len() >= least, "{section}");
        for row in software {
            let [name, version, licence, does, fails] = &row[..] else { panic!("five columns: {row:?}") };
            assert!(
                built.get(name.as_str()).is_some_and(|v| v.contains(&version.as_str())),
                "{name} {version} is not in Cargo.lock"
            );
            assert!(licence.len() > 2 && !does.is_empty() && !fails.is_empty(), "{name}");
            listed.push(name.clone());
        }
    }
    // every dependency named in the manifests of core and image is in the list
    for manifest in ["core/Cargo.toml", "firmware/Cargo.toml", "firmware/controller/Cargo.toml"] {
        let text = read(manifest);
        for part in text.split("\n[").filter(|part| part.lines().next().is_some_and(|head| head.ends_with("dependencies]"))) {
            for name in part.lines().skip(1).filter_map(|line| line.split([' ', '.', '=']).next()) {
                let own = name.is_empty() || name.starts_with(['#', '[']) || name.starts_with("palpate");
                let dev = part.starts_with("dev-") || part.starts_with("build-");
                assert!(own || dev || listed.iter().any(|l| l == name), "{manifest} names {name}, which SAFETY.md does not list");
            }
        }
    }
}
