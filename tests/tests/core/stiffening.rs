//! Tissue that stiffens: forces are the derivatives of the documented energy, the tick settles to
//! the static solution, a closed cycle creates no energy, a light touch feels like tissue that does
//! not stiffen, and taps are stable.

use palpate::stages::force;
use palpate::stages::force::stiffening::CAP;
use palpate::stages::probe::ProbePose;
use palpate::{BuildError, GuardLimits, Model, Params, PatchFile, State, Vector3, tick};
use palpate_fit::statics::{Solver, Statics, Vector};
use palpate_loop::closed_loop::device::DeviceProfile;
use palpate_loop::closed_loop::prepared::Prepared;
use palpate_loop::closed_loop::report::{Target, report};
use palpate_tests::bench::{Bench, Deformation, at_depth};
use palpate_tests::oracle::Oracle;
use palpate_tests::oracle::energy::{depth_inside, of_foundation, of_spring};
use palpate_tests::share::Share;
use palpate_tests::tap::Tap;
use palpate_tissue::patch::{Memory, Patch};
use palpate_tissue::scene::Scene;
use palpate_tissue::session::Session;
use palpate_tissue::stable_step::with_tick;

/// Energy over E [m^3] of all stiffening parts, from the documented law: `sum V mu/2b (exp(2 b w /
/// mu) - 1)`, where w is half the energy of a node's springs and contact points over its volume,
/// and b includes the node's steepness. The other half of the contact energy is added unchanged.
/// Beyond the cap the law continues linearly.
fn stiffening_energy(model: &Model, params: &Params, x: &[Vector], tip_m: Option<Vector>) -> f64 {
    let mut half = vec![0.0; x.len()];
    for s in model.springs {
        let energy: f64 = of_spring(s, params, x[usize::from(s.i)].into(), x[usize::from(s.j)].into());
        half[usize::from(s.i)] += 0.5 * energy;
        half[usize::from(s.j)] += 0.5 * energy;
    }
    let mut outside = 0.0;
    for (triangle, points) in model.triangles.iter().zip(model.foundation.chunks(model.points_per_triangle())) {
        let Some(tip_m) = tip_m else { break };
        let weights = force::foundation::point_weights(points.len());
        for (law, weights) in points.iter().zip(weights) {
            let at: Vector = triangle.node.iter().zip(weights).map(|(n, w)| x[usize::from(*n)] * f64::from(*w)).sum();
            let Some(depth) = depth_inside(params, tip_m.into(), at.into()) else { continue };
            let energy = of_foundation(f64::from(law.k), f64::from(model.stiffening_per_m), depth);
            triangle.node.iter().zip(weights).for_each(|(n, w)| half[usize::from(*n)] += 0.5 * energy * f64::from(*w));
            outside += 0.5 * energy;
        }
    }
    let (b, mu) = (f64::from(params.stiffening_b), 0.5 / (1.0 + f64::from(params.poisson_ratio)));
    let of_node = |((n, energy), node): ((usize, &f64), &palpate::NodeRest)| {
        let (volume_m3, cap) = (f64::from(node.volume_m3), f64::from(CAP));
        let b = b * model.steepness.get(n).map_or(1.0, |steepness| f64::from(*steepness));
        if b == 0.0 {
            return *energy;
        }
        let ln = 2.0 * b * energy / volume_m3 / mu;
        let beyond = (ln - cap).max(0.0) * cap.exp();
        volume_m3 * mu / (2.0 * b) * (ln.min(cap).exp_m1() + beyond)
    };
    half.iter().enumerate().zip(model.nodes).map(of_node).sum::<f64>() + outside
}

/// Derivative of an energy with respect to one node's position, by central differences.
fn slope(energy: impl Fn(&[Vector]) -> f64, x: &[Vector], node: usize) -> Vector {
    Vector::from_fn(|k, _| {
        let moved = |by: f64| {
            let mut x = x.to_vec();
            x[node][k] += by;
            energy(&x)
        };
        (moved(1e-7) - moved(-1e-7)) / 2e-7
    })
}

fn stiffening(nodes: usize, b: f32) -> Bench {
    Bench::block(nodes).with(|p| p.stiffening_b = b)
}

/// The bench with a steepness that varies from node to node between 0 and 2.
fn uneven(mut bench: Bench) -> Bench {
    let nodes = bench.patch.model().nodes.len();
    bench.patch.set_steepness((0..nodes).map(|n| (n * 7 % 11) as f32 * 0.2).collect());
    bench
}

#[test]
fn inner_forces_are_slopes_of_the_energy() {
    // in the first case many nodes are beyond the cap
    for (nodes, b, strain, seed) in [(60, 20.0, 0.15, 1), (60, 20.0, 0.04, 2), (129, 3.0, 0.1, 3), (129, 0.3, 0.15, 4)] {
        let bench = stiffening(nodes, b).with(|p| p.terms.volume = false);
        let bench = if seed % 2 == 0 { uneven(bench) } else { bench };
        let model = bench.patch.wide_model();
        let mut memory = bench.memory();
        let (tuned, mut state) = memory.start(&model, &bench.params).unwrap();
        let moved = Deformation { seed, strain, jitter: 0.5 * strain }.of(&model);
        for (n, x) in moved.iter().enumerate() {
            state.place(n, *x, Vector3::zeros());
        }
        force::accumulate(&model, &tuned, &mut state, at_depth(-1.0), Vector3::zeros());
        let x: Vec<Vector> = moved.iter().map(|x| x.cast()).collect();
        let energy = |x: &[Vector]| stiffening_energy(&model, &bench.params, x, None);
        let (mut worst, mut largest, mut plain) = (0.0_f64, 0.0_f64, 0.0_f64);
        let oracle = Oracle::new(model, bench.params).forces_n(&x);
        for n in (0..x.len()).step_by(7) {
            let expected = -slope(energy, &x, n);
            let found: Vector = state.nodes()[n].force_over_modulus().cast();
            worst = worst.max((found - expected).norm());
            largest = largest.max(expected.norm());
            plain = plain.max((oracle[n] / oracle_modulus(&bench) - expected).norm());
        }
        println!(
            "{nodes} nodes, b = {b}: {:.1e} of the largest force; without stiffening {:.1e}",
            worst / largest,
            plain / largest
        );
        assert!(worst < 2e-5 * largest, "{nodes} nodes, b = {b}: {worst} of {largest}");
        assert!(plain > 1e-2 * largest, "the deformation shows nothing");
    }
}

fn oracle_modulus(bench: &Bench) -> f64 {
    f64::from(bench.params.youngs_modulus_pa)
}

/// Energy and statics share no code; the statics also include foundation and volume.
#[test]
fn statics_are_slopes_of_the_energy_under_the_probe() {
    let bench = uneven(stiffening(129, 10.0)).with(|p| p.terms.volume = false);
    let model = bench.patch.wide_model();
    let statics = Statics::of(&model, &bench.params).unwrap();
    let tip_m = Vector::new(1.3e-3, 0.7e-3, -2e-3);
    let moved = Deformation { seed: 5, strain: 0.02, jitter: 0.05 }.of(&model);
    let x: Vec<Vector> = moved.iter().map(|x| x.cast()).collect();
    let (found, _) = statics.slope(&x, tip_m);
    let energy = |x: &[Vector]| stiffening_energy(&model, &bench.params, x, Some(tip_m));
    let largest = found.iter().map(Vector::norm).fold(0.0, f64::max);
    for (n, found) in found.iter().enumerate() {
        if !model.anchors.contains(&(n as u16)) {
            let off = (found - slope(energy, &x, n)).norm();
            // constants are rounded to single precision, and the exponent magnifies the error
            assert!(off < 3e-5 * largest, "node {n}: {off} of {largest}");
        }
    }
}

#[test]
fn the_tick_settles_to_the_static_force() {
    for (b, substeps) in [(3.0, 3), (20.0, 8)] {
        let bench = stiffening(129, b).with(|p| {
            (p.substeps, p.node_damping_per_s, p.limits) = (substeps, 150.0, GuardLimits::HIGHEST);
        });
        let model = bench.patch.wide_model();
        let statics = Statics::of(&model, &bench.params).unwrap();
        let solver = Solver::of(&statics).unwrap();
        let mut here = solver.rest(&statics, Vector::zeros(), 1e-6).unwrap();
        let mut memory = bench.memory();
        let (tuned, mut state) = memory.start(&model, &bench.params).unwrap();
        tick(&model, &tuned, &mut state, ProbePose { tip_m: at_depth(-1e-3) });
        for depth_m in [1e-3, 3e-3, 5e-3] {
            here = solver.press(&statics, &here, Vector::new(0.0, 0.0, -depth_m), depth_m).unwrap();
            let expected_n = here.force * oracle_modulus(&bench);
            let found_n = (0..3000).fold(0.0, |_, _| {
                let output = tick(&model, &tuned, &mut state, ProbePose { tip_m: at_depth(depth_m as f32) });
                assert_eq!(output.fault, None);
                f64::from(output.force_n.z)
            });
            println!("b = {b}, {depth_m} m: {found_n:.5} N, statics {expected_n:.5} N");
            assert!((found_n / expected_n - 1.0).abs() < 2e-4, "b = {b}, {depth_m} m: {found_n} N, statics {expected_n} N");
        }
    }
}

/// Work of the hand over a closed cycle [J]: in, sideways, out, back above the tissue; and the
/// largest value of this work on the way.
fn cycle_j(bench: &Bench, seconds: f64) -> [f64; 2] {
    let model = bench.patch.wide_model();
    let mut memory = bench.memory();
    let (tuned, mut state) = memory.start(&model, &bench.params).unwrap();
    let way: [[f64; 2]; 6] = [[0.0, 1e-3], [0.0, -4e-3], [3e-3, -3e-3], [3e-3, -4.5e-3], [-2e-3, -2e-3], [0.0, 1e-3]];
    let ticks = (seconds / 5.0 * 1e3).round();
    let mut tip_m = Vector3::new(0.0, 0.0, 1e-3);
    let mut force_n = Vector3::zeros();
    let (mut work_j, mut most_j) = (0.0_f64, 0.0_f64);
    for _ in 0..3 {
        for pair in way.windows(2) {
            for n in 1..=ticks as usize {
                let share = n as f64 / ticks;
                let [x, z] = [0, 1].map(|k| pair[0][k] + share * (pair[1][k] - pair[0][k]));
                let next = Vector3::new(x, 0.0, z).cast::<f32>();
                let output = tick(&model, &tuned, &mut state, ProbePose { tip_m: next });
                assert_eq!(output.fault, None);
                // mean of the forces before and after
                work_j -= f64::from((output.force_n + force_n).dot(&(next - tip_m)) * 0.5);
                most_j = most_j.max(work_j);
                (tip_m, force_n) = (next, output.force_n);
            }
        }
    }
    [work_j, most_j]
}

#[test]
fn a_closed_cycle_gives_the_hand_nothing() {
    let mut share = Share::one_in(4);
    for (b, substeps) in [(3.0, 2), (20.0, 6)] {
        for seconds in [0.4, 2.0, 10.0] {
            if !share.takes() {
                continue;
            }
            let bench = stiffening(129, b).with(|p| p.substeps = substeps);
            let [left_j, most_j] = cycle_j(&bench, seconds);
            println!("b = {b}, {seconds} s: {left_j:.2e} J of {most_j:.2e} J stay in the tissue");
            assert!(left_j > -1e-4 * most_j, "b = {b}, {seconds} s: the tissue gave {:e} J of {most_j:e} J", -left_j);
        }
    }
}

#[test]
fn a_light_touch_is_that_of_tissue_that_keeps_its_stiffness() {
    let force_n = |b: f32, depth_m: f32| {
        let bench = stiffening(129, b).with(|p| p.substeps = 4);
        let model = bench.patch.wide_model();
        let mut memory = bench.memory();
        let (tuned, mut state) = memory.start(&model, &bench.params).unwrap();
        (0..800_u16).fold(0.0, |_, n| {
            let depth_m = (-1e-4 + 2e-5 * f32::from(n)).min(depth_m);
            tick(&model, &tuned, &mut state, ProbePose { tip_m: at_depth(depth_m) }).force_n.z
        })
    };
    let stiffer = |depth_m: f32| force_n(10.0, depth_m) / force_n(0.0, depth_m);
    let [touch, press] = [0.1e-3, 4e-3].map(stiffer);
    println!("{touch} times as stiff at 0.1 mm, {press} at 4 mm");
    assert!((touch - 1.0).abs() < 0.01 && press > 1.3, "{touch} at 0.1 mm, {press} at 4 mm");
}

fn scene(nodes: usize, youngs_modulus_pa: f64, b: f64) -> Scene {
    let text = format!(
        "name = \"tap\"\n[tissue]\nblock_m = [0.08, 0.08, 0.04]\nyoungs_modulus_pa = {youngs_modulus_pa:?}\n\
         poisson_ratio = 0.45\ndensity_kg_per_m3 = 1060.0\nnodes = {nodes}\nstiffening_b = {b:?}\n[probe]\n\
         shape = \"hemisphere\"\nradius_m = 0.008\n[drive]\nkind = \"depth\"\nholds_m = [0.006]\n\
         ramp_m_per_s = 0.04\nhold_s = 0.5\n"
    );
    Scene::parse("tap", &text).unwrap()
}

/// Number of taps at 1 m/s to the depth limit, with a hold of 50 ms, that diverge, of eight that
/// start at different eighths of a tick.
fn faults_of_fast_taps(patch: &Patch, params: &Params) -> usize {
    const STEP_M: f32 = 1e-3;
    let model = patch.wide_model();
    let diverges = |phase: &u8| {
        let mut memory = Memory::for_model(&model);
        let (tuned, mut state) = memory.start(&model, params).unwrap();
        let start_m = -STEP_M * (2.0 + f32::from(*phase) / 8.0);
        (0..60_u8).any(|n| {
            let depth_m = (start_m + STEP_M * f32::from(n)).min(model.depth_limit_m);
            let tip_m = patch.site_m() - params.probe.axis * depth_m;
            tick(&model, &tuned, &mut state, ProbePose { tip_m }).fault.is_some()
        })
    };
    (0..8).filter(diverges).count()
}

/// A tap of 1 m/s is as fast as the shear waves of tissue at 3.5 kPa and stiffens it most. It needs
/// more substeps than a tap of 0.5 m/s, both in a session and in a loop, whose masses are lighter.
#[test]
fn the_fastest_taps_do_not_diverge() {
    let touch = DeviceProfile::load("touch").unwrap();
    let mut share = Share::one_in(3);
    for (youngs_modulus_pa, b) in [(1e3, 5.0), (3.5e3, 5.0), (3.5e3, 10.0), (7e3, 20.0)] {
        if !share.takes() {
            continue;
        }
        let scene = scene(130, youngs_modulus_pa, b);
        let (session, prepared) = (Session::prepare(&scene).unwrap(), Prepared::of(&scene, &touch).unwrap());
        for (who, patch, params) in [("session", session.patch, session.params), ("loop", prepared.patch, prepared.params)] {
            let label = format!("{youngs_modulus_pa} Pa, b = {b}: {} substeps in a {who}", params.substeps);
            println!("{label}");
            assert_eq!(faults_of_fast_taps(&patch, &params), 0, "{label}");
            let half = Params { substeps: params.substeps / 2, ..params };
            assert!(faults_of_fast_taps(&patch, &half) > 0, "{label}: half of them are enough");
        }
    }
}

#[test]
fn a_loop_says_that_no_substeps_hold_the_fastest_taps() {
    let touch = DeviceProfile::load("touch").unwrap();
    let prepared = Prepared::of(&scene(130, 3.5e3, 10.0), &touch).unwrap();
    for held in [true, false] {
        let prepared = Prepared { fast_taps_held: held, ..prepared.clone() };
        let broken = report("b = 10", &Target::Tissue(Box::new(prepared), 3.5e3), &touch, Vec::new()).broken;
        assert_eq!(broken.iter().any(|words| words.contains("taps of 1 m/s diverge")), !held, "{broken:?}");
    }
}

/// Taps to the depth limit come to rest with the session's number of substeps in ticks that are 15
/// % longer, with the masses of the normal tick.
#[test]
fn taps_hold_with_a_margin_of_15_percent() {
    let mut share = Share::one_in(3);
    for (nodes, youngs_modulus_pa, b) in [(130, 3500.0, 20.0), (130, 20e3, 3.0), (410, 3500.0, 20.0), (410, 20e3, 10.0)] {
        if !share.takes() {
            continue;
        }
        let session = Session::prepare(&scene(nodes, youngs_modulus_pa, b)).unwrap();
        let (bench, substeps) = (Bench { patch: session.patch, params: session.params }, session.params.substeps);
        let longer = with_tick(&bench.params, 1.15e-3);
        for speed_m_per_s in [0.5, 1.0] {
            let deep_m = bench.patch.model().depth_limit_m.into();
            let outcome = Tap { deep_m, speed_m_per_s, jitter: 0.0 }.run(&bench, &longer);
            let label = format!("{nodes} nodes, {youngs_modulus_pa} Pa, b = {b}, {substeps} substeps, {speed_m_per_s} m/s");
            println!("{label}: {outcome:?} at a tick 15 % longer");
            assert_eq!(outcome.wrong, None, "{label}");
        }
        assert!(substeps > 1, "{nodes} nodes, b = {b}: one substep shows nothing of the bound");
    }
}

#[test]
fn a_patch_file_keeps_the_steepness_of_its_nodes_where_it_has_one() {
    let words = |bench: &Bench| {
        let bytes = bench.patch.pack(&bench.params, 1e-3);
        let mut words = vec![0_u32; bytes.len() / 4];
        bytemuck::cast_slice_mut(&mut words).copy_from_slice(&bytes);
        words
    };
    let even = stiffening(60, 5.0);
    let uneven = uneven(even.clone());
    let (plain, with) = (words(&even), words(&uneven));
    assert_eq!(with.len() - plain.len(), even.patch.model().nodes.len());
    for (bench, words) in [(&even, &plain), (&uneven, &with)] {
        let file = PatchFile::open(bytemuck::cast_slice(words)).unwrap();
        assert_eq!(file.model.steepness, bench.patch.model().steepness);
        assert_eq!(file.model.check(), Ok(()));
    }
    // without stiffening the steepness is not stored
    let plain = |bench: &Bench| words(&bench.clone().with(|p| p.stiffening_b = 0.0));
    assert_eq!(plain(&uneven), plain(&even));
    let short = [1.0; 3];
    let model = Model { steepness: &short, ..even.patch.model() };
    assert!(matches!(model.check(), Err(BuildError::LengthMismatch { item: "node steepnesses", .. })));
}

#[test]
fn zero_leaves_the_term_out_to_the_bit() {
    let hash = |change: &dyn Fn(&mut Params)| {
        let bench = Bench::block(129).with(change);
        let model = bench.patch.wide_model();
        let mut memory = bench.memory();
        let (tuned, mut state): (_, State) = memory.start(&model, &bench.params).unwrap();
        for n in 0..200_u16 {
            tick(&model, &tuned, &mut state, ProbePose { tip_m: at_depth((-1e-3 + 4e-5 * f32::from(n)).min(4e-3)) });
        }
        state.hash()
    };
    let plain = hash(&|_| ());
    assert_eq!(hash(&|p| p.stiffening_b = 0.0), plain);
    assert_eq!(hash(&|p| (p.stiffening_b, p.terms.stiffening) = (20.0, false)), plain);
    assert_ne!(hash(&|p| p.stiffening_b = 0.3), plain);
}
