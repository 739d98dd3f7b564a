//! Tissue that stiffens: forces are the slopes of the documented energy, the tick settles to the
//! statics, a closed cycle creates no energy, a light touch is that of tissue that does not
//! stiffen, and taps are stable.

use palpate::stages::force;
use palpate::stages::force::stiffening::CAP;
use palpate::stages::probe::ProbePose;
use palpate::{BuildError, GuardLimits, Model, Params, PatchFile, State, Vector3, tick};
use palpate_fit::statics::{Solver, Statics, Vector};
use palpate_tests::bench::{Bench, Deformation, at_depth};
use palpate_tests::oracle::Oracle;
use palpate_tests::oracle::energy::{depth_inside, of_foundation, of_spring};
use palpate_tests::share::Share;
use palpate_tissue::scene::Scene;
use palpate_tissue::session::Session;
use palpate_tissue::stable_step::{substeps_for_taps, with_tick};

/// Energy over E [m^3] of everything that stiffens, from the documented law: `sum V mu/2b (exp(2 b
/// w / mu) - 1)`, w half the energy of the springs and of the pushes at a node over its volume, b
/// times the node's steepness, and the other half of the pushes; straight beyond the cap.
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

/// Slope of an energy along one node, by central differences.
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

/// Every node has another steepness, one of them none.
fn uneven(mut bench: Bench) -> Bench {
    let nodes = bench.patch.model().nodes.len();
    bench.patch.set_steepness((0..nodes).map(|n| (n * 7 % 11) as f32 * 0.2).collect());
    bench
}

#[test]
fn inner_forces_are_slopes_of_the_energy() {
    // in the first one many nodes are beyond the cap
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

/// Energy and statics share no code; the statics also contain foundation and volume.
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
            // the constants are rounded to single precision, and the exponent multiplies that
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

/// Work of the hand over a closed cycle [J]: in, sideways, out, back above the tissue. Also returns
/// the largest energy that was put in.
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
                // the mean of the forces before and after
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

/// Taps to the depth limit at a tick 15 % longer, with the masses of this one: both the substeps of
/// the session and its bound hold.
#[test]
fn taps_hold_with_a_margin_of_15_percent() {
    for (nodes, youngs_modulus_pa, b) in [(130, 3500.0, 20.0), (130, 20e3, 3.0), (410, 3500.0, 20.0), (410, 20e3, 10.0)] {
        let text = format!(
            "name = \"tap\"\n[tissue]\nblock_m = [0.08, 0.08, 0.04]\nyoungs_modulus_pa = {youngs_modulus_pa:?}\n\
             poisson_ratio = 0.45\ndensity_kg_per_m3 = 1060.0\nnodes = {nodes}\nstiffening_b = {b:?}\n[probe]\n\
             shape = \"hemisphere\"\nradius_m = 0.008\n[drive]\nkind = \"depth\"\nholds_m = [0.006]\n\
             ramp_m_per_s = 0.04\nhold_s = 0.5\n"
        );
        let session = Session::prepare(&Scene::parse("tap", &text).unwrap()).unwrap();
        let (model, site_m, substeps) = (session.patch.wide_model(), session.patch.site_m(), session.params.substeps);
        let longer = with_tick(&session.params, 1.15e-3);
        let found = substeps_for_taps(&model, &longer, site_m, substeps).unwrap();
        println!("{nodes} nodes, {youngs_modulus_pa} Pa, b = {b}: {substeps} substeps, {found:?} at a tick 15 % longer");
        assert_eq!(found, Some(substeps), "{nodes} nodes, {youngs_modulus_pa} Pa, b = {b}");
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
    // without stiffening nobody asks for it
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
