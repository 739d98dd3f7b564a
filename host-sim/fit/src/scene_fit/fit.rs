//! Meshes the patch of a block, and collects the targets of its fit.

use palpate::{Params, Probe, ProbeShape};

use super::presses::{DENTS, Presses};
use crate::calibrate::targets::{DISC_RADII, DiscPresses, Reference};
use crate::calibrate::{Calibration, Round, Settings, Targets, calibrate};
use crate::force_map::BlockForces;
use crate::statics::Vector;
use palpate_tissue::error::Error;
use palpate_tissue::patch::{Material, Patch};
use palpate_tissue::scene::Scene;
use palpate_tissue::tissue::{Tissue, place_fine};

/// Radius around the site within which elements are smallest [probe radii].
const FINE_RADII: f64 = 1.25;
/// Element size, as a share of the probe's radius, above which triangles have nine foundation
/// points instead of four (1).
const NINE_ABOVE: f64 = 0.4;
/// Element size, as a multiple of the radius of the shallowest contact, above which triangles have
/// sixteen points (1). The stiffness of a contact that covers only few points changes as it moves
/// over them.
const SIXTEEN_ABOVE: f64 = 1.85;
/// Difference below which two depths count as equal [m].
const SAME_M: f64 = 1e-6;
/// Relative deviation of a force that counts as one unit of error (1), at the centre and away from
/// it.
pub(super) const CENTRE_TOLERANCE: f64 = 0.002;
const TOLERANCE: f64 = 0.005;
/// Smallest factor on the requested number of places at each depth, times the depth in probe radii
/// (1): with it, enough contacts cover the disc of places.
const PER_CONTACT: f64 = 0.1875;
/// Depths of the fit at the centre, as shares of the deepest hold (1). With the solved depths
/// alone, a fit oscillates between them.
const CENTRE: [f64; 9] = [1.0 / 12.0, 0.103, 1.0 / 6.0, 0.21, 1.0 / 3.0, 0.42, 2.0 / 3.0, 0.75, 1.0];
/// Depths of the fit away from the centre, as shares of the deepest hold, each with its own places,
/// and the factor on the requested number of places (1).
const ASIDE: [(f64, f64); 5] = [(1.0 / 12.0, 3.0), (1.0 / 6.0, 2.5), (1.0 / 3.0, 1.25), (2.0 / 3.0, 0.75), (1.0, 0.6)];
/// Number of depths, from the shallowest, that are pressed at additional places under a flat end;
/// `SHALLOW_PLACES` is the factor on the requested number of places. The edge of a flat end makes
/// an equilibrium hard to find from a distant start, so that each place is pressed to one depth
/// after the other.
const SHALLOW_DEPTHS: usize = 2;
/// Deviation of a surface node, as a share of the depth, that counts as one unit of error (1), for
/// each depth of a dent.
const DENT_TOLERANCES: [f64; 3] = [0.008, 0.008, 0.004];
/// Relative deviation of a glued disc's force that counts as one unit of error (1); it is large
/// because there are many discs.
const GLUED_TOLERANCE: f64 = 0.006;
const SHALLOW_PLACES: usize = 2;

/// The patch of a scene before the fit.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// Meshed tissue of the block.
    pub tissue: Tissue,
    /// Constants of the material.
    pub material: Material,
    /// Parameters of the scene.
    pub params: Params,
}

/// Nodes on the top of a block, with their positions [m].
fn top_nodes(tissue: &Tissue) -> Vec<(usize, Vector)> {
    let top = (0..).zip(&tissue.mesh.nodes_m).filter(|(_, x)| (x[2] - tissue.site_m[2]).abs() < 1e-9);
    top.map(|(n, x)| (n, Vector::from(*x))).collect()
}

/// Meshes the block of a scene for its patch.
///
/// # Errors
/// Fails if the block cannot be meshed with such elements.
pub fn prepare(scene: &Scene) -> Result<Prepared, Error> {
    let placed = place_fine(scene, &[], FINE_RADII)?;
    let params = scene.params(placed.axis);
    let material = Material { poisson_ratio: scene.tissue.poisson_ratio, ..Material::default() };
    let element_m = Patch::build(&placed.tissue, &material, None).element_m();
    let points_per_triangle = if element_m > NINE_ABOVE * scene.probe.radius_m { 9 } else { 4 };
    Ok(Prepared { tissue: placed.tissue, material: Material { points_per_triangle, ..material }, params })
}

/// Returns the requested number of foundation points per triangle if it is allowed.
///
/// # Errors
/// Fails for a number other than 4, 9 and 16.
fn checked_points(count: usize) -> Result<usize, Error> {
    match count {
        4 | 9 | 16 => Ok(count),
        _ => Err(Error::Usage(format!("--points {count}: a triangle has 4, 9 or 16 points"))),
    }
}

impl Prepared {
    /// Returns the patch with the given number of foundation points per surface triangle, if one is
    /// given.
    ///
    /// # Errors
    /// Fails for a number other than 4, 9 and 16.
    pub fn with_points(mut self, points: Option<usize>) -> Result<Self, Error> {
        if let Some(points) = points {
            self.material.points_per_triangle = checked_points(points)?;
        }
        Ok(self)
    }

    /// Returns the patch with sixteen foundation points per triangle if its elements are large
    /// compared with the shallowest contact. Boards cannot run such a patch.
    #[must_use]
    pub fn with_enough_points(mut self, scene: &Scene, presses: &Presses) -> Self {
        let contact_m = presses.fitted_m.first().map_or(f64::INFINITY, |m| scene.probe.tip().contact_radius_m(*m));
        if self.uncalibrated().element_m() > SIXTEEN_ABOVE * contact_m {
            self.material.points_per_triangle = 16;
        }
        self
    }

    /// Patch with stiffnesses from the formulas alone.
    #[must_use]
    pub fn uncalibrated(&self) -> Patch {
        Patch::build(&self.tissue, &self.material, None)
    }

    /// Fits the patch to the known answers.
    ///
    /// # Errors
    /// Fails if the reference lacks presses, if the patch cannot be pressed, or if the fit brings
    /// no improvement.
    pub fn fit(
        &self,
        scene: &Scene,
        presses: &Presses,
        known: &BlockForces,
        settings: &Settings,
        progress: &mut dyn FnMut(&Round),
    ) -> Result<Calibration, Error> {
        let lacks = || Error::Check(format!("{}: the finite elements lack presses that the fit needs: fit it anew", scene.file));
        let targets = self.targets(presses, known, settings.places).ok_or_else(lacks)?;
        let fit = calibrate(&self.tissue, &self.material, None, &self.params, &targets, settings, progress)
            .map_err(|cause| Error::Usage(format!("{}: {cause}", scene.file)))?;
        if !matches!((fit.rounds.first(), fit.rounds.last()), (Some(first), Some(last)) if last.cost < first.cost) {
            let why = "the fit did not improve the patch, nothing is written: take more --places or another --nodes";
            return Err(Error::Check(why.into()));
        }
        Ok(fit)
    }

    fn targets(&self, presses: &Presses, known: &BlockForces, places: usize) -> Option<Targets> {
        let centre_m = Vector::from(self.tissue.site_m);
        let radius_m = f64::from(self.params.probe.radius_m);
        let deepest_m = presses.fitted_m.last()?;
        // depths equal the solved ones to the last bit, because no force is known above the
        // shallowest of them, and dents are known only at solved depths
        let solved =
            |depth_m: f64| *presses.fitted_m.iter().find(|solved| (**solved - depth_m).abs() < SAME_M).unwrap_or(&depth_m);
        let depths = |shares: &[f64], tolerance: f64| -> Vec<(f64, f64)> {
            shares.iter().map(|share| (solved(share * deepest_m), tolerance)).collect()
        };
        let aside = ASIDE.map(|(share, times)| (solved(share * deepest_m), times));
        let disc = DiscPresses {
            centre: depths(&CENTRE, CENTRE_TOLERANCE),
            aside: aside_of(places, &self.params.probe, &aside),
            dents: DENTS.iter().zip(DENT_TOLERANCES).map(|(n, tolerance)| (presses.fitted_m[*n], tolerance)).collect(),
        };
        let targets = Targets::over(known, &top_nodes(&self.tissue), centre_m, radius_m, DISC_RADII, &disc)?;
        Some(targets.with_glued(known.glued(), GLUED_TOLERANCE))
    }
}

/// Pairs of a number of places and the depths at each of them. `depths` are depths [m] with their
/// smallest factor on the number `asked` of places. Shallow depths need more places, because a
/// small contact rests on few foundation points, whereas a large one averages over many.
pub(super) fn aside_of(asked: usize, probe: &Probe, depths: &[(f64, f64)]) -> Vec<(usize, Vec<(f64, f64)>)> {
    if probe.shape == ProbeShape::Flat {
        let all: Vec<(f64, f64)> = depths.iter().map(|(depth_m, _)| (*depth_m, TOLERANCE)).collect();
        let shallow = all.iter().take(SHALLOW_DEPTHS).copied().collect();
        return vec![(asked, all), (SHALLOW_PLACES * asked, shallow)];
    }
    let of = |(depth_m, times): &(f64, f64)| {
        let times = times.max(PER_CONTACT * f64::from(probe.radius_m) / depth_m);
        ((times * asked as f64) as usize, vec![(*depth_m, TOLERANCE)])
    };
    depths.iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::places::random;
    use crate::pressed_patch::rms;
    use crate::scene_fit::Level;
    use crate::statics::Statics;
    use palpate_tissue::scene::PRESETS;

    const RADIUS_M: f64 = 0.008;

    fn block(nodes: usize) -> (Scene, Prepared) {
        let mut scene = Scene::parse("block", PRESETS[0].1).unwrap();
        scene.tissue.nodes = Some(nodes);
        let prepared = prepare(&scene).unwrap();
        (scene, prepared)
    }

    #[test]
    fn a_fit_takes_more_points_where_its_shallowest_contact_is_small_beside_an_element() {
        for (nodes, calibrated, fitted) in [(130, 9, 16), (410, 9, 9)] {
            let (scene, prepared) = block(nodes);
            assert_eq!(prepared.material.points_per_triangle, calibrated, "{nodes} nodes");
            let mut presses = Presses::of(&scene, &prepared.tissue, Level::Full);
            // the shallowest fitted depth is a twelfth of 6 mm, whatever the holds of the scene
            presses.fitted_m[0] = 0.0005;
            let enough = prepared.clone().with_enough_points(&scene, &presses);
            assert_eq!(enough.material.points_per_triangle, fitted, "fit, {nodes} nodes");
            for asked in [4, 9, 16] {
                assert_eq!(enough.clone().with_points(Some(asked)).unwrap().material.points_per_triangle, asked);
            }
            let refused = enough.with_points(Some(10)).unwrap_err().to_string();
            assert!(refused.contains("4, 9 or 16"), "{refused}");
        }
    }

    /// Tests the foundation alone, on tissue that does not deform: the force of a sphere as summed
    /// over the foundation points, at places all over the fine elements of 130 nodes, is compared
    /// with the integral.
    #[test]
    fn sixteen_points_integrate_a_small_contact_better_than_nine() {
        let (_, prepared) = block(130);
        let scatter_pct = |points: usize, depth_m: f64| {
            let patch = prepared.clone().with_points(Some(points)).unwrap().uncalibrated();
            let mut statics = Statics::of(&patch.model(), &prepared.params).unwrap();
            statics.stiffening_per_m = 0.0;
            for triangle in &mut statics.triangles {
                let [a, b, c] = triangle.node.map(|n| statics.rest_m[n]);
                triangle.k.fill(0.5 * (b - a).cross(&(c - a)).norm() / points as f64);
            }
            let push = |r_m: f64| {
                let away_m = r_m.hypot(RADIUS_M - depth_m);
                (RADIUS_M - away_m).max(0.0) * (RADIUS_M - depth_m) / away_m
            };
            let rings = 2000;
            let ring = |n: usize| (n as f64 + 0.5) * RADIUS_M / f64::from(rings as u32);
            let width_m = RADIUS_M / f64::from(rings as u32);
            let wanted: f64 = (0..rings).map(|n| std::f64::consts::TAU * ring(n) * push(ring(n)) * width_m).sum();
            let errors: Vec<f64> = random(200, RADIUS_M, 7)
                .into_iter()
                .map(|[x, y]| {
                    let tip_m = Vector::new(x, y, -depth_m);
                    100.0 * (statics.slope(&statics.rest_m, tip_m).1 / wanted - 1.0)
                })
                .collect();
            rms(&errors)
        };
        for depth_m in [0.0005, 0.001] {
            let [four, nine, sixteen] = [4, 9, 16].map(|points| scatter_pct(points, depth_m));
            assert!(sixteen < 0.65 * nine && nine < 0.65 * four, "{depth_m} m: {four} {nine} {sixteen} %");
        }
    }
}
