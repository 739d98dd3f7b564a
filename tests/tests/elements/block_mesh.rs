//! Properties of the built-in block on which the solver relies, for many sizes, shapes and node
//! counts.

use palpate_tissue::mesh::{BlockError, BlockSpec, TetMesh, block, block_of_at_least, radius_ratio};
use std::collections::BTreeMap;
use std::sync::LazyLock;

const MM: f64 = 1e-3;
const TISSUE: BlockSpec =
    BlockSpec { size_m: [80.0 * MM, 80.0 * MM, 40.0 * MM], nodes: 410, fine_at_m: [0.0; 2], fine_radius_m: 8.0 * MM };

fn specs() -> Vec<BlockSpec> {
    let mut specs = [40, 60, 129, 230, 410, 1023].map(|nodes| BlockSpec { nodes, ..TISSUE }).to_vec();
    specs.extend([
        BlockSpec { size_m: [0.2, 0.1, 0.025], ..TISSUE },
        BlockSpec { size_m: [0.02; 3], nodes: 129, ..TISSUE },
        BlockSpec { size_m: [0.07, 0.05, 0.03], nodes: 150, ..TISSUE }, // sides in no simple ratio
        BlockSpec { size_m: [0.0008, 0.0008, 0.0004], fine_radius_m: 0.00008, ..TISSUE },
        BlockSpec { fine_at_m: [0.02, -0.01], ..TISSUE },
        BlockSpec { fine_at_m: [0.04, 0.04], nodes: 129, ..TISSUE },
        BlockSpec { fine_radius_m: 1.0, nodes: 129, ..TISSUE },
    ]);
    specs
}

static MESHES: LazyLock<Vec<(BlockSpec, TetMesh)>> =
    LazyLock::new(|| specs().into_iter().map(|spec| (spec, block(&spec).unwrap())).collect());

fn corners(mesh: &TetMesh, tet: [u32; 4]) -> [[f64; 3]; 4] {
    tet.map(|n| mesh.nodes_m[n as usize])
}

fn volume_m3([a, b, c, d]: [[f64; 3]; 4]) -> f64 {
    let [u, v, w]: [[f64; 3]; 3] = [b, c, d].map(|p| std::array::from_fn(|k| p[k] - a[k]));
    let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    (n[0] * w[0] + n[1] * w[1] + n[2] * w[2]) / 6.0
}

/// Every triangle (sorted nodes) with the number of tets that contain it.
fn triangles(mesh: &TetMesh) -> BTreeMap<Vec<u32>, usize> {
    let mut count = BTreeMap::new();
    for tet in &mesh.tets {
        for left_out in tet {
            let mut face: Vec<u32> = tet.iter().copied().filter(|n| n != left_out).collect();
            face.sort_unstable();
            *count.entry(face).or_insert(0) += 1;
        }
    }
    count
}

fn on_face(mesh: &TetMesh, nodes: &[u32], axis: usize, plane_m: f64) -> bool {
    nodes.iter().all(|n| mesh.nodes_m[*n as usize][axis] == plane_m)
}

#[test]
fn node_count_is_exact_and_every_node_is_used() {
    for (spec, mesh) in MESHES.iter() {
        assert_eq!(mesh.nodes_m.len(), spec.nodes);
        assert_eq!(mesh.regions.len(), mesh.tets.len());
        let mut used: Vec<u32> = mesh.tets.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        assert!(used.into_iter().eq(0..spec.nodes as u32));
    }
}

#[test]
fn positive_tets_fill_the_block() {
    for (spec, mesh) in MESHES.iter() {
        let volumes: Vec<f64> = mesh.tets.iter().map(|t| volume_m3(corners(mesh, *t))).collect();
        assert!(volumes.iter().all(|v| *v > 0.0));
        let whole: f64 = spec.size_m.iter().product();
        // Thousands of terms, each rounded by at most 1e-16 of the total.
        assert!((volumes.iter().sum::<f64>() - whole).abs() < 1e-12 * whole, "{spec:?}");
    }
}

#[test]
fn surface_is_closed_and_lies_on_the_six_faces() {
    for (spec, mesh) in MESHES.iter() {
        let [x, y, z] = [0.5 * spec.size_m[0], 0.5 * spec.size_m[1], -spec.size_m[2]];
        let planes = [(0, -x), (0, x), (1, -y), (1, y), (2, z), (2, 0.0)];
        let mut rims: BTreeMap<[u32; 2], usize> = BTreeMap::new();
        for (face, tets) in triangles(mesh) {
            let hull = planes.iter().any(|(axis, plane_m)| on_face(mesh, &face, *axis, *plane_m));
            assert_eq!(tets, if hull { 1 } else { 2 }, "{spec:?} {face:?}");
            if hull {
                for rim in [[face[0], face[1]], [face[0], face[2]], [face[1], face[2]]] {
                    *rims.entry(rim).or_default() += 1;
                }
            }
        }
        assert!(rims.values().all(|triangles| *triangles == 2));
    }
}

#[test]
fn mesh_is_one_piece_through_shared_triangles() {
    for (_, mesh) in MESHES.iter() {
        // Tets that share a triangle take the smaller of their labels until nothing changes.
        let mut by_face: BTreeMap<Vec<u32>, Vec<usize>> = BTreeMap::new();
        for (t, tet) in mesh.tets.iter().enumerate() {
            for left_out in tet {
                let mut face: Vec<u32> = tet.iter().copied().filter(|n| n != left_out).collect();
                face.sort_unstable();
                by_face.entry(face).or_default().push(t);
            }
        }
        let mut label: Vec<usize> = (0..mesh.tets.len()).collect();
        let mut changed = true;
        while changed {
            changed = false;
            for tets in by_face.values() {
                let least = tets.iter().map(|t| label[*t]).min().unwrap();
                for t in tets {
                    changed |= label[*t] != least;
                    label[*t] = least;
                }
            }
        }
        assert!(label.iter().all(|l| *l == 0));
    }
}

#[test]
fn no_tet_is_flat_and_most_are_near_regular() {
    for (spec, mesh) in MESHES.iter() {
        let quality: Vec<f64> = mesh.tets.iter().map(|t| radius_ratio(corners(mesh, *t))).collect();
        let worst = quality.iter().copied().fold(1.0, f64::min);
        let mean = quality.iter().sum::<f64>() / quality.len() as f64;
        // Measured over 80 node counts: 0.48 and 0.70.
        assert!(worst > 0.4 && mean > 0.68, "{spec:?}: worst {worst}, mean {mean}");
    }
}

#[test]
fn top_is_fine_and_near_equilateral_at_the_spot_and_coarse_away() {
    for (nodes, fine_edge_m) in [(129, 4.9 * MM), (410, 2.95 * MM), (1023, 1.95 * MM)] {
        for fine_at_m in [[0.0; 2], [0.02, -0.01]] {
            let mesh = block(&BlockSpec { nodes, fine_at_m, ..TISSUE }).unwrap();
            let (mut fine, mut coarse) = (vec![], vec![]);
            for face in triangles(&mesh).into_keys().filter(|f| on_face(&mesh, f, 2, 0.0)) {
                let p: Vec<[f64; 3]> = face.iter().map(|n| mesh.nodes_m[*n as usize]).collect();
                let edge = |i: usize, j: usize| (p[i][0] - p[j][0]).hypot(p[i][1] - p[j][1]);
                let edges = [edge(0, 1), edge(1, 2), edge(2, 0)];
                let centre = [0, 1].map(|k| (p[0][k] + p[1][k] + p[2][k]) / 3.0 - fine_at_m[k]);
                let away_m = centre[0].hypot(centre[1]);
                if away_m < TISSUE.fine_radius_m {
                    fine.push(edges);
                } else if away_m > 3.0 * TISSUE.fine_radius_m {
                    coarse.push(edges);
                }
            }
            let mean = |of: &[[f64; 3]]| of.iter().flatten().sum::<f64>() / (3 * of.len()) as f64;
            assert!((mean(&fine) / fine_edge_m - 1.0).abs() < 0.1, "{nodes}: {}", mean(&fine));
            assert!(mean(&coarse) > 2.0 * mean(&fine));
            let ratio = |e: &[f64; 3]| e.iter().copied().fold(0.0, f64::max) / e.iter().copied().fold(1.0, f64::min);
            let stretched = fine.iter().filter(|e| ratio(e) > 1.5).count();
            assert!(10 * stretched <= fine.len(), "{stretched} of {} stretched", fine.len());
        }
    }
}

#[test]
fn same_spec_gives_the_same_bits() {
    assert_eq!(block(&TISSUE).unwrap(), block(&TISSUE).unwrap());
}

#[test]
fn scaled_block_has_the_same_tets() {
    let tissue = block(&TISSUE).unwrap();
    for scale in [0.01, 0.1, 3.7, 1e6] {
        let scaled =
            BlockSpec { size_m: TISSUE.size_m.map(|s| s * scale), fine_radius_m: TISSUE.fine_radius_m * scale, ..TISSUE };
        let scaled = block(&scaled).unwrap();
        assert_eq!(scaled.tets, tissue.tets);
        for (a, b) in scaled.nodes_m.iter().zip(&tissue.nodes_m) {
            // Two roundings: by the unit and by the scale.
            assert!((0..3).all(|k| (a[k] - scale * b[k]).abs() <= 1e-15 * scale * b[k].abs()));
        }
    }
}

#[test]
fn bits_stay_those_on_record() {
    // FNV-1a over coordinates and tets: every machine and compiler must give exactly this mesh.
    let mesh = block(&BlockSpec { nodes: 129, ..TISSUE }).unwrap();
    let words = mesh.nodes_m.iter().flatten().map(|x| x.to_bits());
    let words = words.chain(mesh.tets.iter().flatten().map(|n| u64::from(*n)));
    let hash = words.fold(0xcbf2_9ce4_8422_2325_u64, |h, w| (h ^ w).wrapping_mul(0x0100_0000_01b3));
    assert_eq!(hash, 0xec03_5d74_f6cd_c60e, "{hash:#018x}");
}

#[test]
fn bad_specs_are_refused_in_one_line() {
    let bad = [
        BlockSpec { size_m: [0.08, f64::NAN, 0.04], ..TISSUE },
        BlockSpec { size_m: [0.08, 0.08, 0.0], ..TISSUE },
        BlockSpec { size_m: [f64::INFINITY, 0.08, 0.04], ..TISSUE },
        BlockSpec { size_m: [0.08, 0.08, 0.001], ..TISSUE },
        BlockSpec { nodes: 29, ..TISSUE },
        BlockSpec { nodes: 5001, ..TISSUE },
        BlockSpec { fine_at_m: [0.041, 0.0], ..TISSUE },
        BlockSpec { fine_at_m: [0.0, f64::NAN], ..TISSUE },
        BlockSpec { fine_radius_m: 0.0, ..TISSUE },
        BlockSpec { fine_radius_m: f64::INFINITY, ..TISSUE },
        BlockSpec { size_m: [0.2, 0.2, 0.01], nodes: 100, ..TISSUE },
    ];
    for spec in bad {
        let message = block(&spec).unwrap_err().to_string();
        assert!(message.starts_with("block ") && !message.contains('\n'), "{message}");
    }
}

#[test]
fn least_node_count_that_an_error_names_is_meshed() {
    for size_m in [[0.2, 0.1, 0.025], [0.2, 0.2, 0.01], [0.1, 0.01, 0.01]] {
        match block(&BlockSpec { size_m, nodes: 30, ..TISSUE }) {
            Err(BlockError::TooFew { least, .. }) => {
                assert!(block(&BlockSpec { size_m, nodes: least, ..TISSUE }).is_ok(), "{size_m:?} {least}");
                let mesh = block_of_at_least(&BlockSpec { size_m, nodes: 30, ..TISSUE }).unwrap();
                assert_eq!(mesh.nodes_m.len(), least, "{size_m:?}");
            }
            other => assert!(other.is_ok(), "{size_m:?} {other:?}"),
        }
    }
}
