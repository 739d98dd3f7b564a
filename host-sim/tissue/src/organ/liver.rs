//! A liver with a thick Lobe 2, a thin Lobe 1 that can be lifted, and the fossa of the gallbladder.
//!
//! It has the size of an adult's liver (that of a pig of 100 kg is similar): 21-26 cm across, 14-18
//! cm from front to back, up to 10 cm high, 1.2-1.6 l (Gray's Anatomy, "The liver"; volumetry by
//! computed tomography gives 1.5 l on average). Paper 000 presses and lifts such a liver without
//! printing its size. Lobe 1 is at -y and Lobe 2 at +y; the thin front edge is at +x; the lower
//! face points down.

use super::gallbladder;
use super::parts::{V3, ellipsoid, join, meet, mm, mm3};
use super::{Organ, Region};

/// Gap between liver and gallbladder in the fossa [m], so that they do not overlap.
pub(super) const GAP_M: f64 = 0.3e-3;

pub(super) const LIVER: Organ = Organ {
    name: "liver",
    implicit: shape,
    box_m: [[-0.105, -0.145, -0.042], [0.105, 0.145, 0.052]],
    regions: &[Region { id: 1, name: "parenchyma" }],
    region: |_, _| 1,
    bone: None,
};

fn shape(x: V3) -> f64 {
    // the fossa: all that is nearer to the gallbladder than the gap is cut away, with a rounded rim
    meet(body(x), GAP_M - gallbladder::shape(x), mm(3.0))
}

/// The liver before the fossa is cut out of it.
fn body(x: V3) -> f64 {
    // both ends are swept back, so that the organ is a crescent, as under the ribs
    let x = V3::new(x.x + 1.3 * x.y * x.y - mm(8.0), x.y, x.z);
    let thick = ellipsoid(x, mm3(-4.0, 44.0, 2.0), mm3(84.0, 86.0, 44.0));
    let tongue = ellipsoid(x, mm3(4.0, -52.0, 2.0), mm3(66.0, 80.0, 20.0));
    let lobes = join(thick, tongue, mm(40.0));
    // the lower face is flatter than the dome and rises to the front
    let below = (mm(-29.0) + 0.12 * (x.x - mm(-20.0)) - x.z) * 0.993;
    meet(lobes, below, mm(22.0))
}
