//! A flat end that is tilted, on a shipped patch.
#![cfg(feature = "long-tips")]

use palpate::ProbeShape;

use super::guard::Tissue;

/// Level tissue stores as much energy wherever it is pressed, so its force has no part along the
/// surface. Pushed along the axis of the flat end it would lean as much as the end does.
#[test]
fn a_tilted_flat_end_pushes_level_tissue_straight_down() {
    for degrees in [10.0_f32, 20.0, 30.0] {
        let (sin, cos) = (0.5 * degrees.to_radians()).sin_cos();
        let mut tissue = Tissue::fine(|params| {
            (params.probe.shape, params.probe.radius_m) = (ProbeShape::Flat, 6e-3);
            params.orientation = [0.0, sin, 0.0, cos];
        });
        let felt_n = tissue.press(3e-3).force_n;
        let leans = libm::hypotf(felt_n.x, felt_n.y) / felt_n.z;
        assert!(felt_n.z > 0.02 && leans < 0.4 * degrees.to_radians().tan(), "{degrees} degrees: {felt_n}, leans by {leans}");
    }
}
