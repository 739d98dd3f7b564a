//! Contact map: how the contact force of a tick is distributed over the surface, and the torque
//! about the tip that follows, computed on request.
//!
//! A net force is one vector. Where the tissue pushes, over what area and how unevenly, is known
//! from the foundation points that produced it ([`crate::stages::force::foundation`]). The map
//! evaluates them again, at the node positions that the tick left. No tick needs the map, pays for
//! it or changes because of it: the map writes only scratch fields of the state, which are zero
//! between ticks or are cleared at the start of every tick.
//!
//! * in: positions after a tick, its candidates, the tip that the patch was shown
//! * out: area, centre, axes, peak pressure, normal and friction force, torque; the pressure of
//!   every surface triangle
//! * cost: 0.8 us per touched triangle on a desktop, 20 us at 410 nodes; with stiffening one more
//!   pass over the springs; 19 kB of flash on a board, so the shipped images leave it out
//! * failures: none; empty without contact, after a fault, and for a law, which has no surface

mod covered;
mod moments;

use nalgebra::Vector3;

use crate::lanes::{ROW, vector};
use crate::model::Model;
use crate::params::Tuned;
#[cfg(not(target_os = "none"))]
use crate::stages::force::foundation::Sixteen;
use crate::stages::force::foundation::{Four, Nine, Points, against, centre_m, push, pushed_out, turned_away};
use crate::stages::force::friction;
#[cfg(not(target_os = "none"))]
use crate::stages::force::stiffening;
use crate::state::{Faded, State, node};
use moments::Moments;

/// Area, force and moments of a contact. Pressures are those of the push, without friction.
///
/// The map contains the tissue's part alone: the force of the deformed surface at its present
/// position. In a hold, `force_n` is the force of the tick; while the probe moves, the tick's force
/// also contains the contact's damping and is averaged over the substeps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactMap {
    /// Area of the deformed surface inside the probe [m^2].
    pub area_m2: f32,
    /// Centre of pressure, patch frame [m].
    pub centre_m: Vector3<f32>,
    /// Normal force on the probe, patch frame [N]: the sum of the pushes, which points out of the
    /// tissue.
    pub force_n: Vector3<f32>,
    /// Friction force on the probe, patch frame [N]; it acts along the surface.
    pub friction_n: Vector3<f32>,
    /// Torque of both forces on the probe about its tip, patch frame [N m]: right-handed, and zero
    /// for a force through the tip.
    pub torque_nm: Vector3<f32>,
    /// Principal axes of the area in the plane across `force_n`, unit vectors, the longer first;
    /// their signs are arbitrary.
    pub axes: [Vector3<f32>; 2],
    /// Semi-axes, along `axes`, of the ellipse that has the second moments of the area [m]; if the
    /// contact is an ellipse, they are its own.
    pub half_lengths_m: [f32; 2],
    /// Largest of the mean pressures on single surface triangles [Pa].
    pub peak_pressure_pa: f32,
    /// Number of surface triangles that push.
    pub triangles: u16,
}

/// Force and torque that the tissue exerts on the probe, patch frame, before damping, gains and
/// limits of a loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wrench {
    /// Normal and friction force [N].
    pub force_n: Vector3<f32>,
    /// Torque about the tip that the patch was shown [N m], right-handed.
    pub torque_nm: Vector3<f32>,
}

impl ContactMap {
    /// The map of a probe that touches nothing.
    pub const NONE: Self = Self {
        area_m2: 0.0,
        centre_m: ZERO,
        force_n: ZERO,
        friction_n: ZERO,
        torque_nm: ZERO,
        axes: [ZERO; 2],
        half_lengths_m: [0.0; 2],
        peak_pressure_pa: 0.0,
        triangles: 0,
    };

    /// Wrench on the probe: to move its reference to another point p, add `(tip - p) x force_n` to
    /// the torque.
    #[must_use]
    pub fn wrench(&self) -> Wrench {
        Wrench { force_n: self.force_n + self.friction_n, torque_nm: self.torque_nm }
    }

    /// The contact of the last tick. `pressure_pa` receives the mean pressure on each surface
    /// triangle [Pa], shape \[triangles\] in the model's order, zero where nothing touches. A
    /// shorter slice, even an empty one, receives the first triangles only. The push of a triangle
    /// is directed along the probe's normals at its points, not along its own normal.
    ///
    /// `model` and `tuned` are those of the tick.
    pub fn read(model: &Model, tuned: &Tuned, state: &mut State, pressure_pa: &mut [f32]) -> Self {
        pressure_pa.fill(0.0);
        let Some(tip_m) = state.tip_m.filter(|_| state.in_contact() && state.fault().is_none()) else { return Self::NONE };
        #[cfg(not(target_os = "none"))]
        if tuned.stiffens() {
            state.nodes.iter_mut().for_each(|node| node.p = 0.0);
            let touching = stiffening::measure(model, tuned, state, tip_m);
            return of_patch::<true>(model, tuned, state, tip_m, touching, pressure_pa);
        }
        of_patch::<false>(model, tuned, state, tip_m, state.near, pressure_pa)
    }
}

const ZERO: Vector3<f32> = Vector3::new(0.0, 0.0, 0.0);

/// All candidates that push are among the first `pushing` ones.
fn of_patch<const STIFFENED: bool>(
    model: &Model,
    tuned: &Tuned,
    state: &mut State,
    tip_m: Vector3<f32>,
    pushing: usize,
    pressure_pa: &mut [f32],
) -> ContactMap {
    let sums = tuned.relaxes() || tuned.rubs();
    if sums {
        // the part that has faded at a node is a share of the sum of its pushes, which also limits
        // the friction there
        let near = core::mem::replace(&mut state.near, pushing);
        push::<STIFFENED>(model, tuned, state, tip_m);
        state.near = near;
    }
    let map = match model.points_per_triangle() {
        #[cfg(not(target_os = "none"))]
        16 => of_points::<Sixteen, 16, STIFFENED>(model, tuned, state, tip_m, pressure_pa),
        9 => of_points::<Nine, 9, STIFFENED>(model, tuned, state, tip_m, pressure_pa),
        _ => of_points::<Four, 4, STIFFENED>(model, tuned, state, tip_m, pressure_pa),
    };
    if sums {
        state.nodes.iter_mut().for_each(|node| (node.pass, node.slope) = ([0.0; ROW], 0.0));
    }
    if map.triangles == 0 {
        // a contact too small to have an area
        pressure_pa.fill(0.0);
    }
    map
}

fn of_points<P: Points<Q>, const Q: usize, const STIFFENED: bool>(
    model: &Model,
    tuned: &Tuned,
    state: &State,
    tip_m: Vector3<f32>,
    pressure_pa: &mut [f32],
) -> ContactMap {
    let (probe, shaft) = (&tuned.probe, state.shaft);
    let laws = model.foundation.as_chunks::<Q>().0;
    let centre = centre_m(probe, tip_m);
    let lift = tip_m + probe.axis * probe.radius_m - centre;
    let mut sum = Moments::default();
    for &index in state.candidates.iter().take(state.near) {
        let index = usize::from(index);
        let (Some(triangle), Some(law)) = (model.triangles.get(index), laws.get(index)) else { continue };
        let nodes = triangle.node.map(|n| node(state.nodes, n));
        let corners = nodes.map(|node| vector(&node.x) - centre);
        if turned_away(corners, lift, probe) {
            continue;
        }
        let triangle_m2 = covered::of_triangle(probe, shaft, corners, |at_m, area_m2| sum.add_area(at_m, area_m2));
        let lasting = P::at(triangle.node.map(|n| lasting(tuned, state, n)));
        let stiffer = P::at(if STIFFENED { nodes.map(|node| node.p) } else { [0.0; 3] });
        let (against, mut pushed) = (against(tuned, corners), 0.0);
        for (((d, law), lasting), stiffer) in P::at(corners).into_iter().zip(law).zip(lasting).zip(stiffer) {
            let Some((pen, out)) = pushed_out(probe, shaft, d, against) else { continue };
            let k = if STIFFENED { law.k * (0.5 + stiffer) } else { law.k };
            let push = k * pen * (1.0 + model.stiffening_per_m * pen) * lasting;
            sum.add_push(d, out, push);
            pushed += push;
        }
        if pushed > 0.0 && triangle_m2 > 0.0 {
            let pressure = pushed / triangle_m2;
            if let Some(slot) = pressure_pa.get_mut(index) {
                *slot = pressure * tuned.youngs_modulus_pa;
            }
            sum.add_triangle(pressure);
        }
    }
    for bristle in state.bristles.iter().take(if tuned.rubs() { state.rubbing } else { 0 }) {
        let node = node(state.nodes, bristle.node);
        let faded = state.faded.get(usize::from(bristle.node)).filter(|_| tuned.relaxes()).map_or(ZERO, Faded::sum);
        let at = vector(&node.x) - centre;
        sum.add_friction(at, friction::at_rest(bristle, at, vector(&node.pass), faded, tuned));
    }
    sum.map(centre, tip_m, tuned.youngs_modulus_pa)
}

/// Share of a node's push that has not faded (1).
fn lasting(tuned: &Tuned, state: &State, n: u16) -> f32 {
    if !tuned.relaxes() {
        return 1.0;
    }
    let push = vector(&node(state.nodes, n).pass);
    let square = push.dot(&push);
    let Some(faded) = state.faded.get(usize::from(n)).filter(|_| square > 0.0) else { return 0.0 };
    let share = tuned.prony.at_once - faded.sum().dot(&push) / square;
    if share > 0.0 { share } else { 0.0 }
}
