//! The finite-element reference is verified against exact solutions, against itself, and against
//! the shipped references.

mod balance;
mod block;
mod glued;
mod half_space;
mod linearity;
mod long_tips;
mod mesh;
mod stiffening;
mod uniform;

use palpate::Vector3;
use palpate_fit::reference::body::Material;
use palpate_fit::reference::domain::{BlockBody, BlockCase};
use palpate_fit::reference::newton::Press;
use palpate_fit::reference::probe::RigidProbe;
use palpate_fit::reference::shape::TetRule;
use palpate_tissue::scene::Shape;

/// Radius of the standard hemisphere [m].
pub const RADIUS_M: f64 = 0.008;

fn tissue(poisson_ratio: f64) -> Material {
    Material { poisson_ratio, stiffening_b: 0.0, inclusions: vec![] }
}

/// A quarter of the preset block with `nodes` corner nodes and a fine mesh within `fine_radius_m`
/// of its centre.
pub fn standard_block(nodes: usize, fine_radius_m: f64) -> BlockCase {
    BlockCase {
        size_m: [0.08, 0.08, 0.04],
        place_m: [0.0; 2],
        material: tissue(0.45),
        nodes,
        fine_radius_m,
        rule: TetRule::Four,
        may_cut: [true; 2],
    }
}

/// A probe just above a block, without contact.
pub fn above(block: &BlockBody, shape: Shape, radius_m: f64) -> Press<'_> {
    let probe = RigidProbe::new(shape, radius_m, block.place_m, Vector3::z());
    Press::new(&block.body, probe, block.place_m).expect("a small factor fits into memory")
}

pub fn assert_within(what: &str, got: f64, want: f64, share: f64) {
    let off = got / want - 1.0;
    assert!(off.abs() <= share, "{what}: {got:e} for {want:e}, {:+.3} % off, at most {} %", off * 100.0, share * 100.0);
}
