//! The error for every mesh defect names its position and its remedy.

use crate::mesh_import::{import_text, message};

/// Two tets that share a face; node 9 is unused and has the same position as node 1.
pub const TWO_TETS: &str = "$NOD\n6\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1\n9 0 0 0\n$ENDNOD\n$ELM\n2\n1 4 1 1 4 1 2 3 4\n17 4 1 1 4 2 3 4 5\n$ENDELM\n";

/// `TWO_TETS` with one text, which must occur, replaced by another.
pub fn edited(from: &str, to: &str) -> String {
    assert!(TWO_TETS.contains(from), "{from}");
    TWO_TETS.replace(from, to)
}

#[test]
fn the_fixture_is_sound() {
    let imported = import_text("a.msh", TWO_TETS).unwrap();
    assert_eq!(imported.mesh.tets, [[0, 1, 2, 3], [1, 2, 3, 4]]);
}

#[test]
fn each_defect_of_the_mesh_has_its_own_line() {
    let last = "17 4 1 1 4 2 3 4 5";
    for (from, to, expected) in [
        (
            last,
            "17 4 1 1 4 2 3 4 999",
            "a.msh:13: tet 17 names node 999, but none of the file's 6 nodes has that number: fix the element or re-export the mesh",
        ),
        (last, "17 4 1 1 4 2 3 4 4", "a.msh:13: tet 17 names node 4 twice: remove the element"),
        ("5 1 1 1\n", "4 1 1 1\n", "a.msh:7: node 4 is already on line 6: renumber the nodes"),
        ("5 1 1 1\n", "5 0 -0 0\n", "a.msh:7: node 5 is exactly where node 1 is (line 3): merge duplicate nodes"),
        (
            "5 1 1 1\n",
            "5 0.25 0.5 0.25\n",
            "a.msh:13: tet 17 is flat (quality 0.0e0, regular 1, least 1e-4): optimise the mesh to remove slivers",
        ),
        (
            "5 1 1 1\n",
            "5 0.25 0.5 0.25001\n",
            "a.msh:13: tet 17 is flat (quality 5.0e-6, regular 1, least 1e-4): optimise the mesh to remove slivers",
        ),
        (
            "5 1 1 1\n",
            "5 -1 -1 -1\n",
            "a.msh:13: tets 17 and 1 (line 12) overlap, both on one side of their common face: a node is out of place, untangle the mesh",
        ),
        ("5 1 1 1\n", "5 1 1 nan\n", "a.msh:7: a coordinate is `nan`, not a finite number: re-export the mesh"),
        ("5 1 1 1\n", "5 -inf 1 1\n", "a.msh:7: a coordinate is `-inf`, not a finite number: re-export the mesh"),
        ("5 1 1 1\n", "5 1e999 1 1\n", "a.msh:7: a coordinate is `1e999`, not a finite number: re-export the mesh"),
    ] {
        assert_eq!(message(import_text("a.msh", &edited(from, to))), expected);
    }
}

#[test]
fn a_gapless_numbering_is_answered_with_its_last_number() {
    let text = edited("6\n1 0", "5\n1 0").replace("9 0 0 0\n", "").replace("4 5\n$ENDELM", "4 999\n$ENDELM");
    assert_eq!(
        message(import_text("liver.msh", &text)),
        "liver.msh:12: tet 17 names node 999, but the file has 5 nodes: fix the element or re-export the mesh"
    );
}

#[test]
fn a_wrong_unit_is_answered_with_the_size_and_the_remedy() {
    let scaled = |factor: &str| TWO_TETS.replace(" 1\n", &format!(" {factor}\n"));
    assert_eq!(
        message(import_text("a.msh", &scaled("120"))),
        "a.msh: the mesh is 1000 x 1000 x 120000 mm, outside 1 mm to 2 m: a file unit is taken as 1000 mm, set length_unit (--unit) to \"m\", \"cm\", \"mm\", \"um\" or the metres in a file unit (\"mm\" would make it 120 mm)"
    );
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.msh");
    std::fs::write(&path, TWO_TETS).unwrap();
    let import = |unit_m| palpate_tissue::mesh::import::import(&path, unit_m);
    assert_eq!(
        message(import(1e-4)),
        "a.msh: the mesh is 0.1 x 0.1 x 0.1 mm, outside 1 mm to 2 m: a file unit is taken as 0.1 mm, set length_unit (--unit) to \"m\", \"cm\", \"mm\", \"um\" or the metres in a file unit (\"m\" would make it 1000 mm)"
    );
    assert!(import(1e-3).is_ok() && import(2.0).is_ok());
    assert!(import(0.99e-3).is_err() && import(2.01).is_err() && import(1e300).is_err() && import(1e-300).is_err());
}

#[test]
fn a_third_tet_on_a_face_is_refused() {
    let text = edited("$ELM\n2\n", "$ELM\n3\n").replace("$ENDELM", "20 4 1 1 4 2 3 4 6\n$ENDELM").replace("9 0 0 0", "6 2 2 2");
    assert_eq!(
        message(import_text("a.msh", &text)),
        "a.msh:14: the face of nodes 2, 3, 4 belongs to 3 tets, this is tet 20: a face has at most 2, remove the others"
    );
}

#[test]
fn parts_that_share_no_face_are_refused_with_their_sizes() {
    // The third tet is connected by node 5 only.
    let text = edited("6\n1 0", "9\n1 0")
        .replace("9 0 0 0\n", "9 0 0 0\n10 2 1 1\n11 1 2 1\n12 1 1 2\n")
        .replace("$ELM\n2\n", "$ELM\n3\n")
        .replace("$ENDELM", "30 4 1 1 4 5 10 11 12\n$ENDELM");
    assert_eq!(
        message(import_text("a.msh", &text)),
        "a.msh:17: the tets form 2 parts that share no face (2, 1 tets; tet 30 begins the smallest): keep one connected piece"
    );
}

#[test]
fn a_tet_with_the_nodes_of_another_is_left_out_and_counted() {
    let imported = import_text("a.msh", &edited("17 4 1 1 4 2 3 4 5", "17 4 1 1 4 4 2 1 3")).unwrap();
    assert_eq!((imported.report.tets, imported.report.copies), (1, 1));
}

#[test]
fn a_surface_mesh_is_told_from_an_empty_one() {
    let none = edited("$ELM\n2\n", "$ELM\n0\n").replace("1 4 1 1 4 1 2 3 4\n17 4 1 1 4 2 3 4 5\n", "");
    assert_eq!(message(import_text("a.msh", &none)), "a.msh: no tets: mesh the volume, not only its surface, and re-export");
    let shell = edited("1 4 1 1 4 1 2 3 4", "1 2 1 1 3 1 2 3").replace("17 4 1 1 4 2 3 4 5", "2 1 1 1 2 1 2");
    assert_eq!(
        message(import_text("a.msh", &shell)),
        "a.msh: the surface is open: 3 edges belong to one triangle only, the first at (0.5, 0, 0) in file units: close its holes (Blender: 3D Print Toolbox, Make Manifold; MeshLab: Close Holes)"
    );
}
