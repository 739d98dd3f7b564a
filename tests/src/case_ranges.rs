//! Campaigns in ranges of cases, compared with a single run.

use std::collections::BTreeMap;
use std::path::Path;

use crate::palpate_command::{Desk, palpate};

/// Bytes of every file below a folder, by its path relative to that folder.
///
/// # Panics
/// The folder cannot be read.
pub fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in std::fs::read_dir(folder).expect("the folder is there").flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        if entry.path().is_dir() {
            found.extend(files(&entry.path()).into_iter().map(|(below, bytes)| (format!("{name}/{below}"), bytes)));
        } else {
            found.insert(name, std::fs::read(entry.path()).expect("the file is there"));
        }
    }
    found
}

/// Runs a command, which must exit with `code`.
///
/// # Panics
/// It does not.
#[track_caller]
pub fn ends(scratch: &str, desk: &Desk, code: i32, arguments: &[&str]) {
    let outcome = palpate(scratch, desk.folder(), arguments);
    assert_eq!(outcome.code, Some(code), "{arguments:?}: {outcome:?}");
}

/// Runs ranges of a command's cases into `ranges`.
///
/// # Panics
/// A range does not exit with 0.
#[track_caller]
pub fn ranges(scratch: &str, desk: &Desk, command: &[&str], ranges: &[&str]) {
    for cases in ranges {
        ends(scratch, desk, 0, &[command, &["--out", "ranges", "--cases", cases]].concat());
    }
}

/// Checks that a single run of a command and the merge of its ranges write the same files with the
/// same bytes, and that both exit with `code`. `whole` is the folder, below the single run's, that
/// contains the result to compare.
///
/// # Panics
/// They differ.
#[track_caller]
pub fn are_one(scratch: &str, desk: &Desk, code: i32, command: &[&str], of: &[&str], whole: &str) {
    ends(scratch, desk, code, &[command, &["--out", "one"]].concat());
    ranges(scratch, desk, command, of);
    ends(scratch, desk, code, &["merge", "ranges", "--out", "merged"]);
    let (one, merged) = (files(&desk.folder().join("one").join(whole)), files(&desk.folder().join("merged")));
    assert!(one.len() > 1 && one.contains_key("summary.json"), "{:?}", one.keys());
    assert_eq!(one.keys().collect::<Vec<_>>(), merged.keys().collect::<Vec<_>>());
    for (name, bytes) in &one {
        assert!(*bytes == merged[name], "{name} of {command:?} differs");
    }
}
