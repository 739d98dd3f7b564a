//! The tables of the guide's page on meshes: each row is what the readers do, and they do no more.

use std::collections::BTreeMap;

use palpate_tests::palpate_command::repository;
use palpate_tests::surface_text::{Triangles, ball, projective_plane};
use palpate_tissue::mesh::import::{MeshFile, open};
use palpate_tissue::mesh::{ImportReport, SurfaceReport};
use palpate_tissue::session::coarse::COARSEST_RADII;

use crate::file_variants::{gmsh, polydata, polydata_xml, solids};
use crate::mesh_import::block::regular;
use crate::mesh_import::encode::{Order, Xml};
use crate::mesh_import::write::{Format, write};
use crate::usd_text::TET;

/// Cells of the rows of a table, which begins with this header.
fn rows(header: &str) -> Vec<Vec<String>> {
    let guide = std::fs::read_to_string(repository().join("host-sim/book/src/guide/mesh.md")).unwrap();
    let lines = guide.lines().skip_while(|line| !line.starts_with(header)).skip(2).take_while(|line| line.starts_with('|'));
    let cells = |line: &str| line.trim_matches('|').split('|').map(|cell| cell.trim().to_owned()).collect();
    lines.map(cells).collect()
}

fn read(name: &str, content: &[u8]) -> Result<MeshFile, String> {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join(name);
    std::fs::write(&path, content).unwrap();
    open(&path, if name.starts_with('m') { 1.0 } else { 1e-3 }).map_err(|error| error.defect.to_string())
}

/// A tet in Gmsh 2.0, or its four faces.
fn gmsh_text(version: &str, faces: bool) -> String {
    let nodes = "$Nodes\n4\n1 0 0 0\n2 40 0 0\n3 0 40 0\n4 0 0 40\n$EndNodes\n";
    let elements = if faces { "4\n1 2 0 1 3 2\n2 2 0 1 2 4\n3 2 0 2 3 4\n4 2 0 1 4 3" } else { "1\n1 4 0 1 2 3 4" };
    format!("$MeshFormat\n{version} 0 8\n$EndMeshFormat\n{nodes}$Elements\n{elements}\n$EndElements\n")
}

const GMSH_1: &str = "$NOD\n4\n1 0 0 0\n2 40 0 0\n3 0 40 0\n4 0 0 40\n$ENDNOD\n$ELM\n4\n1 2 1 1 3 1 3 2\n2 2 1 1 3 1 2 4\n3 2 1 1 3 2 3 4\n4 2 1 1 3 1 4 3\n$ENDELM\n";
const GMSH_4_FACES: &str = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 4 1 4\n3 1 0 4\n1\n2\n3\n4\n0 0 0\n40 0 0\n0 40 0\n0 0 40\n$EndNodes\n$Elements\n1 4 1 4\n2 1 2 4\n1 1 3 2\n2 1 2 4\n3 2 3 4\n4 1 4 3\n$EndElements\n";

fn polygons_in_vtu(body: &Triangles) -> String {
    let text = polydata_xml(body, false);
    let cells = text.replace("PolyData", "UnstructuredGrid").replace("Polys", "Cells");
    let types = "5 ".repeat(body.triangles.len());
    let cells = cells
        .replace("</Cells>", &format!("<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">{types}</DataArray></Cells>"));
    cells.replace("NumberOfUnstructuredGrid", "NumberOfCells")
}

/// Name of a file, its content, and whether that is text.
type Example = (&'static str, Vec<u8>, bool);

#[test]
fn every_format_is_read_as_the_guide_says() {
    let (mesh, small) = (regular([2; 3]), ball(20.0, 1));
    let of = |format| write(format, &mesh, 3).1;
    let ply = small.ply();
    let binary_ply = {
        let end = ply.find("end_header\n").unwrap() + "end_header\n".len();
        let mut bytes = ply[..end].replace("ascii", "binary_little_endian").into_bytes();
        bytes.extend(small.corners_mm.iter().flatten().flat_map(|x| (*x as f32).to_le_bytes()));
        for triangle in &small.triangles {
            bytes.push(3);
            bytes.extend(triangle.iter().flat_map(|n| (*n as u32).to_le_bytes()));
        }
        bytes
    };
    let vtu = |xml| of(Format::Vtu(xml, Order::Little, false, false));
    let mut files: BTreeMap<&str, Vec<Example>> = BTreeMap::new();
    let text = |content: String| content.into_bytes();
    files.insert("Gmsh `.msh` 1", vec![("m.msh", of(Format::Gmsh1), true), ("a.msh", text(GMSH_1.into()), true)]);
    files.insert(
        "Gmsh `.msh` 2.0 to 2.2",
        vec![
            ("a.msh", text(gmsh_text("2.0", false)), true),
            ("a.msh", text(gmsh_text("2.1", true)), true),
            ("m.msh", of(Format::Gmsh2Binary(Order::Big)), false),
        ],
    );
    files.insert(
        "Gmsh `.msh` 4.0, 4.1",
        vec![
            ("a.msh", text(gmsh(&solids("prisms"), "4.0", 1, false)), true),
            ("m.msh", of(Format::Gmsh4Binary(Order::Little)), false),
            ("a.msh", text(GMSH_4_FACES.into()), true),
        ],
    );
    files.insert(
        "VTK `.vtk` 1.0 to 5.1",
        vec![
            ("m.vtk", of(Format::Vtk5), true),
            ("m.vtk", of(Format::Vtk4Binary), false),
            ("a.vtk", text(polydata(&small, false, false).replace("Version 4.2", "Version 1.0")), true),
        ],
    );
    files.insert(
        "VTK `.vtu`",
        vec![
            ("m.vtu", vtu(Xml::Ascii), true),
            ("m.vtu", vtu(Xml::AppendedRaw), false),
            ("a.vtu", text(polygons_in_vtu(&small)), true),
        ],
    );
    files.insert("USD `.usda`", vec![("a.usda", text(TET.into()), true)]);
    let encoded = polydata_xml(&small, false);
    files.insert("VTK `.vtp`", vec![("a.vtp", text(encoded.clone()), true), ("a.vtp", in_base64(&encoded), false)]);
    files.insert("STL", vec![("a.stl", text(small.stl()), true), ("a.stl", small.binary_stl(), false)]);
    files.insert("OBJ", vec![("a.obj", text(small.obj()), true)]);
    files.insert("PLY", vec![("a.ply", text(ply), true), ("a.ply", binary_ply, false)]);

    let listed = rows("| file | text |");
    assert_eq!(listed.len(), files.len(), "{listed:?}");
    for row in listed {
        let found: Vec<[bool; 4]> = files[row[0].as_str()]
            .iter()
            .map(|(name, content, is_text)| {
                let solids = matches!(read(name, content).unwrap_or_else(|why| panic!("{row:?}: {why}")), MeshFile::Tets(_));
                [*is_text, !is_text, solids, !solids]
            })
            .collect();
        let any = [0, 1, 2, 3].map(|k| if found.iter().any(|one| one[k]) { "yes" } else { "-" });
        assert_eq!(any.map(str::to_owned).as_slice(), &row[1..5], "{}", row[0]);
    }
}

/// A document with its arrays in base64.
fn in_base64(document: &str) -> Vec<u8> {
    use base64::Engine;
    let mut out = String::new();
    let mut rest = document;
    while let Some(at) = rest.find("<DataArray") {
        let end = at + rest[at..].find('>').unwrap();
        let close = end + rest[end..].find("</DataArray>").unwrap();
        let (head, values) = (&rest[..=end], &rest[end + 1..close]);
        let is_real = head[at..].contains("Float64");
        let bytes: Vec<u8> = values
            .split_whitespace()
            .flat_map(|word| match is_real {
                true => word.parse::<f64>().unwrap().to_le_bytes(),
                false => word.parse::<i64>().unwrap().to_le_bytes(),
            })
            .collect();
        let all = [&(bytes.len() as u32).to_le_bytes(), bytes.as_slice()].concat();
        out += &head.replace("format=\"ascii\"", "format=\"binary\"");
        out += &base64::prelude::BASE64_STANDARD.encode(all);
        rest = &rest[close..];
    }
    (out + rest).into_bytes()
}

fn body(content: &str) -> ImportReport {
    match read("a.msh", content.as_bytes()) {
        Ok(MeshFile::Tets(imported)) => imported.report,
        other => panic!("{other:?}"),
    }
}

fn skin(surface: &Triangles) -> Result<SurfaceReport, String> {
    read("a.obj", surface.obj().as_bytes()).map(|read| match read {
        MeshFile::Surface(imported) => imported.report,
        MeshFile::Tets(_) => panic!("tets"),
    })
}

fn reversed(mut surface: Triangles) -> Triangles {
    surface.triangles.iter_mut().for_each(|triangle| triangle.swap(0, 1));
    surface
}

/// A body of one element of second order, all of whose nodes are where those of the first order
/// would be.
fn second_order(code: u32, corners: &[[f64; 3]], edges: &[[usize; 2]]) -> String {
    let middle = |[a, b]: &[usize; 2]| [0, 1, 2].map(|k| 0.5 * (corners[*a][k] + corners[*b][k]));
    let nodes: Vec<[f64; 3]> = corners.iter().copied().chain(edges.iter().map(middle)).collect();
    let numbers = (1..=nodes.len()).map(|n| n.to_string()).collect::<Vec<_>>().join(" ");
    let places: String = (1..).zip(&nodes).map(|(n, [x, y, z])| format!("{n} {x} {y} {z}\n")).collect();
    format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{}\n{places}$EndNodes\n$Elements\n1\n1 {code} 0 {numbers}\n$EndElements\n",
        nodes.len()
    )
}

#[test]
fn every_content_becomes_what_the_guide_says() {
    let tet = [[0.0, 0.0, 0.0], [40.0, 0.0, 0.0], [0.0, 40.0, 0.0], [0.0, 0.0, 40.0]];
    let pyramid = [[0.0, 0.0, 0.0], [40.0, 0.0, 0.0], [40.0, 40.0, 0.0], [0.0, 40.0, 0.0], [20.0, 20.0, 40.0]];
    let says = |content: Result<SurfaceReport, String>, words: &str| content.unwrap_err().contains(words);
    let mut dented = ball(30.0, 4);
    let at = dented.corners_mm[300];
    dented.corners_mm[300] = [0, 1, 2].map(|k| at[k] + 3.5 * (dented.corners_mm[301][k] - at[k]));
    let mut pierced = ball(30.0, 2);
    pierced.corners_mm[4][2] = -40.0;
    let mut open = ball(30.0, 2);
    open.triangles.pop();
    let case = |name: &str| std::fs::read_to_string(repository().join("tests/data/field").join(name)).unwrap();
    let l_prism = read("a.obj", case("concave-polygon-in-obj/l-prism.obj").as_bytes());
    let hollow = ball(30.0, 2).and(&reversed(ball(10.0, 2)));
    let label = ball(30.0, 2).and(&ball(10.0, 2));
    let far = ball(30.0, 2).moved([11_000.0, 0.0, 0.0]);
    let inverted = gmsh_text("2.2", false).replace("1 2 3 4\n$EndE", "1 3 2 4\n$EndE");
    let coarse = format!("elements at the site larger than {COARSEST_RADII} probe radii");
    let edges = [[0, 1], [1, 2], [2, 0], [0, 3], [2, 3], [1, 3]];
    let checks: Vec<(&str, bool)> = vec![
        ("tets", body(&inverted).flipped_tets == 1 && body(&inverted).tets == 1),
        ("pyramids, prisms, hexahedra", !body(&gmsh(&solids("mixed"), "2.2", 1, false)).divided.is_empty()),
        ("tets of second order", body(&second_order(11, &tet, &edges)).tets == 8),
        (
            "other solids of second order",
            !body(&second_order(19, &pyramid, &[[0, 1], [0, 3], [0, 4], [1, 2], [1, 4], [2, 3], [2, 4], [3, 4]]))
                .by_corners
                .is_empty(),
        ),
        (
            "solids of higher order, polyhedra",
            read("a.msh", gmsh_text("2.2", false).replace("1 4 0", "1 29 0").as_bytes())
                .is_err_and(|why| why.starts_with("1 tet of higher order")),
        ),
        (
            "the same element or triangle twice",
            body(&gmsh(&solids("prisms"), "2.2", 2, false)).copies > 0
                && skin(&{
                    let mut twice = ball(30.0, 1);
                    twice.triangles.push(twice.triangles[0]);
                    twice
                })
                .is_ok_and(|report| report.copies == 1 && report.notes().len() == 1),
        ),
        ("several pieces in one `.vtu` or `.vtp`", read("a.vtp", polydata_xml(&ball(20.0, 1), true).as_bytes()).is_ok()),
        ("polygons, convex or not", matches!(l_prism, Ok(MeshFile::Surface(read)) if read.report.triangles == 20)),
        ("an inner surface that faces inward", skin(&hollow).is_ok_and(|report| (report.hollows, report.labels) == (1, 0))),
        (
            "an inner surface that faces outward",
            skin(&label).is_ok_and(|report| (report.hollows, report.labels, report.notes().len()) == (0, 1, 1)),
        ),
        ("triangles that cross, up to 1 % of the surface", skin(&dented).is_ok_and(|report| report.crossings.is_some())),
        ("more that cross", says(skin(&pierced), "the surface passes through itself")),
        ("a surface that is open", says(skin(&open), "the surface is open: 3 edges")),
        ("a surface with one side", says(skin(&projective_plane()), "has one side only, near (")),
        ("several bodies", says(skin(&ball(30.0, 2).and(&ball(30.0, 2).moved([90.0, 0.0, 0.0]))), "2 separate closed surfaces")),
        ("a body farther than 10 m from the origin", says(skin(&far), "(at most 10 m): move it by (-11000, 0, 0)")),
        // that it is refused is tested with the file of such an organ
        (&coarse, true),
    ];
    let listed: Vec<String> = rows("| content |").into_iter().map(|row| row[0].clone()).collect();
    assert_eq!(listed, checks.iter().map(|(row, _)| (*row).to_owned()).collect::<Vec<_>>());
    for (row, holds) in checks {
        assert!(holds, "{row}");
    }
}
