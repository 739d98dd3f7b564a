//! Errors of the settled force and of the surface shape in the holds, against the reference.

use palpate::{Fault, Vector3};
use serde::{Deserialize, Serialize};

use super::reference::Reference;
use super::survive::{CLEAR_M, positions};
use crate::methods::{Block, RunningMethod};
use palpate_tissue::mesh::surface::surface;
use palpate_tissue::probe_surface::outer_face_m;

/// Depths at which the force is compared [m].
pub const DEPTHS_M: [f64; 4] = [0.001, 0.002, 0.004, 0.008];
/// Depths at which the surface is compared [m].
pub const SURFACE_DEPTHS_M: [f64; 2] = [0.002, 0.004];
/// Distance from the axis up to which the surface is compared [m].
const SURFACE_RADIUS_M: f64 = 0.020;
/// Spacing of the points at which surfaces are compared [m].
const SPACING_M: f64 = 0.001;
/// Speed between the holds [m/s].
pub(super) const SPEED_M_PER_S: f64 = 0.04;
/// Number of ticks over which a force is averaged.
pub(super) const AVERAGED_TICKS: usize = 50;
/// Relative difference of successive means below which a hold counts as settled (1): with the mass
/// floor the last percent takes long.
pub(super) const SETTLED: f64 = 5e-4;
/// Number of settled means in a row that end a hold: at its extremes even a slow oscillation looks
/// settled.
pub(super) const IN_A_ROW: usize = 4;
/// Largest number of means in a hold.
pub(super) const MOST_MEANS: usize = 40;

/// Force and surface errors of a method.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Accuracy {
    /// Settled force at each of [`DEPTHS_M`] [N].
    pub force_n: [f64; 4],
    /// Error of the force at each depth [%]; `None` without a reference.
    pub force_error_pct: [Option<f64>; 4],
    /// Mean distance between the method's surface and the reference's at each of
    /// [`SURFACE_DEPTHS_M`] [mm].
    pub surface_error_mm: [Option<f64>; 2],
}

impl Accuracy {
    /// Presses from one hold to the next, deeper one.
    pub fn measure(block: &Block, running: &mut dyn RunningMethod, reference: &Reference) -> Result<Self, Fault> {
        let mut accuracy = Self { force_n: [0.0; 4], force_error_pct: [None; 4], surface_error_mm: [None; 2] };
        let step_m = SPEED_M_PER_S * f64::from(block.params.tick_s);
        let mut depth_m = -CLEAR_M;
        for (n, &target_m) in DEPTHS_M.iter().enumerate() {
            let ramp = ((target_m - depth_m) / step_m).ceil() as usize;
            for k in 1..=ramp {
                running.tick(block.tip_m(depth_m + (target_m - depth_m) * k as f64 / ramp as f64))?;
            }
            depth_m = target_m;
            let force_n = hold(block, running, depth_m)?;
            accuracy.force_n[n] = force_n;
            let over_e = force_n / f64::from(block.params.youngs_modulus_pa);
            accuracy.force_error_pct[n] = reference.force_over_e_m2(depth_m).map(|f| (over_e / f - 1.0) * 100.0);
            if let Some(s) = SURFACE_DEPTHS_M.iter().position(|d| *d == depth_m) {
                accuracy.surface_error_mm[s] = surface_error_mm(block, running, reference, depth_m);
            }
        }
        Ok(accuracy)
    }

    /// Root mean square of the force errors over the depths that have a reference [%].
    pub fn rms_pct(&self) -> Option<f64> {
        mean(self.force_error_pct.iter().flatten().map(|e| e * e)).map(f64::sqrt)
    }

    /// Mean of the surface errors [mm].
    pub fn surface_mm(&self) -> Option<f64> {
        mean(self.surface_error_mm.iter().flatten().copied())
    }
}

/// Mean force along the probe's axis once it has settled [N].
pub fn hold(block: &Block, running: &mut dyn RunningMethod, depth_m: f64) -> Result<f64, Fault> {
    let (mut last_n, mut still) = (f64::NAN, 0);
    for _ in 0..MOST_MEANS {
        let mut sum_n = 0.0;
        for _ in 0..AVERAGED_TICKS {
            sum_n += f64::from(running.tick(block.tip_m(depth_m))?.dot(&block.params.probe.axis));
        }
        let mean_n = sum_n / AVERAGED_TICKS as f64;
        still = if (mean_n - last_n).abs() <= SETTLED * mean_n.abs() { still + 1 } else { 0 };
        if still == IN_A_ROW {
            return Ok(mean_n);
        }
        last_n = mean_n;
    }
    Ok(last_n)
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), v| (sum + v, count + 1.0));
    (count > 0.0).then(|| sum / count)
}

/// Mean distance between the displaced surfaces of the mesh and of the reference [mm], taken point
/// by point on a square grid of rest positions: each part of the surface is weighted by its area,
/// whatever the mesh.
fn surface_error_mm(block: &Block, running: &dyn RunningMethod, reference: &Reference, depth_m: f64) -> Option<f64> {
    if !running.has_surface() {
        return None;
    }
    let mesh = &block.tissue.mesh;
    let moved = positions(running, mesh.nodes_m.len());
    let rest: Vec<Vector3<f64>> = mesh.nodes_m.iter().map(|x| Vector3::from(*x)).collect();
    let on_top = |t: &[u32; 3]| t.iter().all(|&n| rest[n as usize].z.abs() < 1e-9);
    let top: Vec<[usize; 3]> = surface(&mesh.tets).iter().filter(|t| on_top(t)).map(|t| t.map(|n| n as usize)).collect();
    let reach = (SURFACE_RADIUS_M / SPACING_M) as i32;
    let mut distances = Vec::new();
    for i in -reach..=reach {
        for j in -reach..=reach {
            let at = [f64::from(i) * SPACING_M, f64::from(j) * SPACING_M];
            if at[0].hypot(at[1]) >= SURFACE_RADIUS_M {
                continue;
            }
            let Some(u) = reference.displacement_m(depth_m, at) else { continue };
            let held = top.iter().find_map(|t| weights(t.map(|n| rest[n]), at).map(|w| (t, w)));
            if let Some((t, w)) = held {
                let sum = |of: &[Vector3<f64>]| t.iter().zip(w).map(|(&n, w)| of[n] * w).sum::<Vector3<f64>>();
                // this leaves the surface unchanged for methods without a foundation: it is already
                // on the probe
                let own = outer_face_m(&block.params.probe, block.tip_m(depth_m).cast(), sum(&moved)) - sum(&rest);
                distances.push((own - u).norm() * 1e3);
            }
        }
    }
    mean(distances.into_iter())
}

/// Barycentric weights of (x, y) in a triangle seen from above, if it is inside.
fn weights([a, b, c]: [Vector3<f64>; 3], at: [f64; 2]) -> Option<[f64; 3]> {
    let turn = |p: [f64; 2], q: [f64; 2], r: [f64; 2]| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    let [a, b, c] = [a, b, c].map(|p| [p.x, p.y]);
    let whole = turn(a, b, c);
    let w = [turn(at, b, c) / whole, turn(a, at, c) / whole, turn(a, b, at) / whole];
    w.iter().all(|w| *w >= -1e-9).then_some(w)
}
