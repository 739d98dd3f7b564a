//! A mesh as it is in its file: in file units, with the file's own numbers, and not checked yet.

use std::collections::BTreeMap;

/// Nodes and tets with the numbers that they have in their file.
pub(super) struct RawMesh {
    pub format: &'static str,
    /// Name of the file, for messages.
    pub file: String,
    pub nodes: Vec<RawNode>,
    pub tets: Vec<RawTet>,
    /// Number of elements that are not tets, by kind.
    pub ignored: BTreeMap<&'static str, usize>,
}

pub(super) struct RawNode {
    pub number: u64,
    /// Line in the file, counted from 1; `None` in a binary file.
    pub line: Option<usize>,
    /// Position in file units.
    pub position: [f64; 3],
}

pub(super) struct RawTet {
    pub number: u64,
    /// Line in the file, counted from 1; `None` in a binary file.
    pub line: Option<usize>,
    /// Numbers of its four nodes.
    pub nodes: [u64; 4],
    pub region: u32,
}

impl RawMesh {
    pub fn new(format: &'static str, file: &str) -> Self {
        Self { format, file: file.to_owned(), nodes: Vec::new(), tets: Vec::new(), ignored: BTreeMap::new() }
    }

    pub fn ignore(&mut self, kind: &'static str) {
        *self.ignored.entry(kind).or_default() += 1;
    }
}
