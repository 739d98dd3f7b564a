//! The fit, applied to targets of a known patch.

use palpate::Params;
use palpate_fit::calibrate::places::sunflower;
use palpate_fit::calibrate::targets::PlaceTarget;
use palpate_fit::calibrate::{
    DentTarget, ForceTarget, GluedTarget, Objective, Round, Settings, Sweep, Targets, Unknowns, gauss_newton,
};
use palpate_fit::statics::{Solver, Statics, Vector};
use palpate_tissue::mesh::{BlockSpec, block};
use palpate_tissue::patch::{Material, Patch};
use palpate_tissue::tissue::Tissue;

const RADIUS_M: f64 = 0.008;
const DISC_M: f64 = 0.012;
const DEPTHS_M: [f64; 4] = [0.0005, 0.001, 0.002, 0.004];
const DENT_DEPTH_M: f64 = 0.002;
const DENT_RADIUS_M: f64 = 0.02;

fn tissue(nodes: usize) -> Tissue {
    let size_m = [0.08, 0.08, 0.04];
    let mesh = block(&BlockSpec { size_m, nodes, fine_at_m: [0.0; 2], fine_radius_m: RADIUS_M }).unwrap();
    let anchors = (0_u32..).zip(&mesh.nodes_m).filter(|(_, x)| x[2] < -0.0399).map(|(n, _)| n).collect();
    let stiffness_ratio = vec![1.0; mesh.tets.len()];
    Tissue::closed(mesh, stiffness_ratio, anchors, [0.0; 3], 0.01)
}

fn statics(tissue: &Tissue) -> Statics {
    Statics::of(&Patch::build(tissue, &Material::default(), None).model(), &Params::default()).unwrap()
}

/// Returns the forces of a patch at the centre and at `places` other places, and its surface
/// displacement at the centre.
fn targets(truth: &Statics, places: usize) -> Targets {
    let solver = Solver::of(truth).unwrap();
    let rest = solver.rest(truth, Vector::zeros(), 1e-4).unwrap();
    let near = |n: &usize| truth.rest_m[*n].z > -1e-6 && truth.rest_m[*n].norm() < DENT_RADIUS_M;
    let at = |place_m: Vector, centre: bool| {
        let mut here = rest.with_tip(place_m + Vector::z() * 1e-4);
        let mut target = PlaceTarget { place_m, forces: Vec::new(), dents: Vec::new() };
        for depth_m in DEPTHS_M {
            here = solver.press(truth, &here, place_m - Vector::z() * depth_m, depth_m).unwrap();
            target.forces.push(ForceTarget { depth_m, force: here.force, tolerance: 0.005 });
            if centre && depth_m == DENT_DEPTH_M {
                let nodes = (0..truth.rest_m.len()).filter(near);
                let nodes = nodes.map(|n| (n, here.surface_m(truth, n) - truth.rest_m[n])).collect();
                target.dents.push(DentTarget { depth_m, nodes, tolerance_m: 0.02 * depth_m });
            }
        }
        target
    };
    let mut all = vec![at(Vector::zeros(), true)];
    all.extend(sunflower(places, DISC_M).iter().map(|[x, y]| at(Vector::new(*x, *y, 0.0), false)));
    Targets { places: all, glued: Vec::new(), centre_m: Vector::zeros(), radius_m: RADIUS_M, disc_radii: 1.65 }
}

struct Case {
    base: Statics,
    unknowns: Unknowns,
    targets: Targets,
}

impl Case {
    /// A patch of 60 nodes and targets at 8 places. In the true patch every unknown differs from
    /// its start value, including the two factors shared by all springs and by all nodes.
    fn small() -> Self {
        let tissue = tissue(60);
        let base = statics(&tissue);
        let unknowns = Unknowns::of(&base, &tissue, DISC_M + RADIUS_M);
        let mut z: Vec<f64> = (0..unknowns.len()).map(|n| 0.7 * (1.7 * (n * n) as f64).sin()).collect();
        let [springs, nodes] = unknowns.shared_springs_and_nodes();
        (z[springs], z[nodes]) = (1.5, -1.0);
        let targets = targets(&unknowns.apply(&base, &z), 8);
        Self { base, unknowns, targets }
    }

    fn objective(&self) -> Objective<'_> {
        Objective::new(self.base.clone(), self.unknowns.clone(), &self.targets).unwrap()
    }
}

/// Checks that the record is consistent: the cost falls from row to row, the number of evaluations
/// stays within the budget, and the objective is left at the record's last row.
fn check_record(objective: &mut Objective, rounds: &[Round], most_evaluations: usize) -> Sweep {
    let made = objective.evaluations();
    assert!(made <= most_evaluations, "{made} evaluations of {most_evaluations}");
    assert!(rounds.windows(2).all(|r| r[1].cost < r[0].cost && r[1].evaluations > r[0].evaluations));
    let z = objective.place().to_vec();
    let (sweep, _) = objective.evaluate(&z, false).unwrap();
    let (again, kept) = (objective.round(&sweep, &z).cost, rounds.last().unwrap().cost);
    assert!((again / kept - 1.0).abs() < 1e-3, "left at {again}, recorded {kept}");
    sweep
}

fn rounds_of(rounds: usize) -> Settings {
    Settings { rounds, ..Settings::default() }
}

#[test]
fn gauss_newton_recovers_the_forces() {
    let case = Case::small();
    let mut objective = case.objective();
    let rounds = gauss_newton::fit(&mut objective, &rounds_of(6), &mut |_| {}).unwrap();
    let sweep = check_record(&mut objective, &rounds, 10);
    let worst = sweep.measurement.forces.iter().flatten().fold(0.0, |worst: f64, e| worst.max(e.abs()));
    assert!(rounds[0].force_rms_pct > 5.0, "nothing to recover: {:?}", rounds[0]);
    assert!(worst < 0.003, "a force is {:.3} % off: {rounds:?}", 100.0 * worst);
}

/// Gradient of the cost, misfit plus ridge, at `z`, from a sweep with slopes made there.
fn cost_gradient(sweep: &Sweep, z: &[f64]) -> Vec<f64> {
    let mut gradient: Vec<f64> = z.iter().map(|z| 2.0 * z).collect();
    for (r, row) in sweep.residuals.iter().zip(&sweep.rows) {
        gradient.iter_mut().zip(row).for_each(|(g, j)| *g += 2.0 * r * j);
    }
    gradient
}

#[test]
fn slopes_are_those_of_the_cost() {
    let case = Case::small();
    let mut objective = case.objective();
    let z: Vec<f64> = (0..case.unknowns.len()).map(|n| 0.3 * (n as f64).cos()).collect();
    let (sweep, _) = objective.evaluate(&z, true).unwrap();
    let gradient = cost_gradient(&sweep, &z);
    // the ridge term separately, since it is too small to be visible next to the errors
    let ridge = cost_gradient(&Sweep::default(), &z);
    let ridge_cost =
        |by: f64| objective.round(&Sweep::default(), &z.iter().zip(&ridge).map(|(z, g)| z + by * g).collect::<Vec<_>>()).cost;
    let expected: f64 = ridge.iter().map(|g| g * g).sum();
    let found = (ridge_cost(0.1) - ridge_cost(-0.1)) / 0.2;
    assert!((found / expected - 1.0).abs() < 1e-9, "ridge: gradient {expected}, differences {found}");
    let largest = |from: usize, to: usize| (from..to).max_by(|&a, &b| gradient[a].abs().total_cmp(&gradient[b].abs())).unwrap();
    // the spring with the steepest slope, the steepest other unknown, and every scalar
    let (springs, all) = (case.base.springs.len(), z.len());
    let [first_scalar, _] = case.unknowns.shared_springs_and_nodes();
    let mut asked = vec![largest(0, springs), largest(springs, first_scalar)];
    asked.extend(first_scalar..all);
    let scale = gradient[largest(first_scalar, all)].abs();
    for k in asked {
        let mut cost = |by: f64| {
            let mut there = z.clone();
            there[k] += by;
            let (sweep, _) = objective.evaluate(&there, false).unwrap();
            objective.round(&sweep, &there).cost
        };
        let step = 1e-3;
        let found = (cost(step) - cost(-step)) / (2.0 * step);
        let error = (found - gradient[k]).abs();
        let least = gradient[k].abs().max(1e-3 * scale);
        assert!(error < 5e-3 * least, "unknown {k} of {all}: gradient {}, differences {found}", gradient[k]);
    }
}

/// Stiffnesses of the true patch's glued discs at two places, pressed and sheared.
fn glued(truth: &Statics) -> Vec<GluedTarget> {
    let solver = Solver::of(truth).unwrap();
    let cases = [[0.0, 0.0], [0.006, -0.004]].into_iter().flat_map(|at| [Vector::z(), Vector::x()].map(|way| (at, way)));
    let target = |([x, y], direction): ([f64; 2], Vector)| {
        let place_m = Vector::new(x, y, 0.0);
        let stiffness_m = solver.glued(truth, place_m, RADIUS_M, direction).unwrap().stiffness_m;
        GluedTarget { place_m, radius_m: RADIUS_M, direction, stiffness_m, tolerance: 0.01 }
    };
    cases.map(target).collect()
}

#[test]
fn glued_discs_are_fitted_with_the_presses_and_have_the_slope_of_the_cost() {
    let mut case = Case::small();
    // the true values differ from those of the presses, so that the presses alone would not find
    // them
    let z: Vec<f64> = (0..case.unknowns.len()).map(|n| 0.5 * (2.3 * n as f64).cos()).collect();
    case.targets.glued = glued(&case.unknowns.apply(&case.base, &z));
    case.targets.places.truncate(2);
    let worst = |sweep: &Sweep| sweep.measurement.glued.iter().fold(0.0, |worst: f64, e| worst.max(e.abs()));
    let mut objective = case.objective();
    let rounds = gauss_newton::fit(&mut objective, &rounds_of(8), &mut |_| {}).unwrap();
    let sweep = check_record(&mut objective, &rounds, 20);
    let (start, _) = case.objective().evaluate(&vec![0.0; case.unknowns.len()], false).unwrap();
    assert!(worst(&start) > 0.03, "nothing to fit: {:?}", start.measurement.glued);
    assert!(worst(&sweep) < 0.01, "{:?}, first {:?}", sweep.measurement.glued, start.measurement.glued);

    // only discs as targets, so that only their slopes count
    case.targets.places.iter_mut().for_each(|p| (p.forces, p.dents) = (Vec::new(), Vec::new()));
    let mut objective = case.objective();
    let z: Vec<f64> = (0..case.unknowns.len()).map(|n| 0.3 * (n as f64).sin()).collect();
    let (sweep, _) = objective.evaluate(&z, true).unwrap();
    let gradient = cost_gradient(&sweep, &z);
    let along: Vec<f64> = (0..z.len()).map(|n| (0.7 * n as f64).cos()).collect();
    let mut cost = |by: f64| {
        let there: Vec<f64> = z.iter().zip(&along).map(|(z, a)| z + by * a).collect();
        let (sweep, _) = objective.evaluate(&there, false).unwrap();
        objective.round(&sweep, &there).cost
    };
    let step = 1e-4;
    let found = (cost(step) - cost(-step)) / (2.0 * step);
    let expected: f64 = gradient.iter().zip(&along).map(|(g, a)| g * a).sum();
    assert!((found / expected - 1.0).abs() < 1e-4, "gradient {expected}, differences {found}");
}
