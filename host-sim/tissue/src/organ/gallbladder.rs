//! A gallbladder: a pear in the fossa of the liver.
//!
//! It is 7-10 cm long and 3-4 cm wide, and contains 30-60 ml (Gray's Anatomy, "The biliary
//! apparatus"). The fundus points to the front (+x), the neck back and down: the fossa ends where
//! the neck leaves it, and measures 42 x 22 mm.

use super::parts::{V3, mm, mm3, pear};
use super::{Organ, Region};

pub(super) const GALLBLADDER: Organ = Organ {
    name: "gallbladder",
    implicit: shape,
    box_m: [[-0.050, -0.040, -0.070], [0.060, 0.020, 0.0]],
    regions: &[Region { id: 1, name: "bile-filled sac" }],
    region: |_, _| 1,
    bone: None,
};

pub(super) fn shape(x: V3) -> f64 {
    pear(x, mm3(31.0, -10.0, -35.0), mm3(-25.0, -8.0, -38.0), mm(17.5), mm(6.5))
}
