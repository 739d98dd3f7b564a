//! An abdomen on its back: a segment of a torso, layered from the skin inward.
//!
//! It is about 300 mm wide (x), 260 mm long (y) and 210 mm deep (z), with the belly up. Layers by
//! depth under the surface: skin 2 mm, subcutaneous fat 12 mm, abdominal wall 11 mm (rectus or the
//! three oblique muscles together, ultrasound of adults), viscera inside. The ends, where a body
//! would continue, are rounded off and covered with skin like the rest.

use super::parts::{V3, mm};
use super::{Organ, Region};

/// Depth at which each layer ends [m].
const SKIN_M: f64 = mm(2.0);
const FAT_M: f64 = SKIN_M + mm(12.0);
const MUSCLE_M: f64 = FAT_M + mm(11.0);

const HALF_LENGTH_M: f64 = mm(130.0);
const END_RADIUS_M: f64 = mm(70.0);

pub(super) const ABDOMEN: Organ = Organ {
    name: "abdomen",
    implicit: shape,
    box_m: [[-0.155, -0.135, -0.110], [0.155, 0.135, 0.110]],
    regions: &[
        Region { id: 1, name: "skin" },
        Region { id: 2, name: "fat" },
        Region { id: 3, name: "muscle" },
        Region { id: 4, name: "viscera" },
    ],
    region: layer,
    bone: None,
};

fn shape(x: V3) -> f64 {
    // an ellipse widened toward its corners: close to the superellipse of exponent 2.6, without
    // powers
    let (u, w) = (x.x / mm(150.0), x.z / mm(105.0));
    let round = (u * u + w * w).sqrt();
    let square = (u * u * u * u + w * w * w * w).sqrt().sqrt();
    let section = 0.5 * (round + square) - 1.0;
    // the ends: a cylinder with rounded rims, in units of the shorter half-axis
    let across = section * mm(105.0) + END_RADIUS_M;
    let along = x.y.abs() - HALF_LENGTH_M + END_RADIUS_M;
    let rim = (across.max(0.0) * across.max(0.0) + along.max(0.0) * along.max(0.0)).sqrt();
    across.max(along).min(0.0) + rim - END_RADIUS_M
}

fn layer(organ: &Organ, at_m: V3) -> u32 {
    let depth_m = -organ.distance(at_m);
    match depth_m {
        d if d < SKIN_M => 1,
        d if d < FAT_M => 2,
        d if d < MUSCLE_M => 3,
        _ => 4,
    }
}
