//! File formats are recognised by name and content, and some files are refused as a whole.

use crate::mesh_import::{import_text, message};

const ONE_TET: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n$Elements\n1\n1 4 2 9 1 1 2 3 4\n$EndElements\n";

#[test]
fn line_ends_byte_order_mark_and_extension_do_not_matter() {
    let expected = import_text("a.msh", ONE_TET).unwrap();
    assert_eq!(expected.mesh.regions, [9]);
    let dos = ONE_TET.replace('\n', "\r\n");
    let marked = format!("\u{feff}\n{ONE_TET}");
    let spaced = ONE_TET.replace('\n', "  \n\n");
    for (name, text) in [("a.msh", &dos), ("a.MSH", &marked), ("mesh", &spaced), ("a.txt", &dos)] {
        assert_eq!(import_text(name, text).unwrap(), expected, "{text:?}");
    }
}

#[test]
fn unused_nodes_are_left_out_and_counted() {
    let text = ONE_TET.replace("$Nodes\n4\n", "$Nodes\n6\n90 7 7 7\n").replace("3 0 1 0\n", "3 0 1 0\n80 7 7 7\n");
    let imported = import_text("a.msh", &text).unwrap();
    assert_eq!(imported.report.unused_nodes, 2);
    assert_eq!(imported.mesh, import_text("a.msh", ONE_TET).unwrap().mesh);
}

#[test]
fn what_is_not_read_is_refused_by_name() {
    let vtk = "# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\n";
    for (name, text, expected) in [
        ("a.msh", String::new(), "a.msh: the file is empty: re-export the mesh"),
        ("a.msh", " \n".into(), "a.msh: the file is empty: re-export the mesh"),
        (
            "a.stl",
            "solid organ\nfacet".into(),
            "a.stl: no triangles: export the surface again, triangulated",
        ),
        (
            "a.1.node",
            "4  3  0  0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n".into(),
            "a.1.node: unknown mesh format (starts with `4  3  0  0`): export as Gmsh 2.2 or 4.1 (.msh), as VTK (.vtu, .vtk), as USD text (.usda), or as a closed surface (.stl, .obj, .ply, .vtp)",
        ),
        ("a.vtu", "<?xml version=\"1.0\"?>\n".into(), "a.vtu:1: not sound XML (the document does not have a root node): re-export the mesh"),
        ("a.vtu", "<VTKFile>".into(), "a.vtu:1: not sound XML (the root node was opened but never closed): re-export the mesh"),
        (
            "a.vtu",
            "<VTKFile type=\"ImageData\"/>".into(),
            "a.vtu:1: XML VTK of type `ImageData` is not read: export as UnstructuredGrid (.vtu), or a surface as PolyData (.vtp)",
        ),
        (
            "a.pvtu",
            "<VTKFile type=\"PUnstructuredGrid\"/>".into(),
            "a.pvtu:1: a list of files with the pieces of a mesh: give one file (ParaView: Merge Blocks, then Save Data)",
        ),
        (
            "a.vtu",
            "<VTKFile type=\"UnstructuredGrid\" compressor=\"vtkLZ4DataCompressor\"><UnstructuredGrid><Piece/></UnstructuredGrid></VTKFile>".into(),
            "a.vtu:1: VTK compressor `vtkLZ4DataCompressor` is not read: export with zlib or uncompressed",
        ),
        ("a.msh", ONE_TET.replace("2.2 0 8", "2.2 2 8"), "a.msh:2: expected the file type 0 (ASCII) or 1 (binary), found `2`: fix the line or re-export the mesh"),
        ("a.msh", ONE_TET.replace("2.2 0", "4.2 0"), "a.msh:2: Gmsh version `4.2` is not read: export as Gmsh 2.2 or 4.1"),
        ("a.msh", ONE_TET.replace("2.2 0", "9 0"), "a.msh:2: Gmsh version `9` is not read: export as Gmsh 2.2 or 4.1"),
        (
            "a.msh",
            ONE_TET.replace("$Nodes", "$PartitionedEntities"),
            "a.msh:4: a partitioned mesh is not read: export it as one partition",
        ),
        (
            "a.msh",
            ONE_TET.replace("1 4 2 9 1 1 2 3 4", "1 29 2 9 1 1 2 3 4 5 6 7 8 9 10"),
            "a.msh: 1 tet of higher order would be left out of the body: export tets, pyramids, prisms or hexahedra, of first or second order (Gmsh: Tools, Options, Mesh, Element order 1)",
        ),
        ("a.vtk", vtk.replace("ASCII", "HEX"), "a.vtk:3: expected the word ASCII or BINARY, found `HEX`: fix the line or re-export the mesh"),
        ("a.vtk", vtk.replace("ASCII", "BINARY"), "a.vtk: no POINTS: re-export the mesh with its nodes and tets"),
        ("a.vtk", vtk.replace("3.0", "9.0"), "a.vtk:1: legacy VTK version `9.0` is not read: export as version 2.0 to 5.1"),
        (
            "a.vtk",
            vtk.replace("UNSTRUCTURED_GRID", "STRUCTURED_POINTS"),
            "a.vtk:4: VTK data set `STRUCTURED_POINTS` is not read: export tets as UNSTRUCTURED_GRID or a surface as POLYDATA (a segmented image: 3D Slicer, Segmentations, Export to models)",
        ),
        (
            "a.vtk",
            format!("{vtk}POINTS 1 float 0 0 0 CELLS 1 11 10 0 0 0 0 0 0 0 0 0 0 CELL_TYPES 1 42"),
            "a.vtk: 1 polyhedron would be left out of the body: export tets, pyramids, prisms or hexahedra, of first or second order (Gmsh: Tools, Options, Mesh, Element order 1)",
        ),
    ] {
        assert_eq!(message(import_text(name, &text)), expected);
    }
}

#[test]
fn a_path_that_is_no_file_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let import = |path: &std::path::Path, unit| message(palpate_tissue::mesh::import::import(path, unit));
    assert!(import(&dir.path().join("none.msh"), 1.0).starts_with("none.msh: cannot read the file ("));
    let folder = dir.path().join("folder.msh");
    std::fs::create_dir(&folder).unwrap();
    assert_eq!(import(&folder, 1.0), "folder.msh: not a regular file: give the path of a mesh file");
    for unit in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(import(&folder, unit).starts_with("folder.msh: length unit of "));
    }
}

#[test]
fn a_file_larger_than_any_mesh_that_fits_is_not_read() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.msh");
    // A sparse file, because only its length matters.
    let file = std::fs::File::create(&path).unwrap();
    file.set_len((512 << 20) + 1).unwrap();
    assert_eq!(
        message(palpate_tissue::mesh::import::import(&path, 1.0)),
        "a.msh: larger than 512 MiB: export only the volume mesh, without results"
    );
}

#[test]
fn control_characters_of_a_file_do_not_reach_the_message() {
    let text = ONE_TET.replace("2 1 0 0", "2 1 0\u{1b}[2J 0");
    assert_eq!(
        message(import_text("a.msh", &text)),
        "a.msh:7: expected a coordinate, found `0\u{fffd}[2J`: fix the line or re-export the mesh"
    );
    let error = palpate_tissue::mesh::import::import("no\nfile.msh".as_ref(), 1.0).unwrap_err();
    assert_eq!(error.file, "no\u{fffd}file.msh");
}
