//! The static solution is the state to which the tick settles, and its derivatives are correct.

use palpate::{GuardLimits, Params, Probe, ProbePose, ProbeShape, tick};
use palpate_fit::statics::{Balance, Gradient, Solver, Statics, Vector};
use palpate_tissue::mesh::{BlockSpec, block};
use palpate_tissue::patch::{Material, Memory, Patch};
use palpate_tissue::tissue::Tissue;

const DEPTHS_M: [f64; 3] = [0.001, 0.003, 0.006];
/// A place off the centre, so that nothing is symmetric [m].
const PLACE_M: [f64; 2] = [0.0013, 0.0007];

fn patch() -> Patch {
    let size_m = [0.08, 0.08, 0.04];
    let mesh = block(&BlockSpec { size_m, nodes: 130, fine_at_m: [0.0; 2], fine_radius_m: 0.008 }).unwrap();
    let anchors = (0_u32..).zip(&mesh.nodes_m).filter(|(_, x)| x[2] < -0.0399).map(|(n, _)| n).collect();
    let stiffness_ratio = vec![1.0; mesh.tets.len()];
    let tissue = Tissue::closed(mesh, stiffness_ratio, anchors, [0.0; 3], 0.01);
    Patch::build(&tissue, &Material::default(), None)
}

fn tip_m(depth_m: f64) -> Vector {
    Vector::new(PLACE_M[0], PLACE_M[1], -depth_m)
}

fn pressed(statics: &Statics, depth_m: f64) -> Balance {
    let solver = Solver::of(statics).unwrap();
    let rest = solver.rest(statics, tip_m(0.0), 0.0).unwrap();
    solver.press(statics, &rest, tip_m(depth_m), depth_m).unwrap()
}

#[test]
fn the_tick_settles_to_the_static_force() {
    let patch = patch();
    let model = patch.wide_model();
    let params = Params { node_damping_per_s: 150.0, limits: GuardLimits::HIGHEST, ..Params::default() };
    let statics = Statics::of(&model, &params).unwrap();
    let mut memory = Memory::for_model(&model);
    let (tuned, mut state) = memory.start(&model, &params).unwrap();
    tick(&model, &tuned, &mut state, ProbePose { tip_m: tip_m(-0.001).cast() });
    for depth_m in DEPTHS_M {
        let mut force_n = 0.0;
        for _ in 0..3000 {
            force_n = f64::from(tick(&model, &tuned, &mut state, ProbePose { tip_m: tip_m(depth_m).cast() }).force_n.z);
        }
        let expected_n = pressed(&statics, depth_m).force * f64::from(params.youngs_modulus_pa);
        let error = force_n / expected_n - 1.0;
        assert!(error.abs() < 1e-4, "{depth_m} m: {force_n} N, statics {expected_n} N");
    }
}

/// The tangent includes the probe's curvature; without it the solver would not converge this far.
#[test]
fn the_tick_settles_to_the_static_force_under_a_capsule_and_an_ellipsoid() {
    let patch = patch();
    let model = patch.wide_model();
    let along = palpate::Vector3::new(0.8, 0.6, 0.0);
    let depth_m = 0.003;
    for shape in [ProbeShape::Capsule { length_m: 0.01, along }, ProbeShape::Ellipsoid { semi_axes_m: [0.012, 0.006], along }] {
        let probe = Probe { shape, radius_m: 0.007, ..Params::default().probe };
        let params = Params { probe, node_damping_per_s: 150.0, limits: GuardLimits::HIGHEST, ..Params::default() };
        let statics = Statics::of(&model, &params).unwrap();
        let mut memory = Memory::for_model(&model);
        let (tuned, mut state) = memory.start(&model, &params).unwrap();
        tick(&model, &tuned, &mut state, ProbePose { tip_m: tip_m(-0.001).cast() });
        let mut force_n = 0.0;
        for _ in 0..3000 {
            force_n = f64::from(tick(&model, &tuned, &mut state, ProbePose { tip_m: tip_m(depth_m).cast() }).force_n.z);
        }
        let expected_n = pressed(&statics, depth_m).force * f64::from(params.youngs_modulus_pa);
        let error = force_n / expected_n - 1.0;
        assert!(error.abs() < 1e-4, "{shape:?}: {force_n} N, statics {expected_n} N");
    }
}

/// Compares a derivative with central differences of the whole solution.
fn check(
    name: &str,
    statics: &Statics,
    output: impl Fn(&Statics) -> f64,
    expected: f64,
    scale: f64,
    change: impl Fn(&mut Statics, f64),
) {
    let step = 1e-4;
    let moved = |by: f64| {
        let mut other = statics.clone();
        change(&mut other, by);
        output(&other)
    };
    let found = (moved(step) - moved(-step)) / (2.0 * step);
    assert!((found - expected).abs() <= 2e-3 * scale, "{name}: adjoint {expected:e}, differences {found:e} (scale {scale:e})");
}

fn check_all(statics: &Statics, gradient: &Gradient, output: impl Fn(&Statics) -> f64) {
    let largest =
        |of: &[f64]| of.iter().enumerate().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).map(|(n, v)| (n, *v)).unwrap();
    let (s, slope) = largest(&gradient.spring);
    check("spring", statics, &output, slope, slope.abs(), |m, by| m.springs[s].k *= by.exp());
    let (n, slope) = largest(&gradient.node);
    check("node", statics, &output, slope, slope.abs(), |m, by| m.pressure[n] *= by.exp());
    let (t, slope) = largest(&gradient.bulk);
    check("bulk", statics, &output, slope, slope.abs(), |m, by| m.tets[t].bulk *= by.exp());
    let points: Vec<f64> = gradient.point.iter().flatten().copied().collect();
    let (p, slope) = largest(&points);
    check("point", statics, &output, slope, slope.abs(), |m, by| m.triangles[p / 4].k[p % 4] *= by.exp());
    check("stiffening", statics, &output, gradient.stiffening, gradient.stiffening.abs(), |m, by| m.stiffening_per_m *= by.exp());
    check("compensation", statics, &output, gradient.compensation, gradient.compensation.abs(), |m, by| m.compensation += by);
    let slope = gradient.compensation_threshold;
    check("threshold", statics, &output, slope, slope.abs(), |m, by| m.compensation_threshold += by);
}

#[test]
fn the_adjoint_gives_the_slopes_of_force_and_displacement() {
    let patch = patch();
    let statics = Statics::of(&patch.wide_model(), &Params::default()).unwrap();
    for depth_m in [0.001, 0.006] {
        let balance = pressed(&statics, depth_m);
        check_all(&statics, &balance.force_gradient(&statics), |m| pressed(m, depth_m).force);
        // a node under the probe and one beside it
        for r_m in [0.002, 0.012] {
            let place = Vector::new(PLACE_M[0] + r_m, PLACE_M[1], 0.0);
            let nearest = |n: &usize| (statics.rest_m[*n] - place).norm();
            let node = (0..statics.rest_m.len()).min_by(|a, b| nearest(a).total_cmp(&nearest(b))).unwrap();
            let along = Vector::new(0.3, 0.0, 1.0);
            let gradient = balance.surface_gradient(&statics, node, along);
            check_all(&statics, &gradient, |m| pressed(m, depth_m).surface_m(m, node).dot(&along));
        }
    }
}
