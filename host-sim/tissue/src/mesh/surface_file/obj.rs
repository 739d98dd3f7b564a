//! Wavefront OBJ: `v x y z`, and faces of three or more vertices, which are divided into triangles
//! that share the first vertex. All other lines (normals, textures, groups) are skipped.

use super::RawSurface;
use crate::mesh::error::{Defect, MeshError};
use crate::mesh::lines::Lines;
use crate::mesh::word::Word;

/// First words of the lines of an OBJ file.
const KEYWORDS: [&[u8]; 9] = [b"v", b"vn", b"vt", b"f", b"o", b"g", b"s", b"mtllib", b"usemtl"];

/// Whether the first line that is not a comment is an OBJ line.
pub(super) fn starts(data: &[u8]) -> bool {
    let lines = data.split(|byte| *byte == b'\n').map(<[u8]>::trim_ascii);
    let first = lines.take(1000).find(|line| !line.is_empty() && !line.starts_with(b"#"));
    let mut words = first.unwrap_or_default().split(u8::is_ascii_whitespace);
    words.next().is_some_and(|word| KEYWORDS.contains(&word)) && words.next().is_some()
}

pub(super) fn read(file: &str, text: &str) -> Result<RawSurface, MeshError> {
    let lines = Lines::new(file, text);
    let mut surface = RawSurface { format: "OBJ", vertices: Vec::new(), triangles: Vec::new() };
    for mut line in lines {
        let at = line.at;
        match line.word("an OBJ keyword")?.text {
            "v" => surface.vertices.push(line.position()?),
            "f" => {
                let vertices = surface.vertices.len();
                let corners: Vec<u32> = line.map(|word| vertex(word, vertices)).collect::<Result<_, _>>()?;
                let [first, rest @ ..] = corners.as_slice() else { return Err(at.error(Defect::Missing { what: "the face" })) };
                if rest.len() < 2 {
                    return Err(at.error(Defect::Missing { what: "three vertices of the face" }));
                }
                surface.triangles.extend(rest.windows(2).map(|pair| [*first, pair[0], pair[1]]));
            }
            _ => {}
        }
    }
    Ok(surface)
}

/// Index of the vertex in `vertex[/texture[/normal]]`, counted from 1, or backward from the last
/// with -1.
fn vertex(word: Word, vertices: usize) -> Result<u32, MeshError> {
    let unexpected = || word.unexpected("the number of a vertex above this line");
    let number: i64 = word.text.split('/').next().unwrap_or("").parse().map_err(|_| unexpected())?;
    let index = if number > 0 { number - 1 } else { vertices as i64 + number };
    let known = number != 0 && (0..vertices as i64).contains(&index);
    u32::try_from(index).ok().filter(|_| known).ok_or_else(unexpected)
}
