//! No force acts where the sensed tip is outside the tissue, whatever path took it there; none
//! points into the tissue; none turns round at rest. Judged from the readings and the rest geometry
//! of the patch, never from what the patch or the loop says of contact.

mod campaign;
mod long_tips;
mod named;
mod shapes;
mod watch;

use palpate_loop::closed_loop::paths::PathGround;

/// The index of a patch by name.
fn patch_named(ground: &PathGround, name: &str) -> usize {
    ground.patches.iter().position(|patch| patch.name == name).expect("a shipped patch")
}
