//! Contact as a soft sub-element foundation.
//!
//! Every surface triangle has four fixed points, nine if triangles are large relative to the probe,
//! and sixteen if they are large relative to the smallest contact (not on boards, whose images have
//! no room for a third copy of the code). A point inside the probe by `pen` is pushed out along the
//! probe's normal by `f/E = k pen (1 + s pen)`; the push is distributed to the triangle's nodes,
//! and its opposite is the force on the probe. The foundation represents the local indentation that
//! a flat element cannot have: it is part of the tissue, not a penalty, and its force stays smooth
//! when the probe slides over nodes (with node projection it ripples by 10-36 %, with the
//! foundation by 2-6 %).
//!
//! A tilted flat end pushes against the normals of the deformed triangles instead of along its own.
//! Over level tissue the stored energy does not depend on the place, so there is no force along the
//! surface: the lean of the face is balanced by the side of the low rim, which triangles that are
//! longer than the rim is wide cannot feel. With the face's normal alone the force leaned by the
//! tilt, and a slow circle inside the tissue gave up to 1 mJ per turn.
//!
//! The pushes are summed at the nodes, where the sum is evaluated at the *end* of the substep
//! (`implicit`), so contact neither limits the step nor needs a mass of its own. The dashpot of the
//! contact acts between probe and node, and the contact never pulls.
//!
//! In tissue that relaxes, the foundation fades with the tissue below it. It is in series with the
//! node, so both have carried the same force and share one memory ([`super::relaxation`]): a push
//! is the elastic push minus the part that has faded at its node. A point whose push has faded to
//! zero has lost contact, so the dent behind a probe that leaves recovers with a delay.
//!
//! * in: candidates of `contact`, positions, velocities, the probe
//! * out: adds to `node.f`; the probe's load on the tissue
//! * cost (M4F, estimated): about 300 cycles per touched triangle with four points
//! * failures: none

#[cfg(not(target_os = "none"))]
mod energy;
mod points;
#[cfg(feature = "long-tips")]
pub(crate) mod tip;

use nalgebra::Vector3;

#[cfg(not(target_os = "none"))]
pub(super) use energy::store;
#[cfg(not(target_os = "none"))]
pub(crate) use points::Sixteen;
pub use points::point_weights;
pub(crate) use points::{Four, Nine, Points};

use super::friction::{self, Touch};
use super::relaxation;
use crate::lanes::{ROW, add, row, sqrt, vector};
use crate::model::Model;
pub use crate::params::FLAT_EDGE;
use crate::params::{Probe, ProbeShape, Tuned};
use crate::state::{Faded, Node, State, node};

/// Load of the probe on the tissue.
#[derive(Clone, Copy, Debug)]
pub struct Load {
    /// Force on the *tissue* over E [N/Pa].
    pub force: Vector3<f32>,
    /// Sum of the magnitudes of the pushes over E [N/Pa]: the weight of the two sums below.
    pub push: f32,
    /// Push-weighted sum of contact points, deformed [N/Pa m].
    pub point: Vector3<f32>,
    /// Push-weighted sum of contact points, at rest [N/Pa m].
    pub rest: Vector3<f32>,
    /// Largest push on one surface triangle over E [N/Pa], and the index of that triangle. The push
    /// on the triangle of the last tick counts a quarter more.
    pub strongest: (f32, u16),
    /// The surface has closed over a tip without a handle.
    pub covered: bool,
    /// The tip is beyond the places of a law, or presses more triangles than are allowed.
    pub limited: bool,
}

impl Load {
    /// The load of a surface that the probe does not touch.
    pub const NONE: Self =
        Self { force: ZERO, push: 0.0, point: ZERO, rest: ZERO, strongest: (0.0, 0), covered: false, limited: false };

    /// Sums the loads of a tick's substeps.
    #[inline(always)]
    pub(crate) fn add(&mut self, other: &Self) {
        self.force += other.force;
        self.push += other.push;
        self.point += other.point;
        self.rest += other.rest;
        self.covered |= other.covered;
        self.limited |= other.limited;
        if other.strongest.0 > self.strongest.0 {
            self.strongest = other.strongest;
        }
    }
}

/// Factor by which another triangle's push has to exceed that of the last tick's triangle to
/// replace it (1). Without it, two equal triangles took turns, and the depth limit with them.
const KEPT: f32 = 1.25;
const ZERO: Vector3<f32> = Vector3::new(0.0, 0.0, 0.0);
#[cfg(feature = "long-tips")]
const THIRD: f32 = 1.0 / 3.0;

/// Pushes the surface out of the probe.
// as with `integrate::advance`: inlining it would take registers from the code around it
#[cfg_attr(any(feature = "stage-cost", target_os = "none"), inline(never))]
pub fn press(model: &Model, tuned: &Tuned, state: &mut State, tip_m: Vector3<f32>, velocity_m_per_s: Vector3<f32>) -> Load {
    let mut load = push::<false>(model, tuned, state, tip_m);
    answer(model, tuned, state, tip_m, velocity_m_per_s, &mut load);
    load
}

/// Sums the pushes at the nodes. With `STIFFENED`, half of every node's stiffening factor is in
/// `node.p`, all candidates touch, and the caller determines whether the probe is covered.
#[inline(always)]
pub(crate) fn push<const STIFFENED: bool>(model: &Model, tuned: &Tuned, state: &mut State, tip_m: Vector3<f32>) -> Load {
    let centre = centre_m(&tuned.probe, tip_m);
    let mut load = Load::NONE;
    match model.points_per_triangle() {
        #[cfg(not(target_os = "none"))]
        16 => press_points::<Sixteen, 16, STIFFENED>(model, tuned, state, tip_m, centre, &mut load),
        9 => press_points::<Nine, 9, STIFFENED>(model, tuned, state, tip_m, centre, &mut load),
        _ => press_points::<Four, 4, STIFFENED>(model, tuned, state, tip_m, centre, &mut load),
    }
    if !STIFFENED && !tuned.probe.shape.has_handle() {
        load.covered = covered(model, state, centre, &tuned.probe);
    }
    load
}

/// Evaluates the summed pushes at the end of the substep and completes the load.
#[inline(always)]
pub(super) fn answer(
    model: &Model,
    tuned: &Tuned,
    state: &mut State,
    tip_m: Vector3<f32>,
    velocity_m_per_s: Vector3<f32>,
    load: &mut Load,
) {
    let centre = centre_m(&tuned.probe, tip_m);
    if tuned.remembers {
        // by value: passed by reference, the load would stay in memory, at 2 % more instructions
        load.add(&settle_remembering(model, tuned, state, centre, velocity_m_per_s));
    } else {
        settle::<false>(model, tuned, state, centre, velocity_m_per_s, load);
    }
    // points were summed relative to the probe's centre
    load.point += centre * load.push;
}

/// Sums pushes and slopes of all points at the nodes.
#[inline(always)]
fn press_points<P: Points<Q>, const Q: usize, const STIFFENED: bool>(
    model: &Model,
    tuned: &Tuned,
    state: &mut State,
    tip_m: Vector3<f32>,
    centre: Vector3<f32>,
    load: &mut Load,
) {
    let laws = model.foundation.as_chunks::<Q>().0;
    let (probe, shaft, over) = (&tuned.probe, state.shaft, state.over);
    let lift = tip_m + probe.axis * probe.radius_m - centre;
    let mut left = tuned.most_pressed;
    for &index in state.candidates.iter().take(state.near) {
        let index = usize::from(index);
        let (Some(triangle), Some(points_law)) = (model.triangles.get(index), laws.get(index)) else { continue };
        let [a, b, c] = triangle.node.map(usize::from);
        let (Some(na), Some(nb), Some(nc)) = (state.nodes.get(a), state.nodes.get(b), state.nodes.get(c)) else { continue };
        let corners = [vector(&na.x) - centre, vector(&nb.x) - centre, vector(&nc.x) - centre];
        let against = against(tuned, corners);
        // computing the penetration twice is cheaper than storing it
        let points = P::at(corners);
        let touches = STIFFENED || points.iter().any(|d| penetration(probe, shaft, *d).is_some());
        if !touches || !STIFFENED && turned_away(corners, lift, probe) {
            continue;
        }
        if left == 0 {
            load.limited = true;
            break;
        }
        left -= 1;
        // the half that stiffens with the tissue; the other half of the point's stiffness is
        // constant
        let stiffer = P::at(if STIFFENED { [na.p, nb.p, nc.p] } else { [0.0; 3] });
        // built in place: zeroing the array first costs 800 instructions per tick
        let pushed = core::array::from_fn::<_, Q, _>(|n| {
            let Some((pen, out)) = pushed_out(probe, shaft, points[n], against) else { return (0.0, 0.0, ZERO) };
            let point = &points_law[n];
            let stiffens = model.stiffening_per_m * pen;
            let k = if STIFFENED { point.k * (0.5 + stiffer[n]) } else { point.k };
            let f = k * pen * (1.0 + stiffens);
            (f, k * (1.0 + 2.0 * stiffens), out * f)
        });
        let carried: f32 = pushed.iter().map(|(f, ..)| f).sum();
        let weight_over = if over == Some(index as u16) { carried * KEPT } else { carried };
        if weight_over > load.strongest.0 {
            load.strongest = (weight_over, index as u16);
        }
        let (slopes, force) = (P::shared(pushed.map(|(_, k, _)| k)), P::shared(pushed.map(|(.., f)| f)));
        for ((&n, f), k) in triangle.node.iter().zip(&force).zip(slopes) {
            if let Some(node) = state.nodes.get_mut(usize::from(n)) {
                add(&mut node.pass, &row(*f));
                node.slope += k;
            }
        }
    }
}

/// Runs [`settle`] for tissue that relaxes or for a probe with friction.
#[inline(never)]
fn settle_remembering(
    model: &Model,
    tuned: &Tuned,
    state: &mut State,
    centre: Vector3<f32>,
    velocity_m_per_s: Vector3<f32>,
) -> Load {
    let mut load = Load::NONE;
    // one copy, because each takes 2 KB of a board's flash: it tests at every node what is there
    settle::<true>(model, tuned, state, centre, velocity_m_per_s, &mut load);
    if tuned.relaxes() {
        relaxation::fade(tuned, state);
    }
    load
}

/// Evaluates the push at every touched node at the end of the substep. In tissue that relaxes the
/// push is left in `node.pass` for [`relaxation::fade`], which fades only the elastic forces. The
/// force along the surface of a probe that rubs is treated in the same way; the load contains the
/// push alone. Without `REMEMBERING` there is neither.
#[inline(always)]
fn settle<const REMEMBERING: bool>(
    model: &Model,
    tuned: &Tuned,
    state: &mut State,
    centre: Vector3<f32>,
    velocity_m_per_s: Vector3<f32>,
    load: &mut Load,
) {
    let (relaxes, rubs) = (REMEMBERING && tuned.relaxes(), REMEMBERING && tuned.rubs());
    let mut met = 0;
    for &index in state.candidates.iter().take(state.near) {
        let Some(triangle) = model.triangles.get(usize::from(index)) else { continue };
        for &n in &triangle.node {
            let n = usize::from(n);
            let (Some(node), Some(inertia), Some(rest)) = (state.nodes.get_mut(n), tuned.node_step.get(n), model.nodes.get(n))
            else {
                continue;
            };
            if node.slope > 0.0 {
                let faded = if relaxes { state.faded.get(n) } else { None };
                let (f, push, free) = match faded {
                    Some(faded) => implicit_relaxing(node, faded, inertia.step, tuned, velocity_m_per_s),
                    None => implicit(node, inertia.step, tuned, velocity_m_per_s),
                };
                let mut on_node = f;
                if rubs
                    && push > 0.0
                    && let Some(bristle) = friction::claim(state.bristles, &mut state.rubbing, met, n as u16)
                {
                    met += 1;
                    let touch = Touch {
                        from_centre_m: vector(&node.x) - centre,
                        push: f,
                        length: push,
                        slope: node.slope,
                        yields: tuned.lumping_s * inertia.step,
                        moves_m: vector(&node.v) * (tuned.substep_s * tuned.keep),
                        damps_m: velocity_m_per_s * tuned.contact_damping_s,
                        others: vector(&node.f),
                        faded: faded.map_or(ZERO, Faded::sum),
                    };
                    let along = friction::rub(bristle, &touch, tuned);
                    on_node += along;
                    state.rubbed.force += along;
                    state.rubbed.most += tuned.friction * push;
                }
                node.slope = 0.0;
                if tuned.fields {
                    node.free = free;
                }
                if relaxes {
                    node.pass = row(on_node);
                } else {
                    node.pass = [0.0; ROW];
                    add(&mut node.f, &row(on_node));
                }
                load.force += f;
                load.push += push;
                load.point += (vector(&node.x) - centre) * push;
                load.rest += Vector3::from(rest.rest_m) * push;
            }
        }
    }
    if REMEMBERING {
        state.rubbing = met;
    }
}

/// A node's push at the *end* of the substep, over E [N/Pa]: `f1 = (f0 - K (dt n.v + b n.F - beta
/// dt n.V)) / (1 + K b)`. Here f0 is the push at the node's present position, K its slope, F the
/// sum of the other forces on the node, b the node's displacement per force, and V the probe's
/// velocity. A node at rest carries f0, so statics are unaffected. The push never becomes a pull.
/// Also returns the share `1 / (1 + K b)` of other motions that is left to the node (1).
#[inline(always)]
fn implicit(node: &Node, step: f32, tuned: &Tuned, probe_m_per_s: Vector3<f32>) -> (Vector3<f32>, f32, f32) {
    let push = vector(&node.pass);
    let length = sqrt(push.dot(&push));
    if length == 0.0 {
        return (ZERO, 0.0, 1.0);
    }
    let normal = push * (1.0 / length);
    let yields = tuned.lumping_s * step;
    let speed =
        tuned.substep_s * tuned.keep * vector(&node.v).dot(&normal) - tuned.contact_damping_s * probe_m_per_s.dot(&normal);
    let resists = 1.0 + node.slope * yields;
    let f = (length - node.slope * (speed + yields * vector(&node.f).dot(&normal))) / resists;
    // NaN is not below zero: it reaches the node, and `integrate` turns it into a fault
    let f = if f < 0.0 { 0.0 } else { f };
    (normal * f, f, 1.0 / resists)
}

/// Like `implicit`, for the push `q = C p - n.s`, where p is the elastic push at the end of the
/// substep, C its immediate response and s the part that has faded at the node; F is replaced by
/// `C F + s`. A node at rest carries `C f0 - n.s`.
#[inline(always)]
fn implicit_relaxing(
    node: &Node,
    faded: &Faded,
    step: f32,
    tuned: &Tuned,
    probe_m_per_s: Vector3<f32>,
) -> (Vector3<f32>, f32, f32) {
    let push = vector(&node.pass);
    let length = sqrt(push.dot(&push));
    if length == 0.0 {
        return (ZERO, 0.0, 1.0);
    }
    let normal = push * (1.0 / length);
    let (at_once, faded) = (tuned.prony.at_once, faded.sum().dot(&normal));
    let yields = tuned.lumping_s * step;
    let speed =
        tuned.substep_s * tuned.keep * vector(&node.v).dot(&normal) - tuned.contact_damping_s * probe_m_per_s.dot(&normal);
    let others = at_once * vector(&node.f).dot(&normal) + faded;
    let elastic = length - node.slope * (speed + yields * others);
    let resists = 1.0 + at_once * node.slope * yields;
    let f = (at_once * elastic - faded) / resists;
    let f = if f < 0.0 { 0.0 } else { f };
    (normal * f, f, 1.0 / resists)
}

/// Whether a triangle cannot be pressed from the probe's position: the point one radius above the
/// tip, at `lift` from the probe's centre, is behind the triangle, or the triangle's normal is more
/// than 120 degrees from the axis of a probe with a handle. A probe that entered elsewhere would
/// push such a surface out of the tissue and be pulled into it. For a capsule the vector from the
/// nearest point of the segment is used instead, for an ellipsoid its gradient; like a full sphere,
/// these have no handle.
#[inline(always)]
pub(crate) fn turned_away([a, b, c]: [Vector3<f32>; 3], lift: Vector3<f32>, probe: &Probe) -> bool {
    let normal = (b - a).cross(&(c - a));
    let up = normal.dot(&probe.axis);
    let down = up < 0.0 && 4.0 * (up * up) > normal.dot(&normal) && probe.shape.has_handle();
    #[cfg(not(feature = "long-tips"))]
    let arm = a - lift;
    #[cfg(feature = "long-tips")]
    let arm = match probe.shape {
        ProbeShape::Capsule { length_m, along } => tip::from_segment((a + b + c) * THIRD, length_m, along),
        ProbeShape::Ellipsoid { semi_axes_m, along } => tip::slope_of_ellipsoid((a + b + c) * THIRD, probe, semi_axes_m, along),
        _ => a - lift,
    };
    down || arm.dot(&normal) > 0.0
}

/// Whether the surface has slipped past the widest part of the probe and closed above it: a line
/// from the centre along the axis passes through a triangle within one radius.
#[inline(never)]
pub(super) fn covered(model: &Model, state: &State, centre: Vector3<f32>, probe: &Probe) -> bool {
    let near = state.candidates.iter().take(state.near).filter_map(|&index| model.triangles.get(usize::from(index)));
    let mut corners = near.map(|triangle| triangle.node.map(|n| vector(&node(state.nodes, n).x) - centre));
    corners.any(|[a, b, c]| {
        let normal = (b - a).cross(&(c - a));
        let (rise, above) = (normal.dot(&probe.axis), a.dot(&normal));
        let around = [(a, b), (b, c), (c, a)].iter().all(|(from, to)| from.cross(to).dot(&probe.axis) >= 0.0);
        around && above > 0.0 && above < probe.radius_m * rise
    })
}

/// Whether any foundation point is inside the probe.
pub(crate) fn touches(model: &Model, tuned: &Tuned, state: &State, tip_m: Vector3<f32>) -> bool {
    let (probe, shaft) = (&tuned.probe, state.shaft);
    let centre = centre_m(probe, tip_m);
    let near = state.candidates.iter().take(state.near).filter_map(|&index| model.triangles.get(usize::from(index)));
    let mut corners = near.map(|triangle| triangle.node.map(|n| vector(&node(state.nodes, n).x) - centre));
    let inside = |d| penetration(probe, shaft, d).is_some();
    match model.points_per_triangle() {
        #[cfg(not(target_os = "none"))]
        16 => corners.any(|c| Sixteen::at(c).into_iter().any(inside)),
        9 => corners.any(|c| Nine::at(c).into_iter().any(inside)),
        _ => corners.any(|c| Four::at(c).into_iter().any(inside)),
    }
}

/// Unit normal of a triangle with these corners [m] if the probe is a tilted flat end, which pushes
/// against it.
#[inline(always)]
#[cfg_attr(not(feature = "long-tips"), expect(unused_variables, reason = "no tip is tilted"))]
pub(crate) fn against(tuned: &Tuned, [a, b, c]: [Vector3<f32>; 3]) -> Option<Vector3<f32>> {
    #[cfg(feature = "long-tips")]
    if tuned.probe.shape == ProbeShape::Flat && tuned.probe.axis != tuned.up() {
        let normal = (b - a).cross(&(c - a));
        return Some(normal * (1.0 / sqrt(normal.dot(&normal))));
    }
    None
}

/// Length [m] and direction of the push on a point of a triangle: those of [`penetration`], or
/// against the normal that [`against`] gives. Of the push of the rounded edge, only the part
/// against that normal acts.
#[inline(always)]
pub(crate) fn pushed_out(
    probe: &Probe,
    shaft: bool,
    d: Vector3<f32>,
    against: Option<Vector3<f32>>,
) -> Option<(f32, Vector3<f32>)> {
    let (pen, out) = penetration(probe, shaft, d)?;
    let Some(normal) = against else { return Some((pen, out)) };
    let share = if out == -probe.axis { 1.0 } else { -out.dot(&normal) };
    Some((pen * share, -normal))
}

/// Centre of the sphere, capsule or ellipsoid, or of the flat end [m].
pub(crate) fn centre_m(probe: &Probe, tip_m: Vector3<f32>) -> Vector3<f32> {
    match probe.shape {
        ProbeShape::Flat => tip_m,
        _ => tip_m + probe.axis * probe.radius_m,
    }
}

/// Depth of a point inside the probe [m] and the unit vector along which it leaves the probe;
/// `None` outside. `d` is the point relative to the probe's centre [m].
#[inline(always)]
pub(crate) fn penetration(probe: &Probe, shaft: bool, mut d: Vector3<f32>) -> Option<(f32, Vector3<f32>)> {
    let r = probe.radius_m;
    let along = d.dot(&probe.axis);
    match probe.shape {
        ProbeShape::Flat => {
            let edge = FLAT_EDGE * r;
            let off_axis = d - probe.axis * along;
            let square = off_axis.dot(&off_axis);
            // without a shaft the cylinder ends one radius above the face, so that below the tissue
            // it touches no surface from behind
            if along <= 0.0 || square >= r * r || (!shaft && along > r) {
                return None;
            }
            let inner = r - edge;
            if square <= inner * inner {
                return Some((along, -probe.axis));
            }
            // on the rounded edge: distance from a ring of radius `inner`, `edge` above the face
            let off = sqrt(square);
            let below = if along < edge { edge - along } else { 0.0 };
            let arm = off_axis * ((off - inner) / off) - probe.axis * below;
            let length = sqrt(arm.dot(&arm));
            return (length < edge).then(|| (edge - length, if length > 0.0 { arm * (1.0 / length) } else { -probe.axis }));
        }
        // above the half-sphere there is a cylinder if the tip is in the tissue; otherwise only the
        // ball touches
        ProbeShape::Hemisphere if along > 0.0 && shaft => d -= probe.axis * along,
        #[cfg(feature = "long-tips")]
        ProbeShape::Capsule { length_m, along } => d = tip::from_segment(d, length_m, along),
        #[cfg(feature = "long-tips")]
        ProbeShape::Ellipsoid { semi_axes_m, along } => {
            return tip::inside_ellipsoid(d, probe, semi_axes_m, along);
        }
        _ => {}
    }
    let square = d.dot(&d);
    if square >= r * r {
        return None;
    }
    let l = sqrt(square);
    let out = if l > 0.0 { d * (1.0 / l) } else { -probe.axis };
    Some((r - l, out))
}

#[cfg(test)]
mod tests;
