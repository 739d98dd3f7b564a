//! Targets of a calibration: forces at places over a disc, dents at its centre, and discs glued to
//! the surface.

use super::places::sunflower;
use crate::statics::Vector;
use palpate_tissue::answer::GluedAnswer;

/// Radius of the disc over which places are spread on a whole block [probe radii]: slightly larger
/// than 1.5, the radius within which the force must keep its tolerance.
pub const DISC_RADII: f64 = 1.65;
/// Radius around the centre within which a dent is compared [probe radii].
const DENT_RADII: f64 = 2.5;

/// Target force at one depth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceTarget {
    /// Depth of the tip [m].
    pub depth_m: f64,
    /// Force along the direction of the press, over E [m^2].
    pub force: f64,
    /// Relative deviation that counts as one unit of error (1).
    pub tolerance: f64,
}

/// Target dent at one depth: displacements of surface nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct DentTarget {
    /// Depth of the tip [m].
    pub depth_m: f64,
    /// Pairs of a node and its displacement [m].
    pub nodes: Vec<(usize, Vector)>,
    /// Deviation that counts as one unit of error [m].
    pub tolerance_m: f64,
}

/// Targets of the presses at one place.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaceTarget {
    /// Place on the rest surface [m].
    pub place_m: Vector,
    /// Target forces, in the order of increasing depth.
    pub forces: Vec<ForceTarget>,
    /// Target dents; their depths are among those of the forces.
    pub dents: Vec<DentTarget>,
}

/// Target of a disc that is glued to the surface and moved slightly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GluedTarget {
    /// Centre of the disc on the rest surface [m].
    pub place_m: Vector,
    /// Radius of the disc [m].
    pub radius_m: f64,
    /// Direction of the disc's motion, a unit vector.
    pub direction: Vector,
    /// Force along the displacement over E, divided by the displacement [m].
    pub stiffness_m: f64,
    /// Relative deviation that counts as one unit of error (1).
    pub tolerance: f64,
}

/// All targets of a fit. The first place is the centre.
#[derive(Clone, Debug, PartialEq)]
pub struct Targets {
    /// Targets at each place; the first is the centre.
    pub places: Vec<PlaceTarget>,
    /// Targets of glued discs, pressed and sheared; there may be none.
    pub glued: Vec<GluedTarget>,
    /// Centre of the places on the rest surface [m].
    pub centre_m: Vector,
    /// Radius of the probe [m].
    pub radius_m: f64,
    /// Radius of the disc of places [probe radii].
    pub disc_radii: f64,
}

/// Depths of the presses over a disc of places [m], each with the relative deviation that counts as
/// one unit of error (1).
#[derive(Clone, Debug, PartialEq)]
pub struct DiscPresses {
    /// Presses at the centre, in the order of increasing depth.
    pub centre: Vec<(f64, f64)>,
    /// Presses away from the centre: pairs of a number of places and the depths at each of them.
    pub aside: Vec<(usize, Vec<(f64, f64)>)>,
    /// Depths of the dents at the centre that are compared [m], a subset of the depths in `centre`,
    /// each with the deviation, as a share of the depth, that counts as one unit of error (1).
    pub dents: Vec<(f64, f64)>,
}

/// A reference solution; a query returns `None` if it has no answer. Places are relative to the
/// site.
pub trait Reference: Sync {
    /// Force over E [m^2] of a press at `place_m` to `depth_m`.
    fn force(&self, place_m: Vector, depth_m: f64) -> Option<f64>;
    /// Depth of the deepest centred press [m].
    fn deepest_m(&self) -> f64;
    /// Depth of the shallowest press [m].
    fn shallowest_m(&self) -> f64 {
        0.0
    }
    /// Place on the surface [m] above or below an offset in the tangent plane at the site [m]; on a
    /// flat top the place is in that plane.
    fn place_m(&self, offset_m: [f64; 2]) -> Option<Vector> {
        Some(Vector::new(offset_m[0], offset_m[1], 0.0))
    }
    /// Height above the site, along the press, at which the tip touches first when it comes down at
    /// an offset from the site [m].
    fn touch_m(&self, _offset_m: [f64; 2]) -> Option<f64> {
        Some(0.0)
    }
    /// Answers for discs glued to the surface; there may be none.
    fn glued(&self) -> &[GluedAnswer] {
        &[]
    }
    /// Displacement of the surface at `offset_m` from the site under a centred press to `depth_m`
    /// [m].
    fn displacement_m(&self, depth_m: f64, offset_m: [f64; 2]) -> Option<[f64; 3]>;
}

impl Targets {
    /// Total number of presses.
    #[must_use]
    pub fn presses(&self) -> usize {
        self.places.iter().map(|place| place.forces.len()).sum()
    }

    /// The presses of `disc` within `disc_radii` probe radii, to all depths that the reference has,
    /// with dents at the nodes `surface`, if there are any.
    #[must_use]
    pub fn over(
        reference: &(impl Reference + ?Sized),
        surface: &[(usize, Vector)],
        centre_m: Vector,
        radius_m: f64,
        disc_radii: f64,
        disc: &DiscPresses,
    ) -> Option<Self> {
        let near: Vec<&(usize, Vector)> =
            surface.iter().filter(|(_, x)| (x - centre_m).norm() <= DENT_RADII * radius_m).collect();
        let dent = |(depth_m, tolerance): &(f64, f64)| {
            let node = |(n, x): &&(usize, Vector)| {
                let offset = x - centre_m;
                reference.displacement_m(*depth_m, [offset.x, offset.y]).map(|u| (*n, Vector::from(u)))
            };
            let nodes = near.iter().map(node).collect::<Option<Vec<_>>>()?;
            Some(DentTarget { depth_m: *depth_m, nodes, tolerance_m: tolerance * depth_m })
        };
        // dents need surface nodes that can be compared
        let dents = disc.dents.iter().filter(|_| !surface.is_empty()).map(dent).collect::<Option<Vec<_>>>()?;
        let at_centre = forces(reference, Vector::zeros(), &disc.centre)?;
        let mut all = vec![PlaceTarget { place_m: centre_m, forces: at_centre, dents }];
        for (places, depths) in &disc.aside {
            for [x, y] in sunflower(*places, disc_radii * radius_m) {
                let offset_m = reference.place_m([x, y])?;
                let forces = forces(reference, offset_m, depths)?;
                all.push(PlaceTarget { place_m: centre_m + offset_m, forces, dents: Vec::new() });
            }
        }
        Some(Self { places: all, glued: Vec::new(), centre_m, radius_m, disc_radii })
    }

    /// Returns the targets with the glued discs of an answer, whose places are relative to the
    /// centre. A relative deviation of `tolerance` (1) counts as one unit of error.
    #[must_use]
    pub fn with_glued(mut self, answers: &[GluedAnswer], tolerance: f64) -> Self {
        let target = |disc: &GluedAnswer| GluedTarget {
            place_m: self.centre_m + Vector::from(disc.place_m),
            radius_m: disc.radius_m,
            direction: disc.direction.into(),
            stiffness_m: disc.stiffness_over_e_m,
            tolerance,
        };
        self.glued = answers.iter().map(target).collect();
        self
    }

    /// Radius around the centre that contains all contacts [m].
    #[must_use]
    pub fn reach_m(&self) -> f64 {
        (self.disc_radii + 1.0) * self.radius_m
    }
}

/// Target forces at an offset from the centre, for those of `depths` [m] that the reference has,
/// with their tolerances (1); `None` if the reference does not have the place.
fn forces(reference: &(impl Reference + ?Sized), offset_m: Vector, depths: &[(f64, f64)]) -> Option<Vec<ForceTarget>> {
    let solved = reference.shallowest_m()..=reference.deepest_m() * (1.0 + 1e-9);
    let known = depths.iter().filter(|(depth_m, _)| solved.contains(depth_m));
    let at =
        |&(depth_m, tolerance): &(f64, f64)| Some(ForceTarget { depth_m, force: reference.force(offset_m, depth_m)?, tolerance });
    known.map(at).collect()
}
