//! The documents that everybody has to read stay short: README, changelog, decisions, porting and
//! bring-up.

use palpate_tests::palpate_command::{files_below, repository};

/// Largest number of words of a document.
const MOST_WORDS: [(&str, usize); 4] =
    [("README.md", 700), ("CHANGELOG.md", 1_500), ("firmware/PORTING.md", 900), ("firmware/BRINGUP.md", 900)];
/// Largest number of words of all documents together.
const MOST_WORDS_IN_ALL: usize = 47_000;
/// Largest number of decisions, and of words in one.
const MOST_RECORDS: usize = 60;
const MOST_WORDS_IN_RECORD: usize = 150;
/// Parts that every decision has.
const PARTS: [&str; 3] = ["**Decision.**", "**Reason.**", "**Rejected.**"];

fn words(text: &str) -> usize {
    text.split_whitespace().count()
}

#[test]
fn documents_keep_their_length() {
    for (path, most) in MOST_WORDS {
        let text = std::fs::read_to_string(repository().join(path)).unwrap();
        assert!(words(&text) <= most, "{path}: {} words, at most {most}", words(&text));
    }
}

#[test]
fn all_documents_together_keep_their_length() {
    let texts = files_below(&["."], ".md");
    let found: usize = texts.iter().map(|path| words(&std::fs::read_to_string(path).unwrap())).sum();
    assert!((30_000..=MOST_WORDS_IN_ALL).contains(&found), "{found} words, at most {MOST_WORDS_IN_ALL}");
}

/// Defects of the records of decisions: too many, too long, or without one of their parts.
fn complaints(text: &str) -> Vec<String> {
    let records: Vec<&str> = text.split("\n### ").skip(1).map(|rest| rest.split("\n## ").next().unwrap_or(rest)).collect();
    let mut found = Vec::new();
    if records.is_empty() || records.len() > MOST_RECORDS {
        found.push(format!("{} records, at most {MOST_RECORDS}", records.len()));
    }
    for record in records {
        let title = record.lines().next().unwrap_or_default();
        if words(record) > MOST_WORDS_IN_RECORD {
            found.push(format!("{title}: {} words, at most {MOST_WORDS_IN_RECORD}", words(record)));
        }
        let missing = PARTS.iter().filter(|part| !record.contains(*part));
        found.extend(missing.map(|part| format!("{title}: no {part}")));
    }
    found
}

#[test]
fn decisions_are_few_and_short() {
    let text = std::fs::read_to_string(repository().join("DECISIONS.md")).unwrap();
    let found = complaints(&text);
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn a_decision_that_is_long_or_incomplete_is_seen() {
    let record = "\n### Title\n\n**Decision.** It is. **Reason.** So. **Rejected.** Not so.\n";
    assert_eq!(complaints(record).len(), 0);
    assert_eq!(complaints("## None\n").len(), 1);
    assert_eq!(complaints(&record.replace("**Rejected.** Not so.", "")).len(), 1);
    assert_eq!(complaints(&record.replace("Not so.", &"word ".repeat(150))).len(), 1);
    assert_eq!(complaints(&record.repeat(61)).len(), 1);
}
