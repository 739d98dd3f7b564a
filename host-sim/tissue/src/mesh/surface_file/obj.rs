//! Wavefront OBJ: `v x y z`, and faces of three or more vertices. All other lines (normals,
//! textures, groups) are skipped. A line may go on after `\`, and end in a comment after `#`.

use super::RawSurface;
use crate::mesh::error::{Defect, MeshError};
use crate::mesh::lines::Lines;
use crate::mesh::word::Word;

/// First words of the lines of an OBJ file.
const KEYWORDS: [&[u8]; 9] = [b"v", b"vn", b"vt", b"f", b"o", b"g", b"s", b"mtllib", b"usemtl"];

/// Whether the first line that is not a comment is an OBJ line.
pub(super) fn starts(data: &[u8]) -> bool {
    let lines = data.split(|byte| matches!(byte, b'\n' | b'\r')).map(<[u8]>::trim_ascii);
    let first = lines.take(1000).find(|line| !line.is_empty() && !line.starts_with(b"#"));
    let mut words = first.unwrap_or_default().split(u8::is_ascii_whitespace);
    words.next().is_some_and(|word| KEYWORDS.contains(&word)) && words.next().is_some()
}

pub(super) fn read(file: &str, text: &str) -> Result<RawSurface, MeshError> {
    let mut lines = Lines::new(file, text);
    let mut vertices = Vec::new();
    // vertices of all faces, by their index if the file has them, and the end of each face
    let mut corners: Vec<(i64, Word)> = Vec::new();
    let mut ends = Vec::new();
    let mut words = Vec::new();
    while next_line(&mut lines, &mut words) {
        let [keyword, values @ ..] = words.as_slice() else { continue };
        let at = keyword.at;
        match keyword.text {
            "v" => {
                let mut position = [0.0; 3];
                for (k, what) in ["the x coordinate", "the y coordinate", "the z coordinate"].into_iter().enumerate() {
                    position[k] = values.get(k).ok_or_else(|| at.error(Defect::Missing { what }))?.coordinate()?;
                }
                vertices.push(position);
            }
            "f" | "fo" => {
                if values.len() < 3 {
                    let what = if values.is_empty() { "the face" } else { "three vertices of the face" };
                    return Err(at.error(Defect::Missing { what }));
                }
                for word in values {
                    corners.push((index(*word, vertices.len())?, *word));
                }
                ends.push(corners.len());
            }
            _ => {}
        }
    }
    let mut surface = RawSurface::new("OBJ", vertices);
    let known = surface.vertices.len() as i64;
    let mut face = Vec::new();
    let mut first = 0;
    for end in ends {
        face.clear();
        for (index, word) in &corners[first..end] {
            // a face may precede its vertices
            let exists = (0..known).contains(index);
            face.push(u32::try_from(*index).ok().filter(|_| exists).ok_or_else(|| word.unexpected(VERTEX))?);
        }
        surface.push_polygon(&face);
        first = end;
    }
    Ok(surface)
}

/// The words of the next line that has any, with those of the lines on which it goes on; false at
/// the end of the file.
fn next_line<'a>(lines: &mut Lines<'a>, words: &mut Vec<Word<'a>>) -> bool {
    words.clear();
    for line in lines.by_ref() {
        let mut goes_on = false;
        for word in line {
            if word.text.starts_with('#') {
                goes_on = false;
                break;
            }
            let text = word.text.strip_suffix('\\');
            goes_on = text.is_some();
            let text = text.unwrap_or(word.text);
            if !text.is_empty() {
                words.push(Word { text, ..word });
            }
        }
        if !goes_on && !words.is_empty() {
            break;
        }
    }
    !words.is_empty()
}

const VERTEX: &str = "the number of a vertex of the file";

/// Index of the vertex in `vertex[/texture[/normal]]`, counted from 1, or backward from the last
/// above this line with -1.
fn index(word: Word, vertices: usize) -> Result<i64, MeshError> {
    let number: i64 = word.text.split('/').next().unwrap_or("").parse().map_err(|_| word.unexpected(VERTEX))?;
    match number {
        0 => Err(word.unexpected(VERTEX)),
        1.. => Ok(number - 1),
        _ => Ok(number.saturating_add(vertices as i64)),
    }
}
