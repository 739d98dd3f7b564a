//! Bytes of a mesh file, and its name in messages.

use std::path::Path;
use std::{fs, io};

use super::error::{Defect, MeshError, printable};

/// Largest number of bytes that is read from a file [MiB]. 65 535 nodes and their tets take some 30
/// MB as text; the rest leaves room for results that were saved with the mesh.
pub(super) const MAX_FILE_MIB: u64 = 512;

/// Reads a file, which must not be empty. Bytes that are not text where text is expected appear as
/// replacement characters: harmless in a title, an error in a number.
pub(super) fn content(path: &Path) -> Result<Vec<u8>, MeshError> {
    let unreadable = |error: io::Error| whole_file(path, Defect::Read(error));
    let metadata = fs::metadata(path).map_err(unreadable)?;
    // A pipe or a device may never end.
    if !metadata.is_file() {
        return Err(whole_file(path, Defect::NotAFile));
    }
    if metadata.len() > MAX_FILE_MIB << 20 {
        let limit_mib = MAX_FILE_MIB;
        return Err(whole_file(path, Defect::FileTooLarge { limit_mib }));
    }
    let bytes = fs::read(path).map_err(unreadable)?;
    if bytes.trim_ascii().is_empty() {
        return Err(whole_file(path, Defect::Empty));
    }
    Ok(bytes)
}

pub(super) fn name(path: &Path) -> String {
    printable(&path.display().to_string())
}

pub(super) fn whole_file(path: &Path, defect: Defect) -> MeshError {
    MeshError { file: name(path), line: None, defect }
}
