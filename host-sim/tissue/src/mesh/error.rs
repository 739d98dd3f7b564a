//! Defects of a mesh file, with their places.

use std::io;

/// A mesh file that cannot be used. Displays as one line that says where the defect is, what it is,
/// and how to fix it.
#[derive(Debug, thiserror::Error)]
#[error("{}: {defect}", place(file, *line))]
pub struct MeshError {
    /// Path as the caller gave it, control characters replaced.
    pub file: String,
    /// Line in `file`, counted from 1; `None` if the defect belongs to no single line.
    pub line: Option<usize>,
    /// Defect that was found.
    pub defect: Defect,
}

fn place(file: &str, line: Option<usize>) -> String {
    match line {
        Some(line) => format!("{file}:{line}"),
        None => file.to_owned(),
    }
}

/// Defect of a mesh file.
///
/// `tet` and `node` are the numbers the file itself uses: element and node tags in Gmsh,
/// positions from 0 in VTK.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "each message names what its fields hold")]
pub enum Defect {
    #[error("cannot read the file ({0}): check the path")]
    Read(#[source] io::Error),
    #[error("not a regular file: give the path of a mesh file")]
    NotAFile,
    #[error("larger than {limit_mib} MiB: export only the volume mesh, without results")]
    FileTooLarge { limit_mib: u64 },
    #[error("the file is empty: re-export the mesh")]
    Empty,
    #[error("length unit of {0} m: give a positive, finite number of metres per file unit")]
    LengthUnit(f64),

    #[error(
        "unknown mesh format (starts with `{starts}`): export as Gmsh 2.2 or 4.1 (.msh), as VTK (.vtu, .vtk), as USD text (.usda), or as a closed surface (.stl, .obj, .ply, .vtp)"
    )]
    UnknownFormat { starts: String },
    #[error("{is}: {instead}")]
    Foreign { is: &'static str, instead: &'static str },
    #[error("not sound XML ({cause}): re-export the mesh")]
    Xml { cause: String },
    #[error("{what} `{found}` is not read: export {instead}")]
    Encoding { what: &'static str, found: String, instead: &'static str },
    #[error("{format} version `{found}` is not read: export as {supported}")]
    Version { format: &'static str, found: String, supported: &'static str },
    #[error("the file says metersPerUnit = {own_m}, but {unit_m} m per unit were given: give {own_m} as the unit of length")]
    OwnUnit { own_m: f64, unit_m: f64 },
    #[error("a partitioned mesh is not read: export it as one partition")]
    Partitioned,
    #[error("a list of files with the pieces of a mesh: give one file (ParaView: Merge Blocks, then Save Data)")]
    PieceFiles,
    #[error(
        "VTK data set `{found}` is not read: export tets as UNSTRUCTURED_GRID or a surface as POLYDATA (a segmented image: 3D Slicer, Segmentations, Export to models)"
    )]
    DataSet { found: String },
    #[error("XML VTK of type `{found}` is not read: export as UnstructuredGrid (.vtu), or a surface as PolyData (.vtp)")]
    XmlDataSet { found: String },
    #[error(
        "{kinds} would be left out of the body: export tets, pyramids, prisms or hexahedra, of first or second order (Gmsh: Tools, Options, Mesh, Element order 1)"
    )]
    Unread { kinds: String },

    #[error("expected {what}, found `{found}`: fix the line or re-export the mesh")]
    Expected { what: &'static str, found: String },
    #[error("the line ends before {what}: fix the line or re-export the mesh")]
    Missing { what: &'static str },
    #[error("the file ends before {what}: it is cut short, re-export the mesh")]
    Truncated { what: &'static str },
    #[error("`{found}` is more than the line should hold: fix the line or re-export the mesh")]
    Surplus { found: String },
    #[error("{what} is `{found}`, not a finite number: re-export the mesh")]
    NotFinite { what: &'static str, found: String },
    #[error("{section} announces {announced} {items} but holds {found}: re-export the mesh")]
    TooFew { section: &'static str, items: &'static str, announced: u64, found: u64 },
    #[error("{section} announces {announced} {items} but goes on: re-export the mesh")]
    TooMany { section: &'static str, items: &'static str, announced: u64 },
    #[error("{what} says {says}, but the file holds {found}: re-export the mesh")]
    Disagree { what: &'static str, says: u64, found: u64 },
    #[error("second {section}: keep one")]
    RepeatedSection { section: &'static str },
    #[error("no {section}: re-export the mesh with its nodes and tets")]
    MissingSection { section: &'static str },

    #[error("a surface ({format}), not tets: palpate mesh tets FILE makes them")]
    Surface { format: &'static str },
    #[error("no triangles: export the surface again, triangulated")]
    NoTriangles,
    #[error(
        "the surface is open: {edges} edges belong to one triangle only, the first at {near} in file units: close its holes (Blender: 3D Print Toolbox, Make Manifold; MeshLab: Close Holes)"
    )]
    Open { edges: usize, near: String },
    #[error(
        "{edges} edges belong to more than two triangles, the first at {near} in file units: part the walls that touch there, or remesh by voxels (Blender: Remesh)"
    )]
    CrowdedEdge { edges: usize, near: String },
    #[error(
        "the walls of several parts meet in an edge near {near} in file units and face no common way: turn each part outward (Blender: Recalculate Outside), and unite them (Blender: Boolean, Union)"
    )]
    WallsMeet { near: String },
    #[error("the surface has one side only, near {near} in file units: cut the twisted band there and close it again")]
    OneSided { near: String },
    #[error(
        "the surface passes through itself: {pairs} pairs of triangles cross, the first near {near} in file units: unite its parts (Blender: Boolean, Union) or remesh by voxels"
    )]
    Crossing { pairs: usize, near: String },
    #[error(
        "{pieces} separate closed surfaces, one of them at {near} in file units, not one body with hollows: keep one body, or unite those that touch (Blender: Boolean, Union)"
    )]
    Bodies { pieces: usize, near: String },

    #[error("no tets{ignored}: mesh the volume, not only its surface, and re-export")]
    NoTets { ignored: String },
    #[error("node {node} is already {}: renumber the nodes", first_line.map_or("in the file".to_owned(), |line| format!("on line {line}")))]
    RepeatedNodeNumber { node: u64, first_line: Option<usize> },
    #[error(
        "tet {tet} names node {node}, but {}: fix the element or re-export the mesh",
        no_such_node(*node, *nodes, *last)
    )]
    UnknownNode {
        tet: u64,
        node: u64,
        /// Number of nodes in the file.
        nodes: usize,
        /// Highest node number in the file.
        last: u64,
    },
    #[error("tet {tet} names node {node} twice: remove the element")]
    RepeatedNode { tet: u64, node: u64 },

    #[error("the mesh is {size_mm} mm, outside 1 mm to 2 m: {hint}")]
    Size { size_mm: String, hint: String },
    #[error(
        "the mesh lies up to {farthest_m:.0} m from the origin, where positions are too coarse (at most {most_m:.0} m): move it by ({place}) file units"
    )]
    Far { farthest_m: f64, most_m: f64, place: String },
    #[error("node {node} is exactly where node {first} is{}: merge duplicate nodes", in_line(*first_line))]
    CoincidentNodes { node: u64, first: u64, first_line: Option<usize> },
    #[error("tet {tet} is flat (quality {quality:.1e}, regular 1, least {least:.0e}): optimise the mesh to remove slivers")]
    Flat { tet: u64, quality: f64, least: f64 },
    #[error(
        "the face of nodes {}, {}, {} belongs to {tets} tets, this is tet {tet}: a face has at most 2, remove the others",
        face[0], face[1], face[2]
    )]
    CrowdedFace { tet: u64, face: [u64; 3], tets: usize },
    #[error(
        "tets {tet} and {first}{} overlap, both on one side of their common face: a node is out of place, untangle the mesh",
        in_line(*first_line)
    )]
    FoldedFace { tet: u64, first: u64, first_line: Option<usize> },
    #[error(
        "element {element} is folded over itself: its nodes are not in the order of the format, as those of a hexahedron (type 12) in the order of a voxel (type 11) are not; fix the type or the order"
    )]
    FoldedElement { element: u64 },
    #[error("the tets form {parts} parts that share no face ({sizes}; tet {tet} begins the smallest): keep one connected piece")]
    Parts { parts: usize, sizes: String, tet: u64 },
}

/// The line of an item in a text file, in brackets; empty for a binary file.
fn in_line(line: Option<usize>) -> String {
    line.map_or_else(String::new, |line| format!(" (line {line})"))
}

/// Explains why a node does not exist: it is beyond a gapless numbering, or merely not defined.
fn no_such_node(node: u64, nodes: usize, last: u64) -> String {
    if node > last && last.abs_diff(nodes as u64) <= 1 {
        format!("the file has {nodes} nodes")
    } else {
        format!("none of the file's {nodes} nodes has that number")
    }
}

/// A word of a file, made fit for a one-line message: short, without control characters.
pub(super) fn quoted(text: &str) -> String {
    const LONGEST: usize = 24;
    let mut quote = printable(text).chars().take(LONGEST).collect::<String>();
    if text.chars().nth(LONGEST).is_some() {
        quote.push('…');
    }
    quote
}

/// `text` with its control characters (line ends among them) replaced.
pub(super) fn printable(text: &str) -> String {
    text.replace(char::is_control, "\u{fffd}")
}
