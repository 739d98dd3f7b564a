//! Mutants that may survive `cargo-mutants`, each with a reason, and their comparison with a run.

use std::fs;
use std::path::Path;

use serde::Deserialize;

/// Path of the list, relative to the repository root.
const SURVIVORS: &str = "tests/mutants/survivors.toml";

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct List {
    survivor: Vec<Survivor>,
}

/// A mutant, or several mutants with the same file, description and source line.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq)]
#[serde(deny_unknown_fields)]
pub struct Survivor {
    /// Path relative to the repository root.
    pub file: String,
    /// Description of the mutant, as cargo-mutants prints it.
    pub mutant: String,
    /// Source line that the mutant changes.
    pub line: String,
    /// Reason why no fast test notices the mutant.
    #[serde(default)]
    pub reason: String,
}

impl Survivor {
    /// Parses a line of cargo-mutants' output, `file:line:column: mutant`, and reads the source
    /// line from the file below `tree`.
    fn parse(text: &str, tree: &Path) -> Option<Self> {
        let (place, mutant) = text.split_once(": ")?;
        let mut place = place.splitn(3, ':');
        let (file, number) = (place.next()?, place.next()?.parse::<usize>().ok()?);
        let source = fs::read_to_string(tree.join(file)).ok()?;
        let line = source.lines().nth(number.checked_sub(1)?)?.trim();
        Some(Self { file: file.into(), mutant: mutant.into(), line: line.into(), reason: String::new() })
    }

    fn same(&self, other: &Self) -> bool {
        (&self.file, &self.mutant, &self.line) == (&other.file, &other.mutant, &other.line)
    }
}

/// Reads the list.
pub fn read(root: &Path) -> Result<Vec<Survivor>, String> {
    let text = fs::read_to_string(root.join(SURVIVORS)).map_err(|error| format!("{SURVIVORS}: {error}"))?;
    let list: List = toml::from_str(&text).map_err(|error| format!("{SURVIVORS}: {error}"))?;
    match list.survivor.iter().find(|survivor| survivor.reason.trim().is_empty()) {
        Some(survivor) => Err(format!("{SURVIVORS}: no reason for: {}: {}", survivor.file, survivor.mutant)),
        None => Ok(list.survivor),
    }
}

/// Compares a run with the list and prints the result; returns whether every survivor has a reason.
pub fn compare(root: &Path, tree: &Path, out: &Path) -> Result<bool, String> {
    let lines = |name: &str| -> Result<Vec<String>, String> {
        let path = out.join(name);
        let text = fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
        Ok(text.lines().map(str::to_owned).collect())
    };
    let known = read(root)?;
    let missed = lines("missed.txt")?;
    let (mut explained, mut fresh) = (0, Vec::new());
    for text in &missed {
        let survivor = Survivor::parse(text, tree).ok_or(format!("not a mutant of this source: {text}"))?;
        match known.iter().any(|k| k.same(&survivor)) {
            true => explained += 1,
            false => fresh.push(survivor),
        }
    }
    let noticed = lines("caught.txt")?.len() + lines("timeout.txt")?.len();
    let unbuilt = lines("unviable.txt")?.len();
    let all = noticed + missed.len();
    println!(
        "{noticed} of {all} noticed, {:.1} %; {explained} survivors have a reason, {} have none; {unbuilt} did not build",
        100.0 * noticed as f32 / all.max(1) as f32,
        fresh.len()
    );
    for survivor in &fresh {
        println!("\n[[survivor]]\nfile = {:?}\nmutant = {:?}\nline = {:?}", survivor.file, survivor.mutant, survivor.line);
    }
    Ok(fresh.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_survivor_has_a_reason_and_its_line_still_stands_in_its_file() {
        let root = crate::repository();
        for survivor in read(&root).unwrap() {
            let source = fs::read_to_string(root.join(&survivor.file)).unwrap_or_default();
            let stands = source.lines().any(|line| line.trim() == survivor.line);
            assert!(stands, "{} has no such line: {}", survivor.file, survivor.line);
        }
    }

    #[test]
    fn a_mutant_is_known_by_its_file_its_words_and_its_line() {
        let root = crate::repository();
        let text = "core/src/lib.rs:1:1: replace a with b in c";
        let survivor = Survivor::parse(text, &root).unwrap();
        assert_eq!((survivor.file.as_str(), survivor.mutant.as_str()), ("core/src/lib.rs", "replace a with b in c"));
        assert!(survivor.line.starts_with("//!"));
        let moved = Survivor { line: "x".into(), ..survivor.clone() };
        assert!(survivor.same(&survivor) && !survivor.same(&moved));
        assert!(Survivor::parse("core/src/lib.rs:99999:1: x", &root).is_none());
    }
}
