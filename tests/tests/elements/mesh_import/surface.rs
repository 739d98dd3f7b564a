//! The boundary of a mesh is a closed surface whose triangles face outward.

use std::collections::BTreeMap;

use palpate_tissue::mesh::surface::{edges, surface};
use proptest::prelude::*;

use crate::mesh_import::block::{self, six_volumes, triple};

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 64, ..ProptestConfig::default() })]

    #[test]
    fn the_surface_is_closed(mesh in block::any()) {
        let mut crossings = BTreeMap::new();
        for [a, b, c] in surface(&mesh.tets) {
            for edge in [(a, b), (b, c), (c, a)] {
                *crossings.entry(edge).or_insert(0) += 1;
            }
        }
        for ((a, b), count) in &crossings {
            prop_assert_eq!(*count, 1);
            prop_assert!(crossings.contains_key(&(*b, *a)));
        }
    }

    #[test]
    fn the_surface_encloses_the_volume_of_the_tets(mesh in block::any()) {
        let enclosed: f64 = surface(&mesh.tets).iter().map(|triangle| {
            let [a, b, c] = triangle.map(|node| mesh.nodes_m[node as usize]);
            triple(a, b, c)
        }).sum();
        let filled: f64 = mesh.tets.iter().map(|&tet| six_volumes(&mesh, tet)).sum();
        // Fewer than 100 terms, none larger than the sum.
        prop_assert!((enclosed / filled - 1.0).abs() < 1e-12);
    }

    #[test]
    fn the_order_of_the_tets_leaves_the_surface_and_the_edges(mesh in block::any()) {
        let reversed: Vec<_> = mesh.tets.iter().rev().copied().collect();
        let sorted = |mut triangles: Vec<[u32; 3]>| {
            triangles.sort_unstable();
            triangles
        };
        prop_assert_eq!(sorted(surface(&mesh.tets)), sorted(surface(&reversed)));
        prop_assert_eq!(edges(&mesh.tets), edges(&reversed));
    }

    /// Euler: nodes - edges + faces - tets = 1 for a ball.
    #[test]
    fn the_counts_are_those_of_a_ball(mesh in block::any()) {
        let open = surface(&mesh.tets).len();
        let faces = (4 * mesh.tets.len() + open) / 2;
        prop_assert_eq!(mesh.nodes_m.len() + faces, edges(&mesh.tets).len() + mesh.tets.len() + 1);
    }
}
