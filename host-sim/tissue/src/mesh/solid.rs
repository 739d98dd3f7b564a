//! A mesh between reading and checking: it has indices and metres, and refers back to the file.

use super::TetMesh;
use super::error::{Defect, MeshError};

/// A mesh whose every tet names four different nodes that exist. Shape, orientation
/// and topology are still unchecked.
pub(super) struct Solid {
    pub mesh: TetMesh,
    /// Name of the file, for messages.
    pub file: String,
    /// Origin of each node in the file, shape `[nodes]`.
    pub node_origins: Vec<Origin>,
    /// Origin of each tet in the file, shape `[tets]`.
    pub tet_origins: Vec<Origin>,
    /// Number of nodes in the file that no tet names; they are left out of `mesh`.
    pub unused_nodes: usize,
    /// Number of tets in the file with the nodes of an earlier one; they are left out of `mesh`.
    pub copies: usize,
}

/// Origin of a node or a tet in the file.
#[derive(Clone, Copy)]
pub(super) struct Origin {
    /// Number of the node or tet in the file.
    pub number: u64,
    /// Line in the file, counted from 1; `None` in a binary file.
    pub line: Option<usize>,
}

impl Solid {
    pub fn node(&self, index: usize) -> Origin {
        self.node_origins[index]
    }

    pub fn tet(&self, index: usize) -> Origin {
        self.tet_origins[index]
    }

    pub fn error_at_node(&self, index: usize, defect: Defect) -> MeshError {
        MeshError { file: self.file.clone(), line: self.node(index).line, defect }
    }

    pub fn error_at_tet(&self, index: usize, defect: Defect) -> MeshError {
        MeshError { file: self.file.clone(), line: self.tet(index).line, defect }
    }

    pub fn error(&self, defect: Defect) -> MeshError {
        MeshError { file: self.file.clone(), line: None, defect }
    }
}
