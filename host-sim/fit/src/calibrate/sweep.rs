//! Evaluates the objective once: every press at every place and, on request, the derivatives of
//! each result with respect to every unknown.

use std::time::Instant;

use rayon::prelude::*;

use super::targets::{GluedTarget, PlaceTarget, Targets};
use super::{Measurement, Round, Unknowns};
use crate::statics::{Balance, CLEAR_M, Solver, Statics, Unbalanced, Vector};

/// At most one press in this many may have no equilibrium. This happens where springs can buckle
/// into two shapes or a point is at the edge of a flat tip, and such places must not end a fit.
const MOST_LOST: usize = 50;

/// Whether so many of the presses have no force that a fit, or the verdict on it, says too little.
#[must_use]
pub fn too_many_lost(lost: usize, presses: usize) -> bool {
    MOST_LOST * lost > presses
}

/// Errors in units of their tolerance, one per measurement, and their derivatives with respect to
/// the unknowns, one row per error.
#[derive(Clone, Debug, Default)]
pub struct Sweep {
    /// Errors in units of their tolerance (1).
    pub residuals: Vec<f64>,
    /// Derivatives, shape \[residuals\] [unknowns]; empty unless requested.
    pub rows: Vec<Vec<f64>>,
    /// Indices of the errors that are unknown because their press has no equilibrium; their
    /// residuals and derivatives are zero.
    pub lost: Vec<usize>,
    /// Errors of this evaluation in plain units.
    pub measurement: Measurement,
}

/// Node positions [m] of every press, shape \[places\]\[depths\]\[nodes\].
pub type Positions = Vec<Vec<Vec<Vector>>>;

impl Sweep {
    /// Squared errors, in units of their tolerance, that are known in this sweep but lost in
    /// `other`.
    #[must_use]
    pub fn known_here_alone(&self, other: &Self) -> f64 {
        other.lost.iter().filter_map(|&n| self.residuals.get(n)).map(|r| r * r).sum()
    }
}

/// The objective of a calibration. It counts its evaluations and keeps the latest solutions as
/// starting points for the next one.
#[derive(Debug)]
pub struct Objective<'a> {
    base: Statics,
    unknowns: Unknowns,
    targets: &'a Targets,
    solver: Solver,
    /// Node positions of every press at the last accepted unknowns.
    last: Positions,
    z: Vec<f64>,
    evaluations: usize,
    started: Instant,
}

/// Contribution of one place to a sweep.
struct PlaceSweep {
    positions: Vec<Vec<Vector>>,
    sweep: Sweep,
    forces: Vec<f64>,
    dents_m: Vec<Vec<f64>>,
    /// Reason why the deepest presses at this place have no equilibrium, if that is so.
    unbalanced: Option<Unbalanced>,
}

impl<'a> Objective<'a> {
    /// Creates the objective; its unknowns are those of the uncalibrated patch.
    ///
    /// # Errors
    /// Fails if the mesh is too large to be analysed.
    pub fn new(base: Statics, unknowns: Unknowns, targets: &'a Targets) -> Result<Self, Unbalanced> {
        // one factorisation per core; each of them is too small to be parallelised
        faer::set_global_parallelism(faer::Par::Seq);
        let solver = Solver::of(&base).ok_or(Unbalanced { depth_mm: 0.0, steps: 0 })?;
        let z = vec![0.0; unknowns.len()];
        let last = vec![Vec::new(); targets.places.len()];
        Ok(Self { base, unknowns, targets, solver, last, z, evaluations: 0, started: Instant::now() })
    }

    /// Returns the objective with the node positions from which its presses start.
    #[must_use]
    pub fn starting_near(mut self, positions: Positions) -> Self {
        self.last = positions;
        self
    }

    /// Layout of the vector of unknowns.
    #[must_use]
    pub fn unknowns(&self) -> &Unknowns {
        &self.unknowns
    }

    /// Model of the uncalibrated patch.
    #[must_use]
    pub fn statics(&self) -> &Statics {
        &self.base
    }

    /// Unknowns that were accepted last.
    #[must_use]
    pub fn place(&self) -> &[f64] {
        &self.z
    }

    /// Number of evaluations so far.
    #[must_use]
    pub fn evaluations(&self) -> usize {
        self.evaluations
    }

    /// Number of presses that have no equilibrium at the accepted unknowns.
    #[must_use]
    pub fn lost_presses(&self) -> usize {
        self.targets.presses() - self.last.iter().map(Vec::len).sum::<usize>()
    }

    /// Accepts unknowns; later evaluations start from the solutions found there.
    pub fn accept(&mut self, z: Vec<f64>, found: Found) {
        self.z = z;
        self.last = found.0;
    }

    /// Computes the errors at `z`, and their derivatives if `with_slopes`. At most one press in
    /// fifty may have no equilibrium, and none at the centre.
    ///
    /// # Errors
    /// Fails if more presses have no equilibrium.
    pub fn evaluate(&mut self, z: &[f64], with_slopes: bool) -> Result<(Sweep, Found), Unbalanced> {
        self.evaluations += 1;
        let statics = self.unknowns.apply(&self.base, z);
        let rest = self.solver.rest(&statics, self.targets.centre_m, CLEAR_M)?;
        let places: Vec<PlaceSweep> = self
            .targets
            .places
            .par_iter()
            .zip(&self.last)
            .map(|(place, last)| self.place_sweep(&statics, &rest, place, last, with_slopes))
            .collect();
        let (mut sweep, mut found, mut unbalanced) = (Sweep::default(), Vec::new(), None);
        for place in places {
            unbalanced = unbalanced.or(place.unbalanced);
            if let Some(error) = place.unbalanced.filter(|_| found.is_empty()) {
                return Err(error);
            }
            let before = sweep.residuals.len();
            sweep.lost.extend(place.sweep.lost.iter().map(|n| n + before));
            sweep.residuals.extend(place.sweep.residuals);
            sweep.rows.extend(place.sweep.rows);
            sweep.measurement.forces.push(place.forces);
            sweep.measurement.dents_m.extend(place.dents_m);
            found.push(place.positions);
        }
        if let Some(error) = unbalanced.filter(|_| too_many_lost(sweep.lost.len(), self.targets.presses())) {
            return Err(error);
        }
        let glued: Vec<(f64, Vec<f64>)> = self
            .targets
            .glued
            .par_iter()
            .map(|target| self.glued_sweep(&statics, target, with_slopes))
            .collect::<Result<_, _>>()?;
        for ((stiffness_m, row), target) in glued.into_iter().zip(&self.targets.glued) {
            sweep.measurement.glued.push(stiffness_m / target.stiffness_m - 1.0);
            sweep.residuals.push((stiffness_m / target.stiffness_m).ln() / target.tolerance);
            if with_slopes {
                sweep.rows.push(row);
            }
        }
        sweep.measurement.misfit = sweep.residuals.iter().map(|r| r * r).sum();
        Ok((sweep, Found(found)))
    }

    fn place_sweep(
        &self,
        statics: &Statics,
        rest: &Balance,
        place: &PlaceTarget,
        last: &[Vec<Vector>],
        with_slopes: bool,
    ) -> PlaceSweep {
        let mut out = PlaceSweep {
            positions: Vec::new(),
            sweep: Sweep::default(),
            forces: Vec::new(),
            dents_m: Vec::new(),
            unbalanced: None,
        };
        let row = || vec![0.0; self.unknowns.len()];
        let mut here = rest.with_tip(place.place_m + statics.axis() * CLEAR_M);
        for (n, target) in place.forces.iter().enumerate() {
            let tip_m = place.place_m - statics.axis() * target.depth_m;
            let again = last.get(n).and_then(|x| self.solver.balance(statics, x.clone(), tip_m, target.depth_m).ok());
            here = match again.map_or_else(|| self.solver.press(statics, &here, tip_m, target.depth_m), Ok) {
                Ok(balance) => balance,
                Err(error) => {
                    // the deeper presses at this place are lost too, because they would start from
                    // this one
                    let lost = place.forces.len() - n;
                    out.sweep.lost = (out.sweep.residuals.len()..).take(lost).collect();
                    out.sweep.residuals.extend(vec![0.0; lost]);
                    out.sweep.rows.extend(vec![row(); if with_slopes { lost } else { 0 }]);
                    out.unbalanced = Some(error);
                    return out;
                }
            };
            let error = here.force / target.force - 1.0;
            out.forces.push(error);
            // the logarithm of the force is closer to linear in the unknowns, which are logarithms
            // as well
            out.sweep.residuals.push((here.force / target.force).ln() / target.tolerance);
            if with_slopes {
                let mut slopes = row();
                let scale = 1.0 / (here.force * target.tolerance);
                self.unknowns.slopes(statics, &here.force_gradient(statics), scale, &mut slopes);
                out.sweep.rows.push(slopes);
            }
            for dent in place.dents.iter().filter(|d| d.depth_m == target.depth_m) {
                let mut distances = Vec::new();
                for &(node, wanted) in &dent.nodes {
                    let off = here.surface_m(statics, node) - statics.rest_m[node] - wanted;
                    distances.push(off.norm());
                    for k in 0..3 {
                        out.sweep.residuals.push(off[k] / dent.tolerance_m);
                        if with_slopes {
                            let mut slopes = row();
                            let along = Vector::from_fn(|c, _| f64::from(u8::from(c == k)));
                            let gradient = here.surface_gradient(statics, node, along);
                            self.unknowns.slopes(statics, &gradient, 1.0 / dent.tolerance_m, &mut slopes);
                            out.sweep.rows.push(slopes);
                        }
                    }
                }
                out.dents_m.push(distances);
            }
            out.positions.push(here.x_m.clone());
        }
        out
    }

    /// Stiffness of a glued disc over E [m], and the derivatives of its error with respect to the
    /// unknowns; these are empty unless requested.
    fn glued_sweep(&self, statics: &Statics, target: &GluedTarget, with_slopes: bool) -> Result<(f64, Vec<f64>), Unbalanced> {
        let glued = self.solver.glued(statics, target.place_m, target.radius_m, target.direction)?;
        let mut row = Vec::new();
        if with_slopes {
            row.resize(self.unknowns.len(), 0.0);
            let scale = 1.0 / (glued.stiffness_m * target.tolerance);
            self.unknowns.slopes(statics, &glued.gradient(statics), scale, &mut row);
        }
        Ok((glued.stiffness_m, row))
    }

    /// Record of a round that ends with this evaluation.
    #[must_use]
    pub fn round(&self, sweep: &Sweep, z: &[f64]) -> Round {
        let ridge = z.iter().map(|z| z * z).sum();
        sweep.measurement.round(self.evaluations, ridge, self.started.elapsed().as_secs_f64())
    }
}

/// Node positions of every press of one evaluation.
#[derive(Debug)]
pub struct Found(Positions);
