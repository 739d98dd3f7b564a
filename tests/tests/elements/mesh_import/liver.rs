//! A real liver, read if the folder with the shared data exists beside the project.

use std::path::{Path, PathBuf};

use palpate_tissue::mesh::import::import;
use palpate_tissue::mesh::surface::{edges, surface};

fn liver() -> Option<PathBuf> {
    let found = Path::new(env!("CARGO_MANIFEST_DIR"))
        .ancestors()
        .map(|dir| dir.join("shared/data/liver.msh"))
        .find(|path| path.is_file());
    if found.is_none() {
        eprintln!("skipped: no shared/data/liver.msh above the package");
    }
    found
}

#[test]
fn the_liver_is_as_large_as_a_human_one() {
    let Some(path) = liver() else { return };
    let imported = import(&path, 0.025).unwrap();
    let report = &imported.report;
    eprintln!("{report:#?}");
    assert_eq!(report.format, "Gmsh 1");
    assert_eq!((report.nodes, report.tets), (181, 596));
    let expected_mm = [162.0, 123.0, 111.0];
    for (size_m, expected_mm) in report.size_m.iter().zip(expected_mm) {
        assert!((1e3 * size_m - expected_mm).abs() < 0.6, "{:?}", report.size_m);
    }
    // A single closed surface without handles: nodes - edges + faces - tets = 1.
    let open = surface(&imported.mesh.tets).len();
    let faces = (4 * report.tets + open) / 2;
    assert_eq!(report.nodes + faces, edges(&imported.mesh.tets).len() + report.tets + 1);
}

#[test]
fn the_liver_in_metres_is_refused_for_its_size() {
    let Some(path) = liver() else { return };
    let error = import(&path, 1.0).unwrap_err().to_string();
    assert!(error.contains("set length_unit"), "{error}");
    eprintln!("{error}");
}
