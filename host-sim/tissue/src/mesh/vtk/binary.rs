//! Legacy binary VTK: keywords are lines of text, and the numbers that belong to a keyword follow
//! its line, each with the highest byte first.

use super::cells::Cells;
use super::{Sections, data_set_is_known, version_is_known};
use crate::mesh::bytes::{Bytes, Number, Order};
use crate::mesh::error::{Defect, MeshError};
use crate::mesh::raw::{RawMesh, RawNode};

/// Reads a binary `.vtk` file.
pub(super) fn read(file: &str, data: &[u8]) -> Result<RawMesh, MeshError> {
    let mut bytes = Bytes::new(file, data, Order::Big);
    let version = bytes.required("the VTK version")?;
    version_is_known(&version).map_err(|defect| bytes.error(defect))?;
    // The title may be blank.
    bytes.any_line();
    bytes.required("the word BINARY")?;
    let mut mesh = RawMesh::new("legacy VTK", file);
    let mut sections = Sections::default();
    let mut has_data_set = false;
    while let Some(line) = bytes.line() {
        let mut words = line.split_whitespace();
        let keyword = words.next().unwrap_or_default().to_ascii_uppercase();
        let mut whole = |what: &'static str| {
            let word = words.next().ok_or_else(|| bytes.error(Defect::Missing { what }))?;
            word.parse::<u64>().map_err(|_| bytes.unexpected(what, word))
        };
        let repeated = |section| Err(bytes.error(Defect::RepeatedSection { section }));
        if !has_data_set && keyword != "DATASET" && keyword != "FIELD" {
            return Err(bytes.unexpected("DATASET", &line));
        }
        let (cells, name) = match keyword.as_str() {
            "DATASET" => {
                data_set_is_known(words.next().unwrap_or_default()).map_err(|defect| bytes.error(defect))?;
                has_data_set = true;
                continue;
            }
            "POINTS" if sections.has_points => return repeated("POINTS"),
            "POINTS" => {
                let count = whole("the number of points")?;
                let name = words.next().unwrap_or_default();
                let kind = Number::of_vtk(name).ok_or_else(|| bytes.unexpected("the type float or double", name))?;
                for number in 0..count {
                    let position = [bytes.any_coordinate(kind)?, bytes.any_coordinate(kind)?, bytes.any_coordinate(kind)?];
                    mesh.nodes.push(RawNode { number, line: None, position });
                }
                sections.has_points = true;
                continue;
            }
            "CELL_TYPES" if sections.types.is_some() => return repeated("CELL_TYPES"),
            "CELL_TYPES" => {
                let mut types = Vec::new();
                for _ in 0..whole("the number of cell types")? {
                    types.push((bytes.whole_i32("a cell type")?, None));
                }
                sections.types = Some(types);
                continue;
            }
            "CELL_DATA" | "POINT_DATA" => break,
            // The section ends at a blank line.
            "METADATA" => {
                while !bytes.any_line().is_empty() {}
                continue;
            }
            "FIELD" => {
                words.next();
                for _ in 0..whole_of(&bytes, words.next())? {
                    skip_array(&mut bytes)?;
                }
                continue;
            }
            "CELLS" => (Some(&mut sections.cells), "CELLS"),
            "POLYGONS" => (Some(&mut sections.polygons), "POLYGONS"),
            "TRIANGLE_STRIPS" => (Some(&mut sections.strips), "TRIANGLE_STRIPS"),
            "VERTICES" | "LINES" => (None, "LINES"),
            _ => return Err(bytes.unexpected("the next section (the counts before it are too low)", &line)),
        };
        if cells.as_ref().is_some_and(|cells| cells.is_some()) {
            return repeated(name);
        }
        let (count, size) = (whole("the number of cells")?, whole("the size of the cell list")?);
        let read = if bytes.starts_with("OFFSETS") { with_offsets } else { with_counts };
        let found = read(&mut bytes, count, size)?;
        if let Some(cells) = cells {
            *cells = Some(found);
        }
    }
    sections.finish(&mut mesh, None)?;
    Ok(mesh)
}

fn whole_of(bytes: &Bytes, word: Option<&str>) -> Result<u64, MeshError> {
    let word = word.unwrap_or_default();
    word.parse().map_err(|_| bytes.unexpected("a count", word))
}

/// Skips an array of a FIELD: `name components tuples type`, then its numbers.
fn skip_array(bytes: &mut Bytes) -> Result<(), MeshError> {
    let mut line = bytes.required("an array of the FIELD")?;
    // an array may be followed by what describes it, up to a blank line
    while line.eq_ignore_ascii_case("METADATA") {
        while !bytes.any_line().is_empty() {}
        line = bytes.required("an array of the FIELD")?;
    }
    let mut words = line.split_whitespace().skip(1);
    let (components, tuples) = (whole_of(bytes, words.next())?, whole_of(bytes, words.next())?);
    let values = components.saturating_mul(tuples);
    let name = words.next().unwrap_or_default();
    let what = "the end of a FIELD";
    match (name.to_ascii_lowercase().as_str(), Number::of_vtk(name)) {
        ("bit", _) => bytes.skip(values.div_ceil(8), 1, what),
        ("string" | "utf8_string", _) => (0..values).try_for_each(|_| skip_text(bytes)),
        (_, Some(number)) => bytes.skip(values, number.size(), what),
        (_, None) => Err(bytes.unexpected("a type of number", name)),
    }
}

/// Skips a text: the top two bits of its first byte say in how many bytes its length is written.
fn skip_text(bytes: &mut Bytes) -> Result<(), MeshError> {
    let what = "the length of a text";
    let first = bytes.take(1, what)?[0];
    let more = match first >> 6 {
        3 => 0,
        2 => 1,
        1 => 3,
        _ => 7,
    };
    let start = u64::from(first & 0x3f);
    let length = bytes.take(more, what)?.iter().fold(start, |length, byte| length << 8 | u64::from(*byte));
    bytes.skip(length, 1, "the end of a text")
}

/// Reads cells up to version 4: `count` times `i32 nodes, i32 node...`, `size` numbers in all.
fn with_counts(bytes: &mut Bytes, count: u64, size: u64) -> Result<Cells, MeshError> {
    let mut cells = Cells::default();
    for _ in 0..count {
        let mut nodes = Vec::new();
        for _ in 0..bytes.whole_i32("the number of nodes of a cell")? {
            nodes.push(bytes.whole_i32("a point number")?);
        }
        cells.push(None, &nodes);
    }
    cells.has_size(size).map_err(|defect| bytes.error(defect))?;
    Ok(cells)
}

/// Reads cells from version 5.1 on: `count` offsets, of which the last is the end, then `size`
/// nodes.
fn with_offsets(bytes: &mut Bytes, count: u64, size: u64) -> Result<Cells, MeshError> {
    let offsets = list(bytes, "OFFSETS", count)?;
    let nodes = list(bytes, "CONNECTIVITY", size)?;
    if offsets.is_empty() {
        return Ok(Cells::default());
    }
    let Some((0, ends)) = offsets.split_first().map(|(first, ends)| (*first, ends)) else {
        return Err(bytes.unexpected("the first offset 0", "another"));
    };
    Cells::of_lists(nodes, ends).map_err(|defect| bytes.error(defect))
}

/// Reads a line `keyword type`, then the numbers.
fn list(bytes: &mut Bytes, keyword: &'static str, count: u64) -> Result<Vec<u64>, MeshError> {
    let line = bytes.required(keyword)?;
    let mut words = line.split_whitespace();
    if !words.next().is_some_and(|word| word.eq_ignore_ascii_case(keyword)) {
        return Err(bytes.unexpected(keyword, &line));
    }
    let name = words.next().unwrap_or_default();
    let kind = Number::of_vtk(name).filter(|kind| !matches!(kind, Number::Real(_)));
    let kind = kind.ok_or_else(|| bytes.unexpected("the type vtktypeint64", name))?;
    (0..count).map(|_| bytes.any_whole(kind, keyword)).collect()
}
