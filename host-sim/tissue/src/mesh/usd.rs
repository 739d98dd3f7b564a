//! Tets in USD text (`.usda`): the one `TetMesh` of the file, as physics engines keep it.
//!
//! Coordinates are read as they stand, so that transforms of the mesh, and of prims around it, are
//! refused unless they are the identity. The file's `metersPerUnit` has to agree with the unit that
//! the caller gives, and its `upAxis` turns the mesh.

use super::Up;
use super::element::{Kind, Shape};
use super::error::{Defect, MeshError, quoted};
use super::lines::Lines;
use super::raw::{RawMesh, RawNode};
use super::word::{At, Word};

const FORMAT: &str = "USD text";
const TET: Kind = Kind::solid(Shape::Tet, 4);
const LONG_TEXT: &str = "\"\"\"";
/// Largest relative difference between two statements of one unit.
const SAME_UNIT: f64 = 1e-6;

/// Words of the file: names with their colons and dots, numbers, texts in quotes, and signs.
struct Words<'a> {
    lines: Lines<'a>,
    rest: &'a str,
    at: At<'a>,
}

impl<'a> Words<'a> {
    fn new(file: &'a str, text: &'a str) -> Self {
        let lines = Lines::new(file, text);
        Self { at: lines.at(), lines, rest: "" }
    }

    fn required(&mut self, what: &'static str) -> Result<Word<'a>, MeshError> {
        self.next().ok_or_else(|| self.at.error(Defect::Truncated { what }))
    }

    fn sign(&mut self, sign: &str, what: &'static str) -> Result<(), MeshError> {
        let word = self.required(what)?;
        if word.text == sign { Ok(()) } else { Err(word.unexpected(what)) }
    }

    /// Passes the words of each `(a, b, ...)` of an array to `read`, which starts with `=`.
    fn rows<const N: usize>(&mut self, mut read: impl FnMut([Word<'a>; N]) -> Result<(), MeshError>) -> Result<(), MeshError> {
        self.sign("=", "`=`")?;
        self.sign("[", "`[`")?;
        loop {
            let word = self.required("the end of an array")?;
            match word.text {
                "]" => return Ok(()),
                "," => {}
                "(" => {
                    let mut row = [word; N];
                    for (k, cell) in row.iter_mut().enumerate() {
                        if k > 0 {
                            self.sign(",", "`,` between numbers")?;
                        }
                        *cell = self.required("a number")?;
                    }
                    self.sign(")", "`)` after the numbers")?;
                    read(row)?;
                }
                _ => return Err(word.unexpected("`(` or the end of an array")),
            }
        }
    }
}

impl<'a> Iterator for Words<'a> {
    type Item = Word<'a>;

    fn next(&mut self) -> Option<Word<'a>> {
        loop {
            self.rest = self.rest.trim_start();
            if self.rest.is_empty() || self.rest.starts_with('#') {
                let line = self.lines.next()?;
                (self.rest, self.at) = (line.text, line.at);
                continue;
            }
            if let Some(begun) = self.rest.strip_prefix(LONG_TEXT) {
                self.rest = begun;
                while !self.rest.contains(LONG_TEXT) {
                    let line = self.lines.next()?;
                    (self.rest, self.at) = (line.text, line.at);
                }
                self.rest = self.rest.split_once(LONG_TEXT)?.1;
                continue;
            }
            let length = match self.rest.chars().next()? {
                quote @ ('"' | '\'' | '@') => self.rest[1..].find(quote).map_or(self.rest.len(), |end| end + 2),
                '(' | ')' | '[' | ']' | '{' | '}' | ',' | '=' | ';' => 1,
                _ => self
                    .rest
                    .find([' ', '\t', '(', ')', '[', ']', '{', '}', ',', '=', ';', '"', '\'', '@'])
                    .unwrap_or(self.rest.len()),
            };
            let (text, rest) = self.rest.split_at(length);
            self.rest = rest;
            return Some(Word { at: self.at, text });
        }
    }
}

/// Reads a `.usda` file.
pub(super) fn read(file: &str, data: &[u8], unit_m: f64) -> Result<RawMesh, MeshError> {
    let text = String::from_utf8_lossy(data);
    let mut words = Words::new(file, &text);
    let mut raw = RawMesh::new(FORMAT, file);
    // prims that are open, innermost last; `None` for other braces
    let (mut open, mut begun): (Vec<Option<Prim>>, Option<Prim>) = (Vec::new(), None);
    let (mut meshes, mut tets, mut brackets) = (0, 0, 0);
    while let Some(word) = words.next() {
        let in_tets = matches!(open.last(), Some(Some(prim)) if prim.kind == "TetMesh");
        match word.text {
            "def" => {
                let kind = words.required("the kind of a prim")?.text;
                begun = Some(Prim { kind, transform: None });
                match kind {
                    "TetMesh" => {
                        refuse(open.iter().flatten().find_map(|prim| prim.transform))?;
                        meshes += 1;
                    }
                    "Mesh" => *raw.ignored.entry("surface (Mesh)").or_default() += 1,
                    _ => {}
                }
                if meshes > 1 {
                    return Err(word.at.error(Defect::RepeatedSection { section: "TetMesh" }));
                }
            }
            "(" => brackets += 1,
            ")" => brackets -= 1,
            // braces in brackets are a dictionary of the prim that begins
            "{" => open.push(if brackets > 0 { None } else { begun.take() }),
            "}" => drop(open.pop()),
            "metersPerUnit" if open.is_empty() => {
                words.sign("=", "`=`")?;
                let own_m = words.required("a length")?.coordinate()?;
                if (own_m - unit_m).abs() > SAME_UNIT * own_m.abs() {
                    return Err(word.at.error(Defect::OwnUnit { own_m, unit_m }));
                }
            }
            "upAxis" if open.is_empty() => {
                words.sign("=", "`=`")?;
                raw.up = match words.required("an axis")?.text.trim_matches(['"', '\'']) {
                    "X" => Some(Up::X),
                    "Y" => Some(Up::Y),
                    _ => None,
                };
            }
            "points" if in_tets => words.rows(|row: [Word<'_>; 3]| {
                let [x, y, z] = [row[0].coordinate()?, row[1].coordinate()?, row[2].coordinate()?];
                raw.nodes.push(RawNode { number: raw.nodes.len() as u64, line: Some(row[0].at.line), position: [x, y, z] });
                Ok(())
            })?,
            "tetVertexIndices" if in_tets => words.rows(|row: [Word<'_>; 4]| {
                let mut nodes = [0; 4];
                for (node, word) in nodes.iter_mut().zip(row) {
                    *node = word.whole("the number of a point")?;
                }
                raw.add(TET, tets, Some(row[0].at.line), &nodes, 0);
                tets += 1;
                Ok(())
            })?,
            name if name.starts_with("xformOp:") => {
                let moves = moves(&mut words, word)?.then_some(word);
                refuse(moves.filter(|_| in_tets))?;
                if let Some(Some(prim)) = open.last_mut() {
                    prim.transform = prim.transform.or(moves);
                }
            }
            _ => {}
        }
    }
    Ok(raw)
}

/// A prim that is open.
struct Prim<'a> {
    kind: &'a str,
    /// Name of its first transform that is not the identity.
    transform: Option<Word<'a>>,
}

/// Refuses a transform of the mesh.
fn refuse(transform: Option<Word<'_>>) -> Result<(), MeshError> {
    transform.map_or(Ok(()), |word| {
        Err(word.at.error(Defect::Encoding {
            what: "the transform",
            found: quoted(word.text),
            instead: "with transforms applied to the points",
        }))
    })
}

/// Whether a transform is not the identity; `word` is its name. One that changes with time, or
/// whose value is not written here, counts as such.
fn moves<'a>(words: &mut Words<'a>, word: Word<'a>) -> Result<bool, MeshError> {
    if word.text.ends_with(".timeSamples") {
        return Ok(true);
    }
    words.sign("=", "`=`")?;
    let (mut depth, mut numbers) = (0, Vec::new());
    loop {
        let value = words.required("the value of a transform")?;
        match value.text {
            "(" => depth += 1,
            ")" => depth -= 1,
            "," => {}
            _ => numbers.push(value.coordinate()?),
        }
        if depth == 0 {
            break;
        }
    }
    let kind = word.text.split(':').nth(1).unwrap_or_default();
    let neutral = |k: usize| match kind {
        "scale" => 1.0,
        "orient" => f64::from(u8::from(k == 0)),
        "transform" => f64::from(u8::from(k.is_multiple_of(5))),
        _ => 0.0,
    };
    Ok(numbers.iter().enumerate().any(|(k, number)| *number != neutral(k)))
}
