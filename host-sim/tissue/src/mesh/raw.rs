//! A mesh as its file says it: file units, the file's own numbers, nothing checked yet.

use std::collections::BTreeMap;

/// Nodes and tets under the numbers of their file.
pub(super) struct RawMesh {
    pub format: &'static str,
    /// File that holds the nodes.
    pub node_file: String,
    /// File that holds the tets; the same one except in `TetGen`.
    pub tet_file: String,
    pub nodes: Vec<RawNode>,
    pub tets: Vec<RawTet>,
    /// Elements that are not tets, by kind.
    pub ignored: BTreeMap<&'static str, usize>,
}

pub(super) struct RawNode {
    pub number: u64,
    pub line: usize,
    /// Position in file units.
    pub position: [f64; 3],
}

pub(super) struct RawTet {
    pub number: u64,
    pub line: usize,
    /// Node numbers.
    pub nodes: [u64; 4],
    pub region: u32,
}

impl RawMesh {
    pub fn new(format: &'static str, node_file: &str, tet_file: &str) -> Self {
        Self {
            format,
            node_file: node_file.to_owned(),
            tet_file: tet_file.to_owned(),
            nodes: Vec::new(),
            tets: Vec::new(),
            ignored: BTreeMap::new(),
        }
    }

    pub fn ignore(&mut self, kind: &'static str) {
        *self.ignored.entry(kind).or_default() += 1;
    }
}
