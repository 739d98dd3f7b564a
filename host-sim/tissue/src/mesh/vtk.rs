//! Legacy ASCII VTK, `DATASET UNSTRUCTURED_GRID`, free in its line breaks after the header.
//!
//! Cells come as `count nodes...` up to file version 4, as `OFFSETS` and `CONNECTIVITY` from 5.1.
//! Points and cells count from 0. Attributes after the cells are not read.

mod cells;
mod words;

use super::error::{Defect, MeshError, quoted};
use super::lines::{Line, Lines};
use super::raw::{RawMesh, RawNode};
use super::word::Word;
use cells::Cells;
use words::Words;

/// Reads a `.vtk` file.
pub(super) fn read(file: &str, text: &str) -> Result<RawMesh, MeshError> {
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
            // CELL_DATA or POINT_DATA.
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

/// `# vtk DataFile Version x.x`, a title, `ASCII`.
fn header(lines: &mut Lines) -> Result<(), MeshError> {
    let first = lines.required("the VTK version")?;
    let version = first.text.split_whitespace().last().unwrap_or("");
    let major = version.split('.').next().unwrap_or("");
    if !["1", "2", "3", "4", "5"].contains(&major) {
        return Err(first.at.error(Defect::Version {
            format: "legacy VTK",
            found: quoted(version),
            supported: "version 2.0 to 5.1",
        }));
    }
    // The title may be blank.
    lines.any_line();
    let mut line = lines.required("the word ASCII")?;
    let encoding = line.word("the word ASCII")?;
    match encoding.text.to_ascii_uppercase().as_str() {
        "ASCII" => line.finish(),
        "BINARY" => Err(line.at.error(Defect::Binary { format: "legacy VTK" })),
        _ => Err(encoding.unexpected("the word ASCII")),
    }
}

fn data_set(words: &mut Words) -> Result<(), MeshError> {
    let keyword = words.required("DATASET")?;
    if !keyword.text.eq_ignore_ascii_case("DATASET") {
        return Err(keyword.unexpected("DATASET"));
    }
    let kind = words.required("the kind of data set")?;
    if kind.text.eq_ignore_ascii_case("UNSTRUCTURED_GRID") {
        return Ok(());
    }
    Err(kind.at.error(Defect::DataSet { found: quoted(kind.text) }))
}

/// `POINTS n float|double`, then 3 n coordinates.
fn points(words: &mut Words, mesh: &mut RawMesh) -> Result<(), MeshError> {
    let count = words.whole("the number of points")?;
    let number_type = words.required("the type float or double")?;
    if !["float", "double"].contains(&number_type.text.to_ascii_lowercase().as_str()) {
        return Err(number_type.unexpected("the type float or double"));
    }
    for number in 0..count {
        let first = words.value("POINTS", "points", count, number)?;
        mesh.nodes.push(RawNode {
            number,
            line: first.at.line,
            position: [
                first.coordinate()?,
                words.value("POINTS", "points", count, number)?.coordinate()?,
                words.value("POINTS", "points", count, number)?.coordinate()?,
            ],
        });
    }
    Ok(())
}
