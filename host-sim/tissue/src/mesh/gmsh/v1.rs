//! Gmsh 1: `$ELM`, one `number type physical elementary node-count nodes...` per line.

use super::kind::kind;
use super::{add, lone_count, physical_group, section_end};
use crate::mesh::element::Kind;
use crate::mesh::error::MeshError;
use crate::mesh::lines::Lines;
use crate::mesh::raw::RawMesh;

pub(super) fn elements(lines: &mut Lines, mesh: &mut RawMesh) -> Result<(), MeshError> {
    let count = lone_count(lines, "the number of elements")?;
    lines.rows("$ELM", "elements", count, |mut line| {
        let number = line.whole("an element number")?;
        let kind = kind(line.whole("an element type")?);
        let mut region = 0;
        if let Kind::Solid { shape, nodes } = kind {
            region = physical_group(line.word("the physical region")?)?;
            line.word("the elementary region")?;
            let says = line.word("the number of nodes")?;
            if says.text.parse() != Ok(nodes) {
                let what = if shape.corners() == 4 { "4 nodes" } else { "as many nodes as the type has" };
                return Err(says.unexpected(what));
            }
        } else {
            line.skip_words(3, "the number of nodes")?;
        }
        add(line, mesh, kind, number, region)
    })?;
    section_end(lines, "$ELM", "elements", count)
}
