//! `limits.toml` holds the known limits. LIMITS.md is generated from it, every row names a test or
//! a command that exists, and the page of the book on which a user meets a limit links to its row.

use std::collections::BTreeSet;
use std::path::PathBuf;

use clap::CommandFactory;
use palpate_sim::command::Cli;
use palpate_tests::palpate_command::{files_below, repository};
use serde::Deserialize;

const PAGE: &str = "LIMITS.md";
const BOOK: &str = "host-sim/book/src";
const MOST_ROWS: usize = 120;
const MOST_WORDS: usize = 4_000;

const INTRODUCTION: &str = "\
# Limits

*Missed* means that a figure is outside its bound, *untested* that nobody has tried. The last column names the test or the command that
measures the row again. The glossary explains *quiet*, the hands H0 to H6 and the motions S1 to S12. A test generates this page from
`limits.toml`.
";

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Limits {
    group: Vec<Group>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Group {
    name: String,
    limit: Vec<Limit>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Limit {
    id: String,
    claim: String,
    bound: Option<String>,
    measured: String,
    state: State,
    command: String,
    page: String,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum State {
    Holds,
    Missed,
    Untested,
}

impl State {
    fn text(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::Missed => "**missed**",
            Self::Untested => "untested",
        }
    }
}

fn read(path: &str) -> String {
    std::fs::read_to_string(repository().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

fn limits() -> Limits {
    toml::from_str(&read("limits.toml")).unwrap_or_else(|error| panic!("limits.toml: {error}"))
}

fn rows(limits: &Limits) -> impl Iterator<Item = &Limit> {
    limits.group.iter().flat_map(|group| &group.limit)
}

/// Text of LIMITS.md. Each row has an anchor for links from the book.
fn page(limits: &Limits) -> String {
    let mut page = INTRODUCTION.to_owned();
    for group in &limits.group {
        page.push_str(&format!("\n## {}\n\n|limit|bound|measured|state|measured by|\n|---|---|---|---|---|\n", group.name));
        for Limit { id, claim, bound, measured, state, command, .. } in &group.limit {
            let bound = bound.as_deref().unwrap_or_default();
            page.push_str(&format!("|<a id=\"{id}\"></a>{claim}|{bound}|{measured}|{}|`{command}`|\n", state.text()));
        }
    }
    page
}

#[test]
fn the_page_is_what_the_file_says() {
    let written = std::fs::read_to_string(repository().join(PAGE)).unwrap_or_default();
    assert!(
        written == page(&limits()),
        "{PAGE} is out of date: cargo test --release -p palpate-tests --test command_line -- --ignored rewrite_the_limits"
    );
}

#[test]
#[ignore = "writes the page"]
fn rewrite_the_limits() {
    std::fs::write(repository().join(PAGE), page(&limits())).unwrap();
}

#[test]
fn rows_are_few_and_short() {
    let limits = limits();
    let ids: BTreeSet<&str> = rows(&limits).map(|row| row.id.as_str()).collect();
    assert_eq!(ids.len(), rows(&limits).count(), "two rows have one id");
    assert!(ids.len() <= MOST_ROWS, "{} rows, at most {MOST_ROWS}", ids.len());
    let words = page(&limits).split_whitespace().count();
    assert!(words <= MOST_WORDS, "{words} words, at most {MOST_WORDS}");
    for row in rows(&limits) {
        let cells = [&row.claim, &row.measured, &row.command];
        assert!(cells.iter().all(|cell| !cell.is_empty() && !cell.contains('|')), "{}: an empty cell, or a | in one", row.id);
    }
}

/// Names of the tests of the repository: their functions, and the files that hold some.
fn tests(files: &[PathBuf]) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    for path in files.iter().filter(|path| path.extension().is_some_and(|e| e == "rs")) {
        let text = std::fs::read_to_string(path).unwrap();
        let functions: Vec<String> = text.split("#[test]").skip(1).filter_map(function).collect();
        if !functions.is_empty() {
            names.extend(path.file_stem().and_then(|stem| Some(stem.to_str()?.to_owned())));
        }
        names.extend(functions);
    }
    names
}

/// Name of the first function in a text.
fn function(text: &str) -> Option<String> {
    let (_, rest) = text.split_once("fn ")?;
    Some(rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect())
}

/// Packages of the repository.
fn packages(files: &[PathBuf]) -> BTreeSet<String> {
    let manifests = files.iter().filter(|path| path.ends_with("Cargo.toml"));
    let name = |path: &PathBuf| {
        let manifest: toml::Table = toml::from_str(&std::fs::read_to_string(path).ok()?).ok()?;
        Some(manifest.get("package")?.get("name")?.as_str()?.to_owned())
    };
    manifests.filter_map(name).collect()
}

/// Reason why a row's command cannot be run.
fn refusal(command: &str, tests: &BTreeSet<String>, packages: &BTreeSet<String>) -> Option<String> {
    let words: Vec<&str> = command.split(' ').collect();
    match words.as_slice() {
        ["palpate", ..] => Cli::command().try_get_matches_from(&words).err().map(|error| error.to_string()),
        ["cargo", "bench" | "test", "-p", package] => (!packages.contains(*package)).then(|| "no such package".to_owned()),
        [script] if script.contains('/') => (!repository().join(script).is_file()).then(|| "no such file".to_owned()),
        [test] => (!tests.contains(*test)).then(|| "no such test".to_owned()),
        _ => Some("neither a test, a command line of palpate, nor a script".to_owned()),
    }
}

#[test]
fn every_row_can_be_measured_again() {
    let files = files_below(&[""], "");
    let (tests, packages) = (tests(&files), packages(&files));
    assert!(tests.len() > 1000 && packages.len() > 5, "{} tests, {} packages", tests.len(), packages.len());
    let limits = limits();
    let refused: Vec<String> = rows(&limits)
        .filter_map(|row| Some(format!("{}: `{}`: {}", row.id, row.command, refusal(&row.command, &tests, &packages)?)))
        .collect();
    assert!(refused.is_empty(), "{}", refused.join("\n"));
}

#[test]
fn a_command_that_does_not_exist_is_seen() {
    let set = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<BTreeSet<_>>();
    let refused = |command: &str| refusal(command, &set(&["a_test"]), &set(&["palpate-bench"])).is_some();
    for exists in ["palpate loop --quick", "cargo bench -p palpate-bench", "./test", "a_test"] {
        assert!(!refused(exists), "{exists}");
    }
    for gone in ["palpate lop", "palpate loop --quik", "cargo bench -p palpate-gone", "./gone", "gone", "other program"] {
        assert!(refused(gone), "{gone}");
    }
    assert_eq!(function("\n#[ignore]\nfn rests_at_4_mm() {"), Some("rests_at_4_mm".to_owned()));
}

#[test]
fn every_row_is_linked_from_the_page_where_a_user_meets_it() {
    let limits = limits();
    let missing: Vec<String> = rows(&limits)
        .filter(|row| !read(&format!("{BOOK}/{}", row.page)).contains(&format!("LIMITS.md#{})", row.id)))
        .map(|row| format!("{}: no link to LIMITS.md#{}", row.page, row.id))
        .collect();
    assert!(missing.is_empty(), "{}", missing.join("\n"));
}
