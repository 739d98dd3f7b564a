//! Equilibrium of a press: Newton's method with a line search.

use super::energy::Sum;
use super::mesh::Mesh;
use super::shape;
use crate::reference::cholesky::Cholesky;

/// Penetration at a contact pressure equal to Young's modulus, as a share of sqrt(radius x depth).
pub(super) const SOFTNESS: f64 = 3e-4;
/// Residual over force at which a press has converged (1), and most iterations.
const TOLERANCE: f64 = 1e-5;
const MOST_ITERATIONS: usize = 60;
/// Softness of the contact over its last one, where an equilibrium is not near.
const SOFTER: [f64; 4] = [1000.0, 100.0, 10.0, 1.0];
/// Places of an element at which the edge of the contact is looked for.
const EDGES: u32 = 8;

impl Mesh<'_> {
    /// Equilibrium at a depth [m] from rest, with a contact that is softer at first: a hard one far
    /// from equilibrium does not show the way there.
    pub fn press(&self, solver: &mut Cholesky, depth_m: f64) -> Option<(Vec<f64>, f64)> {
        let rest = (vec![0.0; self.unknowns()], 0.0);
        SOFTER.into_iter().try_fold(rest, |(u, _), softer| self.settle(solver, u, depth_m, softer * SOFTNESS))
    }

    /// Displacements [m] in equilibrium near some others, and the force over E [m^2].
    pub fn settle(&self, solver: &mut Cholesky, mut u: Vec<f64>, depth_m: f64, softness: f64) -> Option<(Vec<f64>, f64)> {
        let mut sum = self.sum(&u, depth_m, softness)?;
        for _ in 0..MOST_ITERATIONS {
            let residual = sum.slope.iter().map(|s| s * s).sum::<f64>().sqrt();
            if sum.force > 0.0 && residual < TOLERANCE * sum.force {
                return Some((u, sum.force));
            }
            let step = self.direction(solver, &mut sum)?;
            let slope: f64 = sum.slope.iter().zip(&step).map(|(s, d)| s * d).sum();
            let rounding = 1e-13 * sum.energy.abs();
            let (mut share, mut next) = (1.0, None);
            while share > 1e-4 && next.is_none() {
                let there: Vec<f64> = u.iter().zip(&step).map(|(u, d)| u + share * d).collect();
                let lower = |there: &Sum| there.energy <= sum.energy + 1e-4 * share * slope + rounding;
                next = self.sum(&there, depth_m, softness).filter(lower).map(|sum| (there, sum));
                share *= 0.5;
            }
            let Some((there, lower)) = next else {
                return (sum.force > 0.0 && residual < 1e-4 * sum.force).then_some((u, sum.force));
            };
            (u, sum) = (there, lower);
        }
        None
    }

    /// Newton step; the tangent is strengthened where it is not positive definite.
    fn direction(&self, solver: &mut Cholesky, sum: &mut Sum) -> Option<Vec<f64>> {
        let mut strengthened = 0.0;
        for share in [0.0, 1e-3, 1e-1, 1.0] {
            for unknown in 0..sum.slope.len() {
                let diagonal = &mut sum.tangent[self.entry(unknown, unknown)];
                *diagonal += (share - strengthened) * diagonal.abs();
            }
            strengthened = share;
            if solver.factorise(&sum.tangent) {
                let mut step: Vec<f64> = sum.slope.iter().map(|s| -s).collect();
                solver.solve(&mut step);
                return Some(step);
            }
        }
        None
    }

    /// Radius of the contact on the free surface [m].
    pub fn contact_radius_m(&self, u: &[f64], depth_m: f64) -> f64 {
        let (mut last, mut edge_m) = ((0.0, -1.0), 0.0);
        for column in (0..self.r_m.len() - 2).step_by(2) {
            for part in 1..=EDGES {
                let x = 2.0 * f64::from(part) / f64::from(EDGES) - 1.0;
                let at = |of: &dyn Fn(usize) -> f64| shape(x).iter().enumerate().map(|(n, s)| s[0] * of(n)).sum::<f64>();
                let rest_m = at(&|n| self.r_m[column + n]);
                let [r, z] = [0, 1].map(|k| at(&|n| u[2 * self.node(column + n, 0) + k]));
                let up_m = z + depth_m - self.of.ball_m;
                let gap_m = if up_m > 0.0 { 0.0 } else { (rest_m + r).hypot(up_m) - self.of.ball_m };
                // within the contact some places may be just above the ball
                if last.1 < 0.0 && gap_m >= 0.0 {
                    edge_m = last.0 + (rest_m - last.0) * last.1 / (last.1 - gap_m);
                }
                last = (rest_m, gap_m);
            }
        }
        if last.1 < 0.0 { last.0 } else { edge_m }
    }
}
