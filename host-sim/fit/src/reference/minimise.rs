//! Newton's method with line search on a potential: what any equilibrium of a body is found with.

use nalgebra::Vector3;

use super::body::{Assembled, Body};
use super::cholesky::Cholesky;

const MOST_ITERATIONS: usize = 25;
/// Line search: least share of the step, sufficient decrease (Armijo).
const LEAST_SHARE: f64 = 1.0 / 4096.0;
const DECREASE: f64 = 1e-4;
/// Shares of the diagonal that are added to a tangent that is not positive definite, one after the
/// other.
const STRENGTHEN: [f64; 5] = [0.0, 1e-3, 1e-2, 1e-1, 1.0];
/// Residual over force at which a search that finds no lower energy has still converged.
const ROUNDED: f64 = 1e-5;

/// Energy of a body and of all that acts on it.
pub(crate) trait Potential {
    /// The body.
    fn body(&self) -> &Body;

    /// Energy over Young's modulus [m^3]; `None` if an element is inside out.
    fn energy(&self, displacement_m: &[Vector3<f64>]) -> Option<f64>;

    /// Energy and its derivatives; `None` if an element is inside out.
    fn assemble(&self, displacement_m: &[Vector3<f64>]) -> Option<Assembled>;

    /// The force over Young's modulus [m^2] that the residual is small against.
    fn force_m2(&self, displacement_m: &[Vector3<f64>], assembled: &Assembled) -> f64;
}

/// The factor and the count of its uses.
pub(crate) struct Minimiser {
    solver: Cholesky,
    /// Newton iterations so far.
    pub iterations: usize,
}

impl Minimiser {
    /// Analyses the body's tangent; `None` if memory for the factor runs out.
    pub fn new(body: &Body) -> Option<Self> {
        Some(Self { solver: body.pattern.analyse()?, iterations: 0 })
    }

    /// Entries of the Cholesky factor.
    pub fn factor_entries(&self) -> usize {
        self.solver.entries()
    }

    /// Goes to the equilibrium in which fixed components stay where they are; false if it is not
    /// found.
    pub fn relax(&mut self, potential: &impl Potential, displacement_m: &mut Vec<Vector3<f64>>, tolerance: f64) -> bool {
        for _ in 0..MOST_ITERATIONS {
            let Some(mut now) = potential.assemble(displacement_m) else { return false };
            let force = potential.force_m2(displacement_m, &now);
            for (residual, fixed) in now.residual_m2.iter_mut().zip(&potential.body().fixed) {
                for k in 0..3 {
                    if fixed[k] {
                        residual[k] = 0.0;
                    }
                }
            }
            let residual = now.residual_m2.iter().map(Vector3::norm_squared).sum::<f64>().sqrt();
            if residual <= tolerance * force {
                return true;
            }
            let Some(step) = self.direction(potential.body(), &mut now) else { return false };
            if !search(potential, displacement_m, &now, &step) {
                // no lower energy is left within rounding: converged as far as it goes
                return residual <= ROUNDED * force;
            }
        }
        false
    }

    /// The first-order answer of the free components to a move of the fixed ones (`moved_m`, zero
    /// elsewhere) and to all forces that are out of balance: the displacement to add.
    pub fn carry(
        &mut self,
        potential: &impl Potential,
        displacement_m: &[Vector3<f64>],
        moved_m: &[Vector3<f64>],
    ) -> Option<Vec<Vector3<f64>>> {
        let body = potential.body();
        let mut now = potential.assemble(displacement_m)?;
        let pushed = body.tangent_times(&now, moved_m);
        for (n, residual) in now.residual_m2.iter_mut().enumerate() {
            for k in 0..3 {
                residual[k] = if body.fixed[n][k] { -moved_m[n][k] } else { residual[k] + pushed[n][k] };
            }
        }
        self.direction(body, &mut now)
    }

    /// Newton's step; a fixed component's is minus its residual.
    fn direction(&mut self, body: &Body, now: &mut Assembled) -> Option<Vec<Vector3<f64>>> {
        self.iterations += 1;
        for share in STRENGTHEN {
            if share > 0.0 {
                body.pattern.strengthen(&mut now.tangent, share);
            }
            body.pattern.fix(&mut now.tangent, &body.fixed);
            if self.solver.factorise(&now.tangent) {
                let mut step: Vec<f64> = now.residual_m2.iter().flat_map(|r| [-r.x, -r.y, -r.z]).collect();
                self.solver.solve(&mut step);
                return Some(step.chunks_exact(3).map(Vector3::from_column_slice).collect());
            }
        }
        None
    }
}

/// Goes along a step as far as the energy falls enough; false if it nowhere does.
fn search(potential: &impl Potential, displacement_m: &mut Vec<Vector3<f64>>, now: &Assembled, step: &[Vector3<f64>]) -> bool {
    let slope: f64 = now.residual_m2.iter().zip(step).map(|(r, s)| r.dot(s)).sum();
    // energies closer than this are equal
    let rounding = 1e-13 * now.energy_m3.abs();
    let mut share = 1.0;
    while share >= LEAST_SHARE {
        let there: Vec<_> = displacement_m.iter().zip(step).map(|(u, s)| u + s * share).collect();
        if let Some(energy) = potential.energy(&there)
            && energy <= now.energy_m3 + DECREASE * share * slope + rounding
        {
            *displacement_m = there;
            return true;
        }
        share *= 0.5;
    }
    false
}
