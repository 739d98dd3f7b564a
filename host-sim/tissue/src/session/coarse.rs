//! Elements that are too coarse for the probe: how soft they make a press, and when it is refused.

use crate::patch::Patch;
use crate::scene::{Scene, SceneError};
use crate::tissue::Tissue;
use crate::tissue::organ::element_at_m;

/// Largest element of a mesh file at the site, in probe radii (1): up to there the force is at most
/// three tenths too low.
pub const COARSEST_RADII: f64 = 1.35;

/// Share of the force that is missing at worst [%] with elements of this size at the site, in probe
/// radii, if the patch is not calibrated: the block in elements of one size on two lattices,
/// pressed by an eighth to half of the radius at 4 to 6 places, against finite elements. With
/// smaller elements the error is that of any uncalibrated patch; with 1.44 and 1.65 radii 43 and
/// 100 % are missing.
const MISSING_PCT: [(f64, f64); 4] = [(0.75, 12.0), (1.0, 20.0), (1.25, 25.0), (1.34, 28.0)];

/// Share of the force that may be missing because the elements under the probe are coarse [%];
/// `None` if they are fine enough, or if a calibration makes up for them. A built-in shape has a
/// node at the site, and loses less.
#[must_use]
pub fn missing_pct(scene: &Scene, patch: &Patch) -> Option<f64> {
    let radii = patch.element_m() / scene.probe.radius_m;
    let is_counted = patch.fitted_places() == 0 && (scene.tissue.mesh.is_some() || radii > 1.0);
    is_counted.then(|| missing_at_pct(radii)).flatten()
}

fn missing_at_pct(radii: f64) -> Option<f64> {
    let [(finest, _), .., (_, most_pct)] = MISSING_PCT;
    if radii <= finest {
        return None;
    }
    let between = MISSING_PCT.windows(2).find_map(|pair| match *pair {
        [(low, low_pct), (high, high_pct)] if radii <= high => {
            Some(low_pct + (high_pct - low_pct) * (radii - low) / (high - low))
        }
        _ => None,
    });
    Some(between.unwrap_or(most_pct))
}

/// Refuses the mesh of a file that the tick cannot hold, or whose elements are too coarse for the
/// probe: it would press between the nodes, with too little force or none.
pub(super) fn refuse(scene: &Scene, tissue: &Tissue) -> Result<(), SceneError> {
    let nodes = tissue.mesh.nodes_m.len();
    let cut = format!("palpate fit --scene {} cuts out a piece with fine elements of its own", scene.file);
    let most = usize::from(u16::MAX);
    if nodes > most {
        return scene.bad("tissue.mesh", &format!("has {nodes} nodes, more than the {most} of a tick: {cut}"));
    }
    let (element_m, radius_m) = (element_at_m(&tissue.mesh, tissue.site_m), scene.probe.radius_m);
    if element_m > COARSEST_RADII * radius_m {
        let [element_mm, radius_mm, most_mm] = [element_m, radius_m, COARSEST_RADII * radius_m].map(|m| m * 1e3);
        let why = format!(
            "has elements of {element_mm:.1} mm at the site, too large for a probe of radius {radius_mm:.1} mm: {cut}; or make them at most {most_mm:.1} mm there"
        );
        return scene.bad("tissue.mesh", &why);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_coarser_the_elements_the_more_force_is_missing() {
        assert_eq!(missing_at_pct(0.7), None);
        let at = [0.76, 0.9, 1.0, 1.1, 1.3, 3.0].map(|radii| missing_at_pct(radii).unwrap());
        assert!(at.is_sorted() && at[0] < at[1] && at[2] < at[3], "{at:?}");
        assert!((at[2] - MISSING_PCT[1].1).abs() < 1e-9 && (at[5] - MISSING_PCT[3].1).abs() < 1e-9);
    }
}
