//! Mesh import: every format, every defect, and damaged files.

pub mod block;
pub mod damage;
mod defects;
pub mod encode;
mod formats;
mod round_trip;
mod size;
mod surface;
mod syntax;
pub mod write;

use std::fs;
use std::path::Path;

use palpate_tissue::mesh::MeshError;
use palpate_tissue::mesh::import::{Imported, import};

/// Imports a file `name` with this content from a folder of its own; the unit of the file is a
/// metre.
fn import_bytes(name: &str, content: &[u8]) -> Result<Imported, MeshError> {
    let dir = tempfile::tempdir().expect("temporary directory");
    let path = dir.path().join(name);
    fs::write(&path, content).expect("writable temporary directory");
    import(&path, 1.0)
}

fn import_text(name: &str, text: &str) -> Result<Imported, MeshError> {
    import_bytes(name, text.as_bytes())
}

/// Error message without the folder of the file.
fn message(result: Result<Imported, MeshError>) -> String {
    match result {
        Ok(imported) => panic!("imported: {:?}", imported.report),
        Err(error) => {
            let mut error = error;
            let name = Path::new(&error.file).file_name().expect("a file name");
            error.file = name.to_string_lossy().into_owned();
            error.to_string()
        }
    }
}
