//! Volume energy: nodal-averaged, with a small per-tet share.
//!
//! Springs alone are a solid with Poisson's ratio 1/4. What is missing to the wanted ratio is `kappa = lambda - mu`, added as
//! `sum_n V_n kappa w(J_n)` with `J_n = sum V_t / sum V_t0` over the node's tets and `w' = 2 (J - 1) / (J (J + 1))`: as stiff as `ln J / J` to
//! second order, without a logarithm. Averaging over nodes does not lock; alone it lets neighbouring tets trade volume, so a share
//! beta acts per tet, and a barrier opens tets below 0.4 of their volume (`compensation`).
//!
//! * in: positions
//! * out: adds to `node.f`; leaves each node's pressure over E in `state.pressure`
//! * cost (M4F, estimated): about 85 + 186 cycles a tet, 33 a node
//! * may fail: never

use nalgebra::Vector3;

use super::compensation;
use crate::lanes::{Lanes, ROW, add};
use crate::model::{Model, NodeRest, Tet};
use crate::params::Tuned;
use crate::state::{Node, State};

/// Below this share of its rest volume a node's pressure stops growing; the barrier takes over long before.
const LEAST_RATIO: f32 = 0.1;

/// Adds the volume forces over E [N/Pa].
#[inline(always)]
pub fn resist(model: &Model, tuned: &Tuned, state: &mut State) {
    measure(model.tets, state.nodes, state.pressure);
    pressurise(model.nodes, state.pressure);
    match tuned.terms.compensation {
        true => push::<true>(model.tets, state.nodes, state.pressure),
        false => push::<false>(model.tets, state.nodes, state.pressure),
    }
}

/// Six times the volume of the tets around every node [m^3].
#[cfg_attr(feature = "stage-cost", inline(never))]
fn measure(tets: &[Tet], nodes: &[Node], six_volume: &mut [f32]) {
    six_volume.fill(0.0);
    #[cfg(not(target_os = "none"))]
    let (fours, tets) = tets.as_chunks::<4>();
    #[cfg(not(target_os = "none"))]
    measure_groups::<wide::f32x4, 4>(fours, nodes, six_volume);
    measure_groups::<f32, 1>(tets.as_chunks().0, nodes, six_volume);
}

#[inline(always)]
fn measure_groups<L: Lanes<W>, const W: usize>(groups: &[[Tet; W]], nodes: &[Node], six_volume: &mut [f32]) {
    for group in groups {
        let (_, v) = gradients::<L, W>(nodes, group);
        for (tet, v) in group.iter().zip(v.to_array()) {
            for n in tet.node {
                if let Some(sum) = six_volume.get_mut(usize::from(n)) {
                    *sum += v;
                }
            }
        }
    }
}

/// Turns every node's volume into its pressure over E, divided by 24 (a quarter for each corner, a sixth for the gradient).
#[cfg_attr(feature = "stage-cost", inline(never))]
fn pressurise(rest: &[NodeRest], pressure: &mut [f32]) {
    for (p, node) in pressure.iter_mut().zip(rest) {
        let j = Lanes::<1>::at_least(*p * node.six_volume_reciprocal, LEAST_RATIO);
        *p = node.pressure * (j - 1.0) / (j * (j + 1.0));
    }
}

/// Pushes every tet's nodes along its volume gradients.
#[cfg_attr(feature = "stage-cost", inline(never))]
fn push<const BARRIER: bool>(tets: &[Tet], nodes: &mut [Node], pressure: &[f32]) {
    #[cfg(not(target_os = "none"))]
    let (fours, tets) = tets.as_chunks::<4>();
    #[cfg(not(target_os = "none"))]
    push_groups::<wide::f32x4, 4, BARRIER>(fours, nodes, pressure);
    push_groups::<f32, 1, BARRIER>(tets.as_chunks().0, nodes, pressure);
}

#[inline(always)]
fn push_groups<L: Lanes<W>, const W: usize, const BARRIER: bool>(groups: &[[Tet; W]], nodes: &mut [Node], pressure: &[f32]) {
    for group in groups {
        let ([g1, g2, g3], v) = gradients::<L, W>(nodes, group);
        let at = |corner: usize| {
            L::from_array(group.each_ref().map(|t| pressure.get(usize::from(t.node[corner])).copied().unwrap_or(0.0)))
        };
        let nodal = (at(0) + at(1)) + (at(2) + at(3));
        let j = v * L::from_array(group.each_ref().map(|t| t.six_volume_reciprocal));
        let bulk = L::from_array(group.each_ref().map(|t| t.bulk));
        // opening is positive: minus the pressure
        let mut p = -nodal - bulk * (j - L::splat(1.0));
        if BARRIER {
            p += compensation::of_tet(j, L::from_array(group.each_ref().map(|t| t.barrier)));
        }
        let (f1, f2, f3) = (g1.map(|g| p * g), g2.map(|g| p * g), g3.map(|g| p * g));
        let f0 = Vector3::new(-((f1.x + f2.x) + f3.x), -((f1.y + f2.y) + f3.y), -((f1.z + f2.z) + f3.z));
        for (corner, f) in [f0, f1, f2, f3].into_iter().enumerate() {
            for (tet, f) in group.iter().zip(L::to_rows(f)) {
                if let Some(node) = nodes.get_mut(usize::from(tet.node[corner])) {
                    add(&mut node.f, &f);
                }
            }
        }
    }
}

/// Gradients of six times the volume with respect to corners b, c, d [m^2], and six times the volume [m^3].
#[inline(always)]
fn gradients<L: Lanes<W>, const W: usize>(nodes: &[Node], group: &[Tet; W]) -> ([Vector3<L>; 3], L) {
    let at = |corner: usize| {
        L::from_rows(group.each_ref().map(|t| nodes.get(usize::from(t.node[corner])).map_or([0.0; ROW], |n| n.x)))
    };
    let a = at(0);
    let (e1, e2, e3) = (at(1) - a, at(2) - a, at(3) - a);
    let (g1, g2, g3) = (cross(e2, e3), cross(e3, e1), cross(e1, e2));
    let v = e1.x * g1.x + e1.y * g1.y + e1.z * g1.z;
    ([g1, g2, g3], v)
}

#[inline(always)]
fn cross<L: Lanes<W>, const W: usize>(a: Vector3<L>, b: Vector3<L>) -> Vector3<L> {
    Vector3::new(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)
}
