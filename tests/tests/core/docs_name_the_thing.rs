//! Docs begin with the thing they document: no sentence is headed by "What", "Which" or the like.
//! Comments are narrow enough to be read next to code.

use palpate_tests::palpate_command::repository;

/// Widest line of a comment [columns].
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

/// Lines of every source file, with their places.
fn lines_that(is_bad: fn(&str) -> bool) -> Vec<String> {
    let mut found = Vec::new();
    let mut folders = ["core", "firmware", "host-sim", "tests"].map(|folder| repository().join(folder)).to_vec();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.extend(Some(path).filter(|path| !path.ends_with("target")));
            } else if path.extension().is_some_and(|e| e == "rs") {
                let text = std::fs::read_to_string(&path).unwrap();
                let bad = text.lines().enumerate().filter(|(_, line)| is_bad(line));
                found.extend(bad.map(|(n, line)| format!("{}:{}: {line}", path.display(), n + 1)));
            }
        }
    }
    found
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
