//! Large files are read completely, or are refused before memory is allocated for them.

use palpate_tests::cube_mesh::chain;

use crate::mesh_import::write::{FORMATS, Format, write};
use crate::mesh_import::{block, import_bytes, import_text, message};

#[test]
fn twenty_thousand_nodes_are_read_whole() {
    let mesh = block::regular([26; 3]);
    // Each reader is used once or twice.
    for format in FORMATS.into_iter().step_by(2) {
        let (name, content) = write(format, &mesh, 7);
        let report = import_bytes(name, &content).unwrap().report;
        assert_eq!((report.nodes, report.tets), (mesh.nodes_m.len(), mesh.tets.len()), "{format:?}");
    }
}

#[test]
fn an_absurd_count_is_refused_without_allocating_for_it() {
    let huge = "1000000000000";
    for (name, text, expected) in [
        (
            "a.msh",
            format!("$NOD\n{huge}\n1 0 0 0\n"),
            "a.msh:3: $NOD announces 1000000000000 nodes but holds 1: re-export the mesh",
        ),
        (
            "a.msh",
            format!("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 1 1 1\n3 1 0 {huge}\n1\n$EndNodes\n"),
            "a.msh:8: a block of $Nodes announces 1000000000000 tags but holds 1: re-export the mesh",
        ),
        (
            "a.vtk",
            format!("# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS {huge} float\n0 0 0\nCELLS 1 5\n"),
            "a.vtk:7: POINTS announces 1000000000000 points but holds 1: re-export the mesh",
        ),
    ] {
        assert_eq!(message(import_text(name, &text)), expected);
    }
}

/// Replaces each announced length in a binary file by a huge number.
#[test]
fn an_absurd_binary_count_is_refused_without_allocating_for_it() {
    let mesh = block::regular([2; 3]);
    for format in FORMATS {
        let (name, content) = write(format, &mesh, 1);
        let counts = [mesh.nodes_m.len(), mesh.tets.len(), mesh.tets.len() + 1, mesh.tets.len() / 2];
        for at in 0..content.len().saturating_sub(8) {
            let found = u32::from_le_bytes(content[at..at + 4].try_into().unwrap());
            let big = u32::from_be_bytes(content[at..at + 4].try_into().unwrap());
            let mut damaged = content.clone();
            if counts.contains(&(found as usize)) {
                damaged[at + 2..at + 4].copy_from_slice(&[0xff, 0x7f]);
            } else if counts.contains(&(big as usize)) {
                damaged[at..at + 2].copy_from_slice(&[0x7f, 0xff]);
            } else {
                continue;
            }
            // the import succeeds only if the number was not a count but an index of a node or a
            // tet
            let _ = import_bytes(name, &damaged).map_err(|error| assert!(error.to_string().len() < 500, "{error}"));
        }
    }
    for (says, lie) in [
        ("NumberOfPoints=\"27\"", "NumberOfPoints=\"99999999999999\""),
        ("NumberOfCells=\"49\"", "NumberOfCells=\"99999999999999\""),
    ] {
        for format in FORMATS.into_iter().filter(|format| matches!(format, Format::Vtu(..))) {
            let (name, content) = write(format, &mesh, 1);
            let at = content.windows(says.len()).position(|window| window == says.as_bytes()).expect("a count");
            let damaged = [&content[..at], lie.as_bytes(), &content[at + says.len()..]].concat();
            assert!(import_bytes(name, &damaged).is_err(), "{format:?}");
        }
    }
}

#[test]
fn more_nodes_than_a_tick_holds_are_read() {
    // the chain is refused for its length alone
    let long = message(import_text("a.msh", &chain(65_536)));
    assert!(long.starts_with("a.msh: the mesh is 6.6e7 x 0.0e0 x 0.0e0 mm"), "{long}");
}
