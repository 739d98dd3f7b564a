//! The models of the two source papers as methods on the core's tick ([`palpate::method`]).
//!
//! | stage | product | [`VolumePreserved`], paper 000 | [`LocalCompression`], paper 004 |
//! |---|---|---|---|
//! | nodes that move | all | all | stress rule (7)-(8) |
//! | force | springs, volume, rim | springs (4), dampers (5), (12) | springs, dampers (1), (2) |
//! | integrate | symplectic Euler | symplectic Euler, which is (3) | velocity Verlet (9)-(10) |
//! | correct | nothing | lengths (6)-(8), directions (9) | over-compression (11)-(13) |
//!
//! Guard, contact and output are the product's. Corrections move positions after a step and leave
//! velocities unchanged, as both papers print it. They act as a stiffness of about m/dt^2, so the
//! force depends on the time step; the product has no such corrections (see
//! `palpate::stages::force::compensation`).

pub mod averaged;
pub mod barycentre;
pub mod damper;
pub mod direction;
pub mod length;
mod local_compression;
pub mod over_compression;
pub mod region;
pub mod velocity_verlet;
mod volume_preserved;

pub use local_compression::LocalCompression;
pub use volume_preserved::VolumePreserved;

use palpate::Tuned;

/// Shares of a correction by which the two ends of a spring move (1). If one end is fixed, the free
/// end moves by the whole correction; the papers do not mention this case.
fn shares(tuned: &Tuned, i: usize, j: usize) -> [f32; 2] {
    let free = |n: usize| tuned.node_step().get(n).is_some_and(|node| node.step > 0.0);
    match (free(i), free(j)) {
        (true, true) => [0.5, 0.5],
        (true, false) => [1.0, 0.0],
        (false, true) => [0.0, 1.0],
        (false, false) => [0.0, 0.0],
    }
}
