//! The list of mistakes: each replaces an exact text in a file by another.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use serde::Deserialize;

/// Path of the list, relative to the repository root.
const LIST: &str = "tests/mutants/list.toml";

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct List {
    mutant: Vec<Mutant>,
}

/// A mistake that the fast suite must notice.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mutant {
    /// Short description of the mistake.
    pub name: String,
    /// Replacements that together make the mistake.
    pub edit: Vec<Edit>,
    /// Reason why no test can notice the mistake. Without a reason, a test must notice it.
    pub equivalent: Option<String>,
}

/// Replacement of a text in one file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Edit {
    /// Path relative to the repository root.
    pub file: String,
    /// Text that occurs exactly once in the file.
    pub find: String,
    /// Text that replaces it.
    pub replace: String,
}

impl Mutant {
    /// Paths of the changed files, separated by spaces.
    pub fn files(&self) -> String {
        let files: BTreeSet<_> = self.edit.iter().map(|edit| edit.file.as_str()).collect();
        files.into_iter().collect::<Vec<_>>().join(" ")
    }

    /// Package whose tests should notice the mistake.
    pub fn package(&self) -> &'static str {
        if self.edit.iter().all(|edit| edit.file.starts_with("core/")) { "palpate" } else { "palpate-controller" }
    }
}

impl Edit {
    /// Returns the file's content with the mistake applied.
    pub fn apply(&self, content: &str) -> Result<String, String> {
        match content.matches(&self.find).count() {
            1 => Ok(content.replacen(&self.find, &self.replace, 1)),
            count => Err(format!("{} has {count} times, not once: {}", self.file, self.find)),
        }
    }
}

/// Reads the list.
pub fn read(root: &Path) -> Result<Vec<Mutant>, String> {
    let text = fs::read_to_string(root.join(LIST)).map_err(|error| format!("{LIST}: {error}"))?;
    let list: List = toml::from_str(&text).map_err(|error| format!("{LIST}: {error}"))?;
    let mut names = BTreeSet::new();
    match list.mutant.iter().find(|mutant| !names.insert(mutant.name.clone())) {
        Some(mutant) => Err(format!("{LIST}: two mistakes are named {}", mutant.name)),
        None => Ok(list.mutant),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_mistake_still_applies_to_the_source_exactly_once() {
        let root = crate::repository();
        let mutants = read(&root).unwrap();
        let mut rotten = Vec::new();
        for mutant in &mutants {
            for edit in &mutant.edit {
                let content = fs::read_to_string(root.join(&edit.file)).unwrap_or_default();
                let applied = edit.apply(&content);
                rotten.extend(applied.as_ref().err().map(|error| format!("{}: {error}", mutant.name)));
                rotten.extend(applied.ok().filter(|to| *to == content).map(|_| format!("{}: changes nothing", mutant.name)));
            }
        }
        assert!(mutants.len() >= 80 && rotten.is_empty(), "{} mistakes\n{}", mutants.len(), rotten.join("\n"));
    }

    #[test]
    fn a_text_that_is_missing_or_stands_twice_is_refused() {
        let edit = Edit { file: "a.rs".into(), find: "x > 0".into(), replace: "x >= 0".into() };
        assert_eq!(edit.apply("if x > 0 {}").unwrap(), "if x >= 0 {}");
        assert!(edit.apply("if x > 1 {}").is_err() && edit.apply("x > 0 && x > 0").is_err());
    }
}
