//! Gmsh 2.x: `$Elements`, one `number type tag-count tags... nodes...` per line; the first tag is
//! the physical group.

use super::kind::kind;
use super::{add, lone_count, physical_group, section_end};
use crate::mesh::element::Kind;
use crate::mesh::error::MeshError;
use crate::mesh::lines::Lines;
use crate::mesh::raw::RawMesh;

pub(super) fn elements(lines: &mut Lines, mesh: &mut RawMesh) -> Result<(), MeshError> {
    let count = lone_count(lines, "the number of elements")?;
    lines.rows("$Elements", "elements", count, |mut line| {
        let number = line.whole("an element number")?;
        let kind = kind(line.whole("an element type")?);
        let tags = line.whole("the number of tags")?;
        let (mut region, mut skipped) = (0, tags);
        if let (Kind::Solid { .. }, 1..) = (kind, tags) {
            region = physical_group(line.word("the physical group")?)?;
            skipped -= 1;
        }
        line.skip_words(skipped, "the last tag")?;
        add(line, mesh, kind, number, region)
    })?;
    section_end(lines, "$Elements", "elements", count)
}
