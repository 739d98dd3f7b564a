//! Paper 000, eqs (3) to (12).

use crate::bench::at_depth;
use palpate::method::Method;
use palpate::stages::probe::ProbePose;
use palpate::{Model, State, Tuned, Vector3, tick_with};
use palpate_lab::paper_method::VolumePreserved;
use palpate_lab::paper_method::damper::{Dampers, DampingLaw};
use palpate_lab::paper_method::direction::SpringDirection;
use palpate_lab::paper_method::length::SpringLength;

use super::{Vector, assert_close, bench, deform, forces_n, masses_kg, positions, springs, velocities};

const FAR: f32 = -0.1;

fn pull(model: &Model, tuned: &Tuned, state: &mut State, method: &mut impl Method) {
    method.force(model, tuned, state, at_depth(FAR), Vector3::zeros());
}

fn plain() -> VolumePreserved<'static> {
    VolumePreserved::default()
}

#[test]
fn eq_3_positions_and_velocities_after_a_step() {
    let bench = bench();
    let model = bench.patch.wide_model();
    let mut memory = bench.memory();
    let (tuned, mut state) = memory.start(&model, &bench.params).unwrap();
    deform(&model, &mut state, 1);
    let (x, v) = (positions(&state), velocities(&state));
    let output = tick_with(&model, &tuned, &mut state, ProbePose { tip_m: at_depth(FAR) }, &mut plain());
    assert_eq!(output.fault, None);
    let (f, m) = (forces_n(&state, &bench.params), masses_kg(&model, &bench.params));
    let dt = f64::from(bench.params.tick_s);
    let free = |n: &usize| !model.anchors.contains(&(*n as u16));
    let nodes: Vec<usize> = (0..x.len()).filter(free).collect();
    // displacements are compared, because an error of 1e-5 m would not be noticed in a position;
    // the rounding of a position, 4e-9 m at 60 mm, is allowed for
    let moved: Vec<Vector> = nodes.iter().map(|&n| positions(&state)[n] - x[n]).collect();
    let wanted: Vec<Vector> = nodes.iter().map(|&n| v[n] * dt + f[n] * (dt * dt / m[n])).collect();
    for (moved, wanted) in moved.iter().zip(&wanted) {
        assert!((moved - wanted).norm() <= 8e-9, "(3) position: {moved:?}, the formula says {wanted:?}");
    }
    let speeds: Vec<Vector> = nodes.iter().map(|&n| velocities(&state)[n]).collect();
    assert_close(&speeds, &wanted.iter().map(|d| d / dt).collect::<Vec<_>>(), "(3) velocity");
}

#[test]
fn eq_4_spring_forces() {
    let bench = bench();
    let model = bench.patch.wide_model();
    let mut memory = bench.memory();
    let (tuned, mut state) = memory.start(&model, &bench.params).unwrap();
    deform(&model, &mut state, 2);
    pull(&model, &tuned, &mut state, &mut plain());
    let x = positions(&state);
    let mut wanted = vec![Vector::zeros(); x.len()];
    for ([i, j], k, rest) in springs(&model, &bench.params) {
        let d = x[j] - x[i];
        let f = d * (k * (d.norm() - rest) / d.norm());
        wanted[i] += f;
        wanted[j] -= f;
    }
    assert_close(&forces_n(&state, &bench.params), &wanted, "(4)");
}

/// (5) with the constants of (12) in each of its forms.
#[test]
fn eq_5_and_12_damper_forces() {
    let bench = bench();
    let model = bench.patch.wide_model();
    let m = masses_kg(&model, &bench.params);
    let constant = |law: DampingLaw, [i, j]: [usize; 2], k: f64, rest: f64| match law {
        DampingLaw::PrintedMetres => 2.0 * (k * (m[i] + m[j])).sqrt() / rest,
        DampingLaw::PrintedMillimetres => 2.0 * (k * (m[i] + m[j])).sqrt() / (rest * 1e3),
        DampingLaw::WithoutLength => 2.0 * (k * (m[i] + m[j])).sqrt(),
        DampingLaw::Critical(share) => f64::from(share) * 2.0 * (k / (1.0 / m[i] + 1.0 / m[j])).sqrt(),
        DampingLaw::Constant(d) => f64::from(d),
    };
    for law in [
        DampingLaw::PrintedMetres,
        DampingLaw::PrintedMillimetres,
        DampingLaw::WithoutLength,
        DampingLaw::Critical(0.1),
        DampingLaw::Constant(3.11e-3),
    ] {
        let mut memory = bench.memory();
        let (tuned, mut state) = memory.start(&model, &bench.params).unwrap();
        let mut damping_m_s = vec![0.0; model.springs.len()];
        law.fill(&model, &bench.params, &mut damping_m_s);
        let mut method = VolumePreserved { dampers: Some(Dampers { damping_m_s: &damping_m_s }), ..plain() };
        deform(&model, &mut state, 3);
        pull(&model, &tuned, &mut state, &mut plain());
        let undamped = forces_n(&state, &bench.params);
        pull(&model, &tuned, &mut state, &mut method);
        let found: Vec<Vector> = forces_n(&state, &bench.params).iter().zip(&undamped).map(|(a, b)| a - b).collect();
        let (x, v) = (positions(&state), velocities(&state));
        let (mut wanted, mut power) = (vec![Vector::zeros(); x.len()], 0.0);
        for (ends, k, rest) in springs(&model, &bench.params) {
            let [i, j] = ends;
            let n = (x[j] - x[i]).normalize();
            let f = n * (constant(law, ends, k, rest) * (v[j] - v[i]).dot(&n));
            wanted[i] += f;
            wanted[j] -= f;
            power += f.dot(&(v[i] - v[j]));
        }
        assert!(power < 0.0, "{law:?} feeds the motion");
        // a difference of sums is compared: the rounding errors are those of the larger sum
        let size = undamped.iter().map(Vector::norm).fold(0.0, f64::max).max(wanted.iter().map(Vector::norm).fold(0.0, f64::max));
        for (f, w) in found.iter().zip(&wanted) {
            assert!((f - w).norm() <= super::ROUNDING * size, "{law:?}: {f:?} is not {w:?}");
        }
    }
}

#[test]
fn eq_6_to_8_lengths_are_corrected_and_averaged() {
    let bench = bench();
    let model = bench.patch.wide_model();
    let (stretch, compression) = (0.03_f32, 0.02_f32);
    let mut memory = bench.memory();
    let (tuned, mut state) = memory.start(&model, &bench.params).unwrap();
    deform(&model, &mut state, 4);
    let x = positions(&state);
    let mut method = VolumePreserved { length: Some(SpringLength { stretch, compression }), ..plain() };
    method.correct(&model, &tuned, &mut state);
    let fixed = |n: usize| model.anchors.contains(&(n as u16));
    let (mut sum, mut count, mut violated) = (vec![Vector::zeros(); x.len()], vec![0.0; x.len()], 0);
    for ([i, j], _, rest) in springs(&model, &bench.params) {
        let n = (x[i] - x[j]).normalize();
        let length = (x[i] - x[j]).norm();
        let too_long = (1.0 + f64::from(stretch)) * rest - length;
        let too_short = length - (1.0 - f64::from(compression)) * rest;
        // (6): dx_i = C/2 n; (8) has the opposite gradient: dx_i = -C/2 n
        let step = if too_long < 0.0 { n * (0.5 * too_long) } else { n * (-0.5 * too_short.min(0.0)) };
        violated += usize::from(step.norm() > 0.0);
        let whole = if fixed(i) || fixed(j) { 2.0 } else { 1.0 };
        sum[i] += step * whole;
        sum[j] -= step * whole;
        count[i] += 1.0;
        count[j] += 1.0;
    }
    assert!(violated > 20, "{violated} springs");
    let moved: Vec<Vector> = positions(&state).iter().zip(&x).map(|(a, b)| a - b).collect();
    let wanted: Vec<Vector> = (0..x.len()).map(|n| if fixed(n) { Vector::zeros() } else { sum[n] / count[n] }).collect();
    // positions are rounded by 4e-9 m, and the corrections are 1e-4 m
    assert_close(&moved, &wanted, "(7)");
}

#[test]
fn eq_9_directions_turn_back_by_the_excess_and_look_again_in_time() {
    let bench = bench();
    let model = bench.patch.wide_model();
    let mut memory = bench.memory();
    let (tuned, mut state) = memory.start(&model, &bench.params).unwrap();
    let angle = 0.12_f64;
    let mut before_m: Vec<[f32; 3]> = model.nodes.iter().map(|n| n.rest_m).collect();
    let old: Vec<Vector> = before_m.iter().map(|x| Vector3::from(*x).cast()).collect();
    let direction = SpringDirection { angle_rad: angle as f32, every: 2, before_m: &mut before_m, age: 0 };
    let mut method = VolumePreserved { direction: Some(direction), ..plain() };
    deform(&model, &mut state, 5);
    let x = positions(&state);
    method.correct(&model, &tuned, &mut state);
    let fixed = |n: usize| model.anchors.contains(&(n as u16));
    let (mut sum, mut count, mut violated) = (vec![Vector::zeros(); x.len()], vec![0.0; x.len()], 0);
    for ([i, j], ..) in springs(&model, &bench.params) {
        let (now, then) = (x[j] - x[i], (old[j] - old[i]).normalize());
        let phi = (now.normalize().dot(&then)).acos();
        count[i] += 1.0;
        count[j] += 1.0;
        if phi <= angle {
            continue;
        }
        violated += 1;
        let u = now.normalize();
        let t = (then - u * u.dot(&then)).normalize();
        // dx_j = -C l/2 t with C = theta - phi
        let step = t * (0.5 * (phi - angle) * now.norm());
        let whole = if fixed(i) || fixed(j) { 2.0 } else { 1.0 };
        sum[j] += step * whole;
        sum[i] -= step * whole;
    }
    assert!(violated > 5, "{violated} springs");
    let moved: Vec<Vector> = positions(&state).iter().zip(&x).map(|(a, b)| a - b).collect();
    let wanted: Vec<Vector> = (0..x.len()).map(|n| if fixed(n) { Vector::zeros() } else { sum[n] / count[n] }).collect();
    // the angle is an arc cosine near one, which magnifies rounding five times
    let size = wanted.iter().map(Vector::norm).fold(0.0, f64::max);
    for (found, wanted) in moved.iter().zip(&wanted) {
        assert!((found - wanted).norm() <= 5.0 * super::ROUNDING * size, "{found:?} is not {wanted:?}");
    }

    // after `every` steps x^p is the present position: nothing has turned since then, so nothing
    // moves
    method.correct(&model, &tuned, &mut state);
    let settled = positions(&state);
    method.correct(&model, &tuned, &mut state);
    assert_eq!(positions(&state), settled);
}

/// A correction of positions acts as a force `m dx/dt^2`: at equal depth, the force rises as the
/// step becomes shorter. Paper 000 does not mention this.
#[test]
fn length_corrections_make_the_force_depend_on_the_step() {
    let force_n = |substeps: u16, fixes: bool| {
        let bench = bench().with(|p| {
            p.tick_s = 1e-3;
            p.substeps = substeps;
            p.node_damping_per_s = 100.0;
        });
        let model = bench.patch.wide_model();
        let mut memory = bench.memory();
        let (tuned, mut state) = memory.start(&model, &bench.params).unwrap();
        let mut method = VolumePreserved { length: fixes.then_some(SpringLength { stretch: 0.0, compression: 0.0 }), ..plain() };
        let mut force_n = 0.0;
        for n in 0..600_u16 {
            let depth_m = (f32::from(n) * 4e-5 - 1e-3).min(3e-3);
            let output = tick_with(&model, &tuned, &mut state, ProbePose { tip_m: at_depth(depth_m) }, &mut method);
            assert_eq!(output.fault, None, "{substeps} substeps, tick {n}");
            force_n = output.force_n.norm();
        }
        force_n
    };
    let [plain, plain_fine] = [2, 32].map(|s| force_n(s, false));
    let [fixed, fixed_fine] = [2, 32].map(|s| force_n(s, true));
    assert!((plain_fine / plain - 1.0).abs() < 0.05, "springs alone: {plain} N, then {plain_fine} N");
    assert!(fixed_fine > 1.5 * fixed, "with (6) to (8): {fixed} N, then {fixed_fine} N");
}
