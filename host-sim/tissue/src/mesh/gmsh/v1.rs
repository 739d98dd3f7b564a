//! Gmsh 1: `$ELM`, one `number type physical elementary node-count nodes...` per line.

use super::kind::{Kind, kind};
use super::{lone_count, physical_group, section_end};
use crate::mesh::error::{Defect, MeshError};
use crate::mesh::lines::Lines;
use crate::mesh::raw::{RawMesh, RawTet};

pub(super) fn elements(lines: &mut Lines, mesh: &mut RawMesh) -> Result<(), MeshError> {
    let count = lone_count(lines, "the number of elements")?;
    lines.rows("$ELM", "elements", count, |mut line| {
        let number = line.whole("an element number")?;
        match kind(line.whole("an element type")?) {
            Kind::HigherOrderTet => Err(line.at.error(Defect::HigherOrder)),
            Kind::Other(kind) => {
                mesh.ignore(kind);
                Ok(())
            }
            Kind::Tet => {
                let region = physical_group(line.word("the physical region")?)?;
                line.word("the elementary region")?;
                let nodes = line.word("the number of nodes")?;
                if nodes.text != "4" {
                    return Err(nodes.unexpected("4 nodes"));
                }
                mesh.tets.push(RawTet { number, line: Some(line.at.line), nodes: line.tet_nodes()?, region });
                line.finish()
            }
        }
    })?;
    section_end(lines, "$ELM", "elements", count)
}
