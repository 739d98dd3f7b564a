//! The contact force on the probe equals the force on the anchors.

use palpate::Vector3;
use palpate_tissue::scene::Shape;

use crate::fem_reference::{RADIUS_M, above, standard_block};

#[test]
fn the_contact_force_is_the_reaction_of_the_anchors() {
    // a place off both planes of symmetry, which requires the whole block and gives the anchors a
    // force with all three components
    let mut case = standard_block(120, 0.008);
    case.place_m = [0.011, -0.007];
    let block = case.build().expect("meshed");
    assert_eq!(block.body.copies, 1.0);
    let mut press = above(&block, Shape::Hemisphere, RADIUS_M);
    press.go_to(0.003, |_| {}).expect("converges");
    let body = &block.body;
    let elastic = body.assemble(&press.displacement_m, None).expect("nothing is inside out").residual_m2;
    let anchors = body.fixed.iter().zip(&elastic).filter(|(fixed, _)| fixed[2]).map(|(_, r)| *r).sum::<Vector3<f64>>();
    let force = press.touch().force_m2;
    assert!(force.z > 2e-5);
    assert!((force - anchors).norm() < 1e-6 * force.norm(), "{force:?} into the tissue, {anchors:?} held");
}
