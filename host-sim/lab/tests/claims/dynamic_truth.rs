//! The dynamic reference is verified against closed-form waves and modes, against the static
//! reference, against an independent computation, and against its own stored tables.

mod bar;
mod moving;
mod stored;

use palpate_lab::dynamic::settings::Settings;
use palpate_tissue::scene::Scene;

/// Settings whose mesh and step take seconds; finer ones change the force by about one per cent.
fn coarse() -> Settings {
    Settings { corner_nodes: 160, fine_radius_m: Some(0.0035), ..Settings::default() }
}

fn block() -> Scene {
    Scene::load("block").expect("a preset")
}
