//! Paper 004, eqs (1) to (3) and (7) to (13); (4)-(6) and (14) exist on the desktop only.

use crate::bench::at_depth;
use palpate::method::Method;
use palpate::stages::probe::ProbePose;
use palpate::{Model, Vector3, tick_with};
use palpate_lab::paper_method::LocalCompression;
use palpate_lab::paper_method::barycentre::BarycentreForce;
use palpate_lab::paper_method::damper::{Dampers, DampingLaw};
use palpate_lab::paper_method::over_compression::OverCompression;
use palpate_lab::paper_method::region::{ContactPressure, StressRule};

use super::{Vector, assert_close, bench, deform, forces_n, masses_kg, positions, springs, velocities};

const FAR: f32 = -0.1;
/// Coefficient c of (2) in the tests [Pa/m].
const VOLUME_PA_PER_M: f32 = 5e8;

fn plain() -> LocalCompression<'static> {
    LocalCompression::default()
}

/// Forces `c (V - V0)` on the corners of each tet, away from its barycentre.
fn volume_forces(model: &Model, x: &[Vector]) -> Vec<Vector> {
    let mut forces = vec![Vector::zeros(); x.len()];
    for tet in model.tets {
        let n = tet.node.map(usize::from);
        let [a, b, c, d] = n.map(|n| x[n]);
        let growth = (b - a).cross(&(c - a)).dot(&(d - a)) / 6.0 - 1.0 / (6.0 * f64::from(tet.six_volume_reciprocal));
        let barycentre = (a + b + c + d) / 4.0;
        for n in n {
            forces[n] -= (x[n] - barycentre).normalize() * (f64::from(VOLUME_PA_PER_M) * growth);
        }
    }
    forces
}

/// Springs, dampers and the volume force are summed as in (1)-(3).
#[test]
fn eq_1_to_3_forces() {
    let bench = bench();
    let model = bench.patch.wide_model();
    let mut memory = bench.memory();
    let (tuned, mut state) = memory.start(&model, &bench.params).unwrap();
    let d = 0.02_f32;
    let mut damping_m_s = vec![0.0; model.springs.len()];
    DampingLaw::Constant(d).fill(&model, &bench.params, &mut damping_m_s);
    let mut method = LocalCompression {
        dampers: Some(Dampers { damping_m_s: &damping_m_s }),
        volume: Some(BarycentreForce { coefficient_pa_per_m: VOLUME_PA_PER_M }),
        ..plain()
    };
    deform(&model, &mut state, 11);
    method.force(&model, &tuned, &mut state, at_depth(FAR), Vector3::zeros());
    let (x, v) = (positions(&state), velocities(&state));
    let volume = volume_forces(&model, &x);
    let mut wanted = volume.clone();
    for ([i, j], k, rest) in springs(&model, &bench.params) {
        let (along, speed) = ((x[j] - x[i]).normalize(), v[j] - v[i]);
        let f = along * (k * ((x[j] - x[i]).norm() - rest) + f64::from(d) * speed.dot(&along));
        wanted[i] += f;
        wanted[j] -= f;
    }
    let share = volume.iter().map(Vector::norm).sum::<f64>() / wanted.iter().map(Vector::norm).sum::<f64>();
    assert!(share > 0.1, "the volume force is {share} of all");
    assert_close(&forces_n(&state, &bench.params), &wanted, "(1) + (2)");

    // (2) violates momentum balance: unit vectors from a barycentre do not sum to zero, so a tet
    // pushes itself
    let (net, all) = (volume.iter().sum::<Vector>().norm(), volume.iter().map(Vector::norm).sum::<f64>());
    assert!(net > 1e-3 * all, "net force {net} N of {all} N");
}

/// The stress of (7) is that of a uniform load on a disc, summed here from Boussinesq's point
/// loads.
#[test]
fn eq_7_is_the_stress_under_a_uniform_disc_and_its_inverse() {
    let rule = |least_stress_pa| StressRule::new(least_stress_pa, 0.45, ContactPressure::UniformLoad);
    let (r, pressure) = (8e-3_f64, 5e3_f64);
    for depth in [9e-3_f64, 15e-3, 40e-3] {
        // sigma_z = 3 P z^3 / (2 pi R^5), integrated over rings of the disc
        let rings = 20_000;
        let stress: f64 = (0..rings)
            .map(|n| {
                let rho = r * (f64::from(n) + 0.5) / f64::from(rings);
                let load = pressure * 2.0 * std::f64::consts::PI * rho * (r / f64::from(rings));
                3.0 * load * depth.powi(3) / (2.0 * std::f64::consts::PI * (depth * depth + rho * rho).powf(2.5))
            })
            .sum();
        let radius = f64::from(rule(stress as f32).radius_m(pressure as f32, r as f32));
        assert!((radius / depth - 1.0).abs() < 1e-3, "stress {stress} Pa is reached at {radius} m, not {depth} m");
    }
    // below the threshold everywhere: the radius is that of the contact itself
    assert_eq!(rule(6e3).radius_m(5e3, 8e-3), 8e-3);
}

/// (8) returns the pressure of each of the two loads from which it is derived.
#[test]
fn eq_8_pressure_from_force_and_depth() {
    let (e, nu, r, p) = (3500.0_f64, 0.45_f64, 8e-3_f64, 900.0_f64);
    let force = p * std::f64::consts::PI * r * r;
    let plane = e / (1.0 - nu * nu);
    // displacement of the centre under a uniform load, and of a rigid punch with the same mean
    // pressure
    for (law, depth) in
        [(ContactPressure::UniformLoad, 2.0 * p * r / plane), (ContactPressure::RigidPunch, force / (2.0 * r * plane))]
    {
        let found = f64::from(StressRule::new(1.0, nu as f32, law).pressure_pa(e as f32, force as f32, depth as f32));
        assert!((found / p - 1.0).abs() < 1e-5, "{law:?}: {found} Pa, not {p} Pa");
    }
}

/// Nodes beyond the radius of (7)-(8) are frozen, those within it move, and their number follows
/// the threshold.
#[test]
fn the_region_follows_the_load() {
    let bench = bench();
    let model = bench.patch.wide_model();
    let active = |least_stress_pa: f32| {
        let mut memory = bench.memory();
        let (tuned, mut state) = memory.start(&model, &bench.params).unwrap();
        let rule = StressRule::new(least_stress_pa, 0.45, ContactPressure::UniformLoad);
        let mut method = LocalCompression { region: Some(rule), ..plain() };
        let mut last = None;
        for n in 0..1500_u16 {
            let depth_m = (f32::from(n) * 4e-6 - 5e-4).min(4e-3);
            let output = tick_with(&model, &tuned, &mut state, ProbePose { tip_m: at_depth(depth_m) }, &mut method);
            assert_eq!(output.fault, None);
            last = Some(output);
        }
        let output = last.unwrap();
        assert!(output.force_n.z > 0.0);
        // the moving nodes are those that the rule selects for the previous tick's force and depth
        let pressure_pa = rule.pressure_pa(bench.params.youngs_modulus_pa, output.force_n.norm(), output.depth_m);
        let radius_m = rule.radius_m(pressure_pa, bench.params.probe.radius_m);
        let within = model
            .nodes
            .iter()
            .enumerate()
            .filter(|(n, node)| !model.anchors.contains(&(*n as u16)) && Vector3::from(node.rest_m).norm() <= radius_m);
        (usize::from(output.active_nodes), within.count())
    };
    let counts = [10.0, 150.0, 300.0].map(active);
    for (active, wanted) in counts {
        // the centre of the contact moves by a few tenths of a millimetre, which may add or remove
        // a node at the edge
        assert!(active.abs_diff(wanted) <= 2, "{active} nodes moved, the rule says {wanted}: {counts:?}");
    }
    assert!(counts[0].0 > counts[1].0 && counts[1].0 > counts[2].0 && counts[2].0 > 0, "{counts:?}");
}

/// Equations (9) and (10) as printed, in double precision, with forces from (1) without dampers.
/// Our implementation stores the velocity at the half step.
#[test]
fn eq_9_and_10_velocity_verlet() {
    let bench = bench();
    let model = bench.patch.wide_model();
    let mut memory = bench.memory();
    let (tuned, mut state) = memory.start(&model, &bench.params).unwrap();
    deform(&model, &mut state, 12);
    let (m, dt) = (masses_kg(&model, &bench.params), f64::from(bench.params.tick_s));
    let network = springs(&model, &bench.params);
    let forces = |x: &[Vector]| {
        let mut f = vec![Vector::zeros(); x.len()];
        for &([i, j], k, rest) in &network {
            let d = x[j] - x[i];
            let pull = d * (k * (1.0 - rest / d.norm()));
            f[i] += pull;
            f[j] -= pull;
        }
        for &anchor in model.anchors {
            f[usize::from(anchor)] = Vector::zeros();
        }
        f
    };
    let (mut x, mut v) = (positions(&state), velocities(&state));
    model.anchors.iter().for_each(|&a| v[usize::from(a)] = Vector::zeros());
    let start = x.clone();
    let mut f = forces(&x);
    let mut method = plain();
    for _ in 0..200 {
        for n in 0..x.len() {
            x[n] += v[n] * dt + f[n] * (dt * dt / (2.0 * m[n]));
        }
        let next = forces(&x);
        for n in 0..x.len() {
            v[n] += (f[n] + next[n]) * (dt / (2.0 * m[n]));
        }
        f = next;
        tick_with(&model, &tuned, &mut state, ProbePose { tip_m: at_depth(FAR) }, &mut method);
    }
    let moved = |x: &[Vector]| x.iter().zip(&start).map(|(a, b)| a - b).collect::<Vec<_>>();
    let (found, wanted) = (moved(&positions(&state)), moved(&x));
    let size = wanted.iter().map(Vector::norm).fold(0.0, f64::max);
    // 200 steps of waves in single precision
    for (f, w) in found.iter().zip(&wanted) {
        assert!((f - w).norm() < 1e-3 * size, "{f:?} is not {w:?}");
    }
}

#[test]
fn eq_11_to_13_compressed_springs_are_pushed_apart_one_by_one() {
    let bench = bench();
    let model = bench.patch.wide_model();
    let mut memory = bench.memory();
    let (tuned, mut state) = memory.start(&model, &bench.params).unwrap();
    deform(&model, &mut state, 13);
    let start = positions(&state);
    let ratio = 0.02_f32;
    let mut method = LocalCompression { compression: Some(OverCompression { ratio }), ..plain() };
    method.correct(&model, &tuned, &mut state);
    let fixed = |n: usize| model.anchors.contains(&(n as u16));
    let mut x = start.clone();
    let mut corrected = 0;
    for ([i, j], _, rest) in springs(&model, &bench.params) {
        let n = (x[i] - x[j]).normalize();
        let c = (x[i] - x[j]).norm() - (1.0 - f64::from(ratio)) * rest;
        if c >= 0.0 {
            continue;
        }
        corrected += 1;
        let [of_i, of_j] = match (fixed(i), fixed(j)) {
            (false, false) => [0.5, 0.5],
            (true, false) => [0.0, 1.0],
            (false, true) => [1.0, 0.0],
            (true, true) => [0.0, 0.0],
        };
        x[i] -= n * (of_i * c);
        x[j] += n * (of_j * c);
    }
    assert!(corrected > 20, "{corrected} springs");
    let moved = |x: &[Vector]| x.iter().zip(&start).map(|(a, b)| a - b).collect::<Vec<_>>();
    assert_close(&moved(&positions(&state)), &moved(&x), "(12), (13)");
}
