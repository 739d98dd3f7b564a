//! Files of other programs, each with the body that independent readers find in it.

use std::path::PathBuf;

use palpate_tissue::mesh::import::{MeshFile, open};
use palpate_tissue::scene::Scene;
use palpate_tissue::session::Session;

fn case(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("data/field").join(name)
}

#[test]
fn every_file_holds_its_body() {
    // volume [cm^3], tets or triangles, number of notes
    for (name, volume_cm3, elements, notes) in [
        ("binary-vtk-with-a-blank-line/blank.vtk", 10.667, 1, 0),
        ("cavity-roof-is-fixed/hollow.stl", 106.612, 512, 0),
        ("closed-surface-as-vtk-polydata/surface.vtk", 10.667, 4, 0),
        ("concave-polygon-in-obj/l-prism.obj", 81.0, 20, 0),
        ("mixed-solids-lose-half-the-body/mixed.msh", 72.0, 648, 1),
        ("obj-lines-of-other-programs/comment.obj", 10.667, 4, 0),
        ("obj-lines-of-other-programs/continued.obj", 10.667, 4, 0),
        ("obj-lines-of-other-programs/faces-first.obj", 10.667, 4, 0),
        ("one-triangle-twice/twice.stl", 109.27, 320, 1),
        ("tet-in-two-physical-groups/two-groups.msh", 10.667, 1, 1),
        ("thin-body-nearest-has-0/two.stl", 20.0, 12, 0),
    ] {
        let (found_m3, found, found_notes) = match open(&case(name), 1e-3).unwrap() {
            MeshFile::Tets(imported) => (imported.report.volume_m3, imported.report.tets, imported.report.notes()),
            MeshFile::Surface(imported) => (imported.report.volume_m3, imported.report.triangles, imported.report.notes()),
        };
        assert!((found_m3 * 1e6 - volume_cm3).abs() < 1e-3, "{name}: {} cm^3", found_m3 * 1e6);
        assert_eq!((found, found_notes.len()), (elements, notes), "{name}: {found_notes:?}");
    }
}

fn prepared(name: &str) -> Result<Session, String> {
    let scene = Scene::load(case(name).to_str().unwrap()).unwrap();
    Session::prepare(&scene).map_err(|error| error.to_string())
}

#[test]
fn no_support_lies_on_the_roof_of_a_cavity() {
    let session = prepared("cavity-roof-is-fixed/hollow.toml").unwrap();
    let mesh = session.patch.mesh();
    for anchor in session.patch.wide_model().anchors {
        let [x, y, z] = mesh.nodes_m[usize::from(*anchor)];
        let off_mm = 1e3 * (x * x + y * y + (z + 0.015) * (z + 0.015)).sqrt();
        assert!(off_mm > 7.5 && z < -0.02, "a support {off_mm} mm from the middle of the cavity, {z} m high");
    }
    assert_eq!(palpate_tissue::mesh::surface::hollows(&mesh), 1);
}

#[test]
fn a_pointed_place_keeps_its_point_and_gets_fine_elements() {
    let session = prepared("pointed-place-gets-coarse-elements/case.toml").unwrap();
    assert!(session.report.element_mm < 4.0, "{} mm", session.report.element_mm);
    let top_m = session.patch.mesh().nodes_m.iter().map(|x| x[2]).fold(f64::MIN, f64::max);
    assert!((top_m - 0.068).abs() < 1e-6, "{top_m}");
}

#[test]
fn what_no_mesh_can_hold_is_refused_with_what_works() {
    let coarse = prepared("coarse-organ-no-force/case.toml").unwrap_err();
    assert!(coarse.contains("has elements of 21.5 mm at the site") && coarse.contains("palpate fit --scene "), "{coarse}");
    let thin = prepared("thin-body-nearest-has-0/sheet.toml").unwrap_err();
    assert!(thin.contains("0.6 mm thick") && !thin.contains("nodes = "), "{thin}");
}

#[test]
fn a_mesh_far_from_the_origin_is_refused_with_the_way_back() {
    let text = std::fs::read_to_string(case("obj-lines-of-other-programs/comment.obj")).unwrap();
    let far = text.replace("v 0 0 0", "v 0 0 20000").replace("v 40 0 0", "v 40 0 20000").replace("v 0 40 0", "v 0 40 20000");
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("far.obj");
    std::fs::write(&path, far.replace("v 0 0 40", "v 0 0 20040")).unwrap();
    let refusal = open(&path, 1e-3).map(|_| ()).unwrap_err().to_string();
    assert!(
        refusal.contains("lies up to 20 m from the origin") && refusal.contains("move it by (-20, -20, -20020)"),
        "{refusal}"
    );
}

/// The table of the guide names what the readers do.
#[test]
fn the_guide_lists_what_is_read() {
    let guide = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../host-sim/book/src/guide/mesh.md");
    let guide = std::fs::read_to_string(guide).unwrap();
    let dir = tempfile::tempdir().unwrap();
    let read = |name: &str, content: &str| {
        let path = dir.path().join(name);
        std::fs::write(&path, content).unwrap();
        open(&path, 1e-3).map(|_| ()).map_err(|error| error.defect.to_string())
    };
    let faces = "3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n";
    let points = "0 0 0\n40 0 0\n0 40 0\n0 0 40\n";
    let gmsh = |version: &str, element: &str| {
        let nodes = "$Nodes\n4\n1 0 0 0\n2 40 0 0\n3 0 40 0\n4 0 0 40\n$EndNodes\n";
        format!("$MeshFormat\n{version} 0 8\n$EndMeshFormat\n{nodes}$Elements\n1\n{element}\n$EndElements\n")
    };
    let block = "$Nodes\n1 4\n1 3 0 4\n1 0 0 0\n2 40 0 0\n3 0 40 0\n4 0 0 40\n$EndNodes\n$Elements\n1 1\n1 3 4 1\n1 1 2 3 4\n$EndElements\n";
    let rows = [
        ("| Gmsh `.msh` 2.0 to 2.2 |", read("a.msh", &gmsh("2.0", "1 4 0 1 2 3 4"))),
        ("| Gmsh `.msh` 4.0, 4.1 |", read("a.msh", &format!("$MeshFormat\n4 0 8\n$EndMeshFormat\n{block}"))),
        (
            "| PLY |",
            read(
                "a.ply",
                &format!(
                    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 4\nproperty list uchar int vertex_index\nend_header\n{points}{faces}"
                ),
            ),
        ),
        (
            "| VTK `.vtk` 1.0 to 5.1 |",
            read(
                "a.vtk",
                &format!(
                    "# vtk DataFile Version 1.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 4 float\n{points}POLYGONS 4 16\n{faces}"
                ),
            ),
        ),
    ];
    for (row, result) in rows {
        assert!(guide.contains(row), "{row}");
        assert_eq!(result, Ok(()), "{row}");
    }
    let refused = read("a.msh", &gmsh("2.2", "1 29 0 1 2 3 4")).unwrap_err();
    assert!(guide.contains("solids of higher order, polyhedra | refused") && refused.starts_with("1 tet of higher order"));
}
