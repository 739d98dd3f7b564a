//! Targets of a calibration: forces over a disc of places, dents at its centre, and discs glued to
//! the surface.

use super::places::sunflower;
use crate::statics::Vector;
use palpate_tissue::answer::GluedAnswer;

/// Radius of the disc over which places are spread for a whole block [probe radii]: slightly more
/// than the 1.5 over which the force must keep its tolerance.
pub const DISC_RADII: f64 = 1.65;
/// Depths of the presses at every place [probe radii].
pub const DEPTHS_RADII: [f64; 5] = [0.0625, 0.125, 0.25, 0.5, 0.875];
/// Depths of the presses at the centre [probe radii].
const CENTRE_DEPTHS_RADII: [f64; 5] = [0.0625, 0.125, 0.25, 0.5, 1.0];
/// Depths of the presses along a stroke [probe radii]: 0.5, 1, 2, 4 mm for a radius of 8 mm, so
/// that a slide 3 mm deep was not fitted.
const STROKE_DEPTHS_RADII: [f64; 4] = [0.0625, 0.125, 0.25, 0.5];
/// Distance by which places extend past both ends of a stroke [probe radii].
const STROKE_ENDS_RADII: f64 = 0.125;
/// Depths of the dents [probe radii].
const DENT_DEPTHS_RADII: [f64; 2] = [0.25, 0.5];
/// Radius around the centre in which a dent is measured [probe radii].
const DENT_RADII: f64 = 2.5;

/// Force at one depth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceTarget {
    /// Depth of the tip [m].
    pub depth_m: f64,
    /// Force along the press over E [m^2].
    pub force: f64,
    /// Deviation that counts as one unit of error (1).
    pub tolerance: f64,
}

/// The dent at one depth: displacement of surface nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct DentTarget {
    /// Depth of the tip [m].
    pub depth_m: f64,
    /// Node and its displacement [m].
    pub nodes: Vec<(usize, Vector)>,
    /// Deviation that counts as one unit of error [m].
    pub tolerance_m: f64,
}

/// The presses at one place.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaceTarget {
    /// Place on the rest surface [m].
    pub place_m: Vector,
    /// Forces, shallow first.
    pub forces: Vec<ForceTarget>,
    /// Dents; their depths are among those of the forces.
    pub dents: Vec<DentTarget>,
}

/// A disc glued to the surface and moved slightly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GluedTarget {
    /// Centre of the disc on the rest surface [m].
    pub place_m: Vector,
    /// Radius of the disc [m].
    pub radius_m: f64,
    /// Direction of its motion, a unit vector.
    pub direction: Vector,
    /// Force along the displacement over E, per displacement [m].
    pub stiffness_m: f64,
    /// Deviation that counts as one unit of error (1).
    pub tolerance: f64,
}

/// Everything a patch is fitted to. The first place is the centre.
#[derive(Clone, Debug, PartialEq)]
pub struct Targets {
    /// Places.
    pub places: Vec<PlaceTarget>,
    /// Glued discs, pressed and sheared; there may be none.
    pub glued: Vec<GluedTarget>,
    /// The centre [m].
    pub centre_m: Vector,
    /// Radius of the probe [m].
    pub radius_m: f64,
    /// Radius of the disc of places [probe radii].
    pub disc_radii: f64,
}

/// Depths [m] of the presses over a disc of places, each with the deviation that counts as one unit
/// of error (1).
#[derive(Clone, Debug, PartialEq)]
pub struct DiscPresses {
    /// Presses at the centre, shallow first.
    pub centre: Vec<(f64, f64)>,
    /// Presses off the centre: numbers of places, and the depths at each of them.
    pub aside: Vec<(usize, Vec<(f64, f64)>)>,
    /// Depths [m] at which the dent at the centre counts, among those of the centre, each with the
    /// share of the depth that counts as one unit of error (1).
    pub dents: Vec<(f64, f64)>,
}

/// Reference solution; a query returns `None` if there is no answer. Places count from the site.
pub trait Reference: Sync {
    /// Force over E [m^2] of a press at a place [m].
    fn force(&self, place_m: Vector, depth_m: f64) -> Option<f64>;
    /// Deepest centred press [m].
    fn deepest_m(&self) -> f64;
    /// Shallowest press [m].
    fn shallowest_m(&self) -> f64 {
        0.0
    }
    /// Place on the surface [m] at an offset in the tangent plane at the site [m]; for a flat top,
    /// in that plane itself.
    fn place_m(&self, offset_m: [f64; 2]) -> Option<Vector> {
        Some(Vector::new(offset_m[0], offset_m[1], 0.0))
    }
    /// Discs glued to the surface.
    fn glued(&self) -> &[GluedAnswer] {
        &[]
    }
    /// Displacement [m].
    fn displacement_m(&self, depth_m: f64, offset_m: [f64; 2]) -> Option<[f64; 3]>;
}

impl Targets {
    /// Number of presses.
    #[must_use]
    pub fn presses(&self) -> usize {
        self.places.iter().map(|place| place.forces.len()).sum()
    }

    /// Presses at the centre and at `places` more over `disc_radii` probe radii, to all depths of
    /// the reference; dents at `surface` nodes, if there are any.
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

    /// The presses of `disc`, over `disc_radii` probe radii, to all depths of the reference; dents
    /// at `surface` nodes, if there are any.
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
        // without surface nodes to compare there are no dents
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

    /// Presses on a flat top (normal along z) along a stroke centred on `centre_m`, over
    /// `half_width_m` to both sides: a lattice of golden ratio, the centre first. `None` if the
    /// reference has no answer.
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

    /// Returns the targets with the glued discs of an answer, whose places count from the centre; a
    /// force that is `tolerance` (1) off counts as one unit of error.
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
    /// has them, and with the weight of presses there multiplied by `weight`.
    #[must_use]
    pub fn with_centre(mut self, reference: &(impl Reference + ?Sized), depths_radii: &[f64], weight: f64) -> Option<Self> {
        let depths: Vec<(f64, f64)> =
            depths_radii.iter().map(|depth| (depth * self.radius_m, tolerance(*depth) / weight)).collect();
        self.places.first_mut()?.forces = forces(reference, Vector::zeros(), &depths)?;
        Some(self)
    }

    /// Radius around the centre that any press touches [m].
    #[must_use]
    pub fn reach_m(&self) -> f64 {
        (self.disc_radii + 1.0) * self.radius_m
    }
}

/// Deviation of a force that counts as one unit of error (1).
const FORCE_TOLERANCE: f64 = 0.005;
/// Deviation of a glued disc's force that counts as one unit of error (1), if there are only a few.
pub const GLUED_TOLERANCE: f64 = 0.002;
/// Deviation of a surface node, as a share of the depth, that counts as one unit of error (1).
const DENT_TOLERANCE: f64 = 0.008;

/// The golden ratio less one: the most even step for places on a line.
const GOLDEN_RATIO: f64 = 1.618_033_988_749_895;

/// Forces at an offset from the centre for those depths [m], with their tolerances (1), that the
/// reference has; `None` if it does not have the place.
fn forces(reference: &(impl Reference + ?Sized), offset_m: Vector, depths: &[(f64, f64)]) -> Option<Vec<ForceTarget>> {
    let solved = reference.shallowest_m()..=reference.deepest_m() * (1.0 + 1e-9);
    let known = depths.iter().filter(|(depth_m, _)| solved.contains(depth_m));
    let at =
        |&(depth_m, tolerance): &(f64, f64)| Some(ForceTarget { depth_m, force: reference.force(offset_m, depth_m)?, tolerance });
    known.map(at).collect()
}

/// Shallow presses, with contacts smaller than an element, may deviate more.
fn tolerance(depth_radii: f64) -> f64 {
    if depth_radii < 0.1 { 2.0 * FORCE_TOLERANCE } else { FORCE_TOLERANCE }
}
