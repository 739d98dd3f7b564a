//! A foot with its sole up: heel, arch, ball and toes as one mass, held by the bones inside.
//!
//! It has the size of an adult's foot: 250 x 95 x 70 mm (x from heel to toes, y across, z up). The
//! heel pad, from the skin to the heel bone, is 18-20 mm thick unloaded (ultrasound of healthy
//! adults), plantar skin 1.5 mm. The inner edge, with the arch, is at +y. Bones are capsules: nodes
//! inside them are anchors.

use super::parts::{V3, capsule, ellipsoid, join, meet, mm, mm3};
use super::{Organ, Region};

const SKIN_M: f64 = mm(1.5);
const FAT_M: f64 = mm(12.0);

pub(super) const FOOT: Organ = Organ {
    name: "foot",
    implicit: shape,
    box_m: [[-0.132, -0.055, -0.045], [0.132, 0.055, 0.042]],
    regions: &[Region { id: 1, name: "skin" }, Region { id: 2, name: "fat pad" }, Region { id: 3, name: "deep tissue" }],
    region: layer,
    bone: Some(bone),
};

fn shape(x: V3) -> f64 {
    let heel = ellipsoid(x, mm3(-82.0, 0.0, 0.0), mm3(43.0, 33.0, 36.0));
    let outer_edge = ellipsoid(x, mm3(-12.0, -10.0, -4.0), mm3(78.0, 30.0, 31.0));
    let ball = ellipsoid(x, mm3(58.0, 0.0, 10.0), mm3(48.0, 46.0, 24.0));
    let toes = ellipsoid(x, mm3(94.0, 4.0, 18.0), mm3(31.0, 40.0, 15.0));
    let mass = join(join(heel, outer_edge, mm(22.0)), join(ball, toes, mm(12.0)), mm(22.0));
    // as in standing, heel, ball and toes share one plane
    meet(mass, x.z - mm(32.0), mm(10.0))
}

/// Distance to the nearest bone [m], negative inside a bone.
fn bone(x: V3) -> f64 {
    let heel_bone = capsule(x, mm3(-88.0, 0.0, -3.0), mm3(-52.0, -2.0, -6.0), mm(15.0));
    let mid_foot = capsule(x, mm3(-46.0, -4.0, -8.0), mm3(-4.0, -2.0, -5.0), mm(13.0));
    let rays = [(-24.0, -32.0), (-14.0, -13.0), (-5.0, 6.0), (4.0, 26.0)].map(|(from_y, to_y)| {
        // from the mid-foot to the heads of the metatarsals under the ball
        capsule(x, mm3(4.0, from_y, -5.0), mm3(64.0, to_y, 10.0), mm(6.0))
    });
    rays.into_iter().fold(heel_bone.min(mid_foot), f64::min)
}

fn layer(organ: &Organ, at_m: V3) -> u32 {
    let (foot, depth_m) = organ.foot(at_m);
    let under_the_sole = organ.gradient(foot).normalize().z > 0.5;
    match -depth_m {
        d if d < SKIN_M => 1,
        d if d < FAT_M && under_the_sole => 2,
        _ => 3,
    }
}
