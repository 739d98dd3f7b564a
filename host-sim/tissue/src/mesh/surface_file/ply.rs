//! PLY: a header in text that names elements and their properties, then their values as text or
//! binary. The vertices, faces and strips of triangles are read, all else is skipped.

use super::RawSurface;
use crate::mesh::bytes::{Bytes, Number, Order};
use crate::mesh::error::{Defect, MeshError};
use crate::mesh::lines::{Line, Lines};

struct Element<'a> {
    name: &'a str,
    count: u64,
    properties: Vec<Property<'a>>,
}

struct Property<'a> {
    name: &'a str,
    /// Type of the number before the values of a list.
    length: Option<Number>,
    kind: Number,
}

pub(super) fn starts(data: &[u8]) -> bool {
    data.starts_with(b"ply") && data.get(3).is_some_and(u8::is_ascii_whitespace)
}

pub(super) fn read(file: &str, data: &[u8]) -> Result<RawSurface, MeshError> {
    const END: &[u8] = b"end_header";
    let end = data.windows(END.len()).position(|window| window == END);
    let (head, rest) = data.split_at(end.map_or(data.len(), |at| at + END.len()));
    let head = String::from_utf8_lossy(head);
    let mut lines = Lines::new(file, &head);
    let (order, elements) = header(&mut lines)?;
    if end.is_none() {
        return Err(lines.at().error(Defect::Truncated { what: "end_header" }));
    }
    let body = rest.strip_prefix(b"\r\n").or_else(|| rest.strip_prefix(b"\n")).or_else(|| rest.strip_prefix(b"\r"));
    let body = body.unwrap_or(rest);
    match order {
        Some(order) => {
            let mut bytes = Bytes::new(file, body, order);
            values("binary PLY", &elements, &mut |number, what| bytes.any(number, what))
                .and_then(|surface| surface.map_err(|defect| MeshError { file: file.to_owned(), line: None, defect }))
        }
        None => {
            let text = String::from_utf8_lossy(body);
            let mut lines = Lines::following(file, &text, lines.at().line);
            let mut line: Option<Line> = None;
            let mut next = |_, what| loop {
                if let Some(word) = line.as_mut().and_then(Line::next) {
                    let value = word.text.parse::<f64>();
                    return value.map_err(|_| word.unexpected(what));
                }
                line = Some(lines.required(what)?);
            };
            let surface = values("PLY", &elements, &mut next)?;
            surface.map_err(|defect| lines.at().error(defect))
        }
    }
}

/// Reads the header; the order of bytes is `None` for text.
fn header<'a>(lines: &mut Lines<'a>) -> Result<(Option<Order>, Vec<Element<'a>>), MeshError> {
    let mut order = None;
    let mut elements: Vec<Element> = Vec::new();
    for mut line in lines.by_ref() {
        let keyword = line.word("a PLY keyword")?;
        match keyword.text {
            "ply" | "comment" | "obj_info" => {}
            "format" => {
                let name = line.word("the PLY format")?;
                order = match name.text {
                    "ascii" => None,
                    "binary_little_endian" => Some(Order::Little),
                    "binary_big_endian" => Some(Order::Big),
                    _ => return Err(name.unexpected("ascii, binary_little_endian or binary_big_endian")),
                };
            }
            "element" => {
                let name = line.word("the name of an element")?.text;
                elements.push(Element { name, count: line.whole("the number of elements")?, properties: Vec::new() });
            }
            "property" => {
                let number = |line: &mut Line<'a>| {
                    let word = line.word("a type of number")?;
                    Number::of_ply(word.text).ok_or_else(|| word.unexpected("a type of number"))
                };
                let mut rest = line;
                let is_list = rest.text.split_whitespace().nth(1) == Some("list");
                let length = if is_list {
                    rest.word("list")?;
                    Some(number(&mut rest)?)
                } else {
                    None
                };
                let kind = number(&mut rest)?;
                let name = rest.word("the name of a property")?.text;
                let element = elements.last_mut().ok_or_else(|| keyword.unexpected("element before a property"))?;
                element.properties.push(Property { name, length, kind });
            }
            "end_header" => break,
            _ => return Err(keyword.unexpected("a PLY keyword")),
        }
    }
    Ok((order, elements))
}

type Next<'a> = dyn FnMut(Number, &'static str) -> Result<f64, MeshError> + 'a;

/// Reads the values of all elements; the inner error belongs to no line.
fn values(format: &'static str, elements: &[Element], next: &mut Next) -> Result<Result<RawSurface, Defect>, MeshError> {
    let mut vertices = Vec::new();
    let mut faces: Vec<i64> = Vec::new();
    let mut ends: Vec<(usize, bool)> = Vec::new();
    for element in elements {
        if element.properties.is_empty() && element.count > 0 {
            return Ok(Err(Defect::Expected { what: "properties of an element", found: element.name.to_owned() }));
        }
        for _ in 0..element.count {
            let mut position = [f64::NAN; 3];
            for property in &element.properties {
                let Some(length) = property.length else {
                    let value = next(property.kind, "a value of an element")?;
                    if let (true, Some(axis)) =
                        (element.name == "vertex", ["x", "y", "z"].iter().position(|n| *n == property.name))
                    {
                        position[axis] = value;
                    }
                    continue;
                };
                let count = next(length, "the length of a list")?;
                if !(count.fract() == 0.0 && (0.0..1e9).contains(&count)) {
                    return Ok(Err(Defect::Expected { what: "the length of a list", found: count.to_string() }));
                }
                let is_strip = element.name == "tristrips";
                let is_face = (element.name == "face" || is_strip) && ["vertex_indices", "vertex_index"].contains(&property.name);
                for _ in 0..count as u64 {
                    let value = next(property.kind, "a vertex of a face")?;
                    if is_face {
                        faces.push(value as i64);
                    }
                }
                if is_face {
                    ends.push((faces.len(), is_strip));
                }
            }
            if element.name == "vertex" {
                if let Some(value) = position.iter().find(|value| !value.is_finite()) {
                    return Ok(Err(Defect::NotFinite { what: "a coordinate", found: value.to_string() }));
                }
                vertices.push(position);
            }
        }
    }
    let mut surface = RawSurface::new(format, vertices);
    let known = surface.vertices.len() as i64;
    let mut first = 0;
    for (end, is_strip) in ends {
        // -1 ends a strip and begins another
        for part in faces[first..end].split(|index| is_strip && *index == -1) {
            if let Some(index) = part.iter().find(|index| !(0..known).contains(*index)) {
                return Ok(Err(Defect::Expected { what: "the number of a vertex of the file", found: index.to_string() }));
            }
            let corners: Vec<u32> = part.iter().map(|index| *index as u32).collect();
            if is_strip { surface.push_strip(&corners) } else { surface.push_polygon(&corners) }
        }
        first = end;
    }
    Ok(Ok(surface))
}
