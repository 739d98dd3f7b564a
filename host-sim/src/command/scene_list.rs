//! The scenes of a folder as the numbered cases of a campaign.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::campaign::fingerprint;
use crate::error::Error;
use palpate_tissue::Error as TissueError;

/// Entry in place of the checksum of a file that cannot be read: only its own scene fails.
const UNREADABLE: &str = "unreadable";

/// Every scene file (.toml) of a folder, by name, with its checksum.
#[derive(Clone, Debug)]
pub(super) struct SceneList {
    folder: PathBuf,
    checksums: BTreeMap<String, String>,
}

impl SceneList {
    /// Reads a folder.
    pub(super) fn of(folder: &Path) -> Result<Self, Error> {
        let refuse = |source| TissueError::Read { path: folder.to_owned(), source };
        let mut checksums = BTreeMap::new();
        for entry in std::fs::read_dir(folder).map_err(refuse)? {
            let path = entry.map_err(refuse)?.path();
            if let (Some("toml"), Some(name), false) =
                (path.extension().and_then(|e| e.to_str()), path.file_stem().and_then(|s| s.to_str()), path.is_dir())
            {
                let checksum = fingerprint::scene(&path.display().to_string()).unwrap_or_else(|_| Some(UNREADABLE.to_owned()));
                let checksum = checksum.unwrap_or_default();
                checksums.insert(name.to_owned(), checksum);
            }
        }
        if checksums.is_empty() {
            let why = format!("--scenes {}: it holds no scene file (.toml): give a folder of scenes", folder.display());
            return Err(TissueError::Usage(why).into());
        }
        Ok(Self { folder: folder.to_owned(), checksums })
    }

    pub(super) fn checksums(&self) -> &BTreeMap<String, String> {
        &self.checksums
    }

    pub(super) fn len(&self) -> u64 {
        self.checksums.len() as u64
    }

    /// Names and files of the scenes with these numbers.
    pub(super) fn files(&self, cases: Range<u64>) -> impl Iterator<Item = (&str, String)> {
        let (first, count) = (cases.start as usize, (cases.end - cases.start) as usize);
        let file = |name: &str| self.folder.join(format!("{name}.toml")).display().to_string();
        self.checksums.keys().skip(first).take(count).map(move |name| (name.as_str(), file(name)))
    }
}

/// Outcome of the work on a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Ended {
    /// The patch is within the tolerance.
    Kept,
    /// The patch is beyond the tolerance.
    Missed,
    /// The scene has no result.
    Failed,
}

impl Ended {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Kept => "kept",
            Self::Missed => "missed",
            Self::Failed => "failed",
        }
    }
}

/// Says in one line of the row why a scene missed or failed. The scene's file and those beside it
/// are named without the folder, which may be in another place on another machine.
pub(super) fn why(error: &Error, name: &str, file: &str) -> String {
    let why = match error {
        Error::Tissue(TissueError::Check(why)) => why.clone(),
        other => other.to_string(),
    };
    named_as(&why, name, file)
}

/// Removes the folder from the names of the scene's file, and of those that it names, in a line of
/// a row.
pub(super) fn named_as(why: &str, name: &str, file: &str) -> String {
    let own = format!("{name}.toml");
    let Some(folder) = file.strip_suffix(&own).filter(|folder| !folder.is_empty()) else { return why.to_owned() };
    // only where a path begins, since the name of the folder may end another path
    let mut said = String::new();
    let mut rest = why;
    while let Some(at) = rest.find(folder) {
        let (before, found) = rest.split_at(at);
        said += before;
        let inside = said.chars().next_back().is_some_and(|c| c.is_alphanumeric() || "/\\._-".contains(c));
        if inside {
            said += folder;
        }
        rest = &found[folder.len()..];
    }
    said + rest
}

/// Whether all later cases would fail as well, because the error is one of the disk and not of the
/// scene.
pub(super) fn ends_all(error: &Error) -> bool {
    matches!(error, Error::Tissue(TissueError::Write { .. } | TissueError::InUse { .. }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_named_as_they_are_in_the_folder() {
        let said = |why: &str, folder: &str| named_as(why, "a", &format!("{folder}a.toml"));
        assert_eq!(said("s/a.toml:1: no mesh (s/gone.msh), of s/", "s/"), "a.toml:1: no mesh (gone.msh), of ");
        assert_eq!(said("see presets/a and /s/b, s/c", "s/"), "see presets/a and /s/b, c");
        assert_eq!(said("/far/s/gone.msh: /far/s/a.toml", "/far/s/"), "gone.msh: a.toml");
        assert_eq!(said("a.toml: too stiff", ""), "a.toml: too stiff");
    }
}
