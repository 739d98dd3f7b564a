//! Friction: a bristle between the probe and every touched node, which gives way at Coulomb's
//! limit.
//!
//! The node is held to the probe by a spring along the surface, which carries at most mu times the
//! node's own push; beyond that, the node slips. The spring is softer than the foundation by the
//! ratio of a half-space's stiffness along its surface to that across it, `2 (1 - nu) / (2 - nu)`,
//! so a probe that sticks feels the stiffness of a glued disc. The bristle's root is a *place on
//! the probe*, so that a hold neither drifts nor relaxes (Hayward, Armstrong, A new computational
//! model of friction applied to haptic rendering, Experimental Robotics VI, 2000). Partial slip
//! arises because the nodes at the edge of a contact slip before those in its middle.
//!
//! The force of a bristle is evaluated at the *end* of the substep like the push
//! ([`super::foundation`]), with the same slope, so friction needs no shorter step. It creates no
//! energy: a bristle that slips gets shorter; one whose slope grows, because more points touch,
//! keeps its force; one whose slope falls keeps its length; one that loses contact is removed.
//!
//! * in: the push of a node with its slope and normal, its motion and that of the probe
//! * out: the force along the surface on that node; the bristle
//! * cost (M4F, estimated): about 250 cycles per touched node
//! * failures: none

use nalgebra::Vector3;

use crate::bristle::Bristle;
use crate::lanes::sqrt;
use crate::params::Tuned;

/// Returns the bristle of a touching node, the `met`-th of this substep; a new bristle if the node
/// did not touch in the last substep. The first `live` bristles belong to the last substep or, in
/// front, to this one, so the bristle of a node is nearly always found next to that of the node
/// before it. `None` if the memory is full: the node then slides freely.
#[inline(always)]
pub(super) fn claim<'b>(bristles: &'b mut [Bristle], live: &mut usize, met: usize, node: u16) -> Option<&'b mut Bristle> {
    let (front, others) = bristles.get_mut(met..)?.split_first_mut()?;
    let others_live = (*live).checked_sub(met + 1);
    if others_live.is_none() || front.node != node {
        let old = others.iter().take(others_live.unwrap_or(0)).position(|bristle| bristle.node == node);
        // if there is no room at the end, the front bristle is lost; its node has not been found in
        // this substep
        if let Some(place) = old.or(others_live).and_then(|n| others.get_mut(n)) {
            core::mem::swap(front, place);
            *live += usize::from(old.is_none());
        }
        if old.is_none() {
            *front = Bristle { node, ..Bristle::ZERO };
        }
    }
    Some(front)
}

/// Factor below which a rise of the slope is rounding noise (1). Shortening the bristle at each
/// such rise, while no fall lengthens it, would make a hold creep by micrometres per minute.
const WAVERS: f32 = 1.0 + 1e-5;

/// A touched node in this substep.
pub(super) struct Touch {
    /// Position of the node relative to the probe's centre [m].
    pub from_centre_m: Vector3<f32>,
    /// Push on the node at the end of the substep, divided by E [N/Pa].
    pub push: Vector3<f32>,
    /// Magnitude of the push [N/Pa].
    pub length: f32,
    /// Slope of the foundation at the node over E [m].
    pub slope: f32,
    /// Displacement of the node per force on it [m per (N/Pa)].
    pub yields: f32,
    /// Displacement in the substep due to the node's velocity [m].
    pub moves_m: Vector3<f32>,
    /// Displacement of the probe that the dashpot between probe and node adds to the bristle [m].
    pub damps_m: Vector3<f32>,
    /// Sum of the other forces on the node over E [N/Pa].
    pub others: Vector3<f32>,
    /// Forces that have faded at the node over E [N/Pa].
    pub faded: Vector3<f32>,
}

/// Force along the surface on a touched node over E [N/Pa], at the end of the substep:
/// `q = -K P (s + d + b F) / (1 + K b)`, and never more than mu times the push. Here K is the
/// slope, s the extension of the bristle, d the displacement due to the velocities in this substep,
/// F the other forces, b the node's displacement per force, and P the projection on the surface. In
/// tissue that relaxes, q is treated as the push is (`implicit_relaxing`).
#[inline(always)]
pub(super) fn rub(bristle: &mut Bristle, touch: &Touch, tuned: &Tuned) -> Vector3<f32> {
    let normal = touch.push * (1.0 / touch.length);
    let along = |v: Vector3<f32>| v - normal * v.dot(&normal);
    let (slope, at_once) = (tuned.along * touch.slope, tuned.prony.at_once);
    let faded = along(touch.faded);
    let grows = slope > bristle.slope * WAVERS;
    let stretched = if bristle.slope == 0.0 {
        // no force when the node first touches, whatever has faded there
        faded * (-1.0 / (at_once * slope))
    } else {
        let stretched = along(touch.from_centre_m - bristle.root_m);
        if grows { stretched * (bristle.slope / slope) } else { stretched }
    };
    let resists = 1.0 + at_once * slope * touch.yields;
    let moves = along(touch.moves_m - touch.damps_m + touch.others * (at_once * touch.yields)) + faded * touch.yields;
    let mut force = ((stretched + moves) * (-at_once * slope) - faded) * (1.0 / resists);
    let mut left = stretched;
    let (square, most) = (force.dot(&force), tuned.friction * touch.length);
    if square > most * most {
        force *= most / sqrt(square);
        // the dashpot acts in this substep only. If the bristle were stretched against it, the
        // force would reverse in the next substep, in which a probe that moves by counts is at
        // rest.
        left = (force + faded) * (-1.0 / (at_once * slope)) - (moves + along(touch.damps_m) + force * touch.yields);
    }
    bristle.root_m = touch.from_centre_m - left;
    if grows || slope < bristle.slope {
        bristle.slope = slope;
    }
    force
}

/// Force along the surface over E [N/Pa] that a bristle exerts on a node at rest, where [`rub`]
/// gives the same. `push` is the elastic push on the node, `faded` what has faded there.
#[cfg(feature = "contact-map")]
pub(crate) fn at_rest(
    bristle: &Bristle,
    from_centre_m: Vector3<f32>,
    push: Vector3<f32>,
    faded: Vector3<f32>,
    tuned: &Tuned,
) -> Vector3<f32> {
    let length = sqrt(push.dot(&push));
    if length == 0.0 {
        return Vector3::zeros();
    }
    let (normal, at_once) = (push * (1.0 / length), tuned.prony.at_once);
    let along = |v: Vector3<f32>| v - normal * v.dot(&normal);
    let force = along((from_centre_m - bristle.root_m) * (-at_once * bristle.slope) - faded);
    let left = at_once * length - faded.dot(&normal);
    let (square, most) = (force.dot(&force), tuned.friction * if left > 0.0 { left } else { 0.0 });
    if square > most * most { force * (most / sqrt(square)) } else { force }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Params;

    /// Half a row of independent points, which by the method of dimensionality reduction responds
    /// as a sphere on a half-space does: a point at x carries `E* dx (d - x^2 / R)`.
    const POINTS: u16 = 1000;
    const RADIUS_M: f32 = 8e-3;
    const DEPTH_M: f32 = 2e-3;

    /// Force along the surface and push of the row after the probe has moved through these
    /// displacements, step by step [N/Pa].
    fn row(mu: f32, displacement_m: &[f32]) -> (f32, f32) {
        let params = Params { friction: mu, ..Params::default() };
        let tuned = params.derive(&mut [], [0.0; 4]);
        let half_m = sqrt(RADIUS_M * DEPTH_M);
        let slope = half_m / f32::from(POINTS);
        let (mut force, mut push) = (0.0, 0.0);
        for n in 0..POINTS {
            let x = (f32::from(n) + 0.5) * slope;
            let length = slope * (DEPTH_M - x * x / RADIUS_M);
            let mut bristle = Bristle::ZERO;
            let mut last = 0.0;
            for at_m in displacement_m {
                let touch = Touch {
                    from_centre_m: Vector3::new(-at_m, 0.0, 0.0),
                    push: Vector3::new(0.0, 0.0, -length),
                    length,
                    slope,
                    yields: 0.0,
                    moves_m: Vector3::zeros(),
                    damps_m: Vector3::zeros(),
                    others: Vector3::zeros(),
                    faded: Vector3::zeros(),
                };
                last = rub(&mut bristle, &touch, &tuned).x;
            }
            force += last;
            push += length;
        }
        (force, push)
    }

    /// Cattaneo and Mindlin: share of full friction at a displacement, in units of the displacement
    /// at which everything slips.
    fn partial(way: f32) -> f32 {
        if way < 1.0 { 1.0 - libm::powf(1.0 - way, 1.5) } else { 1.0 }
    }

    #[test]
    fn a_row_of_points_slips_as_cattaneo_and_mindlin_say() {
        let nu = Params::default().poisson_ratio;
        for mu in [0.1, 0.3, 0.6, 1.0] {
            // u_m = mu (E* / G*) d
            let slips_m = mu * DEPTH_M * (2.0 - nu) / (2.0 * (1.0 - nu));
            for way in [0.05, 0.1, 0.25, 0.5, 0.75, 0.95, 1.0, 2.0] {
                let to_m: [f32; 21] = core::array::from_fn(|n| way * slips_m * n as f32 * 0.05);
                let (force, push) = row(mu, &to_m);
                let expected = mu * push * partial(way);
                assert!((force - expected).abs() < 1e-3 * mu * push, "mu {mu}, way {way}: {force} for {expected}");
            }
        }
    }

    #[test]
    fn a_way_back_unloads_twice_as_stretched() {
        // Mindlin and Deresiewicz: on the way back from U by v, T = T(U) - 2 T(v / 2)
        let nu = Params::default().poisson_ratio;
        let slips_m = 0.3 * DEPTH_M * (2.0 - nu) / (2.0 * (1.0 - nu));
        for back in [0.2, 0.5, 1.0, 1.5] {
            let displacement_m = [0.0, 0.4 * slips_m, 0.8 * slips_m, (0.8 - 0.5 * back) * slips_m, (0.8 - back) * slips_m];
            let (force, push) = row(0.3, &displacement_m);
            let expected = 0.3 * push * (partial(0.8) - 2.0 * partial(0.5 * back));
            assert!((force - expected).abs() < 1e-3 * 0.3 * push, "back {back}: {force} for {expected}");
        }
    }

    #[test]
    fn a_bristle_that_a_jump_has_stretched_pulls_on_while_the_probe_rests() {
        // the probe jumps by a count of 55 um, and the dashpot adds 1.5 times that for one substep
        let tuned = Params { friction: 0.3, ..Params::default() }.derive(&mut [], [0.0; 4]);
        let mut bristle = Bristle::ZERO;
        let mut at = |from_centre_m: f32, damps_m: f32| {
            let touch = Touch {
                from_centre_m: Vector3::new(from_centre_m, 0.0, 0.0),
                push: Vector3::new(0.0, 0.0, -1e-5),
                length: 1e-5,
                slope: 1.0,
                yields: 0.1,
                moves_m: Vector3::zeros(),
                damps_m: Vector3::new(damps_m, 0.0, 0.0),
                others: Vector3::zeros(),
                faded: Vector3::zeros(),
            };
            rub(&mut bristle, &touch, &tuned).x
        };
        at(0.0, 0.0);
        for count in 1..4_u8 {
            let at_m = -55e-6 * f32::from(count);
            assert!((at(at_m, 82e-6) / 3e-6 - 1.0).abs() < 1e-5);
            // the node yields to its force
            assert!((at(at_m + 0.1 * 3e-6, 0.0) / 3e-6 - 1.0).abs() < 0.15, "the probe rests");
        }
    }

    #[test]
    fn more_slope_keeps_the_force_and_less_of_it_keeps_the_bristle() {
        let tuned = Params { friction: 5.0, ..Params::default() }.derive(&mut [], [0.0; 4]);
        let touch = |at_m: f32, slope: f32| Touch {
            from_centre_m: Vector3::new(at_m, 0.0, 0.0),
            push: Vector3::new(0.0, 0.0, -1.0),
            length: 1.0,
            slope,
            yields: 0.0,
            moves_m: Vector3::zeros(),
            damps_m: Vector3::zeros(),
            others: Vector3::zeros(),
            faded: Vector3::zeros(),
        };
        let mut bristle = Bristle::ZERO;
        let mut at = |at_m, slope| rub(&mut bristle, &touch(at_m, slope), &tuned).x;
        assert_eq!(at(0.0, 1.0), 0.0);
        let pulled = at(1e-3, 1.0);
        assert!((pulled + 1e-3 * tuned.along).abs() < 1e-9);
        assert!((at(1e-3, 4.0) - pulled).abs() < 1e-9, "more points touch, none of them stretched");
        assert!((at(1e-3, 1.0) - 0.25 * pulled).abs() < 1e-9, "they leave and take their share");
    }

    /// Claims a bristle for each of `nodes` in this order, adds one to its slope, and returns how
    /// many were claimed.
    fn met(bristles: &mut [Bristle], live: &mut usize, nodes: &[u16]) -> usize {
        let mut met = 0;
        for &node in nodes {
            if let Some(bristle) = claim(bristles, live, met, node) {
                assert_eq!(bristle.node, node);
                bristle.slope += 1.0;
                met += 1;
            }
        }
        *live = met;
        met
    }

    #[test]
    fn a_bristle_lives_as_long_as_its_node_touches() {
        let (mut bristles, mut live) = ([Bristle::ZERO; 4], 0);
        let mut touch = |nodes: &[u16]| -> [(u16, f32); 4] {
            let met = met(&mut bristles, &mut live, nodes);
            core::array::from_fn(|n| if n < met { (bristles[n].node, bristles[n].slope) } else { (0, 0.0) })
        };
        assert_eq!(touch(&[7, 3, 5]), [(7, 1.0), (3, 1.0), (5, 1.0), (0, 0.0)]);
        assert_eq!(touch(&[5, 7, 3]), [(5, 2.0), (7, 2.0), (3, 2.0), (0, 0.0)], "in any order");
        assert_eq!(touch(&[9, 3]), [(9, 1.0), (3, 3.0), (0, 0.0), (0, 0.0)], "one is new, two are gone");
        assert_eq!(touch(&[5, 9, 3, 7, 8]), [(5, 1.0), (9, 2.0), (3, 4.0), (7, 1.0)], "no room for a fifth");
        assert_eq!(touch(&[1, 2, 3, 9]), [(1, 1.0), (2, 1.0), (3, 5.0), (9, 1.0)], "nor for those not met yet");
        assert_eq!(touch(&[]), [(0, 0.0); 4]);
    }
}
