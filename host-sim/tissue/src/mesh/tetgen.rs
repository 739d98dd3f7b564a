//! `TetGen`: nodes in `name.node`, tets in `name.ele`, comments from `#`.
//!
//! Both files number their entries, from 0 or from 1; the numbers are taken as they stand.

use super::error::{Defect, MeshError};
use super::lines::Lines;
use super::raw::{RawMesh, RawNode, RawTet};

/// A file that was read: the name to report and its text.
pub(super) struct Source<'a> {
    pub file: &'a str,
    pub text: &'a str,
}

/// Reads the pair.
pub(super) fn read(node: &Source, ele: &Source) -> Result<RawMesh, MeshError> {
    let mut mesh = RawMesh::new("TetGen", node.file, ele.file);
    nodes(node, &mut mesh)?;
    tets(ele, &mut mesh)?;
    Ok(mesh)
}

/// `nodes 3 attributes markers`, then `number x y z attributes... [marker]` each.
fn nodes(source: &Source, mesh: &mut RawMesh) -> Result<(), MeshError> {
    let mut lines = Lines::new(source.file, source.text).with_comments('#');
    let mut header = lines.required("the number of nodes")?;
    let count = header.whole("the number of nodes")?;
    let dimension = header.word("the dimension 3")?;
    if dimension.text != "3" {
        return Err(dimension.unexpected("the dimension 3"));
    }
    // Either may be left out, and then is 0.
    let mut extra = 0;
    for what in ["the number of attributes", "the number of markers"] {
        if let Some(word) = header.next() {
            extra = word.whole(what)?.saturating_add(extra);
        }
    }
    header.finish()?;
    lines.rows(".node", "nodes", count, |mut line| {
        mesh.nodes.push(RawNode { number: line.whole("a node number")?, line: line.at.line, position: line.position()? });
        line.skip_words(extra, "the last attribute or marker")?;
        line.finish()
    })?;
    nothing_follows(lines, ".node", "nodes", count)
}

/// `tets 4 attributes`, then `number a b c d attributes...` each, the last attribute the region.
fn tets(source: &Source, mesh: &mut RawMesh) -> Result<(), MeshError> {
    let mut lines = Lines::new(source.file, source.text).with_comments('#');
    let mut header = lines.required("the number of tets")?;
    let count = header.whole("the number of tets")?;
    let corners = header.word("the number of nodes a tet")?;
    let attributes = match header.next() {
        Some(word) => word.whole("the number of attributes")?,
        None => 0,
    };
    header.finish()?;
    match corners.text {
        "4" => {}
        "10" => return Err(corners.at.error(Defect::HigherOrder)),
        _ => return Err(corners.unexpected("4 nodes a tet")),
    }
    lines.rows(".ele", "tets", count, |mut line| {
        let number = line.whole("a tet number")?;
        let nodes = line.tet_nodes()?;
        line.skip_words(attributes.saturating_sub(1), "the last attribute")?;
        let region = match attributes {
            0 => 0,
            _ => line.word("the region attribute")?.region()?,
        };
        mesh.tets.push(RawTet { number, line: line.at.line, nodes, region });
        line.finish()
    })?;
    nothing_follows(lines, ".ele", "tets", count)
}

fn nothing_follows(mut lines: Lines, section: &'static str, items: &'static str, announced: u64) -> Result<(), MeshError> {
    match lines.next() {
        None => Ok(()),
        Some(line) => Err(line.at.error(Defect::TooMany { section, items, announced })),
    }
}
