//! Force of the standard press, from converged finite elements.

use crate::scene::{Scene, Shape};

/// Depth [m] and force over E [m^2] of the standard press: block 80 x 80 x 40 mm, bottom fixed, frictionless hemisphere R = 8 mm at the centre of the
/// top, neo-Hookean, nu = 0.45; within 0.3 %.
pub const STANDARD_PRESS: [(f64, f64); 3] = [(0.002, 14.065e-6), (0.004, 39.65e-6), (0.008, 107.0e-6)];

/// Depth [m] and force [N], if the scene is the standard press at any stiffness; empty otherwise.
#[must_use]
pub fn of(scene: &Scene) -> Vec<(f64, f64)> {
    let tissue = &scene.tissue;
    let standard = tissue.block_m == Some([0.08, 0.08, 0.04])
        && tissue.inclusion.is_empty()
        && tissue.gravity_m_per_s2 == [0.0; 3]
        && tissue.poisson_ratio == 0.45
        && scene.probe.shape == Shape::Hemisphere
        && scene.probe.radius_m == 0.008
        && scene.probe.position_m.unwrap_or_default() == [0.0, 0.0];
    match standard {
        true => STANDARD_PRESS.iter().map(|&(depth, over_e)| (depth, over_e * tissue.youngs_modulus_pa)).collect(),
        false => Vec::new(),
    }
}
