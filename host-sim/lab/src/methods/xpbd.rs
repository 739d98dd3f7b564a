//! Extended position-based dynamics (Macklin et al. 2016), one Gauss-Seidel pass per substep
//! ("small steps", Macklin et al. 2019).
//!
//! The constraints are the length of every edge with compliance `1/k`, where k is the spring
//! constant of our own model, and the volume of every tet with compliance `V / kappa`, where kappa
//! = lambda - mu. The small-strain moduli are therefore those of springs with per-tet volume. The
//! core moves the nodes and presses the surface; then the constraints move the nodes again, and
//! this displacement is also added to the velocity.

use palpate::method::Method;
use palpate::stages::force::{self, foundation, foundation::Load};
use palpate::{Model, Params, State, Terms, Tuned, Vector3};

use super::{OnCore, RunningMethod};
use palpate_tissue::error::Error;
use palpate_tissue::patch::{Memory, Patch};

struct Edge {
    node: [u16; 2],
    rest_m: f32,
    /// Compliance over dt^2 [1/kg].
    compliance: f32,
    /// Reciprocal of the sum of inverse masses and compliance [kg].
    gain: f32,
}

struct Cell {
    node: [u16; 4],
    six_volume_m3: f32,
    /// 36 times the compliance over dt^2 [m^4/kg].
    compliance: f32,
}

/// Constraints, and the positions on which they act.
pub struct Xpbd {
    edges: Vec<Edge>,
    cells: Vec<Cell>,
    inverse_mass: Vec<f32>,
    position_m: Vec<Vector3<f32>>,
    per_substep: f32,
    /// Reciprocal of E times the square of the substep.
    per_dt2_e: f32,
}

impl Xpbd {
    /// Floating-point operations per edge and per tet, counted in this file; a division or root
    /// counts as 14, its number of cycles on the Cortex-M4F.
    pub const FLOPS: [f64; 2] = [55.0, 160.0];

    fn new(model: &Model, tuned: &Tuned, params: &Params) -> Self {
        let dt_s = params.tick_s / f32::from(params.substeps);
        let per_dt2 = 1.0 / (dt_s * dt_s * params.youngs_modulus_pa);
        let inverse_mass: Vec<f32> = (0..model.nodes.len()).map(|n| 1.0 / tuned.mass_kg(n).unwrap_or(f32::INFINITY)).collect();
        let edges = model.springs.iter().map(|s| {
            let node = [s.i, s.j];
            let compliance = per_dt2 / s.k;
            let inverse: f32 = node.iter().map(|&n| inverse_mass[usize::from(n)]).sum();
            Edge { node, rest_m: s.k_rest / s.k, compliance, gain: 1.0 / (inverse + compliance) }
        });
        let cells = model.tets.iter().map(|t| {
            let six_volume_m3 = 1.0 / t.six_volume_reciprocal;
            // kappa over E is six times `bulk`; the constraint C is six times the change of volume
            Cell { node: t.node, six_volume_m3, compliance: 36.0 * per_dt2 * (six_volume_m3 / 6.0) / (6.0 * t.bulk) }
        });
        Self {
            edges: edges.collect(),
            cells: cells.collect(),
            position_m: vec![Vector3::zeros(); model.nodes.len()],
            inverse_mass,
            per_substep: 1.0 / dt_s,
            per_dt2_e: per_dt2,
        }
    }

    /// Runs one Gauss-Seidel pass over all constraints.
    fn project(&mut self) {
        let (x, w) = (&mut self.position_m, &self.inverse_mass);
        for edge in &self.edges {
            let [i, j] = edge.node.map(usize::from);
            let d = x[j] - x[i];
            let length = d.norm();
            debug_assert!(edge.compliance > 0.0);
            let pull = d * ((length - edge.rest_m) * edge.gain / length);
            x[i] += pull * w[i];
            x[j] -= pull * w[j];
        }
        for cell in &self.cells {
            let [a, b, c, d] = cell.node.map(usize::from);
            let (u, v, t) = (x[b] - x[a], x[c] - x[a], x[d] - x[a]);
            let (gb, gc, gd) = (v.cross(&t), t.cross(&u), u.cross(&v));
            let ga = -(gb + gc + gd);
            let soft = w[a] * ga.norm_squared() + w[b] * gb.norm_squared() + w[c] * gc.norm_squared() + w[d] * gd.norm_squared();
            let push = (cell.six_volume_m3 - u.dot(&gb)) / (soft + cell.compliance);
            for (n, g) in [(a, ga), (b, gb), (c, gc), (d, gd)] {
                x[n] += g * (push * w[n]);
            }
        }
    }
}

/// The constraints, and their effect in the last substep as a force over E on each node [N/Pa],
/// because contact needs the other forces on a node.
struct Projection {
    xpbd: Xpbd,
    force: Vec<Vector3<f32>>,
}

impl Method for Projection {
    fn force(&mut self, model: &Model, tuned: &Tuned, state: &mut State, tip_m: Vector3<f32>, speed: Vector3<f32>) -> Load {
        force::accumulate_inner(model, tuned, state);
        self.force.iter().enumerate().for_each(|(n, f)| state.add_force(n, *f));
        let load = foundation::press(model, tuned, state, tip_m, speed);
        self.force.iter().enumerate().for_each(|(n, f)| state.add_force(n, -f));
        load
    }

    fn correct(&mut self, _: &Model, _: &Tuned, state: &mut State) {
        let Self { xpbd, force } = self;
        for (x, node) in xpbd.position_m.iter_mut().zip(state.nodes()) {
            *x = node.position_m();
        }
        xpbd.project();
        for (n, ((x, w), force)) in xpbd.position_m.iter().zip(&xpbd.inverse_mass).zip(force).enumerate() {
            if *w > 0.0 {
                let node = state.nodes()[n];
                let moved = x - node.position_m();
                state.place(n, *x, node.velocity_m_per_s() + moved * xpbd.per_substep);
                *force = moved * (xpbd.per_dt2_e / w);
            }
        }
    }
}

/// Runs the constraints on a patch whose volume stiffness is entirely per tet.
pub(super) fn with<T>(patch: &Patch, params: &Params, work: impl FnOnce(&mut dyn RunningMethod) -> T) -> Result<T, Error> {
    let whole = patch.wide_model();
    let mut memory = Memory::for_model(&whole);
    let params = Params { terms: Terms::SPRINGS_ONLY, ..*params };
    let (tuned, state) = memory.start(&whole, &params)?;
    let xpbd = Xpbd::new(&whole, &tuned, &params);
    let model = Model { springs: &[], ..whole };
    Ok(work(&mut OnCore {
        model: &model,
        tuned: &tuned,
        state,
        method: Projection { xpbd, force: vec![Vector3::zeros(); whole.nodes.len()] },
    }))
}
