//! Organs at rest under their weight: held at some nodes, displaced at others, and tied to each
//! other.
//!
//! The weight and the displacement of the moved nodes are applied together, in the largest steps
//! that converge. Each step begins with the first-order response of the free nodes (Euler's
//! predictor; Bonet and Wood, *Nonlinear Continuum Mechanics*, 9.5), which Newton's method then
//! corrects.

use nalgebra::Vector3;

use super::suspension::{HangError, Suspension};
use palpate_fit::reference::body::{Assembled, Body};
use palpate_fit::reference::minimise::{Minimiser, Potential};

/// First and smallest step, as shares of the whole load (1).
const FIRST_STEP: f64 = 0.25;
const LEAST_STEP: f64 = 1.0 / 512.0;
/// Norm of the residual divided by that of the forces, in the last step and in earlier ones (1).
const TOLERANCE: f64 = 1e-8;
const LOOSE: f64 = 1e-2;

/// Reaction force and moment at some nodes, over Young's modulus.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Support {
    /// Force on the body over Young's modulus [m^2].
    pub force_m2: Vector3<f64>,
    /// Moment on the body about the origin, over Young's modulus, with nodes at their present
    /// positions [m^3].
    pub moment_m3: Vector3<f64>,
}

/// A suspension that is loaded step by step, from rest without weight.
pub struct Hanging<'a> {
    suspension: &'a Suspension,
    solver: Minimiser,
    /// Displacement of every node [m].
    pub displacement_m: Vec<Vector3<f64>>,
    weight_share: f64,
}

/// A suspension under a share of its weight.
struct Weighed<'a> {
    suspension: &'a Suspension,
    weight_share: f64,
}

impl Potential for Weighed<'_> {
    fn body(&self) -> &Body {
        &self.suspension.body
    }

    fn energy(&self, displacement_m: &[Vector3<f64>]) -> Option<f64> {
        self.suspension.energy_m3(displacement_m, self.weight_share)
    }

    fn assemble(&self, displacement_m: &[Vector3<f64>], tangent: bool) -> Option<Assembled> {
        self.suspension.derive(displacement_m, self.weight_share, tangent)
    }

    fn force_m2(&self, _: &[Vector3<f64>], assembled: &Assembled) -> f64 {
        let held = assembled.residual_m2.iter().zip(&self.suspension.body.fixed).flat_map(|(r, fixed)| {
            let parts = [0, 1, 2].map(|k| if fixed[k] { r[k] * r[k] } else { 0.0 });
            parts.into_iter()
        });
        held.sum::<f64>().sqrt().max(self.suspension.no_force_m2)
    }
}

impl<'a> Hanging<'a> {
    /// Prepares the suspension at rest, without weight.
    pub fn new(suspension: &'a Suspension) -> Result<Self, HangError> {
        let body = &suspension.body;
        let nodes = body.mesh.nodes_m.len();
        if !body.fixed.iter().flatten().any(|fixed| *fixed) {
            return Err(HangError::Loose);
        }
        let solver = Minimiser::new(body).ok_or(HangError::Memory { nodes })?;
        Ok(Self { suspension, solver, displacement_m: vec![Vector3::zeros(); nodes], weight_share: 0.0 })
    }

    /// Changes the share of the weight to `share`, with the gripped nodes fixed.
    pub fn weigh(&mut self, share: f64) -> Result<(), HangError> {
        let grip: Vec<_> = self.suspension.grip.iter().map(|n| self.displacement_m[*n as usize]).collect();
        self.go_to(share, &grip, |_| {})
    }

    /// Changes the share of the weight and, at the same time, moves the gripped nodes straight to
    /// displacements from rest [m], one per node in the order of the grip. After each step,
    /// `progress` receives the share of the change that is complete.
    pub fn go_to(&mut self, weight_share: f64, grip_m: &[Vector3<f64>], mut progress: impl FnMut(f64)) -> Result<(), HangError> {
        let grip = &self.suspension.grip;
        if grip_m.len() != grip.len() || !grip_m.iter().flatten().all(|x| x.is_finite()) {
            return Err(HangError::Moves { given: grip_m.len(), nodes: grip.len() });
        }
        let mut displacement_m = vec![Vector3::zeros(); self.displacement_m.len()];
        for (n, to) in grip.iter().zip(grip_m) {
            displacement_m[*n as usize] = to - self.displacement_m[*n as usize];
        }
        let start = self.weight_share;
        let (mut done, mut step) = (0.0_f64, FIRST_STEP);
        while done < 1.0 {
            let last = done + step > 1.0 - LEAST_STEP;
            let to = if last { 1.0 } else { done + step };
            let weighed = Weighed { suspension: self.suspension, weight_share: start + to * (weight_share - start) };
            let mut there = self.displacement_m.clone();
            let moved: Vec<_> = displacement_m.iter().map(|way| way * (to - done)).collect();
            let found = self.solver.carry(&weighed, &there, &moved).is_some_and(|ahead| {
                there.iter_mut().zip(&ahead).for_each(|(u, s)| *u += s);
                self.solver.relax(&weighed, &mut there, if last { TOLERANCE } else { LOOSE })
            });
            if found {
                self.displacement_m = there;
                self.weight_share = weighed.weight_share;
                done = to;
                step *= 2.0;
                progress(done);
            } else {
                // the step may have failed because the equilibrium before it was only approximate
                let stood = Weighed { suspension: self.suspension, weight_share: self.weight_share };
                self.solver.relax(&stood, &mut self.displacement_m, TOLERANCE);
                step = 0.5 * (to - done);
                if step < LEAST_STEP {
                    return Err(HangError::Stalled { share: done, weight_share });
                }
            }
        }
        Ok(())
    }

    /// Present force and moment at some nodes, over Young's modulus; at fixed or gripped nodes this
    /// is the reaction.
    pub fn support(&self, nodes: impl IntoIterator<Item = u32>) -> Support {
        let mut support = Support::default();
        let Some(now) = self.suspension.assemble(&self.displacement_m, self.weight_share) else { return support };
        for n in nodes {
            let n = n as usize;
            let force = now.residual_m2[n];
            support.force_m2 += force;
            support.moment_m3 += (self.suspension.body.mesh.nodes_m[n] + self.displacement_m[n]).cross(&force);
        }
        support
    }

    /// Number of Newton iterations so far.
    pub fn iterations(&self) -> usize {
        self.solver.iterations
    }

    /// Number of entries of the Cholesky factor.
    pub fn factor_entries(&self) -> usize {
        self.solver.factor_entries()
    }
}
