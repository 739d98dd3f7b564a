//! Finds the equilibrium of a pressed patch by Newton's iteration.

use thiserror::Error;

use super::tangent::{Factor, Pattern};
use super::{Statics, Vector, elastic};

/// Norm of the remaining nodal forces, as a share of the probe's force, at which the patch is in
/// equilibrium (1).
const TOLERANCE: f64 = 1e-7;
const MOST_STEPS: usize = 60;
/// Number of consecutive steps without gain after which an iteration counts as stalled. Of 2 021
/// equilibria that were found under a flat tip, two had stalled for longer.
const STALLED_STEPS: usize = 12;
/// The share of the probe's force that suffices at an edge of the probe (1), where the gradient
/// vanishes at no position and the remaining forces do not fall further.
const ON_AN_EDGE: f64 = 1e-3;
/// Ratio to the imbalance after the last gain below which a step counts as a gain (1).
const GAINS: f64 = 0.9;
/// Largest ratio of the imbalance after a step to that before it with which a factor is reused (1).
const STILL_GOOD: f64 = 0.25;
/// Largest distance from the equilibrium at which a factor is used for derivatives there [m].
const NEAR_M: f64 = 2e-6;
/// Shares of the diagonal that are added, one after the other, if the tangent is not positive
/// definite.
const SHIFTS: [f64; 6] = [0.0, 1e-3, 1e-2, 0.1, 1.0, 10.0];
/// Smallest piece into which the displacement of the tip is divided, as a share of the whole (1).
const FINEST_WAY: f64 = 1.0 / 64.0;

/// Error of a press for which no equilibrium was found.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[error("no equilibrium {depth_mm:.2} mm deep after {steps} steps: press less deep or in smaller steps")]
pub struct Unbalanced {
    /// Depth of the tip along the press [mm].
    pub depth_mm: f64,
    /// Number of Newton steps.
    pub steps: usize,
}

/// A pressed patch in equilibrium.
#[derive(Clone, Debug)]
pub struct Balance {
    /// Node positions [m], shape \[nodes\].
    pub x_m: Vec<Vector>,
    /// Position of the tip [m].
    pub tip_m: Vector,
    /// Force on the probe along its axis, over E [m^2]; positive out of the tissue.
    pub force: f64,
    /// Factored tangent, computed at `x_m` or within `NEAR_M` of it.
    pub(super) factor: Factor,
}

/// Sparsity pattern and symbolic factorisation of one mesh, which all solutions share.
#[derive(Clone, Debug)]
pub struct Solver {
    pub(super) pattern: Pattern,
}

impl Solver {
    /// Analyses a mesh; returns `None` if the mesh is too large to be analysed.
    #[must_use]
    pub fn of(statics: &Statics) -> Option<Self> {
        Pattern::of(statics).map(|pattern| Self { pattern })
    }

    /// The patch at rest, with the probe `clear_m` above the site `site_m` [m].
    ///
    /// # Errors
    /// [`Unbalanced`] if the stiffness at rest is not positive definite.
    pub fn rest(&self, statics: &Statics, site_m: Vector, clear_m: f64) -> Result<Balance, Unbalanced> {
        let tip_m = site_m + statics.axis() * clear_m;
        let failed = |_| Unbalanced { depth_mm: 0.0, steps: 0 };
        let factor = statics.factor(&self.pattern, &statics.rest_m, None, 0.0).map_err(failed)?;
        Ok(Balance { x_m: statics.rest_m.clone(), tip_m, force: 0.0, factor })
    }

    /// Moves the tip of a pressed patch to `tip_m`, at the depth `depth_m`, in as many pieces as
    /// necessary.
    ///
    /// # Errors
    /// [`Unbalanced`] if Newton's iteration does not converge.
    pub fn press(&self, statics: &Statics, from: &Balance, tip_m: Vector, depth_m: f64) -> Result<Balance, Unbalanced> {
        let (mut here, mut gone, mut piece) = (from.clone(), 0.0, 1.0_f64);
        while gone < 1.0 {
            let to = (gone + piece).min(1.0);
            let tip = from.tip_m + (tip_m - from.tip_m) * to;
            match self.balance(statics, here.follow(statics, tip), tip, depth_m) {
                Ok(next) => (here, gone) = (next, to),
                Err(error) if piece <= FINEST_WAY => return Err(error),
                Err(_) => piece *= 0.5,
            }
        }
        Ok(here)
    }

    /// Finds the equilibrium under a tip at `tip_m`, starting from the positions `x_m`.
    ///
    /// # Errors
    /// [`Unbalanced`] if Newton's iteration does not converge.
    pub fn balance(&self, statics: &Statics, mut x_m: Vec<Vector>, tip_m: Vector, depth_m: f64) -> Result<Balance, Unbalanced> {
        let failed = |steps| Unbalanced { depth_mm: depth_m * 1e3, steps };
        let mut factor: Option<Factor> = None;
        let mut factored_at = Vec::new();
        let (mut slope, mut force) = statics.slope(&x_m, tip_m);
        let mut least = (f64::INFINITY, Vec::new(), 0.0);
        let (mut gained_at, mut stalled, mut steps) = (f64::INFINITY, 0, 0);
        for step in 0..MOST_STEPS {
            steps = step;
            let left = norm(&slope);
            (gained_at, stalled) = if left < GAINS * gained_at { (left, 0) } else { (gained_at, stalled + 1) };
            if left < least.0 {
                least = (left, x_m.clone(), force);
            }
            if stalled > STALLED_STEPS {
                break;
            }
            if left <= TOLERANCE * force.max(1e-12) {
                let near =
                    x_m.iter().zip(&factored_at).all(|(x, at): (&Vector, &Vector)| (x - at).norm_squared() <= NEAR_M * NEAR_M);
                let factor = match factor.take().filter(|_| near) {
                    Some(factor) => factor,
                    None => statics.factor(&self.pattern, &x_m, Some(tip_m), 0.0).map_err(|_| failed(step))?,
                };
                return Ok(Balance { x_m, tip_m, force, factor });
            }
            let fresh = factor.is_none();
            let used = match factor.take() {
                Some(f) => f,
                None => {
                    factored_at.clone_from(&x_m);
                    SHIFTS
                        .iter()
                        .find_map(|&shift| statics.factor(&self.pattern, &x_m, Some(tip_m), shift).ok())
                        .ok_or_else(|| failed(step))?
                }
            };
            let way = used.solve_nodes(statics, &slope);
            let downhill: f64 = way.iter().zip(&slope).map(|(w, s)| w.dot(s)).sum();
            let mut share = 1.0;
            let (next, next_slope, next_force) = loop {
                let next: Vec<Vector> = x_m.iter().zip(&way).map(|(x, w)| x - w * share).collect();
                let (slope, force) = statics.slope(&next, tip_m);
                let after: f64 = way.iter().zip(&slope).map(|(w, s)| w.dot(s)).sum();
                if (after.abs() <= 0.9 * downhill && norm(&slope).is_finite()) || share < 1e-3 {
                    break (next, slope, force);
                }
                share *= 0.5;
            };
            let gained = norm(&next_slope) / left;
            if !gained.is_finite() {
                return Err(failed(step));
            }
            if !fresh && gained > 1.0 {
                continue; // an old factor misled the iteration: try again from here with a new one
            }
            (x_m, slope, force) = (next, next_slope, next_force);
            let balanced = norm(&slope) <= TOLERANCE * force.max(1e-12);
            factor = (balanced || gained <= STILL_GOOD).then_some(used);
        }
        let (left, x_m, force) = least;
        if left > ON_AN_EDGE * force {
            return Err(failed(steps));
        }
        let factor = SHIFTS.iter().find_map(|&shift| statics.factor(&self.pattern, &x_m, Some(tip_m), shift).ok());
        Ok(Balance { x_m, tip_m, force, factor: factor.ok_or_else(|| failed(steps))? })
    }
}

impl Balance {
    /// Small displacements of the nodes [1/m] under small forces on the nodes over E, about the
    /// equilibrium; anchors do not move.
    #[must_use]
    pub fn answer(&self, statics: &Statics, force: &[Vector]) -> Vec<Vector> {
        self.factor.solve_nodes(statics, force)
    }

    /// Returns the patch at rest with the tip of its probe, which does not touch it, at `tip_m`.
    #[must_use]
    pub fn with_tip(&self, tip_m: Vector) -> Self {
        Self { tip_m, ..self.clone() }
    }

    /// Positions of the nodes after the tip has moved to `tip_m`, to first order.
    fn follow(&self, statics: &Statics, tip_m: Vector) -> Vec<Vector> {
        let way = tip_m - self.tip_m;
        let mut pull = vec![Vector::zeros(); self.x_m.len()];
        for push in statics.pushes(&self.x_m, self.tip_m) {
            let along = push.curvature * way;
            let node = statics.triangles[push.triangle].node;
            node.iter().zip(push.weights).for_each(|(&n, w)| pull[n] += along * w);
        }
        self.x_m.iter().zip(self.factor.solve_nodes(statics, &pull)).map(|(x, u)| x + u).collect()
    }
}

fn norm(v: &[Vector]) -> f64 {
    v.iter().map(Vector::norm_squared).sum::<f64>().sqrt()
}

impl Statics {
    /// Gradient of the energy over E with respect to every node's position [m^2] (zero at anchors),
    /// and force on the probe along its axis over E [m^2].
    #[must_use]
    pub fn slope(&self, x: &[Vector], tip_m: Vector) -> (Vec<Vector>, f64) {
        let mut slope = vec![Vector::zeros(); x.len()];
        let pushes = self.pushes(x, tip_m);
        let stiffer = self.stiffer(x, &pushes);
        for s in &self.springs {
            let pull = self.pull(s, x);
            let factor = stiffer.as_ref().map_or(1.0, |stiffer| stiffer.of_spring(s.node));
            let f = pull.along * (pull.tension * factor);
            slope[s.node[1]] += f;
            slope[s.node[0]] -= f;
        }
        if self.volume_acts {
            let shapes: Vec<elastic::TetGeometry> = self.tets.iter().map(|t| elastic::geometry(t, x)).collect();
            let mut around = vec![0.0; x.len()];
            for (t, shape) in self.tets.iter().zip(&shapes) {
                t.node.iter().for_each(|&n| around[n] += shape.six_volume);
            }
            let nodal = self.node_pressures(&around);
            for (t, shape) in self.tets.iter().zip(&shapes) {
                let own = elastic::own_pressure(t, shape.six_volume, self.compensation_acts).0;
                let pressure = own + t.node.iter().map(|&n| nodal[n].0).sum::<f64>();
                t.node.iter().zip(&shape.gradient).for_each(|(&n, g)| slope[n] += g * pressure);
            }
        }
        if let Some(rim) = &self.rim {
            rim.add_slope(&self.rest_m, x, &mut slope);
        }
        let mut force = 0.0;
        for push in pushes {
            let node = self.triangles[push.triangle].node;
            let factor = stiffer.as_ref().map_or(1.0, |stiffer| stiffer.of_point(node, push.weights));
            let f = push.out * (push.force * factor);
            node.iter().zip(push.weights).for_each(|(&n, w)| slope[n] -= f * w);
            force -= f.dot(&self.axis());
        }
        slope.iter_mut().zip(&self.free).filter(|(_, f)| f.is_none()).for_each(|(s, _)| *s = Vector::zeros());
        (slope, force)
    }
}
