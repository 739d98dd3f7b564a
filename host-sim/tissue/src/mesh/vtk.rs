//! VTK: legacy files with `DATASET UNSTRUCTURED_GRID` or `POLYDATA`, as text (free in its line
//! breaks after the header) or binary, and the same in XML.
//!
//! Legacy cells are written as `count nodes...` up to file version 4, and as `OFFSETS` and
//! `CONNECTIVITY` from 5.1 on. Points and cells are counted from 0. Attributes are not read.

mod arrays;
mod binary;
mod cells;
mod kind;
mod words;
pub(super) mod xml;

use super::bytes::Number;
use super::error::{Defect, MeshError, quoted};
use super::lines::{Line, Lines};
use super::raw::{RawMesh, RawNode};
use super::word::Word;
use cells::Cells;
use words::Words;

/// Reads a `.vtk` file.
pub(super) fn read(file: &str, data: &[u8]) -> Result<RawMesh, MeshError> {
    // under the version and the title, each on a line of its own even if it is blank
    let mut lines = data.trim_ascii_start().split(|byte| *byte == b'\n').skip(2).map(<[u8]>::trim_ascii);
    let encoding = lines.find(|line| !line.is_empty()).unwrap_or_default();
    if encoding.eq_ignore_ascii_case(b"BINARY") {
        binary::read(file, data)
    } else {
        read_text(file, &String::from_utf8_lossy(data))
    }
}

/// The sections of a legacy file, as far as they have been read.
#[derive(Default)]
struct Sections {
    has_points: bool,
    cells: Option<Cells>,
    /// Type code of each cell, with its line.
    types: Option<Vec<(u64, Option<usize>)>>,
    polygons: Option<Cells>,
    strips: Option<Cells>,
}

impl Sections {
    /// Makes elements of the cells once all sections are read, since their order is free.
    fn finish(self, mesh: &mut RawMesh, last: Option<usize>) -> Result<(), MeshError> {
        let file = mesh.file.clone();
        let error = |line, defect| MeshError { file: file.clone(), line, defect };
        let missing = |section| Err(error(last, Defect::MissingSection { section }));
        if !self.has_points {
            return missing("POINTS");
        }
        let is_surface = self.polygons.is_some() || self.strips.is_some();
        let faces = [(self.polygons, false), (self.strips, true)];
        for (cells, strips) in faces.into_iter().filter_map(|(cells, strips)| Some((cells?, strips))) {
            cells.take_faces(&|own| own, strips, mesh).map_err(|defect| error(last, defect))?;
        }
        match (self.cells, self.types) {
            (None, None) if is_surface => Ok(()),
            (None, _) => missing("CELLS"),
            (Some(_), None) => missing("CELL_TYPES"),
            (Some(cells), Some(types)) => {
                cells.as_many_types(types.len() as u64).map_err(|defect| error(last, defect))?;
                for (number, (code, line)) in (0..).zip(types) {
                    cells.take(number, code, &|own| own, mesh).map_err(|defect| error(line, defect))?;
                }
                Ok(())
            }
        }
    }
}

fn read_text(file: &str, text: &str) -> Result<RawMesh, MeshError> {
    let mut lines = Lines::new(file, text);
    header(&mut lines)?;
    let mut words = Words::new(lines);
    data_set(&mut words)?;
    let mut mesh = RawMesh::new("legacy VTK", file);
    let mut sections = Sections::default();
    while let Some(word) = words.next_section()? {
        let keyword = word.text.to_ascii_uppercase();
        let cells = match keyword.as_str() {
            "POINTS" if sections.has_points => return Err(repeated(word, "POINTS")),
            "POINTS" => {
                points(&mut words, &mut mesh)?;
                sections.has_points = true;
                continue;
            }
            "CELL_TYPES" if sections.types.is_some() => return Err(repeated(word, "CELL_TYPES")),
            "CELL_TYPES" => {
                sections.types = Some(types(&mut words, sections.cells.as_ref())?);
                continue;
            }
            "CELLS" => (&mut sections.cells, "CELLS"),
            "POLYGONS" => (&mut sections.polygons, "POLYGONS"),
            "TRIANGLE_STRIPS" => (&mut sections.strips, "TRIANGLE_STRIPS"),
            "VERTICES" | "LINES" => {
                Cells::read(&mut words)?;
                continue;
            }
            // This is CELL_DATA or POINT_DATA, which is not read.
            _ => break,
        };
        if cells.0.is_some() {
            return Err(repeated(word, cells.1));
        }
        *cells.0 = Some(Cells::read(&mut words)?);
    }
    sections.finish(&mut mesh, Some(words.at().line))?;
    Ok(mesh)
}

fn repeated(word: Word, section: &'static str) -> MeshError {
    word.at.error(Defect::RepeatedSection { section })
}

/// Reads `CELL_TYPES n`, then one code for each cell.
fn types(words: &mut Words, cells: Option<&Cells>) -> Result<Vec<(u64, Option<usize>)>, MeshError> {
    let announced = words.whole("the number of cell types")?;
    if let Some(cells) = cells {
        cells.as_many_types(announced).map_err(|defect| words.at().error(defect))?;
    }
    let mut types = Vec::new();
    for number in 0..announced {
        let code = words.value("CELL_TYPES", "types", announced, number)?;
        types.push((code.whole("a cell type")?, Some(code.at.line)));
    }
    Ok(types)
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
    let known = ["UNSTRUCTURED_GRID", "POLYDATA"].iter().any(|known| kind.eq_ignore_ascii_case(known));
    if known { Ok(()) } else { Err(Defect::DataSet { found: quoted(kind) }) }
}

fn data_set(words: &mut Words) -> Result<(), MeshError> {
    let mut keyword = words.required("DATASET")?;
    // from version 4.2 on, the data of the whole file may precede it
    if keyword.text.eq_ignore_ascii_case("FIELD") {
        words.skip_field()?;
        keyword = words.required("DATASET")?;
    }
    if !keyword.text.eq_ignore_ascii_case("DATASET") {
        return Err(keyword.unexpected("DATASET"));
    }
    let kind = words.required("the kind of data set")?;
    data_set_is_known(kind.text).map_err(|defect| kind.at.error(defect))
}

/// Reads `POINTS n type`, then 3 n coordinates.
fn points(words: &mut Words, mesh: &mut RawMesh) -> Result<(), MeshError> {
    let count = words.whole("the number of points")?;
    let number_type = words.required("the type float or double")?;
    if Number::of_vtk(number_type.text).is_none() {
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
