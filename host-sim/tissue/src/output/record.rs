//! Record in an output folder that tells which of its files palpate wrote.

use std::collections::BTreeSet;
use std::io;
use std::path::Path;

/// File name of the record.
pub(super) const RECORD: &str = ".palpate";
const HEAD: &str = "files that palpate wrote; the next run into this folder replaces them; run ";

/// Names of the files that palpate wrote, and the number of runs that have written here.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Record {
    /// Rises with every result, and so distinguishes a result from the one that it replaces.
    pub(super) run: u64,
    pub(super) names: BTreeSet<String>,
}

impl Record {
    /// Reads the record of a folder; `None` if the folder has no result.
    pub(super) fn read(folder: &Path) -> Option<Self> {
        let text = std::fs::read_to_string(folder.join(RECORD)).ok()?;
        let (head, names) = text.split_once('\n')?;
        Some(Self { run: head.strip_prefix(HEAD)?.parse().ok()?, names: names.lines().map(str::to_owned).collect() })
    }

    /// Writes the record, completely or not at all.
    pub(super) fn write(&self, folder: &Path) -> io::Result<()> {
        let mut text = format!("{HEAD}{}\n", self.run);
        for name in &self.names {
            text.push_str(name);
            text.push('\n');
        }
        let part = folder.join(format!("{RECORD}.part"));
        std::fs::write(&part, text)?;
        std::fs::rename(part, folder.join(RECORD))
    }
}
