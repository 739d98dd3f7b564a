//! The error for every syntax error in a file names its position and its remedy.

use crate::mesh_import::defects::edited;
use crate::mesh_import::{import_text, message};

#[test]
fn each_defect_of_the_text_has_its_own_line() {
    for (from, to, expected) in [
        ("$NOD\n6", "$NOD\n7", "a.msh:9: $NOD announces 7 nodes but holds 6: re-export the mesh"),
        ("$NOD\n6", "$NOD\n5", "a.msh:8: $NOD announces 5 nodes but goes on: re-export the mesh"),
        ("$ELM\n2", "$ELM\n3", "a.msh:14: $ELM announces 3 elements but holds 2: re-export the mesh"),
        ("$NOD\n6", "$NOD\nsix", "a.msh:2: expected the number of nodes, found `six`: fix the line or re-export the mesh"),
        ("$NOD\n6", "$NOD\n-6", "a.msh:2: expected the number of nodes, found `-6`: fix the line or re-export the mesh"),
        ("5 1 1 1\n", "5 1 1\n", "a.msh:7: the line ends before the z coordinate: fix the line or re-export the mesh"),
        ("5 1 1 1\n", "5 1 1 1 9\n", "a.msh:7: `9` is more than the line should hold: fix the line or re-export the mesh"),
        ("5 1 1 1\n", "5 1 1 1,5\n", "a.msh:7: expected a coordinate, found `1,5`: fix the line or re-export the mesh"),
        (
            "2 3 4 5\n$ENDELM\n",
            "2 3 4 5\n",
            "a.msh:13: the file ends before the end of the section: it is cut short, re-export the mesh",
        ),
        ("2 3 4 5\n$ENDELM\n", "2 3", "a.msh:13: the line ends before a node number: fix the line or re-export the mesh"),
        ("$ENDNOD\n", "", "a.msh:9: expected the end of the section, found `$ELM`: fix the line or re-export the mesh"),
        ("$ENDNOD\n", "$ENDNOD\n$NOD\n", "a.msh:10: second $NOD: keep one"),
        (
            "$ENDNOD\n",
            "$ENDNOD\n$Periodic\n",
            "a.msh:10: the file ends before this section ends: it is cut short, re-export the mesh",
        ),
        ("$ENDNOD\n", "$ENDNOD\n3 4 5\n", "a.msh:10: expected a $Section, found `3 4 5`: fix the line or re-export the mesh"),
        ("1 4 1 1 4 1", "1 4 1 1 5 1", "a.msh:12: expected 4 nodes, found `5`: fix the line or re-export the mesh"),
        (
            "1 4 1 1 4 1",
            "1 4 x 1 4 1",
            "a.msh:12: expected a region number (whole, from 0), found `x`: fix the line or re-export the mesh",
        ),
        (
            "\n1 0 0 0",
            "\n1 0 0 aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa",
            "a.msh:3: expected a coordinate, found `aaaaaaaaaaaaaaaaaaaaaaaa…`: fix the line or re-export the mesh",
        ),
    ] {
        assert_eq!(message(import_text("a.msh", &edited(from, to))), expected);
    }
    assert_eq!(
        message(import_text("a.msh", "$ELM\n0\n$ENDELM\n")),
        "a.msh:3: no $NOD section: re-export the mesh with its nodes and tets"
    );
}

#[test]
fn the_counts_of_a_vtk_file_must_agree() {
    let old = "# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n0 0 0 1 0 0 0 1 0 0 0 1\nCELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n10\n";
    let new = old.replace("CELLS 1 5\n4 0 1 2 3\n", "CELLS 2 4\nOFFSETS vtktypeint64\n0 4\nCONNECTIVITY vtktypeint64\n0 1 2 3\n");
    assert_eq!(import_text("a.vtk", old).unwrap(), import_text("a.vtk", &new).unwrap());
    for (text, expected) in [
        (old.replace("POINTS 4", "POINTS 5"), "a.vtk:7: POINTS announces 5 points but holds 4: re-export the mesh"),
        (
            old.replace("POINTS 4", "POINTS 3"),
            "a.vtk:6: expected the next section (the counts before it are too low), found `0`: fix the line or re-export the mesh",
        ),
        (old.replace("CELLS 1 5", "CELLS 1 6"), "a.vtk:8: CELLS size says 6, but the file holds 5: re-export the mesh"),
        (old.replace("CELLS 1 5", "CELLS 2 5"), "a.vtk:9: CELLS announces 2 cells but holds 1: re-export the mesh"),
        (old.replace("CELL_TYPES 1", "CELL_TYPES 2"), "a.vtk:9: CELL_TYPES says 2, but the file holds 1: re-export the mesh"),
        (old.replace("\n10\n", "\n"), "a.vtk:9: CELL_TYPES announces 1 types but holds 0: re-export the mesh"),
        (
            old.replace("4 0 1 2 3\n", "3 0 1 2\n").replace("1 5", "1 4"),
            "a.vtk:10: expected a type that fits the cell (a tet has 4 nodes), found `10`: fix the line or re-export the mesh",
        ),
        (
            old.replace("0 1 2 3\n", "0 1 2 4\n"),
            "a.vtk:8: tet 0 names node 4, but the file has 4 nodes: fix the element or re-export the mesh",
        ),
        (old.replace("CELL_TYPES 1\n10\n", ""), "a.vtk:8: no CELL_TYPES: re-export the mesh with its nodes and tets"),
        (
            new.replace("0 4\n", "0 5\n"),
            "a.vtk:9: expected an offset that does not fall, into CONNECTIVITY, found `5`: fix the line or re-export the mesh",
        ),
        (new.replace("0 4\n", "1 4\n"), "a.vtk:9: expected the first offset 0, found `1`: fix the line or re-export the mesh"),
        (
            new.replace("0 4\n", "0 3\n"),
            "a.vtk:9: expected the last offset to be the size of CONNECTIVITY, found `3`: fix the line or re-export the mesh",
        ),
        (new.replace("CELLS 2 4", "CELLS 2 5"), "a.vtk:12: CONNECTIVITY announces 5 entries but holds 4: re-export the mesh"),
    ] {
        assert_eq!(message(import_text("a.vtk", &text)), expected);
    }
}

#[test]
fn the_blocks_of_gmsh_4_must_add_up() {
    let text = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 4 1 4\n3 1 0 4\n10\n20\n30\n40\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n$EndNodes\n$Elements\n1 1 5 5\n3 1 4 1\n5 10 20 30 40\n$EndElements\n";
    assert!(import_text("a.msh", text).is_ok());
    let entities = "$Entities\n0 0 0 1\n2 0 0 0 1 1 1 0 0\n$EndEntities\n$Nodes";
    for (from, to, expected) in [
        ("1 4 1 4", "1 5 1 4", "a.msh:15: $Nodes announces 5 nodes but holds 4: re-export the mesh"),
        ("1 4 1 4", "1 3 1 4", "a.msh:15: $Nodes announces 3 nodes but goes on: re-export the mesh"),
        (
            "1 4 1 4",
            "2 4 1 4",
            "a.msh:15: expected the dimension of the entity, found `$EndNodes`: fix the line or re-export the mesh",
        ),
        ("3 1 0 4", "3 1 2 4", "a.msh:6: expected the parametric flag 0 or 1, found `2`: fix the line or re-export the mesh"),
        ("1 1 5 5", "1 2 5 5", "a.msh:20: $Elements announces 2 elements but holds 1: re-export the mesh"),
        (
            "10 20 30 40",
            "10 20 30 41",
            "a.msh:19: tet 5 names node 41, but none of the file's 4 nodes has that number: fix the element or re-export the mesh",
        ),
        ("$Nodes", entities, "a.msh:22: expected a volume listed in $Entities, found `1`: fix the line or re-export the mesh"),
    ] {
        assert_eq!(message(import_text("a.msh", &text.replacen(from, to, 1))), expected);
    }
}
