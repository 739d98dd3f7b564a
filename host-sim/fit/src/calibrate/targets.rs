//! Targets of a calibration: forces at places over a disc, dents at its centre, and discs glued to
//! the surface.

use super::places::sunflower;
use crate::statics::Vector;
use palpate_tissue::answer::GluedAnswer;

/// Radius of the disc over which places are spread on a whole block [probe radii]: slightly larger
/// than 1.5, the radius within which the force must keep its tolerance.
pub const DISC_RADII: f64 = 1.65;
/// Depths of the presses at every place [probe radii].
pub const DEPTHS_RADII: [f64; 5] = [0.0625, 0.125, 0.25, 0.5, 0.875];
/// Depths of the presses at the centre [probe radii].
const CENTRE_DEPTHS_RADII: [f64; 5] = [0.0625, 0.125, 0.25, 0.5, 1.0];
/// Depths of the presses along a stroke [probe radii]: 0.5, 1, 2, 4 mm for a radius of 8 mm, so
/// that a slide at a depth of 3 mm is not part of the fit.
const STROKE_DEPTHS_RADII: [f64; 4] = [0.0625, 0.125, 0.25, 0.5];
/// Distance by which the places extend beyond both ends of a stroke [probe radii].
const STROKE_ENDS_RADII: f64 = 0.125;
/// Depths at which dents are compared [probe radii].
const DENT_DEPTHS_RADII: [f64; 2] = [0.25, 0.5];
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

    /// Presses at the centre and at `places` further places within `disc_radii` probe radii, to all
    /// depths that the reference has, with dents at the nodes `surface`, if there are any.
    #[must_use]
    pub fn over_a_disc(
        reference: &(impl Reference + ?Sized),
        surface: &[(usize, Vector)],
        centre_m: Vector,
        radius_m: f64,
        disc_radii: f64,
        places: usize,
    ) -> Option<Self> {
        let pressed = |depths: &[f64]| depths.iter().map(|depth| (depth * radius_m, tolerance(*depth))).collect();
        let disc = DiscPresses {
            centre: pressed(&CENTRE_DEPTHS_RADII),
            aside: vec![(places, pressed(&DEPTHS_RADII))],
            dents: DENT_DEPTHS_RADII.iter().map(|depth| (depth * radius_m, DENT_TOLERANCE)).collect(),
        };
        Self::over(reference, surface, centre_m, radius_m, disc_radii, &disc)
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

    /// Presses along a stroke on a flat top (normal along z). The stroke is centred on `centre_m`;
    /// the places extend over `half_width_m` to both sides and form a golden-ratio lattice, after
    /// the centre. Returns `None` if the reference has no answer.
    #[must_use]
    pub fn over_a_stroke(
        reference: &(impl Reference + ?Sized),
        centre_m: Vector,
        stroke_m: [f64; 3],
        half_width_m: f64,
        radius_m: f64,
        places: usize,
    ) -> Option<Self> {
        let stroke = Vector::from(stroke_m);
        let along = stroke.try_normalize(0.0).unwrap_or_else(Vector::x);
        let half_length_m = 0.5 * stroke.norm() + STROKE_ENDS_RADII * radius_m;
        let across = Vector::z().cross(&along);
        let depths = STROKE_DEPTHS_RADII.map(|depth| (depth * radius_m, tolerance(depth)));
        let press = |offset_m: Vector| {
            let forces = forces(reference, offset_m, &depths)?;
            Some(PlaceTarget { place_m: centre_m + offset_m, forces, dents: Vec::new() })
        };
        let mut all = vec![press(Vector::zeros())?];
        for n in 0..places {
            let share = (n as f64 + 0.5) / places as f64;
            let aside = (GOLDEN_RATIO * (n as f64 + 0.5)).fract();
            let offset = along * (half_length_m * (2.0 * share - 1.0)) + across * (half_width_m * (2.0 * aside - 1.0));
            all.push(press(offset)?);
        }
        let disc_radii = half_length_m.hypot(half_width_m) / radius_m;
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

    /// Returns the targets with other depths [probe radii] at the centre, as far as the reference
    /// has them, and with the weight of these presses multiplied by `weight`.
    #[must_use]
    pub fn with_centre(mut self, reference: &(impl Reference + ?Sized), depths_radii: &[f64], weight: f64) -> Option<Self> {
        let depths: Vec<(f64, f64)> =
            depths_radii.iter().map(|depth| (depth * self.radius_m, tolerance(*depth) / weight)).collect();
        self.places.first_mut()?.forces = forces(reference, Vector::zeros(), &depths)?;
        Some(self)
    }

    /// Radius around the centre that contains all contacts [m].
    #[must_use]
    pub fn reach_m(&self) -> f64 {
        (self.disc_radii + 1.0) * self.radius_m
    }
}

/// Relative deviation of a force that counts as one unit of error (1).
const FORCE_TOLERANCE: f64 = 0.005;
/// Relative deviation of a glued disc's force that counts as one unit of error (1), if there are
/// only a few discs.
pub const GLUED_TOLERANCE: f64 = 0.002;
/// Deviation of a surface node, as a share of the depth, that counts as one unit of error (1).
const DENT_TOLERANCE: f64 = 0.008;

/// The golden ratio: the fractional parts of its multiples spread places most evenly over an
/// interval.
const GOLDEN_RATIO: f64 = 1.618_033_988_749_895;

/// Target forces at an offset from the centre, for those of `depths` [m] that the reference has,
/// with their tolerances (1); `None` if the reference does not have the place.
fn forces(reference: &(impl Reference + ?Sized), offset_m: Vector, depths: &[(f64, f64)]) -> Option<Vec<ForceTarget>> {
    let solved = reference.shallowest_m()..=reference.deepest_m() * (1.0 + 1e-9);
    let known = depths.iter().filter(|(depth_m, _)| solved.contains(depth_m));
    let at =
        |&(depth_m, tolerance): &(f64, f64)| Some(ForceTarget { depth_m, force: reference.force(offset_m, depth_m)?, tolerance });
    known.map(at).collect()
}

/// Tolerance of a force (1): shallow presses, whose contacts are smaller than an element, may
/// deviate more.
fn tolerance(depth_radii: f64) -> f64 {
    if depth_radii < 0.1 { 2.0 * FORCE_TOLERANCE } else { FORCE_TOLERANCE }
}
