//! VTK: legacy files with `DATASET UNSTRUCTURED_GRID`, as text (free in its line breaks after the
//! header) or binary, and `UnstructuredGrid` in XML.
//!
//! Legacy cells are written as `count nodes...` up to file version 4, and as `OFFSETS` and
//! `CONNECTIVITY` from 5.1 on. Points and cells are counted from 0. Attributes are not read.

mod arrays;
mod binary;
mod cells;
mod words;
pub(super) mod xml;

use super::error::{Defect, MeshError, quoted};
use super::lines::{Line, Lines};
use super::raw::{RawMesh, RawNode};
use super::word::Word;
use cells::Cells;
use words::Words;

/// Reads a `.vtk` file.
pub(super) fn read(file: &str, data: &[u8]) -> Result<RawMesh, MeshError> {
    let encoding = data.split(|byte| *byte == b'\n').nth(2).unwrap_or_default();
    if encoding.trim_ascii().eq_ignore_ascii_case(b"BINARY") {
        binary::read(file, data)
    } else {
        read_text(file, &String::from_utf8_lossy(data))
    }
}

fn read_text(file: &str, text: &str) -> Result<RawMesh, MeshError> {
    let mut lines = Lines::new(file, text);
    header(&mut lines)?;
    let mut words = Words::new(lines);
    data_set(&mut words)?;
    let mut mesh = RawMesh::new("legacy VTK", file);
    let mut cells = None;
    let mut has_types = false;
    while let Some(word) = words.next_section()? {
        match word.text.to_ascii_uppercase().as_str() {
            "POINTS" if !mesh.nodes.is_empty() => return Err(repeated(word, "POINTS")),
            "POINTS" => points(&mut words, &mut mesh)?,
            "CELLS" if cells.is_some() => return Err(repeated(word, "CELLS")),
            "CELLS" => cells = Some(Cells::read(&mut words)?),
            "CELL_TYPES" => {
                if has_types {
                    return Err(repeated(word, "CELL_TYPES"));
                }
                let Some(cells) = &cells else {
                    return Err(word.unexpected("CELLS before CELL_TYPES"));
                };
                cells.take_tets(&mut words, &mut mesh)?;
                has_types = true;
            }
            // This is CELL_DATA or POINT_DATA, which is not read.
            _ => break,
        }
    }
    for (found, section) in [(!mesh.nodes.is_empty(), "POINTS"), (cells.is_some(), "CELLS"), (has_types, "CELL_TYPES")] {
        if !found {
            return Err(words.at().error(Defect::MissingSection { section }));
        }
    }
    Ok(mesh)
}

fn repeated(word: Word, section: &'static str) -> MeshError {
    word.at.error(Defect::RepeatedSection { section })
}

/// Reads `# vtk DataFile Version x.x`, a title, and `ASCII`.
fn header(lines: &mut Lines) -> Result<(), MeshError> {
    let first = lines.required("the VTK version")?;
    version_is_known(first.text).map_err(|defect| first.at.error(defect))?;
    // The title may be blank.
    lines.any_line();
    let mut line = lines.required("the word ASCII or BINARY")?;
    let encoding = line.word("the word ASCII or BINARY")?;
    if encoding.text.eq_ignore_ascii_case("ASCII") { line.finish() } else { Err(encoding.unexpected("the word ASCII or BINARY")) }
}

/// Checks the version at the end of the first line of a legacy file.
fn version_is_known(line: &str) -> Result<(), Defect> {
    let version = line.split_whitespace().last().unwrap_or("");
    let major = version.split('.').next().unwrap_or("");
    if ["1", "2", "3", "4", "5"].contains(&major) {
        return Ok(());
    }
    Err(Defect::Version { format: "legacy VTK", found: quoted(version), supported: "version 2.0 to 5.1" })
}

fn data_set_is_known(kind: &str) -> Result<(), Defect> {
    if kind.eq_ignore_ascii_case("UNSTRUCTURED_GRID") { Ok(()) } else { Err(Defect::DataSet { found: quoted(kind) }) }
}

/// True for `double`, false for `float`, `None` for any other type.
fn number_is_double(name: &str) -> Option<bool> {
    match name.to_ascii_lowercase().as_str() {
        "double" => Some(true),
        "float" => Some(false),
        _ => None,
    }
}

fn data_set(words: &mut Words) -> Result<(), MeshError> {
    let keyword = words.required("DATASET")?;
    if !keyword.text.eq_ignore_ascii_case("DATASET") {
        return Err(keyword.unexpected("DATASET"));
    }
    let kind = words.required("the kind of data set")?;
    data_set_is_known(kind.text).map_err(|defect| kind.at.error(defect))
}

/// Reads `POINTS n float|double`, then 3 n coordinates.
fn points(words: &mut Words, mesh: &mut RawMesh) -> Result<(), MeshError> {
    let count = words.whole("the number of points")?;
    let number_type = words.required("the type float or double")?;
    if number_is_double(number_type.text).is_none() {
        return Err(number_type.unexpected("the type float or double"));
    }
    for number in 0..count {
        let first = words.value("POINTS", "points", count, number)?;
        mesh.nodes.push(RawNode {
            number,
            line: Some(first.at.line),
            position: [
                first.coordinate()?,
                words.value("POINTS", "points", count, number)?.coordinate()?,
                words.value("POINTS", "points", count, number)?.coordinate()?,
            ],
        });
    }
    Ok(())
}
