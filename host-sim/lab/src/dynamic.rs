//! The dynamic reference (*truth*): the force on a moving probe, computed by finite elements with
//! true masses.
//!
//! ```text
//! scene ─ piece ─┐
//! motion ────────┼─ march (inertial step, implicit) ─ history ─ truths (the stored table)
//! settings ──────┘
//! ```
//!
//! The elements, the energy of the tissue and the frictionless penalty contact are those of the
//! static [`reference`](palpate_fit::reference). This module adds consistent masses, the node
//! damping of the product (a force of damping times mass times velocity) and an implicit time step
//! ([`scheme`]). Every step is the minimum of a potential, which the Newton's method of the static
//! reference finds. Nothing is shared with the real-time core, so the two verify each other.
//!
//! # Convergence
//! Force over Young's modulus [mm^2] of the preset block (3.5 kPa) during a ramp to 4 mm, for
//! several numbers of corner nodes of the quarter, fine radii and time steps:
//!
//! | speed | nodes | fine | step | 0.4 mm | 1 mm | 2 mm | 3 mm | 4 mm |
//! |---|---|---|---|---|---|---|---|---|
//! | 200 mm/s | 150 | 6 mm | 1 ms | 3.17 | 8.47 | 20.42 | 33.98 | 48.87 |
//! | | 150 | 6 mm | 0.125 ms | 3.26 | 8.56 | 20.24 | 34.00 | 48.89 |
//! | | 400 | 6 mm | 1 ms | 2.94 | 8.48 | 20.23 | 33.74 | 48.58 |
//! | | 400 | 6 mm | 0.25 ms | 2.97 | 8.50 | 20.16 | 33.74 | 48.56 |
//! | | 400 | 3 mm | 1 ms | 3.07 | 8.66 | 20.20 | 33.79 | 48.64 |
//! | | 400 | 3 mm | 0.25 ms | 3.07 | 8.63 | 20.22 | 33.81 | 48.62 |
//! | | 800 | 6 mm | 0.5 ms | 3.15 | 8.61 | 20.20 | 33.69 | 48.53 |
//! | | 1000 | 3.5 mm | 1 ms | 3.11 | 8.61 | 20.19 | 33.70 | 48.54 |
//! | | 500, as stored | 3.5 mm | 1 ms | 3.09 | 8.62 | 20.24 | 33.76 | 48.54 |
//! | 40 mm/s | 150 | 6 mm | 1 ms | 1.53 | 5.52 | 14.86 | 26.85 | 40.88 |
//! | | 400 | 6 mm | 1 ms | 1.50 | 5.45 | 14.76 | 26.70 | 40.63 |
//! | | 400 | 6 mm | 2 ms | 1.50 | 5.45 | 14.76 | 26.70 | 40.62 |
//! | | 500, as stored | 3.5 mm | 2 ms | 1.48 | 5.43 | 14.75 | 26.70 | 40.72 |
//!
//! The stored forces are thus accurate to 0.5 % from 2 mm on, to 1 % at 1 mm and to 3 % at 0.4 mm,
//! where the edge of the contact crosses only a few elements. A press at a place 7.85 mm from the
//! centre (200 mm/s) was computed on half of the block and, with the place rotated about the
//! centre, on the whole block: the forces differ by at most 0.7 % from 0.8 mm on. The horizontal
//! force in a frictionless drag is smaller than the mesh resolves: on average 0.05 mm^2 opposite to
//! the motion, with a ripple of the same size.

pub mod error;
pub mod fading;
pub mod history;
mod inertial;
pub mod march;
pub mod motion;
pub mod piece;
pub mod scheme;
pub mod settings;
mod task;
pub mod truths;

use error::DynamicError;
use history::History;
use march::MovingScene;
use motion::Motion;
use palpate_tissue::scene::Scene;
use piece::Piece;
use settings::Settings;

/// Computes the force on a probe that performs `motion` from the place at which the scene presses.
/// The drive of the scene is ignored.
pub fn compute(scene: &Scene, motion: &Motion, settings: &Settings) -> Result<History, DynamicError> {
    compute_with(scene, motion, settings, |_| {})
}

/// Like [`compute`], and calls `progress` with the time [s] after every step.
pub fn compute_with(
    scene: &Scene,
    motion: &Motion,
    settings: &Settings,
    progress: impl FnMut(f64),
) -> Result<History, DynamicError> {
    motion.check()?;
    settings.check()?;
    let piece = Piece::of(scene, motion, settings)?;
    MovingScene::new(scene, motion, settings, &piece)?.run(progress)
}
