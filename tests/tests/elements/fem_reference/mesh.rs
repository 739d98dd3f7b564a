//! An imported mesh gives the same results as the block's own mesh.

use palpate::Vector3;
use palpate_fit::reference::domain::mesh_body;
use palpate_fit::reference::newton::Press;
use palpate_fit::reference::probe::RigidProbe;
use palpate_fit::reference::refine::refine;
use palpate_fit::reference::shape::TetRule;
use palpate_tissue::mesh::{BlockSpec, block};
use palpate_tissue::scene::Shape;

use crate::fem_reference::{RADIUS_M, assert_within, tissue};

#[test]
fn a_coarse_mesh_refined_at_the_site_and_tilted_gives_the_blocks_force() {
    let spec = BlockSpec { size_m: [0.08, 0.08, 0.04], nodes: 60, fine_at_m: [0.0; 2], fine_radius_m: 0.02 };
    let mut mesh = block(&spec).expect("meshed");
    mesh = refine(&mesh, |x| 0.0032 + 0.6 * (Vector3::from(x).norm() - 0.004).max(0.0), 900);
    // a quarter turn about x, after which the press is along -y
    for x in &mut mesh.nodes_m {
        *x = [x[0], x[2], -x[1]];
    }
    let axis = Vector3::y();
    let body = mesh_body(&mesh, &axis, &tissue(0.45), TetRule::Four);
    let mut press =
        Press::new(&body, RigidProbe::new(Shape::Hemisphere, RADIUS_M, Vector3::zeros(), axis), Vector3::zeros()).expect("small");
    press.go_to(0.002, |_| {}).expect("converges");
    assert_within("force", press.force_over_e_m2(), 14.065e-6, 0.02);
}
