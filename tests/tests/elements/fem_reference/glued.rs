//! The glued disc compared with exact solutions and with the shipped reference.

use palpate::Vector3;
use palpate_fit::reference::body::Stiffness;
use palpate_fit::reference::glued::{Disc, GluedError, glued_stiffness};
use palpate_fit::scene_fit::{GluedDiscs, Level};
use palpate_fit::solved::Solved;
use palpate_tissue::answer::{Answer, GluedAnswer};
use palpate_tissue::mesh::{BlockSpec, TetMesh, block};
use palpate_tissue::scene::Scene;

use crate::fem_reference::{RADIUS_M, assert_within};

/// Mesh of a block, and the nodes of its fixed bottom.
fn tissue(size_m: [f64; 3], nodes: usize, fine_radius_m: f64) -> (TetMesh, Vec<u32>) {
    let mesh = block(&BlockSpec { size_m, nodes, fine_at_m: [0.0; 2], fine_radius_m }).expect("meshed");
    let bottom = (0..).zip(&mesh.nodes_m).filter(|(_, x)| x[2] <= -size_m[2]).map(|(n, _)| n).collect();
    (mesh, bottom)
}

fn disc(radius_m: f64) -> Disc {
    Disc { place_m: Vector3::zeros(), axis: Vector3::z(), radius_m }
}

fn soft(poisson_ratio: f64) -> impl Fn(usize, &Vector3<f64>) -> Stiffness {
    move |_, _| Stiffness { ratio: 1.0, poisson_ratio, stiffening_b: 0.0 }
}

#[test]
fn a_column_glued_all_over_is_a_spring() {
    // without lateral strain, stretch is uniaxial and exact on any mesh; a quarter of the block
    // that is twice as stiff acts as a spring in series
    let size_m = [0.02, 0.03, 0.04];
    let (mesh, bottom) = tissue(size_m, 150, 0.02);
    let over = size_m[0] * size_m[1] / size_m[2];
    let up = [Vector3::z()];
    let plain = glued_stiffness(&mesh, soft(0.0), &bottom, &disc(0.05), &up, &[0.2]).expect("solved");
    assert_within("stretch", plain.limit_m[0], over, 1e-9);
    let firm = |_: usize, _: &Vector3<f64>| Stiffness { ratio: 2.5, poisson_ratio: 0.0, stiffening_b: 0.0 };
    let firm = glued_stiffness(&mesh, firm, &bottom, &disc(0.05), &up, &[0.2]).expect("solved");
    assert_within("firm stretch", firm.limit_m[0], 2.5 * over, 1e-9);
}

#[test]
fn every_tet_keeps_its_own_stiffness_through_the_refinement() {
    // nu = 0 with stiffness per tet: the upper half is ten times stiffer, on a mesh of two layers
    // made by mirroring one
    let size_m = [0.02, 0.02, 0.02];
    let (lower, bottom) = tissue(size_m, 100, 0.02);
    let mut mesh = lower.clone();
    // the mirror image above the top shares the top's nodes
    let mirrored: Vec<u32> = (0..)
        .zip(&lower.nodes_m)
        .map(|(n, x)| {
            if x[2] == 0.0 {
                return n;
            }
            mesh.nodes_m.push([x[0], x[1], -x[2]]);
            mesh.nodes_m.len() as u32 - 1
        })
        .collect();
    mesh.tets.extend(lower.tets.iter().map(|[a, b, c, d]| [*b, *a, *c, *d].map(|n| mirrored[n as usize])));
    mesh.regions.extend(&lower.regions);
    let stiffness = |t: usize, _: &Vector3<f64>| Stiffness {
        ratio: if t < lower.tets.len() { 1.0 } else { 10.0 },
        poisson_ratio: 0.0,
        stiffening_b: 0.0,
    };
    let top = Disc { place_m: Vector3::new(0.0, 0.0, size_m[2]), ..disc(0.018) };
    let found = glued_stiffness(&mesh, stiffness, &bottom, &top, &[Vector3::z()], &[0.2]).expect("solved");
    let series = size_m[0] * size_m[1] / (size_m[2] + size_m[2] / 10.0);
    assert_within("two layers", found.limit_m[0], series, 1e-9);
}

#[test]
#[ignore = "long: two large blocks"]
fn on_a_large_block_press_and_shear_are_those_of_a_half_space() {
    let nu = 0.45_f64;
    let shear_modulus = 0.5 / (1.0 + nu);
    // adhesive punch (Mossakovskii 1954, Spence 1968) and sheared disc (Mindlin 1949; its coupling
    // to the normal traction is neglected, which is a small error near nu = 1/2)
    let press_m = 4.0 * shear_modulus * RADIUS_M * (3.0 - 4.0 * nu).ln() / (1.0 - 2.0 * nu);
    let shear_m = 8.0 * shear_modulus * RADIUS_M / (2.0 - nu);
    let on = |scale: f64| {
        let (mesh, bottom) = tissue([0.08 * scale, 0.08 * scale, 0.04 * scale], 300, 0.03);
        let ways = [Vector3::z(), Vector3::x()];
        glued_stiffness(&mesh, soft(nu), &bottom, &disc(RADIUS_M), &ways, &[0.4, 0.2]).expect("solved").limit_m
    };
    // the effect of the walls falls with their distance
    let (near, far) = (on(4.0), on(8.0));
    assert_within("press, walls away", far[0], press_m, 0.04);
    assert_within("shear, walls away", far[1], shear_m, 0.02);
    assert_within("press", 2.0 * far[0] - near[0], press_m, 0.01);
    assert_within("shear", 2.0 * far[1] - near[1], shear_m, 0.01);
}

#[test]
#[ignore = "long: half a minute of finite elements"]
fn the_shipped_disc_at_the_centre_is_what_other_meshes_say() {
    let shipped = Answer::block().glued;
    assert_eq!(shipped.len(), 4);
    meshes_agree(&shipped[..2]);
    // computed independently with hexahedra
    assert_within("press at the centre", shipped[0].stiffness_over_e_m, 24.35e-3, 0.003);
}

#[test]
#[ignore = "long: minutes of finite elements"]
fn the_shipped_disc_aside_is_what_other_meshes_say() {
    meshes_agree(&Answer::block().glued[2..]);
}

/// Checks the stiffnesses of a shipped disc, pressed and sheared, on another mesh.
fn meshes_agree(pair: &[GluedAnswer]) {
    let size_m = [0.08, 0.08, 0.04];
    // another mesh, with elements two to four times as large
    let (mesh, bottom) = tissue(size_m, 500, 0.016);
    assert_eq!(pair[0].place_m, pair[1].place_m);
    let ways = [Vector3::from(pair[0].direction), Vector3::from(pair[1].direction)];
    let disc = Disc { place_m: pair[0].place_m.into(), axis: Vector3::z(), radius_m: pair[0].radius_m };
    let found = glued_stiffness(&mesh, soft(0.45), &bottom, &disc, &ways, &[0.2, 0.1]).expect("solved");
    for ((answer, found_m), levels) in pair.iter().zip(&found.limit_m).zip(0..) {
        assert_within("glued disc", *found_m, answer.stiffness_over_e_m, 0.003);
        // a finer mesh is softer: displacement elements bound the stiffness from above, except for
        // the polygon that represents the disc
        assert!(found.levels_m[1][levels] < found.levels_m[0][levels]);
    }
}

#[test]
fn what_cannot_be_glued_is_refused() {
    let (mesh, bottom) = tissue([0.04, 0.04, 0.02], 100, 0.01);
    let above = Disc { place_m: Vector3::new(0.0, 0.0, 0.02), ..disc(0.008) };
    let off = glued_stiffness(&mesh, soft(0.45), &bottom, &above, &[Vector3::z()], &[0.4]);
    assert_eq!(off, Err(GluedError::Off { radius_m: 0.008 }));
    let loose = glued_stiffness(&mesh, soft(0.45), &[], &disc(0.008), &[Vector3::z()], &[0.4]);
    assert_eq!(loose, Err(GluedError::Loose));
    let rigid = glued_stiffness(&mesh, soft(0.5), &bottom, &disc(0.008), &[Vector3::z()], &[0.4]);
    assert_eq!(rigid, Err(GluedError::Unsound));
}

#[test]
#[ignore = "long: minutes of finite elements"]
fn discs_of_a_fit_are_what_other_meshes_say() {
    let folder = tempfile::tempdir().expect("a folder");
    for (size_m, poisson_ratio) in [([0.08, 0.08, 0.04], 0.45), ([0.06, 0.06, 0.01], 0.45), ([0.08, 0.05, 0.04], 0.25)] {
        let mut scene = Scene::parse("block.toml", include_str!("../../../../host-sim/scenes/block.toml")).expect("a scene");
        (scene.tissue.block_m, scene.tissue.poisson_ratio) = (Some(size_m), poisson_ratio);
        let kept = Solved::beside(&folder.path().join("out"));
        let discs = GluedDiscs::solve(&scene, Level::Full, &kept, |_, _| {}).expect("solved");
        // some of the law's own discs, none of which was solved, and all discs of the evaluation
        let some = discs.known.chunks(3).step_by(6).chain(discs.unseen.chunks(3).step_by(2));
        for disc in some {
            let own = Disc { place_m: disc[0].place_m.into(), axis: Vector3::z(), radius_m: disc[0].radius_m };
            let (mesh, bottom) = tissue(size_m, 500, 2.0 * own.radius_m);
            let ways: Vec<Vector3<f64>> = disc.iter().map(|d| d.direction.into()).collect();
            let found = glued_stiffness(&mesh, soft(poisson_ratio), &bottom, &own, &ways, &[0.2, 0.1]).expect("solved");
            for (answer, found_m) in disc.iter().zip(found.limit_m) {
                assert_within("glued disc", answer.stiffness_over_e_m, found_m, 0.006);
            }
        }
    }
}
