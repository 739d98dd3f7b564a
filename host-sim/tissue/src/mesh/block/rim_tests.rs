//! The patches in these tests are measured from the mesh alone, by the centroids of their tets.

use super::*;
use std::collections::{BTreeMap, BTreeSet};

const BLOCK_M: [f64; 3] = [0.08, 0.08, 0.04];

fn sizes(radius_mm: f64, fine_mm: f64, growth: f64) -> Sizes {
    Sizes { radius_m: radius_mm * 1e-3, fine_m: fine_mm * 1e-3, fine_radius_m: 8e-3, growth }
}

/// Patch that is cut out, measured from the mesh alone.
#[derive(Debug)]
struct Patch {
    nodes: usize,
    rim: usize,
    shell_share: f64,
    volume_m3: f64,
    worst: f64,
    /// Mean length of an edge within the fine radius [m].
    fine_edge_m: f64,
    rim_edge_m: f64,
}

fn away_m(p: Vec3, at_m: [f64; 2]) -> f64 {
    super::super::vector::distance(p, [at_m[0], at_m[1], 0.0])
}

fn faces(tet: [u32; 4]) -> [[u32; 3]; 4] {
    let mut tet = tet;
    tet.sort_unstable();
    let [a, b, c, d] = tet;
    [[a, b, c], [a, b, d], [a, c, d], [b, c, d]]
}

fn measure(mesh: &TetMesh, at_m: [f64; 2], sizes: &Sizes) -> Patch {
    let at = |n: u32| mesh.nodes_m[n as usize];
    let inside: Vec<bool> = mesh.tets.iter().map(|t| away_m(centroid(&mesh.nodes_m, *t), at_m) <= sizes.radius_m).collect();
    let mut by_face: BTreeMap<[u32; 3], Vec<usize>> = BTreeMap::new();
    for (t, tet) in mesh.tets.iter().enumerate() {
        faces(*tet).into_iter().for_each(|f| by_face.entry(f).or_default().push(t));
    }
    let rim_faces: Vec<[u32; 3]> =
        by_face.iter().filter(|(_, t)| t.len() == 2 && inside[t[0]] != inside[t[1]]).map(|(f, _)| *f).collect();
    let on_shell = |n: &u32| (away_m(at(*n), at_m) - sizes.radius_m).abs() < 1e-9;
    let shell_faces = rim_faces.iter().filter(|f| f.iter().all(on_shell)).count();
    let patch: Vec<[u32; 4]> = mesh.tets.iter().zip(&inside).filter(|(_, i)| **i).map(|(t, _)| *t).collect();
    let six_volume = |t: &[u32; 4]| {
        let [a, b, c, d] = t.map(at);
        let [u, v, w] = [b, c, d].map(|p| [p[0] - a[0], p[1] - a[1], p[2] - a[2]]);
        w[0] * (u[1] * v[2] - u[2] * v[1]) + w[1] * (u[2] * v[0] - u[0] * v[2]) + w[2] * (u[0] * v[1] - u[1] * v[0])
    };
    let quality: Vec<f64> = mesh.tets.iter().map(|t| radius_ratio(t.map(at))).collect();
    let length = |[a, b]: [u32; 2]| super::super::vector::distance(at(a), at(b));
    let mean = |edges: Vec<[u32; 2]>| edges.iter().map(|e| length(*e)).sum::<f64>() / edges.len() as f64;
    let near: Vec<[u32; 2]> = super::super::relax::edges(&patch)
        .into_iter()
        .filter(|e| e.iter().all(|n| away_m(at(*n), at_m) <= sizes.fine_radius_m))
        .collect();
    let rim_edges: BTreeSet<[u32; 2]> = rim_faces.iter().flat_map(|[a, b, c]| [[*a, *b], [*a, *c], [*b, *c]]).collect();
    Patch {
        fine_edge_m: mean(near),
        rim_edge_m: mean(rim_edges.iter().copied().collect()),
        nodes: patch.iter().flatten().collect::<BTreeSet<_>>().len(),
        rim: rim_faces.iter().flatten().collect::<BTreeSet<_>>().len(),
        shell_share: shell_faces as f64 / rim_faces.len() as f64,
        volume_m3: patch.iter().map(six_volume).sum::<f64>() / 6.0,
        worst: quality.iter().copied().fold(1.0, f64::min),
    }
}

/// Radius [mm], size [mm], growth, and the least and most nodes: close to the values that worked
/// well for patches with jagged rims.
const RECIPES: [(f64, f64, f64, [usize; 2]); 3] =
    [(17.0, 5.2, 0.45, [60, 75]), (18.0, 4.0, 0.45, [105, 130]), (20.0, 3.0, 0.36, [210, 260])];

fn built(size_m: [f64; 3], at_m: [f64; 2], sizes: &Sizes, variant: u32) -> (TetMesh, Patch) {
    let mesh = block_with_rim(size_m, at_m, sizes, variant).unwrap();
    let patch = measure(&mesh, at_m, sizes);
    (mesh, patch)
}

#[test]
fn patches_have_the_nodes_asked_for_and_end_on_the_shell() {
    for (radius_mm, fine_mm, growth, [least, most]) in RECIPES {
        let sizes = sizes(radius_mm, fine_mm, growth);
        for variant in 0..4 {
            let (_, patch) = built(BLOCK_M, [0.0; 2], &sizes, variant);
            assert!((least..=most).contains(&patch.nodes), "{patch:?}");
            assert!(patch.shell_share > 0.95, "{patch:?}");
            let expected = 2.0 * std::f64::consts::PI * sizes.radius_m.powi(2) / (0.75_f64.sqrt() * patch.rim_edge_m.powi(2));
            assert!((patch.rim as f64 / expected - 1.0).abs() < 0.3, "{expected} {patch:?}");
            assert!(patch.worst > 0.4, "{patch:?}");
            assert!((patch.fine_edge_m / sizes.fine_m - 1.0).abs() < 0.2, "{patch:?}");
        }
    }
}

/// A triangle with edges of length s inscribed in a sphere lies s^2 / (8 R) below it on average.
#[test]
fn patch_volume_is_the_half_sphere_less_the_chords() {
    for (radius_mm, fine_mm, growth, _) in RECIPES {
        let sizes = sizes(radius_mm, fine_mm, growth);
        let (_, patch) = built([0.1, 0.08, 0.04], [0.0; 2], &sizes, 0);
        assert!(patch.shell_share > 0.95, "{patch:?}");
        let (r, s) = (sizes.radius_m, patch.rim_edge_m);
        let pi = std::f64::consts::PI;
        let missing = 2.0 / 3.0 * pi * r.powi(3) - patch.volume_m3;
        let expected = 2.0 * pi * r * r * (s * s / (8.0 * r));
        assert!((missing / expected - 1.0).abs() < 0.3, "{radius_mm}: {missing:e} {expected:e}");
    }
}

#[test]
fn whole_block_is_filled() {
    let (mesh, _) = built(BLOCK_M, [0.012, -0.005], &sizes(16.0, 4.0, 0.45), 0);
    let six_volume = |t: &[u32; 4]| {
        let [a, b, c, d] = t.map(|n| mesh.nodes_m[n as usize]);
        let [u, v, w] = [b, c, d].map(|p| [p[0] - a[0], p[1] - a[1], p[2] - a[2]]);
        w[0] * (u[1] * v[2] - u[2] * v[1]) + w[1] * (u[2] * v[0] - u[0] * v[2]) + w[2] * (u[0] * v[1] - u[1] * v[0])
    };
    let volumes: Vec<f64> = mesh.tets.iter().map(six_volume).collect();
    assert!(volumes.iter().all(|v| *v > 0.0));
    assert!((volumes.iter().sum::<f64>() / 6.0 - 0.08 * 0.08 * 0.04).abs() < 1e-15);
}

#[test]
fn no_tet_spans_from_rim_to_wall() {
    for size_m in [[0.3, 0.3, 0.025], [0.08, 0.08, 0.04], [0.3, 0.3, 0.1]] {
        let sizes = sizes(17.0, 4.6, 0.45);
        let (mesh, patch) = built(size_m, [0.0; 2], &sizes, 0);
        let at = |n: &u32| mesh.nodes_m[*n as usize];
        let in_patch = |n: &u32| away_m(at(n), [0.0; 2]) <= sizes.radius_m + 1e-9;
        let on_wall = |n: &u32| at(n)[2] == -size_m[2] || (0..2).any(|k| at(n)[k].abs() == 0.5 * size_m[k]);
        assert!(!mesh.tets.iter().any(|t| t.iter().any(in_patch) && t.iter().any(on_wall)), "{size_m:?}");
        assert!(patch.shell_share > 0.95, "{patch:?}");
    }
}

#[test]
fn same_arguments_give_the_same_bits_and_another_variant_another_mesh() {
    let sizes = sizes(17.0, 4.6, 0.45);
    let mesh = |variant| block_with_rim(BLOCK_M, [0.0; 2], &sizes, variant).unwrap();
    let (first, other) = (mesh(0), mesh(1));
    assert_eq!(first, mesh(0));
    assert_eq!(first.nodes_m.len(), other.nodes_m.len());
    assert_ne!(first.nodes_m, other.nodes_m);
    let big = sizes_times(&sizes, 2.0);
    let doubled = block_with_rim(BLOCK_M.map(|s| 2.0 * s), [0.0; 2], &big, 0).unwrap();
    assert_eq!(doubled.tets, first.tets);
}

fn sizes_times(sizes: &Sizes, by: f64) -> Sizes {
    Sizes { radius_m: by * sizes.radius_m, fine_m: by * sizes.fine_m, fine_radius_m: by * sizes.fine_radius_m, ..*sizes }
}

#[test]
fn what_does_not_fit_is_refused_and_the_value_named_works() {
    let good = sizes(17.0, 4.6, 0.45);
    let refuse = |at_m: [f64; 2], sizes: Sizes| block_with_rim(BLOCK_M, at_m, &sizes, 0).unwrap_err();
    let at = [0.0; 2];
    let BlockError::Swallows { most, .. } = refuse(at, Sizes { radius_m: 0.04, ..good }) else { panic!() };
    assert!((most - 0.0354).abs() < 1e-12);
    assert!(block_with_rim(BLOCK_M, at, &Sizes { radius_m: most, ..good }, 0).is_ok());
    let BlockError::Fine { most, .. } = refuse(at, Sizes { fine_m: 0.018, ..good }) else { panic!() };
    assert!(block_with_rim(BLOCK_M, at, &Sizes { fine_m: most, ..good }, 0).is_ok());
    assert!(matches!(refuse([0.04, 0.0], good), BlockError::AtWall { .. }));
    assert!(matches!(refuse([0.05, 0.0], good), BlockError::Spot { axis: 0, .. }));
    let even = Sizes { fine_m: 1e-3, growth: 0.0, radius_m: 0.01, ..good };
    let BlockError::TooMany { nodes, least, .. } = refuse(at, even) else { panic!() };
    assert!(nodes > MAX_NODES);
    assert!(checked(BLOCK_M, at, &Sizes { fine_m: least, ..even }).is_ok());
    let tiny = Sizes { fine_m: 4e-4, growth: 0.0, radius_m: 5e-4, ..good };
    let BlockError::TooEven { least, .. } = refuse(at, tiny) else { panic!() };
    assert!(checked(BLOCK_M, at, &Sizes { fine_m: 5e-4, growth: least, fine_radius_m: 1e-3, ..tiny }).is_ok());
    for bad in [f64::NAN, f64::INFINITY, 0.0, -1.0] {
        for sizes in [Sizes { radius_m: bad, ..good }, Sizes { fine_m: bad, ..good }, Sizes { fine_radius_m: bad, ..good }] {
            assert!(matches!(refuse(at, sizes), BlockError::Length { .. }));
        }
    }
    for bad in [f64::NAN, -0.1, 1.1] {
        assert!(matches!(refuse(at, Sizes { growth: bad, ..good }), BlockError::Growth { .. }));
    }
}
