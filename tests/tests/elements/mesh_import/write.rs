//! Writers for every format that is read, including the additional content of real files.

use std::fmt::Write;

use palpate_tissue::mesh::TetMesh;

use super::encode::{self, Order, Xml};

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Format {
    Gmsh1,
    Gmsh2,
    Gmsh4,
    Vtk4,
    Vtk5,
    Gmsh2Binary(Order),
    Gmsh4Binary(Order),
    Vtk4Binary,
    Vtk5Binary,
    /// Encoding, byte order, whether headers are 64 bits wide, whether data are compressed.
    Vtu(Xml, Order, bool, bool),
}

pub const FORMATS: [Format; 17] = [
    Format::Gmsh1,
    Format::Gmsh2,
    Format::Gmsh4,
    Format::Vtk4,
    Format::Vtk5,
    Format::Gmsh2Binary(Order::Little),
    Format::Gmsh2Binary(Order::Big),
    Format::Gmsh4Binary(Order::Little),
    Format::Gmsh4Binary(Order::Big),
    Format::Vtk4Binary,
    Format::Vtk5Binary,
    Format::Vtu(Xml::Ascii, Order::Little, false, false),
    Format::Vtu(Xml::Base64, Order::Little, false, false),
    Format::Vtu(Xml::Base64, Order::Big, true, true),
    Format::Vtu(Xml::Appended, Order::Little, true, false),
    Format::Vtu(Xml::Appended, Order::Big, false, true),
    Format::Vtu(Xml::AppendedRaw, Order::Little, false, true),
];

impl Format {
    pub fn has_regions(self) -> bool {
        matches!(self, Self::Gmsh1 | Self::Gmsh2 | Self::Gmsh4 | Self::Gmsh2Binary(_) | Self::Gmsh4Binary(_))
    }
}

/// Name and content of a file of `mesh`. In text, Gmsh nodes are numbered `stride * index + 1`.
pub fn write(format: Format, mesh: &TetMesh, stride: u64) -> (&'static str, Vec<u8>) {
    match format {
        Format::Gmsh1 => ("mesh.msh", gmsh1(mesh, stride).into()),
        Format::Gmsh2 => ("mesh.msh", gmsh2(mesh, stride).into()),
        Format::Gmsh4 => ("mesh.msh", gmsh4(mesh, stride).into()),
        Format::Vtk4 => ("mesh.vtk", vtk(mesh, "3.0", &vtk_cells_4(mesh)).into()),
        Format::Vtk5 => ("mesh.vtk", vtk(mesh, "5.1", &vtk_cells_5(mesh)).into()),
        Format::Gmsh2Binary(order) => ("mesh.msh", encode::gmsh_2(mesh, order)),
        Format::Gmsh4Binary(order) => ("mesh.msh", encode::gmsh_4(mesh, order)),
        Format::Vtk4Binary => ("mesh.vtk", encode::vtk(mesh, false)),
        Format::Vtk5Binary => ("mesh.vtk", encode::vtk(mesh, true)),
        Format::Vtu(form, order, wide, packed) => ("mesh.vtu", encode::vtu(mesh, form, order, wide, packed)),
    }
}

/// Writes lines, each from one displayable value.
macro_rules! lines {
    ($text:ident, $($line:expr),+ $(,)?) => { $( writeln!($text, "{}", $line).unwrap(); )+ };
}

fn spaced<T: ToString>(items: impl IntoIterator<Item = T>) -> String {
    let words: Vec<_> = items.into_iter().map(|item| item.to_string()).collect();
    words.join(" ")
}

fn tag(node: u32, stride: u64) -> u64 {
    u64::from(node) * stride + 1
}

fn numbered_nodes(text: &mut String, mesh: &TetMesh, stride: u64) {
    lines!(text, mesh.nodes_m.len());
    for (node, at) in (0..).zip(&mesh.nodes_m) {
        lines!(text, format_args!("{} {}", tag(node, stride), spaced(at)));
    }
}

fn gmsh1(mesh: &TetMesh, stride: u64) -> String {
    let mut text = String::from("$NOD\n");
    numbered_nodes(&mut text, mesh, stride);
    lines!(text, "$ENDNOD", "$ELM", mesh.tets.len() + 1, "1 2 7 7 3 1 2 3");
    for (number, (tet, region)) in (2..).zip(mesh.tets.iter().zip(&mesh.regions)) {
        let nodes = spaced(tet.map(|node| tag(node, stride)));
        lines!(text, format_args!("{number} 4 {region} 1 4 {nodes}"));
    }
    lines!(text, "$ENDELM");
    text
}

fn gmsh2(mesh: &TetMesh, stride: u64) -> String {
    let mut text = String::from("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n");
    lines!(text, "$PhysicalNames", 1, "3 1 \"liver tissue\"", "$EndPhysicalNames", "$Nodes");
    numbered_nodes(&mut text, mesh, stride);
    lines!(text, "$EndNodes", "$Elements", mesh.tets.len() + 1, "1 2 2 7 7 1 2 3");
    for (number, (tet, region)) in (2..).zip(mesh.tets.iter().zip(&mesh.regions)) {
        let nodes = spaced(tet.map(|node| tag(node, stride)));
        lines!(text, format_args!("{number} 4 3 -{region} 1 0 {nodes}"));
    }
    lines!(text, "$EndElements", "$NodeData", 1, "\"pressure\"", "$EndNodeData");
    text
}

fn gmsh4(mesh: &TetMesh, stride: u64) -> String {
    let mut text = String::from("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n");
    // Volume 10 + r contains region r; region 0 has no physical group.
    lines!(text, "$Entities", "1 0 1 4", "1 0 0 0 0", "5 0 0 0 1 1 1 1 3 0");
    lines!(text, "10 0 0 0 1 1 1 0 1 5");
    for region in 1..4 {
        lines!(text, format_args!("{} 0 0 0 1 1 1 1 {region} 1 5", 10 + region));
    }
    let (nodes, half) = (mesh.nodes_m.len(), mesh.nodes_m.len() / 2);
    lines!(text, "$EndEntities", "$Nodes", format_args!("3 {nodes} 1 {nodes}"));
    lines!(text, "0 1 0 0");
    for (header, from, to, parameters) in [("2 5 1", 0, half, " 0.5 0.25"), ("3 10 0", half, nodes, "")] {
        lines!(text, format_args!("{header} {}", to - from));
        for node in from..to {
            lines!(text, tag(u32::try_from(node).unwrap(), stride));
        }
        for at in &mesh.nodes_m[from..to] {
            lines!(text, format_args!("{}{parameters}", spaced(at)));
        }
    }
    let tets: Vec<_> = mesh.tets.iter().zip(&mesh.regions).zip(2..).collect();
    let runs: Vec<_> = tets.chunk_by(|((_, a), _), ((_, b), _)| a == b).collect();
    let count = tets.len() + 1;
    lines!(text, "$EndNodes", "$Elements", format_args!("{} {count} 1 {count}", runs.len() + 1));
    lines!(text, "2 5 2 1", "1 1 2 3");
    for run in runs {
        let ((_, region), _) = run[0];
        lines!(text, format_args!("3 {} 4 {}", 10 + region, run.len()));
        for ((tet, _), number) in run {
            lines!(text, format_args!("{number} {}", spaced(tet.map(|node| tag(node, stride)))));
        }
    }
    lines!(text, "$EndElements");
    text
}

fn vtk(mesh: &TetMesh, version: &str, cells: &str) -> String {
    let mut text = format!("# vtk DataFile Version {version}\n\nASCII\nDATASET UNSTRUCTURED_GRID\n");
    lines!(text, "FIELD FieldData 1", "TIME 1 1 double", "0.5");
    lines!(text, format_args!("POINTS {} double", mesh.nodes_m.len()));
    // Three points per line, as VTK itself writes them.
    for points in mesh.nodes_m.chunks(3) {
        lines!(text, spaced(points.iter().flatten()));
    }
    lines!(text, "METADATA", "INFORMATION 0", "");
    text.push_str(cells);
    lines!(text, format_args!("CELL_TYPES {}", mesh.tets.len() + 1), 5);
    for _ in &mesh.tets {
        lines!(text, 10);
    }
    lines!(text, "CELL_DATA 1", "SCALARS material int 1", "LOOKUP_TABLE default", 1);
    text
}

fn vtk_cells_4(mesh: &TetMesh) -> String {
    let count = mesh.tets.len();
    let mut text = format!("CELLS {} {}\n3 0 1 2\n", count + 1, 5 * count + 4);
    for tet in &mesh.tets {
        lines!(text, format_args!("4 {}", spaced(tet)));
    }
    text
}

fn vtk_cells_5(mesh: &TetMesh) -> String {
    let count = mesh.tets.len();
    let offsets = (0..=count).map(|cell| 4 * cell + 3);
    let mut text = format!("CELLS {} {}\n", count + 2, 4 * count + 3);
    lines!(text, "OFFSETS vtktypeint64", format_args!("0 {}", spaced(offsets)));
    lines!(text, "CONNECTIVITY vtktypeint64", "0 1 2", spaced(mesh.tets.iter().flatten()));
    text
}
