//! Legacy binary VTK: keywords are lines of text, and the numbers that belong to a keyword follow
//! its line, each with the highest byte first.

use super::cells::Cells;
use super::{data_set_is_known, number_is_double, version_is_known};
use crate::mesh::bytes::{Bytes, Order};
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
    let line = bytes.required("DATASET")?;
    match line.split_whitespace().collect::<Vec<_>>()[..] {
        [keyword, kind] if keyword.eq_ignore_ascii_case("DATASET") => data_set_is_known(kind),
        _ => return Err(bytes.unexpected("DATASET", &line)),
    }
    .map_err(|defect| bytes.error(defect))?;
    let mut mesh = RawMesh::new("legacy VTK", file);
    let mut cells = None;
    let mut has_types = false;
    while let Some(line) = bytes.line() {
        let mut words = line.split_whitespace();
        let keyword = words.next().unwrap_or_default().to_ascii_uppercase();
        let mut whole = |what: &'static str| {
            let word = words.next().ok_or_else(|| bytes.error(Defect::Missing { what }))?;
            word.parse::<u64>().map_err(|_| bytes.unexpected(what, word))
        };
        let repeated = |section| Err(bytes.error(Defect::RepeatedSection { section }));
        match keyword.as_str() {
            "POINTS" if !mesh.nodes.is_empty() => return repeated("POINTS"),
            "POINTS" => {
                let count = whole("the number of points")?;
                let name = words.next().unwrap_or_default();
                let double = number_is_double(name).ok_or_else(|| bytes.unexpected("the type float or double", name))?;
                for number in 0..count {
                    mesh.nodes.push(RawNode { number, line: None, position: bytes.position(double)? });
                }
            }
            "CELLS" if cells.is_some() => return repeated("CELLS"),
            "CELLS" => {
                let (count, size) = (whole("the number of cells")?, whole("the size of the cell list")?);
                let read = if bytes.starts_with("OFFSETS") { with_offsets } else { with_counts };
                cells = Some(read(&mut bytes, count, size)?);
            }
            "CELL_TYPES" if has_types => return repeated("CELL_TYPES"),
            "CELL_TYPES" => {
                let count = whole("the number of cell types")?;
                let Some(cells) = &cells else { return Err(bytes.unexpected("CELLS before CELL_TYPES", &line)) };
                cells.as_many_types(count).map_err(|defect| bytes.error(defect))?;
                for number in 0..count {
                    let code = bytes.whole_i32("a cell type")?;
                    cells.take(number, code, &mut mesh).map_err(|defect| bytes.error(defect))?;
                }
                has_types = true;
            }
            "CELL_DATA" | "POINT_DATA" => break,
            // The section ends at a blank line.
            "METADATA" => while !bytes.any_line().is_empty() {},
            "FIELD" => {
                words.next();
                let arrays = whole_of(&bytes, words.next())?;
                for _ in 0..arrays {
                    skip_array(&mut bytes)?;
                }
            }
            _ => return Err(bytes.unexpected("the next section (the counts before it are too low)", &line)),
        }
    }
    for (found, section) in [(!mesh.nodes.is_empty(), "POINTS"), (cells.is_some(), "CELLS"), (has_types, "CELL_TYPES")] {
        if !found {
            return Err(bytes.error(Defect::MissingSection { section }));
        }
    }
    Ok(mesh)
}

fn whole_of(bytes: &Bytes, word: Option<&str>) -> Result<u64, MeshError> {
    let word = word.unwrap_or_default();
    word.parse().map_err(|_| bytes.unexpected("a count", word))
}

/// Skips an array of a FIELD: `name components tuples type`, then its numbers.
fn skip_array(bytes: &mut Bytes) -> Result<(), MeshError> {
    let line = bytes.required("an array of the FIELD")?;
    let mut words = line.split_whitespace().skip(1);
    let (components, tuples) = (whole_of(bytes, words.next())?, whole_of(bytes, words.next())?);
    let name = words.next().unwrap_or_default();
    let size = match name.to_ascii_lowercase().as_str() {
        "char" | "unsigned_char" => 1,
        "short" | "unsigned_short" => 2,
        "int" | "unsigned_int" | "float" | "vtkidtype" => 4,
        "long" | "unsigned_long" | "vtktypeint64" | "vtktypeuint64" | "double" => 8,
        _ => return Err(bytes.unexpected("a type of number", name)),
    };
    bytes.skip(components.saturating_mul(tuples), size, "the end of a FIELD")
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
    let Some((0, ends)) = offsets.split_first().map(|(first, ends)| (*first, ends)) else {
        return Err(bytes.unexpected("the first offset 0", offsets.first().map_or("none", |_| "another")));
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
    let wide = match words.next().unwrap_or_default().to_ascii_lowercase().as_str() {
        "vtktypeint64" | "vtktypeuint64" => true,
        "vtktypeint32" | "vtktypeuint32" | "int" => false,
        other => return Err(bytes.unexpected("the type vtktypeint64", other)),
    };
    let mut numbers = Vec::new();
    for _ in 0..count {
        numbers.push(if wide { bytes.u64(keyword)? } else { bytes.whole_i32(keyword)? });
    }
    Ok(numbers)
}
