//! STL: three corners for every triangle. Normals are not read: they follow from the order of the
//! corners.

use super::RawSurface;
use crate::mesh::bytes::{Bytes, Number, Order};
use crate::mesh::error::{Defect, MeshError, quoted};
use crate::mesh::lines::Lines;

/// Number of bytes before the number of triangles.
const HEADER: usize = 80;
/// Number of bytes of a triangle.
const TRIANGLE: usize = 50;

/// Whether the file has the length of a binary file with the number of triangles that it announces.
pub(super) fn is_exactly_binary(data: &[u8]) -> bool {
    count(data).is_some_and(|count| count > 0 && data.len() == HEADER + 4 + TRIANGLE * count)
}

/// Whether the file begins as text does. Many programs begin a binary file with `solid` as well;
/// but a number of triangles that fits into a file fills no four bytes, one that the program left
/// open is all ones, and no text has a byte of zeros or of ones.
pub(super) fn is_text(data: &[u8]) -> bool {
    let head = data.trim_ascii_start();
    let is_solid = head.get(..5).is_some_and(|start| start.eq_ignore_ascii_case(b"solid"));
    is_solid && !begins_binary(data)
}

/// Whether the file begins as a binary one does, whatever its length.
pub(super) fn is_binary_solid(data: &[u8]) -> bool {
    let head = data.get(..5).is_some_and(|start| start.eq_ignore_ascii_case(b"solid"));
    head && begins_binary(data)
}

fn begins_binary(data: &[u8]) -> bool {
    data.iter().take(HEADER + 4).any(|byte| matches!(byte, 0 | 0xff))
}

fn count(data: &[u8]) -> Option<usize> {
    let bytes = data.get(HEADER..HEADER + 4)?.try_into().ok()?;
    usize::try_from(u32::from_le_bytes(bytes)).ok()
}

/// Reads a header of 80 bytes, the number of triangles, then for each triangle a normal, three
/// corners and two bytes more. What follows the last triangle is not read.
pub(super) fn read_binary(file: &str, data: &[u8]) -> Result<RawSurface, MeshError> {
    let mut bytes = Bytes::new(file, data, Order::Little);
    bytes.skip(1, HEADER, "the end of the STL header")?;
    let announced = bytes.any_whole(Number::Unsigned(4), "the number of triangles")?;
    let mut surface = RawSurface::new("binary STL", Vec::new());
    for found in 0..announced {
        let Ok(triangle) = bytes.take(TRIANGLE, "a triangle") else {
            let (section, items) = ("the STL file", "triangles");
            return Err(bytes.error(Defect::TooFew { section, items, announced, found }));
        };
        let mut corners = Bytes::new(file, &triangle[12..], Order::Little);
        surface.push_loop(&[corners.position(false)?, corners.position(false)?, corners.position(false)?]);
    }
    Ok(surface)
}

/// Reads `facet normal ..`, `outer loop`, three times `vertex x y z`, `endloop`, `endfacet`,
/// between `solid` and `endsolid`, whatever the line breaks between them. `end` may stand apart.
pub(super) fn read_text(file: &str, text: &str) -> Result<RawSurface, MeshError> {
    let mut lines = Lines::new(file, text);
    let mut surface = RawSurface::new("STL", Vec::new());
    let mut corners: Option<Vec<[f64; 3]>> = None;
    let mut lone_end = false;
    'lines: for mut line in lines.by_ref() {
        while let Some(keyword) = line.next() {
            let lower = keyword.text.to_ascii_lowercase();
            let full = if lone_end { format!("end{lower}") } else { lower };
            lone_end = full == "end";
            match full.as_str() {
                // the rest of the line is a name
                "solid" | "endsolid" => continue 'lines,
                "end" | "facet" | "endfacet" | "loop" => {}
                "normal" => line.skip_words(3, "the normal")?,
                "color" | "#" => continue 'lines,
                "outer" => corners = Some(Vec::new()),
                "vertex" => {
                    let unexpected = || keyword.unexpected("outer loop before a vertex");
                    corners.as_mut().ok_or_else(unexpected)?.push(line.position()?);
                }
                "endloop" => match corners.take() {
                    Some(corners) if corners.len() >= 3 => surface.push_loop(&corners),
                    _ => {
                        let what = "three vertices in a loop";
                        return Err(keyword.at.error(Defect::Expected { what, found: "endloop".into() }));
                    }
                },
                _ => {
                    return Err(keyword.at.error(Defect::Expected { what: "an STL keyword", found: quoted(keyword.text) }));
                }
            }
        }
    }
    match corners {
        None => Ok(surface),
        Some(_) => Err(lines.at().error(Defect::Truncated { what: "endloop" })),
    }
}

impl RawSurface {
    fn push_loop(&mut self, corners: &[[f64; 3]]) {
        let first = self.vertices.len() as u32;
        self.vertices.extend(corners);
        let polygon: Vec<u32> = (first..self.vertices.len() as u32).collect();
        self.push_polygon(&polygon);
    }
}
