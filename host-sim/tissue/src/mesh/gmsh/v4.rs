//! Gmsh 4.1: nodes and elements in blocks, one block per geometric entity. The physical group of a
//! tet is the one that `$Entities` gives to its volume.

use std::collections::BTreeMap;

use super::kind::{Kind, kind};
use super::{physical_group, section_end};
use crate::mesh::error::{Defect, MeshError};
use crate::mesh::lines::Lines;
use crate::mesh::raw::{RawMesh, RawNode, RawTet};
use crate::mesh::word::Word;

/// Region of every volume that `$Entities` lists, by volume tag.
pub(super) type Regions = BTreeMap<u64, u32>;

/// Reads `points curves surfaces volumes`, then one line for each entity; that of a volume is `tag
/// min-xyz max-xyz physical-count physical-tags... surface-count surface-tags...`.
pub(super) fn regions(lines: &mut Lines) -> Result<Regions, MeshError> {
    let mut line = lines.required("the entity counts")?;
    let points = line.whole("the number of points")?;
    let curves = line.whole("the number of curves")?;
    let surfaces = line.whole("the number of surfaces")?;
    let volumes = line.whole("the number of volumes")?;
    line.finish()?;
    let mut regions = Regions::new();
    for (items, count) in [("points", points), ("curves", curves), ("surfaces", surfaces)] {
        lines.rows("$Entities", items, count, |_| Ok(()))?;
    }
    lines.rows("$Entities", "volumes", volumes, |mut line| {
        let volume = line.whole("a volume tag")?;
        line.skip_words(6, "the bounding box")?;
        // The first group decides: a solid cannot have two materials.
        let region = match line.whole("the number of physical groups")? {
            0 => 0,
            _ => physical_group(line.word("a physical group")?)?,
        };
        regions.insert(volume, region);
        Ok(())
    })?;
    section_end(lines, "$Entities", "volumes", volumes)?;
    Ok(regions)
}

/// Reads `blocks nodes min-tag max-tag`, then for each block `dimension entity parametric count`,
/// that many tags, and that many `x y z [u v w]`.
pub(super) fn nodes(lines: &mut Lines, mesh: &mut RawMesh) -> Result<(), MeshError> {
    let (blocks, count) = header(lines, "nodes")?;
    for _ in 0..blocks {
        let mut line = lines.required("the next block of nodes")?;
        line.whole("the dimension of the entity")?;
        line.word("an entity tag")?;
        let parametric = line.word("the parametric flag 0 or 1")?;
        let in_block = line.whole("the number of nodes in the block")?;
        line.finish()?;
        let may_have_parameters = match parametric.text {
            "0" => false,
            "1" => true,
            _ => return Err(parametric.unexpected("the parametric flag 0 or 1")),
        };
        let mut numbers = Vec::new();
        lines.rows("a block of $Nodes", "tags", in_block, |mut line| {
            numbers.push(line.whole("a node number")?);
            line.finish()
        })?;
        let mut numbers = numbers.into_iter();
        lines.rows("a block of $Nodes", "positions", in_block, |mut line| {
            let position = line.position()?;
            mesh.nodes.extend(numbers.next().map(|number| RawNode { number, line: Some(line.at.line), position }));
            if may_have_parameters {
                return Ok(());
            }
            line.finish()
        })?;
    }
    agree(lines, "$Nodes", "nodes", count, mesh.nodes.len() as u64)
}

/// Reads `blocks elements min-tag max-tag`, then for each block `dimension entity type count` and
/// that many `number nodes...`.
pub(super) fn elements(lines: &mut Lines, mesh: &mut RawMesh, regions: Option<&Regions>) -> Result<(), MeshError> {
    let (blocks, count) = header(lines, "elements")?;
    let mut found = 0_u64;
    for _ in 0..blocks {
        let mut line = lines.required("the next block of elements")?;
        line.whole("the dimension of the entity")?;
        let entity = line.word("an entity tag")?;
        let kind = kind(line.whole("an element type")?);
        let in_block = line.whole("the number of elements in the block")?;
        line.finish()?;
        let region = match kind {
            Kind::Tet => region_of(entity, regions)?,
            Kind::HigherOrderTet | Kind::Other(_) => 0,
        };
        lines.rows("a block of $Elements", "elements", in_block, |mut line| {
            found += 1;
            let number = line.whole("an element number")?;
            match kind {
                Kind::HigherOrderTet => Err(line.at.error(Defect::HigherOrder)),
                Kind::Other(kind) => {
                    mesh.ignore(kind);
                    Ok(())
                }
                Kind::Tet => {
                    mesh.tets.push(RawTet { number, line: Some(line.at.line), nodes: line.tet_nodes()?, region });
                    line.finish()
                }
            }
        })?;
    }
    agree(lines, "$Elements", "elements", count, found)
}

/// Region of a volume. A file may omit `$Entities`; if the section is there, it lists every volume.
fn region_of(entity: Word, regions: Option<&Regions>) -> Result<u32, MeshError> {
    let volume = entity.whole("a volume tag")?;
    match regions {
        None => Ok(0),
        Some(regions) => regions.get(&volume).copied().ok_or_else(|| entity.unexpected("a volume listed in $Entities")),
    }
}

fn header(lines: &mut Lines, items: &'static str) -> Result<(u64, u64), MeshError> {
    let mut line = lines.required(items)?;
    let blocks = line.whole("the number of blocks")?;
    let count = line.whole("the number of entries")?;
    line.word("the lowest tag")?;
    line.word("the highest tag")?;
    line.finish()?;
    Ok((blocks, count))
}

/// Checks that the section ends here and has as many entries as its header says.
fn agree(lines: &mut Lines, section: &'static str, items: &'static str, announced: u64, found: u64) -> Result<(), MeshError> {
    section_end(lines, section, items, announced)?;
    if found < announced {
        return Err(lines.at().error(Defect::TooFew { section, items, announced, found }));
    }
    if found > announced {
        return Err(lines.at().error(Defect::TooMany { section, items, announced }));
    }
    Ok(())
}
