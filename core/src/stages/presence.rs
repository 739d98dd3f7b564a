//! Presence: whether the *sensed* tip is at the tissue at all, by geometry alone.
//!
//! The guard of [`super::probe`] keeps the tip that the patch is given inside the tissue. If a hand
//! went on through the side, the underside or past the patch's edge, a force would remain, and the
//! tip given to the patch would follow the hand. So every sensed tip is located first, in the rest
//! shape:
//!
//! | sensed tip | contact |
//! |---|---|
//! | inside a tet | yes, if it came in through the surface that a probe can touch |
//! | outside, at the triangle that carried most of the last tick's push | yes |
//! | elsewhere | no: the patch is shown the sensed tip, and contact begins with a fresh approach |
//!
//! Location is a walk from tet to tet through their faces (Devillers, Pion, Teillaud, Walking in a
//! triangulation, 2002). It starts at the tet where the walk of the last tick ended, so one or two
//! tets are tested per tick.
//!
//! * in: sensed tip [m], rest positions, `Model::neighbours`, the triangle touched last
//! * out: [`Presence`]; the tet that the next walk starts from
//! * cost: about 110 instructions of a Cortex-M4F per tet, one or two of them per tick and some
//!   thirty in the first tick of a patch
//! * failures: none; a tip that the walk does not reach within its steps counts as outside until a
//!   later tick reaches it

use nalgebra::Vector3;

use crate::lanes::sqrt;
use crate::model::{Model, NodeRest};
use crate::params::{Probe, ProbeShape, Tuned};
use crate::state::{Seat, State};

/// Largest height of the probe above the touched triangle, and largest depth of its tip below it,
/// at which contact is still possible [m].
const SURFACE_M: f32 = 1e-3;
/// Number of tets tested per tick: 1.5 mm of motion crosses one or two.
const STEPS: u16 = 8;
/// Number of tets tested in the first tick after a reset, when the tip may be anywhere.
const FIRST_STEPS: u16 = 512;

/// Position of the sensed tip relative to the tissue at rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Presence {
    /// In the rest volume, entered through the touchable surface.
    Inside,
    /// Outside the rest volume, within a millimetre of contact with the triangle touched last.
    AtSurface,
    /// No contact is possible.
    Outside,
}

/// Rest plane of a surface triangle.
#[derive(Clone, Copy, Debug)]
pub struct Plane {
    /// A point of the plane: the triangle's middle [m].
    pub middle_m: Vector3<f32>,
    /// Outward unit normal.
    pub normal: Vector3<f32>,
    /// Corners at rest, patch frame [m].
    corners_m: [Vector3<f32>; 3],
}

impl Plane {
    /// The plane of the triangle with this index.
    pub(crate) fn of(model: &Model, triangle: u16) -> Option<Self> {
        let triangle = model.triangles.get(usize::from(triangle))?;
        let [a, b, c] = triangle.node.map(|n| rest_m(model.nodes, n));
        let middle_m = (a + b + c) * (1.0 / 3.0);
        let area = (b - a).cross(&(c - a));
        Some(Self { middle_m, normal: area * (1.0 / sqrt(area.dot(&area))), corners_m: [a, b, c] })
    }

    /// Whether the plane is so steep that a tip below it says nothing about the probe's body.
    pub fn steep(&self, axis: Vector3<f32>) -> bool {
        self.normal.dot(&axis) < 0.7
    }

    /// Depth of a point below the plane [m].
    pub fn depth_m(&self, point_m: Vector3<f32>) -> f32 {
        (self.middle_m - point_m).dot(&self.normal)
    }

    /// Depth of the probe's deepest point below the plane [m]; that of the tip if the plane is
    /// normal to the axis.
    pub fn probe_depth_m(&self, probe: &Probe, tip_m: Vector3<f32>) -> f32 {
        self.depth_m(tip_m) + probe.below_tip_m(&self.normal)
    }

    /// Whether the probe with its tip at `tip_m` is at the plane, with the tip on the outer side,
    /// and no further beyond the triangle's edges than the probe reaches.
    fn holds(&self, probe: &Probe, tip_m: Vector3<f32>) -> bool {
        let lift_m = if probe.shape == ProbeShape::Flat { 0.0 } else { probe.radius_m };
        let end_m = tip_m + probe.axis * lift_m;
        let [a, b, c] = self.corners_m;
        let mut beyond_m = 0.0_f32;
        for (from_m, to_m) in [(a, b), (b, c), (c, a)] {
            // in the plane, away from the triangle: a limit on the distance from the triangle's
            // middle would also accept a probe beside a long triangle, where there is no tissue
            let out = (to_m - from_m).cross(&self.normal);
            let off_m = (end_m - from_m).dot(&out) / sqrt(out.dot(&out));
            beyond_m = if off_m > beyond_m { off_m } else { beyond_m };
        }
        let near_m = probe.reach_m() + SURFACE_M;
        if probe.shape == ProbeShape::Flat && self.steep(probe.axis) {
            // a flat end pushes only along its axis: below a wall it would touch the wall's points
            return false;
        }
        self.depth_m(tip_m) <= SURFACE_M && self.probe_depth_m(probe, tip_m) >= -SURFACE_M && beyond_m <= near_m
    }
}

/// Locates the sensed tip and decides whether there can be contact; also returns the rest plane of
/// the triangle touched last.
#[cfg_attr(feature = "stage-cost", inline(never))]
pub fn locate(model: &Model, tuned: &Tuned, state: &mut State, tip_m: Vector3<f32>) -> (Presence, Option<Plane>) {
    let before = state.seat;
    if !before.inside
        && !before.walking
        && let Some(&tet) = state.over.and_then(|triangle| model.owners.get(usize::from(triangle)))
    {
        state.seat.tet = tet;
    }
    let most = if state.tip_m.is_none() { FIRST_STEPS } else { STEPS };
    walk(model, &mut state.seat, tip_m, tuned.up(), most);
    let plane = state.over.and_then(|triangle| Plane::of(model, triangle));
    state.shaft = state.seat.inside;
    if state.seat.inside {
        // a body that enters from the side also touches the surface, with its tip below it
        let at_surface = |tip_m| plane.is_some_and(|plane| plane.holds(&tuned.probe, tip_m));
        if !before.inside && !before.above && !at_surface(tip_m) && !state.tip_m.is_some_and(at_surface) {
            // the tip entered through a side or from below: there is no force until it touches the
            // surface from outside
            state.been_outside = false;
        }
        return (Presence::Inside, plane);
    }
    if plane.is_some_and(|plane| plane.holds(&tuned.probe, tip_m)) {
        return (Presence::AtSurface, plane);
    }
    if before.inside || state.apart || state.touch.is_some() {
        // the tip left through a face other than the one by which it entered
        state.been_outside = false;
    }
    state.over = None;
    (Presence::Outside, None)
}

/// Whether the probe's body is in the tissue while its tip is at `tip_m`. It is, if the rest volume
/// contains the point above the tip that no press brings below the surface: one radius above the
/// tip, or the depth limit and a millimetre, whichever is more. Such a probe entered elsewhere.
#[cfg_attr(feature = "stage-cost", inline(never))]
pub fn buried(model: &Model, tuned: &Tuned, state: &mut State, tip_m: Vector3<f32>) -> bool {
    let probe = &tuned.probe;
    let deepest_m = model.depth_limit_m + SURFACE_M;
    let above_m = if probe.radius_m > deepest_m { probe.radius_m } else { deepest_m };
    if state.seat.inside && !state.body.inside && !state.body.walking {
        state.body.tet = state.seat.tet;
    }
    walk(model, &mut state.body, tip_m + tuned.up() * above_m, tuned.up(), STEPS);
    state.body.inside
}

/// Walks from tet to tet towards the tip. The walk ends inside a tet, or at one whose faces towards
/// the tip are all boundary.
fn walk(model: &Model, seat: &mut Seat, tip_m: Vector3<f32>, axis: Vector3<f32>, most: u16) {
    (seat.inside, seat.above, seat.walking) = (false, false, false);
    for _ in 0..most {
        let index = seat.tet as usize;
        let (Some(tet), Some(across)) = (model.tets.get(index), model.neighbours.get(index)) else {
            seat.tet = 0;
            return;
        };
        let [a, b, c, d] = tet.node.map(|n| rest_m(model.nodes, n) - tip_m);
        let (ab, cd) = (a.cross(&b), c.cross(&d));
        // six times the signed volumes of the tip with each face, the face opposite node k at index
        // k
        let volumes = [b.dot(&cd), -a.dot(&cd), d.dot(&ab), -c.dot(&ab)];
        if volumes.iter().all(|volume| *volume >= 0.0) {
            seat.inside = true;
            return;
        }
        seat.steps = seat.steps.wrapping_add(1);
        let (mut above, mut next) = (false, None);
        for k in 0..4 {
            let k = (k + usize::from(seat.steps)) % 4;
            // a NaN tip is beyond every face
            if let (Some(volume), Some(&tet)) = (volumes.get(k), across.get(k))
                && (*volume < 0.0 || volume.is_nan())
            {
                match tet {
                    Model::HIDDEN => {}
                    Model::TOUCHABLE => above |= outward([a, b, c, d], k).dot(&axis) > 0.0,
                    _ => next = Some(tet),
                }
            }
        }
        match next {
            Some(tet) => seat.tet = tet,
            None => {
                seat.above = above;
                return;
            }
        }
    }
    seat.walking = true;
}

/// Outward normal, of any length, of the face opposite corner `k` of a tet.
#[inline(always)]
fn outward([a, b, c, d]: [Vector3<f32>; 4], k: usize) -> Vector3<f32> {
    let [p, q, r] = match k {
        0 => [b, c, d],
        1 => [a, d, c],
        2 => [a, b, d],
        _ => [a, c, b],
    };
    (q - p).cross(&(r - p))
}

/// Rest position of a node [m]; past the end, which no checked model reaches, the origin.
#[inline(always)]
fn rest_m(nodes: &[NodeRest], index: u16) -> Vector3<f32> {
    nodes.get(usize::from(index)).map_or(Vector3::new(0.0, 0.0, 0.0), |node| node.rest_m.into())
}
