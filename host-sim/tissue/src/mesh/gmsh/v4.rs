//! Gmsh 4: nodes and elements in blocks, one block per geometric entity. The physical group of a
//! tet is the one that `$Entities` gives to its volume.

use std::collections::BTreeMap;

use super::kind::kind;
use super::{add, physical_group, section_end};
use crate::mesh::element::Kind;
use crate::mesh::error::{Defect, MeshError};
use crate::mesh::lines::{Line, Lines};
use crate::mesh::raw::{RawMesh, RawNode};
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
/// that many tags, and that many `x y z [u v w]`. In 4.0 there are no lowest and highest tag, and a
/// tag is on the line of its position.
pub(super) fn nodes(lines: &mut Lines, mesh: &mut RawMesh, is_40: bool) -> Result<(), MeshError> {
    let (blocks, count) = header(lines, "nodes", is_40)?;
    for _ in 0..blocks {
        let mut line = lines.required("the next block of nodes")?;
        entity(&mut line, is_40)?;
        let parametric = line.word("the parametric flag 0 or 1")?;
        let in_block = line.whole("the number of nodes in the block")?;
        line.finish()?;
        let may_have_parameters = match parametric.text {
            "0" => false,
            "1" => true,
            _ => return Err(parametric.unexpected("the parametric flag 0 or 1")),
        };
        if is_40 {
            lines.rows("a block of $Nodes", "nodes", in_block, |mut line| {
                let number = line.whole("a node number")?;
                mesh.nodes.push(RawNode { number, line: Some(line.at.line), position: line.position()? });
                if may_have_parameters { Ok(()) } else { line.finish() }
            })?;
            continue;
        }
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
pub(super) fn elements(lines: &mut Lines, mesh: &mut RawMesh, regions: Option<&Regions>, is_40: bool) -> Result<(), MeshError> {
    let (blocks, count) = header(lines, "elements", is_40)?;
    let mut found = 0_u64;
    for _ in 0..blocks {
        let mut line = lines.required("the next block of elements")?;
        let entity = entity(&mut line, is_40)?;
        let kind = kind(line.whole("an element type")?);
        let in_block = line.whole("the number of elements in the block")?;
        line.finish()?;
        let region = match kind {
            Kind::Solid { .. } => region_of(entity, regions)?,
            Kind::Face { .. } | Kind::Unread(_) | Kind::Other(_) => 0,
        };
        lines.rows("a block of $Elements", "elements", in_block, |mut line| {
            found += 1;
            let number = line.whole("an element number")?;
            add(line, mesh, kind, number, region)
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

/// Reads `dimension tag` of an entity, or `tag dimension` in 4.0; returns the tag.
fn entity<'a>(line: &mut Line<'a>, is_40: bool) -> Result<Word<'a>, MeshError> {
    if is_40 {
        let tag = line.word("an entity tag")?;
        line.whole("the dimension of the entity")?;
        return Ok(tag);
    }
    line.whole("the dimension of the entity")?;
    line.word("an entity tag")
}

fn header(lines: &mut Lines, items: &'static str, is_40: bool) -> Result<(u64, u64), MeshError> {
    let mut line = lines.required(items)?;
    let blocks = line.whole("the number of blocks")?;
    let count = line.whole("the number of entries")?;
    if !is_40 {
        line.word("the lowest tag")?;
        line.word("the highest tag")?;
    }
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
