//! Presses for which the force is known in closed form.

use palpate::Vector3;
use palpate_fit::reference::domain::BlockCase;
use palpate_fit::reference::newton::Press;
use palpate_fit::reference::probe::RigidProbe;
use palpate_fit::reference::refine::refine;
use palpate_tissue::mesh::{self, BlockSpec};
use palpate_tissue::scene::Shape;

use crate::fem_reference::{RADIUS_M, above, assert_within, standard_block};

/// E* over E: 1/(1 - nu^2).
fn plane_modulus(nu: f64) -> f64 {
    1.0 / (1.0 - nu * nu)
}

#[test]
fn a_shallow_ball_on_a_large_block_follows_hertz() {
    // the contact radius is 0.77 mm, and the walls are 250 radii away: the block is a half-space
    // within about 0.5 %
    let (radius_m, depth_m) = (0.01_f64, 6e-5_f64);
    let case = BlockCase { size_m: [0.4, 0.4, 0.2], ..standard_block(100, 0.05) };
    let quarter = BlockSpec { size_m: [0.2; 3], nodes: 100, fine_at_m: [-0.1; 2], fine_radius_m: 0.05 };
    let mut mesh = mesh::block(&quarter).expect("meshed");
    for x in &mut mesh.nodes_m {
        *x = [x[0] + 0.1, x[1] + 0.1, x[2]];
    }
    // a coarse mesh is refined, because the generator does not grade by a factor of hundreds
    let mesh = refine(&mesh, |x| 4e-4 + 0.6 * (Vector3::from(x).norm() - 8e-4).max(0.0), 1500);
    let block = case.support(&mesh, [true; 2]);
    let mut press = above(&block, Shape::Sphere, radius_m);
    press.go_to(depth_m, |_| {}).expect("shallow");
    let hertz = 4.0 / 3.0 * plane_modulus(0.45) * radius_m.sqrt() * depth_m.powf(1.5);
    assert_within("force", press.force_over_e_m2(), hertz, 0.02);
}

#[test]
fn a_flat_punch_has_the_linear_force_of_this_block() {
    // in linear elasticity, 1.213 times the half-space's 2 a E* depth, for a sharp edge
    let block = standard_block(700, 1.05 * RADIUS_M).build().expect("meshed");
    let depth_m = 2e-5;
    let mut probe = RigidProbe::new(Shape::Flat, RADIUS_M, block.place_m, Vector3::z());
    probe.edge_m = RADIUS_M / 1000.0;
    let mut press = Press::new(&block.body, probe, block.place_m).expect("small");
    press.go_to(depth_m, |_| {}).expect("shallow");
    assert_within("force", press.force_over_e_m2(), 1.213 * 2.0 * RADIUS_M * plane_modulus(0.45) * depth_m, 0.02);
}
