//! No force acts while the sensed tip is outside the tissue, whatever path led there; no force
//! points into the tissue; no force alternates at rest. The checks use the readings and the rest
//! geometry of the patch, never the contact that patch or loop report.

mod campaign;
mod long_tips;
mod named;
mod shapes;
mod watch;

use std::sync::LazyLock;

use palpate_lab::faults::paths::PathGround;

pub use self::long_tips::tilted;

/// Every shipped patch with every tip. Each is pressed once to find the depth of its guard, which
/// takes some seconds of processor time, so all tests share the result.
static GROUND: LazyLock<PathGround> = LazyLock::new(|| PathGround::load().unwrap());

/// Index of the patch with this name.
fn patch_named(ground: &PathGround, name: &str) -> usize {
    ground.patches.iter().position(|patch| patch.name == name).expect("a shipped patch")
}
