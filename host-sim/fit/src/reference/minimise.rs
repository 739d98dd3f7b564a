//! Newton's method with line search on a potential; every equilibrium of a body is found with it.

use nalgebra::Vector3;

use super::body::{Assembled, Body, Contact};
use super::cholesky::Cholesky;
use super::near::{Near, State, Stiffness};

const MOST_FACTORISATIONS: usize = 25;
const MOST_IDLE: usize = 3;
/// A factor is used for further iterations as long as each of them reduces the residual to at most
/// this share: a factorisation takes as long as ten to thirty iterations with an existing factor.
const KEEP: f64 = 0.3;
/// Line search: smallest share of the step, and share of the predicted decrease that suffices
/// (Armijo).
const LEAST_SHARE: f64 = 1.0 / 4096.0;
const DECREASE: f64 = 1e-4;
/// Shares of the diagonal that are added, one after the other, to a tangent that is not positive
/// definite.
const STRENGTHEN: [f64; 5] = [0.0, 1e-3, 1e-2, 1e-1, 1.0];
/// Residual divided by the force up to which a line search that finds no lower energy counts as
/// converged.
const ROUNDED: f64 = 1e-5;

/// Energy of a body and of all loads except the contact with the probe.
pub trait Potential {
    /// Body whose equilibrium is sought.
    fn body(&self) -> &Body;

    /// The contact with a probe, if one touches the body.
    fn contact(&self) -> Option<&Contact> {
        None
    }

    /// Energy over Young's modulus [m^3]; `None` if an element is inverted.
    fn energy(&self, displacement_m: &[Vector3<f64>]) -> Option<f64>;

    /// Energy and its first derivative and, if requested, its second; `None` if an element is
    /// inverted.
    fn assemble(&self, displacement_m: &[Vector3<f64>], tangent: bool) -> Option<Assembled>;

    /// Force over Young's modulus [m^2] with which the residual is compared.
    fn force_m2(&self, displacement_m: &[Vector3<f64>], assembled: &Assembled) -> f64;
}

/// Unbalanced forces at one displacement.
struct Balance {
    /// Energy and its derivatives, without the contact near the probe.
    sum: Assembled,
    /// Force over Young's modulus with which the residual is compared [m^2].
    force: f64,
    /// Norm of the residual over Young's modulus, including all contact [m^2].
    residual: f64,
}

/// Finds equilibria of one body, and keeps the Cholesky factor between iterations.
pub struct Minimiser {
    solver: Cholesky,
    near: Near,
    /// Condensed stiffness of the near nodes from the last factor; `None` if a tangent must be
    /// factorised.
    kept: Option<Stiffness>,
    /// Number of Newton iterations so far.
    pub iterations: usize,
}

impl Minimiser {
    /// Analyses the body's tangent; `None` if there is not enough memory for the factor.
    pub fn new(body: &Body) -> Option<Self> {
        Some(Self { solver: body.pattern.analyse(&[])?, near: Near::default(), kept: None, iterations: 0 })
    }

    /// Number of entries of the Cholesky factor.
    pub fn factor_entries(&self) -> usize {
        self.solver.entries()
    }

    /// Finds the equilibrium in which fixed components keep their values; returns false if none is
    /// found.
    pub fn relax(&mut self, potential: &impl Potential, displacement_m: &mut Vec<Vector3<f64>>, tolerance: f64) -> bool {
        let body = potential.body();
        let (mut before, mut least) = (f64::INFINITY, f64::INFINITY);
        let (mut factorisations, mut idle, mut aged) = (0, 0, true);
        while factorisations <= MOST_FACTORISATIONS {
            let Some(mut now) = self.balance(potential, displacement_m) else { return false };
            if now.residual <= tolerance * now.force {
                return true;
            }
            if self.kept.is_some() && now.residual > KEEP * before {
                self.kept = None;
                let Some(anew) = self.balance(potential, displacement_m) else { return false };
                now = anew;
            }
            // steps with the current tangent bring no improvement: converged as far as possible
            idle = if now.residual < 0.5 * least { 0 } else { idle + usize::from(!aged) };
            least = least.min(now.residual);
            if idle >= MOST_IDLE && now.residual <= ROUNDED * now.force {
                return true;
            }
            before = now.residual;
            aged = self.kept.is_some();
            factorisations += usize::from(!aged);
            let state = potential.contact().map(|contact| State { body, contact, displacement_m });
            let Some(mut step) = self.direction(body, state, &mut now.sum) else { return false };
            if let (Some(contact), Some(kept)) = (potential.contact(), &self.kept) {
                self.near.correct(body, contact, displacement_m, &self.solver, kept, &mut step);
            }
            let step: Vec<_> = step.chunks_exact(3).map(Vector3::from_column_slice).collect();
            if !self.search(potential, displacement_m, &now.sum, &step) {
                if !aged {
                    // no lower energy within rounding: converged as far as possible
                    return now.residual <= ROUNDED * now.force;
                }
                self.kept = None;
            }
        }
        false
    }

    /// Unbalanced forces at a displacement, and the tangent if a factor is needed.
    fn balance(&mut self, potential: &impl Potential, displacement_m: &[Vector3<f64>]) -> Option<Balance> {
        let body = potential.body();
        if let Some(contact) = potential.contact() {
            self.watch(body, displacement_m, contact)?;
        }
        let mut sum = potential.assemble(displacement_m, self.kept.is_none())?;
        let force = potential.force_m2(displacement_m, &sum);
        if let Some(contact) = potential.contact() {
            body.add_contact(&self.near.others, displacement_m, contact, &mut sum);
        }
        hold(&body.fixed, &mut sum.residual_m2);
        let mut residual_m2 = sum.residual_m2.clone();
        if let Some(contact) = potential.contact() {
            body.add_push(&self.near.triangles, displacement_m, contact, &mut residual_m2);
            hold(&body.fixed, &mut residual_m2);
        }
        let residual = residual_m2.iter().map(Vector3::norm_squared).sum::<f64>().sqrt();
        Some(Balance { sum, force, residual })
    }

    /// Makes the near region include all contact; `None` if there is not enough memory for the
    /// factor.
    fn watch(&mut self, body: &Body, displacement_m: &[Vector3<f64>], contact: &Contact) -> Option<()> {
        if self.near.misses(body, displacement_m, contact) {
            self.near = Near::of(body, displacement_m, contact);
            self.solver = body.pattern.analyse(&self.near.nodes)?;
            self.kept = None;
        }
        Some(())
    }

    /// First-order response of the free components to a displacement of the fixed ones (`moved_m`,
    /// zero elsewhere) and to all unbalanced forces. Returns the displacement to be added.
    pub fn carry(
        &mut self,
        potential: &impl Potential,
        displacement_m: &[Vector3<f64>],
        moved_m: &[Vector3<f64>],
    ) -> Option<Vec<Vector3<f64>>> {
        let body = potential.body();
        let mut now = potential.assemble(displacement_m, true)?;
        let pushed = body.tangent_times(&now, moved_m);
        for (n, residual) in now.residual_m2.iter_mut().enumerate() {
            for k in 0..3 {
                residual[k] = if body.fixed[n][k] { -moved_m[n][k] } else { residual[k] + pushed[n][k] };
            }
        }
        self.kept = None;
        let step = self.direction(body, None, &mut now)?;
        Some(step.chunks_exact(3).map(Vector3::from_column_slice).collect())
    }

    /// Newton step, with the kept factor if there is one. The step of a fixed component is minus
    /// its residual.
    fn direction(&mut self, body: &Body, state: Option<State>, now: &mut Assembled) -> Option<Vec<f64>> {
        self.iterations += 1;
        if self.kept.is_none() {
            self.kept = Some(self.factorise(body, state, &mut now.tangent)?);
        }
        let mut step: Vec<f64> = now.residual_m2.iter().flat_map(|r| [-r.x, -r.y, -r.z]).collect();
        self.solver.solve(&mut step);
        Some(step)
    }

    fn factorise(&mut self, body: &Body, state: Option<State>, tangent: &mut [f64]) -> Option<Stiffness> {
        if let Some(state) = &state {
            body.stiffen(&self.near.triangles, state.displacement_m, state.contact, false, tangent);
        }
        for share in STRENGTHEN {
            if share > 0.0 {
                body.pattern.strengthen(tangent, share);
            }
            body.pattern.fix(tangent, &body.fixed);
            if self.solver.factorise(tangent) {
                return Some(Stiffness::of(&self.solver, &self.near, state.as_ref()));
            }
        }
        None
    }

    /// Moves along a step as far as the energy decreases sufficiently; returns false if it does
    /// not.
    fn search(
        &self,
        potential: &impl Potential,
        displacement_m: &mut Vec<Vector3<f64>>,
        now: &Assembled,
        step: &[Vector3<f64>],
    ) -> bool {
        let body = potential.body();
        let near = |at: &[Vector3<f64>]| {
            potential.contact().map_or(0.0, |contact| body.contact_energy_m3(&self.near.triangles, at, contact))
        };
        let others = |at: &[Vector3<f64>]| {
            potential.contact().map_or(0.0, |contact| body.contact_energy_m3(&self.near.others, at, contact))
        };
        let ahead = |share: f64| displacement_m.iter().zip(step).map(|(u, s)| u + s * share).collect::<Vec<_>>();
        // the slope does not include the contact near the probe: the change of its energy along the
        // whole step is used instead (Lee, Sun, Saunders 2014, SIAM J Optim 24:1420)
        let touching = near(displacement_m);
        let slope = now.residual_m2.iter().zip(step).map(|(r, s)| r.dot(s)).sum::<f64>() + (near(&ahead(1.0)) - touching);
        let energy = now.energy_m3 + touching;
        // energies that differ by less than this count as equal
        let rounding = 1e-13 * energy.abs() + body.rounding_m3;
        let mut share = 1.0;
        while share >= LEAST_SHARE {
            let there = ahead(share);
            if let Some(smooth) = potential.energy(&there)
                && smooth + near(&there) + others(&there) <= energy + DECREASE * share * slope + rounding
            {
                *displacement_m = there;
                return true;
            }
            share *= 0.5;
        }
        false
    }
}

/// Sets the residual of fixed components to zero, because it is their reaction.
fn hold(fixed: &[[bool; 3]], residual_m2: &mut [Vector3<f64>]) {
    for (residual, fixed) in residual_m2.iter_mut().zip(fixed) {
        (0..3).filter(|k| fixed[*k]).for_each(|k| residual[k] = 0.0);
    }
}
