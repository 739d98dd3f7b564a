//! Gmsh 2.x: `$Elements`, one `number type tag-count tags... nodes...` per line; the first tag is
//! the physical group.

use super::kind::{Kind, kind};
use super::{lone_count, physical_group, section_end};
use crate::mesh::error::{Defect, MeshError};
use crate::mesh::lines::Lines;
use crate::mesh::raw::{RawMesh, RawTet};

pub(super) fn elements(lines: &mut Lines, mesh: &mut RawMesh) -> Result<(), MeshError> {
    let count = lone_count(lines, "the number of elements")?;
    lines.rows("$Elements", "elements", count, |mut line| {
        let number = line.whole("an element number")?;
        match kind(line.whole("an element type")?) {
            Kind::HigherOrderTet => Err(line.at.error(Defect::HigherOrder)),
            Kind::Other(kind) => {
                mesh.ignore(kind);
                Ok(())
            }
            Kind::Tet => {
                let tags = line.whole("the number of tags")?;
                let region = match tags {
                    0 => 0,
                    _ => physical_group(line.word("the physical group")?)?,
                };
                line.skip_words(tags.saturating_sub(1), "the last tag")?;
                mesh.tets.push(RawTet { number, line: Some(line.at.line), nodes: line.tet_nodes()?, region });
                line.finish()
            }
        }
    })?;
    section_end(lines, "$Elements", "elements", count)
}
