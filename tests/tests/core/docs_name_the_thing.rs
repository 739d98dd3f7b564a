//! Doc comments begin with the thing that they document: no sentence is headed by "What", "Which"
//! or the like. Comment lines are narrow enough to be read next to code.

use std::path::PathBuf;

use palpate_tests::palpate_command::files_below;

/// Folders of the source tree.
const TREE: [&str; 4] = ["core", "firmware", "host-sim", "tests"];
/// Largest width of a comment line [columns].
const WIDEST: usize = 100;

#[test]
fn no_doc_begins_with_a_headless_clause() {
    let found = lines_that(is_headless);
    assert!(found.is_empty(), "name the thing first:\n{}", found.join("\n"));
}

#[test]
fn no_comment_is_wider_than_a_hundred_columns() {
    let found = lines_that(is_wide_comment);
    assert!(found.is_empty(), "break at {WIDEST} columns:\n{}", found.join("\n"));
}

/// `doctest = false` in a manifest saves rustdoc's run over the crate, but would also skip an
/// example.
#[test]
fn an_example_in_docs_is_run() {
    let (mut off, mut on) = (0, 0);
    for manifest in files_below(&TREE, "Cargo.toml") {
        let sources = manifest.with_file_name("src");
        let examples = files_below(&TREE, ".rs").into_iter().filter(|path| path.starts_with(&sources));
        let examples: Vec<_> = examples.filter(|path| has_example(&std::fs::read_to_string(path).unwrap())).collect();
        if std::fs::read_to_string(&manifest).unwrap().contains("doctest = false") {
            assert!(examples.is_empty(), "take `doctest = false` out of {}: {examples:?}", manifest.display());
            off += 1;
        } else {
            on += examples.len();
        }
    }
    assert!(off > 5 && on > 2, "{off} crates without, {on} files with examples");
    assert!(has_example("/// ```\n/// f();\n/// ```") && has_example("//! ```text\n//! ```\n    /// ```no_run"));
    assert!(!has_example("/// ```text\n/// ```\n//! ```toml\n//! ```"));
}

/// Whether a file's docs contain an example that rustdoc runs: a block without a language, or in
/// Rust.
fn has_example(text: &str) -> bool {
    let docs = text.lines().map(str::trim_start).filter(|line| line.starts_with("///") || line.starts_with("//!"));
    let fences = docs.filter_map(|line| line[3..].trim_start().strip_prefix("```"));
    fences.step_by(2).any(|language| !["text", "toml", "sh", "ignore"].contains(&language))
}

/// Lines of every source file for which `is_bad` is true, with their positions.
fn lines_that(is_bad: fn(&str) -> bool) -> Vec<String> {
    let bad = |path: PathBuf| {
        let text = std::fs::read_to_string(&path).unwrap();
        let bad = text.lines().enumerate().filter(|(_, line)| is_bad(line));
        bad.map(|(n, line)| format!("{}:{}: {line}", path.display(), n + 1)).collect::<Vec<_>>()
    };
    files_below(&TREE, ".rs").into_iter().flat_map(bad).collect()
}

fn is_wide_comment(line: &str) -> bool {
    line.trim_start().starts_with("//") && line.chars().count() > WIDEST
}

fn is_headless(line: &str) -> bool {
    let line = line.trim_start();
    let doc = line.strip_prefix("///").or_else(|| line.strip_prefix("//!")).map(str::trim_start);
    let heads = ["What ", "The same", "Which ", "Who ", "Nobody "];
    doc.is_some_and(|doc| heads.iter().any(|head| doc.starts_with(head)))
}

#[test]
fn a_headless_clause_is_seen_and_a_noun_is_not() {
    assert!(is_headless("    /// What was clamped.") && is_headless("//! The same in millimetres."));
    assert!(!is_headless("/// Inputs that were clamped.") && !is_headless("// What was clamped."));
}

#[test]
fn a_wide_comment_is_seen_and_code_is_not() {
    let words = "x".repeat(WIDEST - 2);
    assert!(is_wide_comment(&format!("///{words}")) && is_wide_comment(&format!("    //{words}")));
    assert!(!is_wide_comment(&format!("//{words}")) && !is_wide_comment(&format!("let x = {words};")));
}
