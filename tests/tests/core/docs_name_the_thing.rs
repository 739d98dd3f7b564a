//! Docs begin with the thing they document: no sentence is headed by "What" or "The same".

use palpate_tests::palpate_command::repository;

#[test]
fn no_doc_begins_with_a_headless_clause() {
    let mut found = Vec::new();
    let mut folders = ["core", "firmware", "host-sim", "tests"].map(|folder| repository().join(folder)).to_vec();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.extend(Some(path).filter(|path| !path.ends_with("target")));
            } else if path.extension().is_some_and(|e| e == "rs") {
                let text = std::fs::read_to_string(&path).unwrap();
                let bad = text.lines().enumerate().filter(|(_, line)| is_headless(line));
                found.extend(bad.map(|(n, line)| format!("{}:{}: {line}", path.display(), n + 1)));
            }
        }
    }
    assert!(found.is_empty(), "name the thing first:\n{}", found.join("\n"));
}

fn is_headless(line: &str) -> bool {
    let line = line.trim_start();
    let doc = line.strip_prefix("///").or_else(|| line.strip_prefix("//!")).map(str::trim_start);
    doc.is_some_and(|doc| doc.starts_with("What ") || doc.starts_with("The same"))
}

#[test]
fn a_headless_clause_is_seen_and_a_noun_is_not() {
    assert!(is_headless("    /// What was clamped.") && is_headless("//! The same in millimetres."));
    assert!(!is_headless("/// Inputs that were clamped.") && !is_headless("// What was clamped."));
}
