//! Gmsh `.msh`: format 1 (`$NOD`/`$ELM`), 2.x, 4.0 and 4.1, all but the first as text or binary.
//!
//! A file is a list of `$Section` ... `$EndSection` blocks; as text, one record per line as Gmsh
//! writes them.

mod binary;
mod kind;
mod v1;
mod v2;
mod v4;

use self::kind::in_order;
use super::element::Kind;
use super::error::{Defect, MeshError, quoted};
use super::lines::{Line, Lines};
use super::raw::{RawMesh, RawNode};
use super::word::Word;

/// Format version that `$MeshFormat` announces; format 1 has no such section.
#[derive(Clone, Copy, PartialEq)]
enum Version {
    V1,
    V2,
    /// 4.0, whose blocks begin with the tag, not the dimension, and whose nodes are on one line.
    V40,
    V4,
}

/// Reads a `.msh` file, whichever format its header announces.
pub(super) fn read(file: &str, data: &[u8]) -> Result<RawMesh, MeshError> {
    if is_binary(data) { binary::read(file, data) } else { read_text(file, &String::from_utf8_lossy(data)) }
}

/// Whether the second word under `$MeshFormat` is 1.
fn is_binary(data: &[u8]) -> bool {
    let mut lines = data.split(|byte| *byte == b'\n').map(<[u8]>::trim_ascii).filter(|line| !line.is_empty());
    let format = lines.next().filter(|line| *line == b"$MeshFormat").and_then(|_| lines.next());
    let mut words = format.unwrap_or_default().split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
    words.nth(1) == Some(b"1")
}

fn read_text(file: &str, text: &str) -> Result<RawMesh, MeshError> {
    let mut lines = Lines::new(file, text);
    let mut mesh = RawMesh::new("Gmsh 1", file);
    let mut version = Version::V1;
    let mut regions = None;
    let (mut has_nodes, mut has_elements) = (false, false);
    while let Some(line) = lines.next() {
        match (line.text, version) {
            ("$MeshFormat", _) => (version, mesh.format) = format(&mut lines)?,
            ("$NOD", Version::V1) => {
                once(&mut has_nodes, &line, "$NOD")?;
                numbered_nodes(&mut lines, &mut mesh, "$NOD")?;
            }
            ("$ELM", Version::V1) => {
                once(&mut has_elements, &line, "$ELM")?;
                v1::elements(&mut lines, &mut mesh)?;
            }
            ("$Nodes", Version::V2) => {
                once(&mut has_nodes, &line, "$Nodes")?;
                numbered_nodes(&mut lines, &mut mesh, "$Nodes")?;
            }
            // with the position of each node on its curve or face behind it
            ("$ParametricNodes", Version::V2) => {
                once(&mut has_nodes, &line, "$Nodes")?;
                numbered_nodes(&mut lines, &mut mesh, "$ParametricNodes")?;
            }
            ("$Elements", Version::V2) => {
                once(&mut has_elements, &line, "$Elements")?;
                v2::elements(&mut lines, &mut mesh)?;
            }
            ("$Entities", Version::V40 | Version::V4) => regions = Some(v4::regions(&mut lines)?),
            ("$PartitionedEntities", _) => return Err(line.at.error(Defect::Partitioned)),
            ("$Nodes", Version::V40 | Version::V4) => {
                once(&mut has_nodes, &line, "$Nodes")?;
                v4::nodes(&mut lines, &mut mesh, version == Version::V40)?;
            }
            ("$Elements", Version::V40 | Version::V4) => {
                once(&mut has_elements, &line, "$Elements")?;
                v4::elements(&mut lines, &mut mesh, regions.as_ref(), version == Version::V40)?;
            }
            _ => skip_section(&mut lines, &line)?,
        }
    }
    let (nodes, elements) = match version {
        Version::V1 => ("$NOD section", "$ELM section"),
        Version::V2 | Version::V40 | Version::V4 => ("$Nodes section", "$Elements section"),
    };
    for (found, section) in [(has_nodes, nodes), (has_elements, elements)] {
        if !found {
            return Err(lines.at().error(Defect::MissingSection { section }));
        }
    }
    Ok(mesh)
}

fn once(seen: &mut bool, line: &Line, section: &'static str) -> Result<(), MeshError> {
    if std::mem::replace(seen, true) {
        return Err(line.at.error(Defect::RepeatedSection { section }));
    }
    Ok(())
}

fn version(text: &str) -> Result<(Version, &'static str), Defect> {
    match text {
        "2" | "2.0" | "2.1" | "2.2" => Ok((Version::V2, "Gmsh 2")),
        "4" | "4.0" => Ok((Version::V40, "Gmsh 4.0")),
        "4.1" => Ok((Version::V4, "Gmsh 4.1")),
        found => Err(Defect::Version { format: "Gmsh", found: quoted(found), supported: "Gmsh 2.2 or 4.1" }),
    }
}

/// Reads `version file-type data-size`; file type 0 is text.
fn format(lines: &mut Lines) -> Result<(Version, &'static str), MeshError> {
    let mut line = lines.required("the Gmsh version")?;
    let word = line.word("the Gmsh version")?;
    let known = version(word.text).map_err(|defect| word.at.error(defect))?;
    let file_type = line.word("the Gmsh file type")?;
    match file_type.text {
        "0" => end(lines, "$EndMeshFormat").map(|()| known),
        _ => Err(file_type.unexpected("the file type 0 (ASCII) or 1 (binary)")),
    }
}

/// Reads the nodes of format 1 or 2: their number, then `number x y z` for each.
fn numbered_nodes(lines: &mut Lines, mesh: &mut RawMesh, section: &'static str) -> Result<(), MeshError> {
    let count = lone_count(lines, "the number of nodes")?;
    lines.rows(section, "nodes", count, |mut line| {
        mesh.nodes.push(RawNode { number: line.whole("a node number")?, line: Some(line.at.line), position: line.position()? });
        if section == "$ParametricNodes" { Ok(()) } else { line.finish() }
    })?;
    section_end(lines, section, "nodes", count)
}

/// Adds the element whose nodes are the rest of a line.
fn add(mut line: Line, mesh: &mut RawMesh, kind: Kind, number: u64, region: u32) -> Result<(), MeshError> {
    let mut nodes = Vec::new();
    if let Kind::Solid { nodes: count, .. } | Kind::Face { nodes: count, .. } = kind {
        for _ in 0..count {
            nodes.push(line.whole("a node number")?);
        }
        in_order(&mut nodes);
        mesh.add(kind, number, Some(line.at.line), &nodes, region);
        return line.finish();
    }
    mesh.add(kind, number, Some(line.at.line), &nodes, region);
    Ok(())
}

fn lone_count(lines: &mut Lines, what: &'static str) -> Result<u64, MeshError> {
    let mut line = lines.required(what)?;
    let count = line.whole(what)?;
    line.finish()?;
    Ok(count)
}

/// Reads the line that ends a section of `count` records.
fn section_end(lines: &mut Lines, section: &'static str, items: &'static str, count: u64) -> Result<(), MeshError> {
    let line = lines.required("the end of the section")?;
    let (at, text) = (line.at, line.text);
    if ended_section(text).is_some() {
        return Ok(());
    }
    if text.starts_with('$') {
        return Err(Word { at, text }.unexpected("the end of the section"));
    }
    Err(at.error(Defect::TooMany { section, items, announced: count }))
}

/// Reads the line `tag`, which ends a section without records.
fn end(lines: &mut Lines, tag: &'static str) -> Result<(), MeshError> {
    let line = lines.required(tag)?;
    if line.text == tag {
        return Ok(());
    }
    let (at, text) = (line.at, line.text);
    Err(Word { at, text }.unexpected(tag))
}

/// Skips a section that the mesh does not need: names, periodicity, results.
fn skip_section(lines: &mut Lines, start: &Line) -> Result<(), MeshError> {
    let (at, text) = (start.at, start.text);
    let Some(name) = text.strip_prefix('$') else {
        return Err(Word { at, text }.unexpected("a $Section"));
    };
    if lines.any(|line| ended_section(line.text) == Some(name)) {
        return Ok(());
    }
    Err(at.error(Defect::Truncated { what: "this section ends" }))
}

/// Name of the section that a line ends: the text after `$End`, or after `$END` in format 1.
fn ended_section(text: &str) -> Option<&str> {
    text.strip_prefix("$End").or_else(|| text.strip_prefix("$END"))
}

/// Reads a physical group as a region. A negative group, by which Gmsh reverses elements, is the
/// same region, since the sign says nothing about the material.
fn physical_group(word: Word) -> Result<u32, MeshError> {
    let text = word.text.strip_prefix('-').unwrap_or(word.text);
    Word { text, ..word }.region()
}
