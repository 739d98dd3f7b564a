//! Gmsh `.msh`, binary: format 2.x, 4.0 and 4.1. Section names are lines of text; the content of a
//! section is numbers without separators.

use super::kind::{in_order, kind, nodes_of};
use super::v4::Regions;
use super::{Version, version};
use crate::mesh::bytes::{Bytes, Order};
use crate::mesh::element::Kind;
use crate::mesh::error::{Defect, MeshError};
use crate::mesh::raw::{RawMesh, RawNode};

/// The only size of a `size_t` that Gmsh writes today [bytes].
const DATA_SIZE: &str = "8";

/// Reads a binary `.msh` file.
pub(super) fn read(file: &str, data: &[u8]) -> Result<RawMesh, MeshError> {
    let mut bytes = Bytes::new(file, data, Order::Little);
    let mut mesh = RawMesh::new("Gmsh", file);
    let version = format(&mut bytes, &mut mesh)?;
    let mut regions = None;
    let (mut has_nodes, mut has_elements) = (false, false);
    while let Some(tag) = bytes.line() {
        let section = match tag.as_str() {
            "$Nodes" => {
                once(&bytes, &mut has_nodes, "$Nodes")?;
                match version {
                    Version::V40 | Version::V4 => nodes_4(&mut bytes, &mut mesh, version == Version::V40)?,
                    Version::V1 | Version::V2 => nodes_2(&mut bytes, &mut mesh)?,
                }
                "$EndNodes"
            }
            "$Elements" => {
                once(&bytes, &mut has_elements, "$Elements")?;
                match version {
                    Version::V40 | Version::V4 => {
                        elements_4(&mut bytes, &mut mesh, regions.as_ref(), version == Version::V40)?;
                    }
                    Version::V1 | Version::V2 => elements_2(&mut bytes, &mut mesh)?,
                }
                "$EndElements"
            }
            "$ParametricNodes" => {
                let (what, found, instead) = ("binary Gmsh section", tag, "without parametric coordinates");
                return Err(bytes.error(Defect::Encoding { what, found, instead }));
            }
            "$Entities" if version != Version::V2 => {
                regions = Some(entities(&mut bytes, version == Version::V40)?);
                "$EndEntities"
            }
            "$PartitionedEntities" => return Err(bytes.error(Defect::Partitioned)),
            other => {
                let Some(name) = other.strip_prefix('$') else { return Err(bytes.unexpected("a $Section", other)) };
                if !bytes.skip_past(&format!("$End{name}")) {
                    return Err(bytes.error(Defect::Truncated { what: "a section ends" }));
                }
                continue;
            }
        };
        let end = bytes.required("the end of the section")?;
        if end != section {
            return Err(bytes.unexpected("the end of the section", &end));
        }
    }
    for (found, section) in [(has_nodes, "$Nodes section"), (has_elements, "$Elements section")] {
        if !found {
            return Err(bytes.error(Defect::MissingSection { section }));
        }
    }
    Ok(mesh)
}

fn once(bytes: &Bytes, seen: &mut bool, section: &'static str) -> Result<(), MeshError> {
    if std::mem::replace(seen, true) { Err(bytes.error(Defect::RepeatedSection { section })) } else { Ok(()) }
}

/// Reads `version 1 data-size` as text, then the `i32` 1, which shows the order of the bytes.
fn format(bytes: &mut Bytes, mesh: &mut RawMesh) -> Result<Version, MeshError> {
    bytes.required("$MeshFormat")?;
    let line = bytes.required("the Gmsh version")?;
    let mut words = line.split_whitespace();
    let (version, name) = version(words.next().unwrap_or_default()).map_err(|defect| bytes.error(defect))?;
    mesh.format = name;
    if words.nth(1) != Some(DATA_SIZE) {
        return Err(bytes.unexpected("the data size 8", &line));
    }
    let one = bytes.i32("the number 1 that shows the order of the bytes")?;
    bytes.order = match one.to_le_bytes() {
        [1, 0, 0, 0] => Order::Little,
        [0, 0, 0, 1] => Order::Big,
        _ => return Err(bytes.unexpected("the number 1 that shows the order of the bytes", &one.to_string())),
    };
    match bytes.required("$EndMeshFormat")?.as_str() {
        "$EndMeshFormat" => Ok(version),
        found => Err(bytes.unexpected("$EndMeshFormat", found)),
    }
}

fn count_line(bytes: &mut Bytes, what: &'static str) -> Result<u64, MeshError> {
    let line = bytes.required(what)?;
    line.parse().map_err(|_| bytes.unexpected(what, &line))
}

/// Reads a count as text, then `i32 number, f64 x y z` for each node.
fn nodes_2(bytes: &mut Bytes, mesh: &mut RawMesh) -> Result<(), MeshError> {
    for _ in 0..count_line(bytes, "the number of nodes")? {
        let number = bytes.whole_i32("a node number")?;
        mesh.nodes.push(RawNode { number, line: None, position: bytes.position(true)? });
    }
    Ok(())
}

/// Reads a count as text, then blocks `i32 type count tags`, each followed by `i32 number tags...
/// nodes...` for each element; the first tag is the physical group.
fn elements_2(bytes: &mut Bytes, mesh: &mut RawMesh) -> Result<(), MeshError> {
    let announced = count_line(bytes, "the number of elements")?;
    let mut found = 0;
    while found < announced {
        let (kind, count) = element(bytes)?;
        let in_block = bytes.whole_i32("the number of elements in the block")?;
        let tags = bytes.whole_i32("the number of tags")?;
        if in_block == 0 || in_block > announced - found {
            return Err(bytes.unexpected("a block that fits the number of elements", &in_block.to_string()));
        }
        found += in_block;
        for _ in 0..in_block {
            let number = bytes.whole_i32("an element number")?;
            let region = if tags == 0 { 0 } else { bytes.i32("the physical group")?.unsigned_abs() };
            bytes.skip(tags.saturating_sub(1), 4, "the last tag")?;
            let nodes = nodes_of_element(bytes, count, |bytes| bytes.whole_i32("a node number"))?;
            mesh.add(kind, number, None, &nodes, region);
        }
    }
    Ok(())
}

/// Reads the type code of the next element; returns its kind and number of nodes.
fn element(bytes: &mut Bytes) -> Result<(Kind, usize), MeshError> {
    let code = bytes.whole_i32("an element type")?;
    nodes_of(code).map(|count| (kind(code), count)).ok_or_else(|| {
        let (what, found, instead) = ("binary Gmsh element type", code.to_string(), "only elements of first order");
        bytes.error(Defect::Encoding { what, found, instead })
    })
}

fn nodes_of_element(
    bytes: &mut Bytes,
    count: usize,
    node: impl Fn(&mut Bytes) -> Result<u64, MeshError>,
) -> Result<Vec<u64>, MeshError> {
    let mut nodes = (0..count).map(|_| node(bytes)).collect::<Result<Vec<_>, _>>()?;
    in_order(&mut nodes);
    Ok(nodes)
}

/// Reads four counts, then the entities; a volume is `i32 tag, f64 x6, count, i32 physical...,
/// count, i32 surfaces...`. Counts are 64 bits wide.
/// A point has one position, in 4.0 a box like the others.
fn entities(bytes: &mut Bytes, is_40: bool) -> Result<Regions, MeshError> {
    let mut counts = [0; 4];
    for count in &mut counts {
        *count = bytes.u64("the entity counts")?;
    }
    let mut regions = Regions::new();
    for (dimension, count) in counts.into_iter().enumerate() {
        for _ in 0..count {
            let tag = bytes.i32("an entity tag")?;
            bytes.skip(if dimension == 0 && !is_40 { 3 } else { 6 }, 8, "the bounding box")?;
            let groups = bytes.u64("the number of physical groups")?;
            // The first group decides: a solid cannot have two materials.
            let region = if groups == 0 { 0 } else { bytes.i32("a physical group")?.unsigned_abs() };
            bytes.skip(groups.saturating_sub(1), 4, "the physical groups")?;
            if dimension > 0 {
                let bounding = bytes.u64("the number of bounding entities")?;
                bytes.skip(bounding, 4, "the bounding entities")?;
            }
            if let (3, Ok(volume)) = (dimension, u64::try_from(tag)) {
                regions.insert(volume, region);
            }
        }
    }
    Ok(regions)
}

/// Reads `blocks count min max`, or `blocks count` in 4.0.
fn header_4(bytes: &mut Bytes, is_40: bool) -> Result<(u64, u64), MeshError> {
    let (blocks, count) = (bytes.u64("the number of blocks")?, bytes.u64("the number of entries")?);
    bytes.skip(if is_40 { 0 } else { 2 }, 8, "the lowest and the highest tag")?;
    Ok((blocks, count))
}

/// Reads the dimension and the tag of an entity, in 4.0 in the other order.
fn entity(bytes: &mut Bytes, is_40: bool) -> Result<(i32, i32), MeshError> {
    let (first, second) = (bytes.i32("the dimension of the entity")?, bytes.i32("an entity tag")?);
    Ok(if is_40 { (second, first) } else { (first, second) })
}

/// Reads blocks of `i32 dimension entity parametric`, a count, that many tags, and that many `f64 x
/// y z [u v w]`. In 4.0 a tag is an `i32` before its position.
fn nodes_4(bytes: &mut Bytes, mesh: &mut RawMesh, is_40: bool) -> Result<(), MeshError> {
    let (blocks, announced) = header_4(bytes, is_40)?;
    for _ in 0..blocks {
        let (dimension, _) = entity(bytes, is_40)?;
        let dimension = u64::from(dimension.unsigned_abs());
        let parameters = match bytes.i32("the parametric flag 0 or 1")? {
            0 => 0,
            1 => dimension,
            other => return Err(bytes.unexpected("the parametric flag 0 or 1", &other.to_string())),
        };
        let in_block = bytes.u64("the number of nodes in the block")?;
        if is_40 {
            for _ in 0..in_block {
                let number = bytes.whole_i32("a node number")?;
                mesh.nodes.push(RawNode { number, line: None, position: bytes.position(true)? });
                bytes.skip(parameters, 8, "the parameters of a node")?;
            }
            continue;
        }
        let first = mesh.nodes.len();
        for _ in 0..in_block {
            mesh.nodes.push(RawNode { number: bytes.u64("a node number")?, line: None, position: [0.0; 3] });
        }
        for node in &mut mesh.nodes[first..] {
            node.position = bytes.position(true)?;
            bytes.skip(parameters, 8, "the parameters of a node")?;
        }
    }
    agree(bytes, "$Nodes", "nodes", announced, mesh.nodes.len() as u64)
}

/// Reads blocks of `i32 dimension entity type`, a count, and that many `number nodes...`, all 64
/// bits wide, or 32 in 4.0.
fn elements_4(bytes: &mut Bytes, mesh: &mut RawMesh, regions: Option<&Regions>, is_40: bool) -> Result<(), MeshError> {
    let (blocks, announced) = header_4(bytes, is_40)?;
    let mut found = 0_u64;
    for _ in 0..blocks {
        let (_, entity) = entity(bytes, is_40)?;
        let (kind, count) = element(bytes)?;
        let in_block = bytes.u64("the number of elements in the block")?;
        let region = match (kind, regions) {
            (Kind::Solid { .. }, Some(regions)) => u64::try_from(entity)
                .ok()
                .and_then(|volume| regions.get(&volume).copied())
                .ok_or_else(|| bytes.unexpected("a volume listed in $Entities", &entity.to_string()))?,
            _ => 0,
        };
        for _ in 0..in_block {
            found += 1;
            let number = |bytes: &mut Bytes, what| if is_40 { bytes.whole_i32(what) } else { bytes.u64(what) };
            let own = number(bytes, "an element number")?;
            let nodes = nodes_of_element(bytes, count, |bytes| number(bytes, "a node number"))?;
            mesh.add(kind, own, None, &nodes, region);
        }
    }
    agree(bytes, "$Elements", "elements", announced, found)
}

fn agree(bytes: &Bytes, section: &'static str, items: &'static str, announced: u64, found: u64) -> Result<(), MeshError> {
    match found.cmp(&announced) {
        std::cmp::Ordering::Equal => Ok(()),
        std::cmp::Ordering::Less => Err(bytes.error(Defect::TooFew { section, items, announced, found })),
        std::cmp::Ordering::Greater => Err(bytes.error(Defect::TooMany { section, items, announced })),
    }
}
