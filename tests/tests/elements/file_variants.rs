//! One body in every legal variant of every format, each read to the same body.

use std::fmt::Write;

use palpate_tests::surface_text::{Triangles, ball};
use palpate_tissue::mesh::import::{MeshFile, open};
use proptest::prelude::*;
use proptest::sample::select;

fn open_bytes(name: &str, content: &[u8]) -> MeshFile {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join(name);
    std::fs::write(&path, content).unwrap();
    open(&path, 1e-3).unwrap_or_else(|error| panic!("{error}\n{}", String::from_utf8_lossy(content)))
}

/// A box of 20 x 20 x 30 mm in solids of one or two kinds: cubes, prisms or pyramids with tets.
pub(crate) struct Solids {
    nodes: Vec<[f64; 3]>,
    /// Kind by its number of nodes, and node indices.
    solids: Vec<(usize, Vec<usize>)>,
}

pub(crate) fn solids(kind: &str) -> Solids {
    let mut nodes = Vec::new();
    for k in 0..4 {
        for j in 0..3 {
            for i in 0..3 {
                nodes.push([i, j, k].map(|n| 10.0 * f64::from(n)));
            }
        }
    }
    let mut solids = Vec::new();
    for (i, j, k) in (0..12).map(|n| (n % 2, n / 2 % 2, n / 4)) {
        let node = |a: usize, b: usize, c: usize| i + a + 3 * (j + b) + 9 * (k + c);
        let h = [
            node(0, 0, 0),
            node(1, 0, 0),
            node(1, 1, 0),
            node(0, 1, 0),
            node(0, 0, 1),
            node(1, 0, 1),
            node(1, 1, 1),
            node(0, 1, 1),
        ];
        match kind {
            "hexahedra" => solids.push((8, h.to_vec())),
            "prisms" => {
                solids.push((6, vec![h[0], h[1], h[2], h[4], h[5], h[6]]));
                solids.push((6, vec![h[0], h[2], h[3], h[4], h[6], h[7]]));
            }
            "mixed" if (i + j + k) % 2 == 0 => solids.push((8, h.to_vec())),
            _ => {
                let middle = nodes.len();
                nodes.push([0, 1, 2].map(|axis| h.iter().map(|n| nodes[*n][axis]).sum::<f64>() / 8.0));
                for q in [[0, 1, 2, 3], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]] {
                    solids.push((5, q.map(|n| h[n]).into_iter().chain([middle]).collect()));
                }
            }
        }
    }
    Solids { nodes, solids }
}

/// Ends of lines, blank lines and what stands between words.
#[derive(Clone, Debug)]
struct Layout {
    end: &'static str,
    space: &'static str,
    blank: bool,
    trailing: &'static str,
}

fn layout() -> impl Strategy<Value = Layout> {
    let trailing = select(vec!["", "\n\n", "\0\0", "\u{1a}"]);
    (select(vec!["\n", "\r\n", "\r"]), select(vec![" ", "  ", "\t"]), any::<bool>(), trailing)
        .prop_map(|(end, space, blank, trailing)| Layout { end, space, blank, trailing })
}

impl Layout {
    fn apply(&self, text: &str) -> Vec<u8> {
        let end = if self.blank { format!("{}{}", self.end, self.end) } else { self.end.to_owned() };
        let mut out = text.replace(' ', self.space).replace('\n', &end);
        out.push_str(self.trailing);
        out.into_bytes()
    }

    /// The layout of all but the first lines, whose place in a file is fixed.
    fn apply_below(&self, lines: usize, text: &str) -> Vec<u8> {
        let head: usize = text.split_inclusive('\n').take(lines).map(str::len).sum();
        let (head, rest) = text.split_at(head);
        [head.replace('\n', self.end).into_bytes(), self.apply(rest)].concat()
    }
}

pub(crate) fn gmsh(body: &Solids, version: &str, groups: usize, nodes_last: bool) -> String {
    let code = |nodes: usize| match nodes {
        8 => 5,
        6 => 6,
        5 => 7,
        _ => 4,
    };
    let row = |items: &[usize]| items.iter().map(|n| (n * 3 + 7).to_string()).collect::<Vec<_>>().join(" ");
    let place = |at: &[f64; 3]| at.map(|x| x.to_string()).join(" ");
    let mut nodes = String::new();
    let mut elements = String::new();
    let (n, count) = (body.nodes.len(), body.solids.len());
    match version {
        "4.1" | "4.0" => {
            let minmax = if version == "4.1" { " 7 9999" } else { "" };
            let _ = writeln!(nodes, "$Nodes\n1 {n}{minmax}\n{} 0 {n}", if version == "4.1" { "3 1" } else { "1 3" });
            if version == "4.1" {
                (0..n).for_each(|k| writeln!(nodes, "{}", row(&[k])).unwrap());
                body.nodes.iter().for_each(|at| writeln!(nodes, "{}", place(at)).unwrap());
            } else {
                body.nodes.iter().enumerate().for_each(|(k, at)| writeln!(nodes, "{} {}", row(&[k]), place(at)).unwrap());
            }
            let _ = writeln!(elements, "$Elements\n{count} {count}{}", if version == "4.1" { " 1 9999" } else { "" });
            for (k, (kind, solid)) in body.solids.iter().enumerate() {
                let entity = if version == "4.1" { "3 1" } else { "1 3" };
                let _ = writeln!(elements, "{entity} {} 1\n{} {}", code(*kind), k + 1, row(solid));
            }
        }
        _ => {
            let _ = writeln!(nodes, "$Nodes\n{n}");
            body.nodes.iter().enumerate().for_each(|(k, at)| writeln!(nodes, "{} {}", row(&[k]), place(at)).unwrap());
            let _ = writeln!(elements, "$Elements\n{}", count * groups);
            for (k, (kind, solid)) in (0..groups).flat_map(|_| &body.solids).enumerate() {
                let _ = writeln!(elements, "{} {} 2 {} 1 {}", k + 1, code(*kind), k / count + 1, row(solid));
            }
        }
    }
    let (nodes, elements) = (nodes + "$EndNodes\n", elements + "$EndElements\n");
    let head = format!("$MeshFormat\n{version} 0 8\n$EndMeshFormat\n$Comments\nby hand\n$EndComments\n");
    if nodes_last { head + &elements + &nodes } else { head + &nodes + &elements }
}

pub(crate) fn vtk(body: &Solids, is_51: bool, field: bool, types_first: bool) -> String {
    let code = |nodes: usize| match nodes {
        8 => 12,
        6 => 13,
        5 => 14,
        _ => 10,
    };
    let count = body.solids.len();
    let all: usize = body.solids.iter().map(|(n, _)| n).sum();
    let row = |items: &[usize]| items.iter().map(ToString::to_string).collect::<Vec<_>>().join(" ");
    let mut cells = String::new();
    if is_51 {
        let _ = writeln!(cells, "CELLS {} {all}\nOFFSETS vtktypeint64\n0", count + 1);
        let mut end = 0;
        for (n, _) in &body.solids {
            end += n;
            let _ = writeln!(cells, "{end}");
        }
        let _ = writeln!(cells, "CONNECTIVITY vtktypeint64");
        body.solids.iter().for_each(|(_, solid)| writeln!(cells, "{}", row(solid)).unwrap());
    } else {
        let _ = writeln!(cells, "CELLS {count} {}", all + count);
        body.solids.iter().for_each(|(n, solid)| writeln!(cells, "{n} {}", row(solid)).unwrap());
    }
    let types: String = body.solids.iter().map(|(n, _)| format!("{}\n", code(*n))).collect();
    let types = format!("CELL_TYPES {count}\n{types}");
    let field = if field { "FIELD FieldData 2\nTIME 1 1 double\n0.5\nNAME 1 2 int\n1 2\n" } else { "" };
    let points: String = body.nodes.iter().map(|at| at.map(|x| x.to_string()).join(" ") + "\n").collect();
    let (first, second) = if types_first { (&types, &cells) } else { (&cells, &types) };
    format!(
        "# vtk DataFile Version {}\na title\nASCII\nDATASET UNSTRUCTURED_GRID\n{field}POINTS {} double\n{points}{first}{second}CELL_DATA {count}\n",
        if is_51 { "5.1" } else { "3.0" },
        body.nodes.len()
    )
}

fn off(content: &MeshFile) -> (f64, usize) {
    match content {
        MeshFile::Tets(imported) => ((imported.report.volume_m3 * 1e6 - 12.0).abs(), imported.report.nodes),
        MeshFile::Surface(_) => panic!("a surface"),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 120, ..ProptestConfig::default() })]

    #[test]
    fn every_variant_of_solids_is_one_body(
        kind in select(vec!["hexahedra", "prisms", "pyramids", "mixed"]),
        version in select(vec!["2.2", "4.0", "4.1"]),
        groups in 1..4_usize,
        (flag, other, third) in any::<(bool, bool, bool)>(),
        layout in layout(),
    ) {
        let body = solids(kind);
        let read = open_bytes("a.msh", &layout.apply(&gmsh(&body, version, groups, flag)));
        let (off_cm3, nodes) = off(&read);
        prop_assert!(off_cm3 < 1e-9 && nodes == body.nodes.len());
        let MeshFile::Tets(gmsh) = read else { unreachable!() };
        let copies = if version == "2.2" { (groups - 1) * gmsh.report.tets } else { 0 };
        prop_assert_eq!((gmsh.report.copies, gmsh.report.flipped_tets), (copies, 0));
        let content = layout.apply_below(3, &vtk(&body, flag, other, third));
        let MeshFile::Tets(vtk) = open_bytes("a.vtk", &content) else { panic!("a surface") };
        prop_assert_eq!(vtk.mesh.tets, gmsh.mesh.tets);
        prop_assert_eq!(vtk.mesh.nodes_m, gmsh.mesh.nodes_m);
    }

    #[test]
    fn every_variant_of_a_surface_is_one_body(
        stl in (select(vec!["solid a", "SOLID", "solid"]), any::<(bool, bool)>()),
        obj in any::<(bool, bool, bool, bool)>(),
        header in select(vec!["solid made by a CAD program", "binary", ""]),
        trailing in 0..5_usize,
        layout in layout(),
    ) {
        let body = ball(20.0, 1);
        let files = [
            ("a.stl", layout.apply(&stl_text(&body, stl.0, stl.1))),
            ("b.obj", layout.apply(&obj_text(&body, obj))),
            ("c.ply", Layout { blank: false, ..layout.clone() }.apply(&body.ply())),
            ("d.vtk", layout.apply_below(3, &polydata(&body, obj.0, obj.1))),
            ("e.stl", binary_stl(&body, header, trailing)),
            ("f.vtp", polydata_xml(&body, obj.0).into_bytes()),
        ];
        for (name, content) in files {
            let MeshFile::Surface(read) = open_bytes(name, &content) else { panic!("tets") };
            prop_assert_eq!((read.report.triangles, read.report.vertices, read.report.turned_triangles), (32, 18, 0), "{}", name);
            prop_assert!((read.report.volume_m3 * 1e9 / body.volume_mm3() - 1.0).abs() < 1e-6, "{}", name);
        }
    }
}

pub(crate) fn stl_text(body: &Triangles, solid: &str, (apart, one_line): (bool, bool)) -> String {
    let end = if apart { "end " } else { "end" };
    let mut text = format!("{solid}\n");
    let gap = if one_line { " " } else { "\n" };
    for t in &body.triangles {
        let _ = write!(text, "facet normal 0 0 nan{gap}outer loop{gap}");
        for n in t {
            let [x, y, z] = body.corners_mm[*n];
            let _ = write!(text, "vertex {x:.9e} {y:.9e} {z:.9e}{gap}");
        }
        let _ = writeln!(text, "{end}loop{gap}{end}facet");
    }
    text + end + "solid a name\n"
}

pub(crate) fn obj_text(body: &Triangles, (faces_first, continued, comments, backward): (bool, bool, bool, bool)) -> String {
    let vertices: String = body.corners_mm.iter().map(|[x, y, z]| format!("v {x} {y} {z} 1.0\n")).collect();
    let backward = backward && !faces_first;
    let number = |n: usize| if backward { n as i64 - body.corners_mm.len() as i64 } else { n as i64 + 1 };
    let gap = if continued { " \\\n" } else { " " };
    let comment = if comments { " # a face" } else { "" };
    let face = |t: &[usize; 3]| format!("f {}//1{gap}{}/2{gap}{}/3/4{comment}\n", number(t[0]), number(t[1]), number(t[2]));
    let faces: String = body.triangles.iter().map(face).collect();
    let head = "# by hand\nmtllib a.mtl\no ball\n";
    if faces_first { format!("{head}{faces}{vertices}") } else { format!("{head}{vertices}usemtl a\ns off\n{faces}") }
}

pub(crate) fn polydata(body: &Triangles, is_51: bool, strips: bool) -> String {
    let points: String = body.corners_mm.iter().map(|at| at.map(|x| x.to_string()).join(" ") + "\n").collect();
    let count = body.triangles.len();
    let row = |t: &[usize; 3]| format!("{} {} {}\n", t[0], t[1], t[2]);
    let section = if strips { "TRIANGLE_STRIPS" } else { "POLYGONS" };
    let cells = if is_51 {
        let ends: String = (0..=count).map(|k| format!("{}\n", 3 * k)).collect();
        let rows: String = body.triangles.iter().map(row).collect();
        format!("{section} {} {}\nOFFSETS vtktypeint64\n{ends}CONNECTIVITY vtktypeint64\n{rows}", count + 1, 3 * count)
    } else {
        let rows: String = body.triangles.iter().map(|t| format!("3 {}", row(t))).collect();
        format!("{section} {count} {}\n{rows}", 4 * count)
    };
    format!(
        "# vtk DataFile Version {}\nvtk output\nASCII\nDATASET POLYDATA\nPOINTS {} float\n{points}VERTICES 1 2\n1 0\n{cells}POINT_DATA {}\n",
        if is_51 { "5.1" } else { "4.2" },
        body.corners_mm.len(),
        body.corners_mm.len()
    )
    // in version 5.1 the counts of the vertices are those of their lists
    .replace("VERTICES 1 2\n1 0\n", if is_51 { "VERTICES 2 1\nOFFSETS vtktypeint64\n0 1\nCONNECTIVITY vtktypeint64\n0\n" } else { "VERTICES 1 2\n1 0\n" })
}

pub(crate) fn polydata_xml(body: &Triangles, pieces: bool) -> String {
    let points: String = body.corners_mm.iter().map(|at| at.map(|x| x.to_string()).join(" ") + "\n").collect();
    let half = if pieces { body.triangles.len() / 2 } else { 0 };
    let piece = |triangles: &[[usize; 3]]| {
        let rows: String = triangles.iter().map(|t| format!("{} {} {} ", t[0], t[1], t[2])).collect();
        let ends: String = (1..=triangles.len()).map(|k| format!("{} ", 3 * k)).collect();
        format!(
            "<Piece NumberOfPoints=\"{}\" NumberOfPolys=\"{}\"><Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">{points}</DataArray></Points><Polys><DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">{rows}</DataArray><DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">{ends}</DataArray></Polys></Piece>",
            body.corners_mm.len(),
            triangles.len()
        )
    };
    let all: String =
        [&body.triangles[..half], &body.triangles[half..]].into_iter().filter(|p| !p.is_empty()).map(piece).collect();
    format!("<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\"><PolyData>{all}</PolyData></VTKFile>")
}

pub(crate) fn binary_stl(body: &Triangles, header: &str, trailing: usize) -> Vec<u8> {
    let mut bytes = body.binary_stl();
    bytes[..80].fill(b' ');
    bytes[..header.len()].copy_from_slice(header.as_bytes());
    bytes.extend(vec![b'x'; trailing]);
    bytes
}
