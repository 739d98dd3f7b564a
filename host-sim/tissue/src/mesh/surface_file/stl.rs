//! STL: three corners for every triangle. Normals are not read: they follow from the order of the
//! corners.

use super::RawSurface;
use crate::mesh::bytes::{Bytes, Order};
use crate::mesh::error::{Defect, MeshError, quoted};
use crate::mesh::lines::Lines;

/// Number of bytes before the number of triangles.
const HEADER: usize = 80;
/// Number of bytes of a triangle.
const TRIANGLE: usize = 50;

/// Whether the file has the length of a binary file with the number of triangles that it announces.
pub(super) fn is_binary(data: &[u8]) -> bool {
    let count = data.get(HEADER..HEADER + 4).and_then(|bytes| bytes.try_into().ok()).map(u32::from_le_bytes);
    count.is_some_and(|count| count > 0 && data.len() as u64 == (HEADER + 4) as u64 + TRIANGLE as u64 * u64::from(count))
}

/// Reads a header of 80 bytes, the number of triangles, then for each triangle a normal, three
/// corners and two bytes more.
pub(super) fn read_binary(file: &str, data: &[u8]) -> Result<RawSurface, MeshError> {
    let mut bytes = Bytes::new(file, data, Order::Little);
    bytes.skip(1, HEADER, "the end of the STL header")?;
    let announced = bytes.whole_i32("the number of triangles")?;
    let mut surface = RawSurface { format: "binary STL", vertices: Vec::new(), triangles: Vec::new() };
    for found in 0..announced {
        let Ok(triangle) = bytes.take(TRIANGLE, "a triangle") else {
            let (section, items) = ("the STL file", "triangles");
            return Err(bytes.error(Defect::TooFew { section, items, announced, found }));
        };
        let mut corners = Bytes::new(file, &triangle[12..], Order::Little);
        surface.push([corners.position(false)?, corners.position(false)?, corners.position(false)?]);
    }
    Ok(surface)
}

/// Reads `facet normal ..`, `outer loop`, three times `vertex x y z`, `endloop`, `endfacet`,
/// between `solid` and `endsolid`.
pub(super) fn read_text(file: &str, text: &str) -> Result<RawSurface, MeshError> {
    let mut lines = Lines::new(file, text);
    let mut surface = RawSurface { format: "STL", vertices: Vec::new(), triangles: Vec::new() };
    let mut corners: Option<Vec<[f64; 3]>> = None;
    for mut line in lines.by_ref() {
        let at = line.at;
        let keyword = line.word("an STL keyword")?;
        match keyword.text.to_ascii_lowercase().as_str() {
            "solid" | "endsolid" | "facet" | "endfacet" => {}
            "outer" => corners = Some(Vec::new()),
            "vertex" => {
                let loop_so_far = corners.as_mut().ok_or_else(|| keyword.unexpected("outer loop before a vertex"))?;
                loop_so_far.push(line.position()?);
                line.finish()?;
            }
            "endloop" => match corners.take().and_then(|corners| corners.try_into().ok()) {
                Some(triangle) => surface.push(triangle),
                None => return Err(at.error(Defect::Expected { what: "three vertices in a loop", found: "endloop".into() })),
            },
            _ => return Err(at.error(Defect::Expected { what: "an STL keyword", found: quoted(keyword.text) })),
        }
    }
    match corners {
        None => Ok(surface),
        Some(_) => Err(lines.at().error(Defect::Truncated { what: "endloop" })),
    }
}

impl RawSurface {
    fn push(&mut self, corners: [[f64; 3]; 3]) {
        let first = self.vertices.len() as u32;
        self.vertices.extend(corners);
        self.triangles.push([first, first + 1, first + 2]);
    }
}
