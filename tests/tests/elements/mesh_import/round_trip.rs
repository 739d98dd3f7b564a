//! A mesh written to a file is imported bit for bit.

use palpate_tissue::mesh::TetMesh;
use proptest::prelude::*;

use crate::mesh_import::write::{FORMATS, Format, write};
use crate::mesh_import::{block, import_bytes};

fn through_a_file(format: Format, mesh: &TetMesh, stride: u64) -> palpate_tissue::mesh::import::Imported {
    let (name, content) = write(format, mesh, stride);
    import_bytes(name, &content).unwrap_or_else(|error| panic!("{format:?}: {error}"))
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 64, ..ProptestConfig::default() })]

    #[test]
    fn every_format_gives_the_mesh_back(mesh in block::any(), stride in 1..1_000_000_000_u64) {
        for format in FORMATS {
            let imported = through_a_file(format, &mesh, stride);
            let mut expected = mesh.clone();
            if !format.has_regions() {
                expected.regions.fill(0);
            }
            prop_assert_eq!(&imported.mesh, &expected, "{:?}", format);
            prop_assert_eq!(imported.report.flipped_tets, 0);
            prop_assert_eq!(imported.report.unused_nodes, 0);
            let triangles = imported.report.ignored.get("triangle").copied();
            prop_assert_eq!(triangles, Some(1), "{:?}", format);
        }
    }

    #[test]
    fn inverted_tets_are_turned_and_counted(
        mesh in block::any(),
        inverted in prop::collection::vec(any::<bool>(), 48),
        all in any::<bool>(),
        which in 0..FORMATS.len(),
    ) {
        let mut twisted = mesh.clone();
        let mut count = 0;
        for (tet, invert) in twisted.tets.iter_mut().zip(inverted) {
            if invert || all {
                tet.swap(0, 1);
                count += 1;
            }
        }
        let imported = through_a_file(FORMATS[which], &twisted, 1);
        prop_assert_eq!(imported.report.flipped_tets, count);
        prop_assert_eq!(&imported.mesh.nodes_m, &mesh.nodes_m);
        for (turned, original) in imported.mesh.tets.iter().zip(&mesh.tets) {
            prop_assert!(block::six_volumes(&imported.mesh, *turned) > 0.0);
            let (mut a, mut b) = (*turned, *original);
            a.sort_unstable();
            b.sort_unstable();
            prop_assert_eq!(a, b);
        }
    }

    #[test]
    fn the_report_measures_the_mesh(cells in [1..=3_usize, 1..=3, 1..=3]) {
        let mesh = block::regular(cells);
        let report = through_a_file(Format::Gmsh2, &mesh, 1).report;
        let size = cells.map(|n| n as f64 * block::STEP_M);
        let volume = size[0] * size[1] * size[2];
        prop_assert_eq!(report.size_m, size);
        // The sum has at most 162 tets.
        prop_assert!((report.volume_m3 / volume - 1.0).abs() < 1e-13);
        // The longest edge is the cube's diagonal, and the volume is a sixth of the cube's: sqrt(2)
        // / sqrt(27).
        prop_assert!((report.worst_tet.quality - (2.0_f64 / 27.0).sqrt()).abs() < 1e-12);
        prop_assert_eq!((report.nodes, report.tets), (mesh.nodes_m.len(), mesh.tets.len()));
    }

    /// A power of two scales without rounding, so only the scale may change the bits.
    #[test]
    fn the_scale_of_a_mesh_decides_nothing(mesh in block::any(), power in -3..=6) {
        let unit_m = 2.0_f64.powi(power);
        let metre = through_a_file(Format::Gmsh2, &mesh, 1);
        let mut shrunk = mesh;
        for x in shrunk.nodes_m.iter_mut().flatten() {
            *x *= unit_m;
        }
        let scaled = through_a_file(Format::Gmsh2, &shrunk, 1);
        prop_assert_eq!(&scaled.mesh, &shrunk);
        prop_assert_eq!(scaled.report.worst_tet, metre.report.worst_tet);
        prop_assert_eq!(scaled.report.size_m, metre.report.size_m.map(|x| x * unit_m));
        prop_assert_eq!(scaled.report.volume_m3, metre.report.volume_m3 * unit_m * unit_m * unit_m);
    }
}
