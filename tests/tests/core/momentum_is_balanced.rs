//! Internal forces of the tissue and their moments sum to zero; the force on the probe is opposite
//! to the force on the tissue.

use palpate::stages::probe::{Motion, ProbePose};
use palpate::stages::{contact, force};
use palpate::{ClampFlags, Model, Output, RimEdge, RimNode, State, Vector3, tick};
use palpate_tests::bench::{Bench, Deformation, Noise, at_depth};
use palpate_tests::oracle::Oracle;
use palpate_tests::rounding::{self, UNIT};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

type Vector = Vector3<f64>;

fn deformations() -> impl Strategy<Value = Deformation> {
    (any::<u64>(), 0.0..0.6, 0.0..0.6).prop_map(|(seed, strain, jitter)| Deformation { seed, strain, jitter })
}

fn place(state: &mut State, model: &Model, deformation: Deformation, speed_m_per_s: f64) {
    let mut noise = Noise::new(!deformation.seed);
    for (n, x) in deformation.of(model).into_iter().enumerate() {
        state.place(n, x, (noise.vector() * speed_m_per_s).cast());
    }
}

fn positions(state: &State) -> Vec<Vector> {
    state.nodes().iter().map(|n| n.position_m().cast()).collect()
}

fn velocities(state: &State) -> Vec<Vector> {
    state.nodes().iter().map(|n| n.velocity_m_per_s().cast()).collect()
}

/// Node forces over E [N/Pa].
fn forces(state: &State) -> Vec<Vector> {
    state.nodes().iter().map(|n| n.force_over_modulus().cast()).collect()
}

/// A rim made of springs between neighbours; a rim edge gives its two nodes opposite forces.
fn spring_rim(model: &Model) -> (Vec<RimNode>, Vec<RimEdge>) {
    let mut blocks = vec![[0.0_f32; 6]; model.nodes.len()];
    let mut edges = Vec::new();
    for s in model.springs.iter().take(40) {
        // powers of two, so that the ground's part is the exact sum of the edges' parts
        let [a, b, c] = [2.0_f32.powi(-10), 2.0_f32.powi(-11), 2.0_f32.powi(-12)];
        edges.push(RimEdge { node: [s.i, s.j], block_m: [-a, -b, -c, -b, -a, -b, -c, -b, -a] });
        for n in [s.i, s.j] {
            blocks[usize::from(n)].iter_mut().zip([a, a, a, b, c, b]).for_each(|(sum, v)| *sum += v);
        }
    }
    edges.sort_by_key(|e| e.node[0]);
    (blocks.into_iter().zip(0..).map(|(block_m, node)| RimNode { node, block_m }).collect(), edges)
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, rng_seed: RngSeed::Fixed(2), cases: 40, ..ProptestConfig::default() })]

    #[test]
    fn inner_forces_and_their_moments_sum_to_nothing(deformation in deformations()) {
        let bench = Bench::block(129);
        let model = bench.patch.wide_model();
        let mut memory = bench.memory();
        let (tuned, mut state) = memory.start(&model, &bench.params).unwrap();
        place(&mut state, &model, deformation, 1.0);
        force::accumulate(&model, &tuned, &mut state, at_depth(-1.0), Vector3::zeros());

        let (x, f) = (positions(&state), forces(&state));
        let bound = rounding::of_forces_n(&model, &bench.params, &x);
        let e = f64::from(tuned.youngs_modulus_pa());
        let force = f.iter().sum::<Vector>().norm() * e;
        let allowed = rounding::together(bound.iter().copied());
        prop_assert!(force <= allowed, "{force} N left, rounding explains {allowed} N");
        let moment = x.iter().zip(&f).map(|(x, f)| x.cross(f)).sum::<Vector>().norm() * e;
        let allowed = rounding::together(bound.iter().zip(&x).map(|(b, x)| b * x.norm()));
        prop_assert!(moment <= allowed, "{moment} N m left, rounding explains {allowed} N m");
    }

    #[test]
    fn rim_edges_give_what_they_take(deformation in deformations()) {
        let bench = Bench::block(60).with(|p| p.terms.volume = false);
        let (rim_nodes, rim_edges) = spring_rim(&bench.patch.wide_model());
        let model = Model { rim_nodes: &rim_nodes, rim_edges: &rim_edges, springs: &[], spring_rows: &[], ..bench.patch.wide_model() };
        let mut memory = bench.memory();
        let (tuned, mut state) = memory.start(&model, &bench.params).unwrap();
        place(&mut state, &bench.patch.wide_model(), deformation, 0.0);
        force::accumulate(&model, &tuned, &mut state, at_depth(-1.0), Vector3::zeros());
        let left = forces(&state).iter().sum::<Vector>().norm();
        // 80 block rows of entries up to 2^-10 m, 3 products each, displacements up to 0.1 m, 12
        // roundings
        let allowed = 80.0 * 3.0 * 2.0_f64.powi(-10) * 0.1 * 12.0 * UNIT;
        prop_assert!(left <= allowed, "{left} N/Pa left, rounding explains {allowed} N/Pa");
        prop_assert!(forces(&state).iter().any(|f| f.norm() > 0.0) || deformation.strain == 0.0);
    }

    #[test]
    fn the_probe_feels_the_opposite_of_what_the_tissue_gets(deformation in deformations(), depth_m in 1e-3_f32..5e-3) {
        let bench = Bench::block(129);
        let model = bench.patch.wide_model();
        let mut memory = bench.memory();
        let (tuned, mut state) = memory.start(&model, &bench.params).unwrap();
        place(&mut state, &model, Deformation { strain: 0.05 * deformation.strain, jitter: 0.1 * deformation.jitter, ..deformation }, 0.0);
        let velocity = Vector3::new(0.1, -0.2, -0.3);
        for to_m in [at_depth(-0.1), at_depth(depth_m)] {
            let mut motion = Motion { from_m: to_m, to_m, velocity_m_per_s: velocity, apart_m: 0.0, beyond_m: Vector3::zeros(), outside: false, limiters: ClampFlags::default() };
            contact::find(&model, &tuned, &mut state, &mut motion);
        }
        let load = force::accumulate(&model, &tuned, &mut state, at_depth(depth_m), velocity);
        let touched = forces(&state);
        force::accumulate(&model, &tuned, &mut state, at_depth(-0.1), velocity);
        let on_tissue: Vector = touched.iter().zip(forces(&state)).map(|(a, b)| a - b).sum();
        // each node's sum, in which the contact part is added last, is rounded; the probe's sum has
        // as many terms
        let allowed = touched.iter().zip(forces(&state)).map(|(a, b)| 4.0 * UNIT * (a.norm() + b.norm())).sum::<f64>()
            + 100.0 * UNIT * f64::from(load.push);
        let on_probe: Vector = load.force.cast();
        prop_assert!(load.push > 0.0);
        prop_assert!((on_tissue - on_probe).norm() <= allowed, "{on_tissue:?} is not {on_probe:?} within {allowed}");
    }

    /// In a tick, momentum changes by the force on the tissue times the tick. The probe is at rest,
    /// because the force on a moving probe excludes the mass that the floor adds. In each substep,
    /// node damping takes the share `alpha dt` of the momentum.
    #[test]
    fn a_tick_changes_momentum_by_force_times_time(seed: u64, depth_m in 1e-3_f32..4e-3, substeps in 1_u16..4) {
        let bench = Bench::floating(129).with(|p| {
            p.substeps = substeps;
            // with one substep the loss by damping is known; with more, only the sum of the forces
            // is known
            p.node_damping_per_s = if substeps == 1 { 40.0 } else { 0.0 };
        });
        let model = bench.patch.wide_model();
        prop_assert!(model.anchors.is_empty());
        let mut memory = bench.memory();
        let (tuned, mut state) = memory.start(&model, &bench.params).unwrap();
        tick(&model, &tuned, &mut state, ProbePose { tip_m: at_depth(-0.5e-3) });
        place(&mut state, &model, Deformation { seed, strain: 0.01, jitter: 0.02 }, 0.05);
        let (mut start, mut output) = (Vec::new(), Output::NONE);
        for n in [0, 1, 2, 3, 4, 5, 5_u8] {
            start = velocities(&state);
            output = tick(&model, &tuned, &mut state, ProbePose { tip_m: at_depth(depth_m * f32::from(n) / 5.0) });
        }
        prop_assert_eq!(output.fault, None);
        prop_assert!(!output.limiters.contains(ClampFlags::FORCE) && output.force_n.norm() > 0.01);
        let momenta = Oracle::new(model, bench.params).momenta();
        let momentum = |v: &[Vector]| momenta(v).iter().sum::<Vector>();
        let keep = if substeps == 1 { 1.0 - 40.0e-3 } else { 1.0 };
        let gained = momentum(&velocities(&state)) - momentum(&start) * keep;
        let given = -output.force_n.cast::<f64>() * 1e-3;
        // rounding errors of the internal forces times dt, and of the velocities: three operations
        // per substep, over all substeps
        let inner = rounding::together(rounding::of_forces_n(&model, &bench.params, &positions(&state))) * 1e-3;
        let speeds = rounding::together(momenta(&velocities(&state)).iter().map(|p| p.norm()));
        let allowed = 2.0 * inner + 4.0 * f64::from(substeps) * UNIT * 2.0 * rounding::SIGMAS * speeds + 100.0 * UNIT * given.norm();
        prop_assert!((gained - given).norm() <= allowed, "gained {gained:?}, given {given:?}, rounding explains {allowed}");
        prop_assert!(given.norm() > 10.0 * allowed, "{given:?} would hide behind {allowed}");
    }
}
