//! No force acts where the sensed tip is outside the tissue, whatever path took it there; none
//! points into the tissue; none alternates at rest. This is checked from the readings and the rest
//! geometry of the patch, never from the contact reported by the patch or the loop.

mod campaign;
mod long_tips;
mod named;
mod shapes;
mod watch;

use std::sync::LazyLock;

use palpate_loop::closed_loop::paths::PathGround;

/// Every shipped patch under every tip. Each is pressed once for the depth of its guard, which
/// takes some seconds of processor time, so all tests share them.
static GROUND: LazyLock<PathGround> = LazyLock::new(|| PathGround::load().unwrap());

/// The index of a patch by name.
fn patch_named(ground: &PathGround, name: &str) -> usize {
    ground.patches.iter().position(|patch| patch.name == name).expect("a shipped patch")
}
