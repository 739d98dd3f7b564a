//! Stiffness of a contact, measured by a press, and width of the tip against the elements under it.
//!
//! Both are measured when a patch is packed or opened, before the loop runs. The stiffness is
//! measured by pressing the patch to its depth limit; everything elastic is per pascal, so one
//! press serves every modulus. A tip narrower than the elements rests on so few foundation points
//! that it loses and regains one again and again, and the force swings. A board refuses a contact
//! that is too stiff ([`super::ceiling`]) or too narrow.
//!
//! * in: a patch, its site and a depth [m]
//! * out: tangent stiffness per pascal [m]; contact radius over element size (1)
//! * cost: a measurement runs some 250 ticks
//! * failures: the fault of a patch that diverges in the press

use nalgebra::Vector3;

use crate::fault::Fault;
use crate::lanes::square_root;
use crate::model::Model;
use crate::params::{GuardLimits, Probe, ProbeShape, Tuned};
use crate::stages::probe::{ProbePose, continuation_m};
use crate::state::State;
use crate::tick::tick;

/// Speed of the press [m/tick].
/// Source: measured on four shipped patches; at half and at twice the speed the tangent differs by
/// 0.6 % at most. A press of 8 mm takes 110 ticks.
const PER_TICK_M: f32 = 0.1e-3;
/// Height above the site at which the press begins [m]: a flat end is outside a curved body there.
/// Source: chosen for that.
const ABOVE_M: f32 = 3e-3;
/// Step over which the slope is taken [m].
/// Source: derived; 4 mm deep, the slope of a Hertz contact over this step is 3 % below its
/// tangent.
const STEP_M: f32 = 0.5e-3;
/// Largest share of that step in the depth (1).
/// Source: derived; over a quarter of the depth, the slope of a Hertz contact is 7 % below its
/// tangent.
const STEP_SHARE: f32 = 0.25;
/// Ticks for which the press rests before its force is read.
/// Source: derived; of a velocity, [`KEEP`] leaves 0.02 % after as many ticks. Measured on the same
/// patches: at 160 the tangent differs by 0.4 %, at 40 by 4 %, at 20 by 16 %.
const REST_TICKS: u16 = 80;
/// Share of its velocity that a node keeps in a substep of the press (1), near critical damping of
/// the slowest motion. With its own damping the tissue would ring for a quarter of a second.
/// Source: measured; over four shipped patches at 2 and 4 mm, the tangent at 0.8 is within 0.3 % of
/// that at 0.9; at 0.95 it is up to 5 % off, at 0.98 up to 15 %.
const KEEP: f32 = 0.9;

/// Smallest contact radius of a rounded tip, in elements (1). Of 1 332 presses of a hemisphere,
/// held for a second (six patches, 3.5 to 100 kPa), the force swings by more than 5 % in 29 % of
/// those at
/// 0.25, in 1 % at 0.55, and in none from 0.7 on.
/// Source: those presses.
pub const LEAST_WIDTH: f32 = 0.7;
/// Smallest radius of a flat tip, in elements (1): its edge crosses foundation points at full
/// pressure. Of 180 presses at each radius, 9 swing by more than 5 % at 1.0, 2 at 1.4, none at 1.6.
/// Source: those presses.
pub const LEAST_WIDTH_FLAT: f32 = 1.6;

/// A press that is measured: radius of the tip and depth [m].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Press {
    /// Radius of the tip [m].
    pub radius_m: f32,
    /// Depth below the site [m].
    pub depth_m: f32,
}

/// Measures the tangent stiffness of a contact per pascal of Young's modulus [m]. Relaxation is
/// left out, because the loop meets the instantaneous stiffness. The patch is at rest afterwards.
///
/// # Errors
/// The fault of a patch that diverges.
#[inline]
pub fn tangent_m(
    model: &Model,
    tuned: &mut Tuned<'_>,
    state: &mut State<'_>,
    site_m: Vector3<f32>,
    press: Press,
    after_round: &mut dyn FnMut(),
) -> Result<f32, Fault> {
    let (probe, limits, keep) = (tuned.probe, tuned.limits, tuned.keep);
    let (prony, remembers, friction) = (tuned.prony, tuned.remembers, tuned.friction);
    // beyond the depth limit the contact has this stiffness, whatever the tissue there
    let beyond_m = continuation_m(&Probe { radius_m: press.radius_m, ..probe }, model.poisson_ratio, press.depth_m);
    tuned.probe.radius_m = press.radius_m;
    tuned.limits = GuardLimits { max_force_n: f32::MAX, ..limits };
    (tuned.prony.terms, tuned.remembers, tuned.friction, tuned.keep) = (0, false, 0.0, KEEP);
    state.reset(model);
    let slope = slope_n_per_m(model, tuned, state, site_m, press.depth_m, after_round);
    state.reset(model);
    (tuned.probe, tuned.limits, tuned.keep) = (probe, limits, keep);
    (tuned.prony, tuned.remembers, tuned.friction) = (prony, remembers, friction);
    let tangent_m = slope? / tuned.youngs_modulus_pa;
    // a tip that finds no resistance has none to continue
    Ok(if tangent_m > 0.0 && tangent_m < beyond_m { beyond_m } else { tangent_m })
}

#[inline]
fn slope_n_per_m(
    model: &Model,
    tuned: &Tuned<'_>,
    state: &mut State<'_>,
    site_m: Vector3<f32>,
    depth_m: f32,
    after_round: &mut dyn FnMut(),
) -> Result<f32, Fault> {
    let axis = tuned.up();
    let step_m = if STEP_SHARE * depth_m < STEP_M { STEP_SHARE * depth_m } else { STEP_M };
    let mut at_m = -ABOVE_M;
    let mut held_n = |to_m: f32| {
        let mut rested = 0;
        loop {
            let output = tick(model, tuned, state, ProbePose { tip_m: site_m - axis * at_m });
            after_round();
            if let Some(fault) = output.fault {
                return Err(fault);
            }
            if rested == REST_TICKS {
                return Ok(output.force_n.dot(&axis));
            }
            rested += u16::from(at_m >= to_m);
            at_m = if at_m + PER_TICK_M < to_m { at_m + PER_TICK_M } else { to_m };
        }
    };
    let shallow_n = held_n(depth_m - step_m)?;
    Ok((held_n(depth_m)? - shallow_n) / step_m)
}

/// Radius of the contact under a probe at this depth [m]: that of a flat end, or that of a sphere
/// on a half-space (Hertz).
#[must_use]
#[inline]
pub fn contact_radius_m(probe: &Probe, depth_m: f32) -> f32 {
    let radius_m = probe.radius_m;
    match probe.shape {
        ProbeShape::Flat => radius_m,
        _ if depth_m < radius_m => square_root(radius_m * depth_m),
        _ => radius_m,
    }
}

/// Smallest contact radius of a tip of this shape, in elements (1).
#[must_use]
#[inline]
pub fn least_width(shape: ProbeShape) -> f32 {
    if shape == ProbeShape::Flat { LEAST_WIDTH_FLAT } else { LEAST_WIDTH }
}

/// Radius of the narrowest tip that is wide enough at this depth [m].
#[must_use]
#[inline]
pub fn least_radius_m(probe: &Probe, depth_m: f32, element_m: f32) -> f32 {
    let contact_m = least_width(probe.shape) * element_m;
    match probe.shape {
        ProbeShape::Flat => contact_m,
        _ if depth_m < contact_m => contact_m * contact_m / depth_m,
        _ => contact_m,
    }
}

/// Size of the surface elements at a site [m]: edge of an equilateral triangle with the mean area
/// of the triangles around the surface node nearest to the site.
#[must_use]
#[inline]
pub fn element_m(model: &Model, site_m: Vector3<f32>) -> f32 {
    /// Square of an equilateral triangle's edge over twice its area (1): two over the root of
    /// three. Source: geometry.
    const SQUARE: f32 = 1.154_700_5;
    let at_m = |node: u16| model.nodes.get(usize::from(node)).map_or(Vector3::repeat(f32::MAX), |node| node.rest_m.into());
    let (mut nearest, mut least_m2) = (0, f32::MAX);
    for node in model.triangles.iter().flat_map(|triangle| triangle.node) {
        let from_m = at_m(node) - site_m;
        let square_m2 = from_m.dot(&from_m);
        if square_m2 < least_m2 {
            (nearest, least_m2) = (node, square_m2);
        }
    }
    let (mut twice_m2, mut count) = (0.0, 0.0);
    for triangle in model.triangles.iter().filter(|triangle| triangle.node.contains(&nearest)) {
        let [a, b, c] = triangle.node.map(at_m);
        let normal_m2 = (b - a).cross(&(c - a));
        twice_m2 += square_root(normal_m2.dot(&normal_m2));
        count += 1.0;
    }
    square_root(SQUARE * twice_m2 / count)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_radius_is_just_wide_enough() {
        for shape in [ProbeShape::Flat, ProbeShape::Sphere, ProbeShape::Hemisphere] {
            for (depth_m, element_m) in [(0.5e-3, 4e-3), (5e-3, 4e-3), (5e-3, 9e-3)] {
                let mut probe = Probe { shape, radius_m: 0.0, axis: Vector3::z() };
                probe.radius_m = least_radius_m(&probe, depth_m, element_m);
                let width = contact_radius_m(&probe, depth_m) / element_m;
                assert!((width / least_width(shape) - 1.0).abs() < 1e-6, "{shape:?} {depth_m}: {width}");
            }
        }
    }
}
