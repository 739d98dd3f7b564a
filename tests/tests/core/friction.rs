//! A probe with friction. In full slip the tangential force is mu times the normal force; partial
//! slip is near Cattaneo and Mindlin; a sticking probe is as stiff as a glued disc; a hold does not
//! creep; no motion gains energy; without friction the results are bit-identical to those without
//! the term.

use palpate::stages::probe::ProbePose;
use palpate::{
    Fault, MOST_TERMS, Model, Node, NodeStep, Output, Params, ProbeShape, PronyTerm, State, TetShapes, Tuned, Vector3, tick,
};
use palpate_fit::partial_slip::PartialSlip;
use palpate_tests::bench::{Bench, Noise, at_depth};
use palpate_tissue::answer::Answer;
use palpate_tissue::patch::Memory;
use palpate_tissue::stable_step::with_tick;

/// A patch and a probe whose position the test sets in every tick.
struct Rig<'a> {
    model: &'a Model<'a>,
    tuned: Tuned<'a>,
    state: State<'a>,
}

impl<'a> Rig<'a> {
    fn new(model: &'a Model<'a>, params: &Params, memory: &'a mut Memory) -> Self {
        let (tuned, state) = memory.start(model, params).unwrap();
        Self { model, tuned, state }
    }

    fn at(&mut self, tip_m: Vector3<f64>) -> Output {
        let output = tick(self.model, &self.tuned, &mut self.state, ProbePose { tip_m: tip_m.cast() });
        assert_eq!(output.fault, None);
        output
    }

    /// Presses to a depth at 20 mm/s and rests there.
    fn pressed(&mut self, depth_m: f64) -> Output {
        let mut last = Output::NONE;
        for n in 0..2000 {
            last = self.at(Vector3::new(0.0, 0.0, -(-1e-3 + 2e-5 * f64::from(n)).min(depth_m)));
        }
        last
    }
}

/// Tangential force against the direction `along`, and normal force [N].
fn parts(output: &Output, along: &Vector3<f64>) -> [f64; 2] {
    let (force, normal) = (output.force_n.cast::<f64>(), output.normal.cast::<f64>());
    let push = force.dot(&normal);
    [-(force - normal * push).dot(along), push]
}

fn heading(turned: f64) -> Vector3<f64> {
    Vector3::new(turned.cos(), turned.sin(), 0.0)
}

const HEADINGS: [f64; 3] = [0.0, 0.8, 2.1];

/// Tangential force over mu times the normal force in every tick of a drag of `step_m` per tick
/// (1).
fn dragged(bench: &Bench, depth_m: f64, along: &Vector3<f64>, step_m: f64, ticks: u32) -> Vec<f64> {
    let model = bench.patch.wide_model();
    let mut memory = bench.memory();
    let mut rig = Rig::new(&model, &bench.params, &mut memory);
    rig.pressed(depth_m);
    let mu = f64::from(bench.params.friction);
    let share = |output: &Output| parts(output, along);
    (1..=ticks)
        .map(|n| {
            let [slides, push] = share(&rig.at(along * (step_m * f64::from(n)) - Vector3::z() * depth_m));
            slides / (mu * push)
        })
        .collect()
}

/// Under a flat end all contact forces have the same direction, so full slip transmits mu N.
#[test]
fn a_flat_end_that_slides_bears_mu_times_the_push() {
    for mu in [0.1_f32, 0.3, 0.6, 1.0] {
        let bench = Bench::calibrated(130).with(|p| {
            (p.friction, p.probe.shape) = (mu, ProbeShape::Flat);
        });
        let model = bench.patch.wide_model();
        let mut memory = bench.memory();
        let mut rig = Rig::new(&model, &bench.params, &mut memory);
        rig.pressed(2e-4);
        let mut last = Output::NONE;
        for n in 1..=1500 {
            last = rig.at(Vector3::new(2e-6 * f64::from(n), 0.0, -2e-4));
        }
        let [slides, push] = parts(&last, &Vector3::x());
        let (share, grip) = (slides / push, f64::from(last.grip_n) / push);
        println!("mu {mu}: {share:.4} of the push, {grip:.4} at most");
        assert!((share / f64::from(mu) - 1.0).abs() < 5e-3 && (grip / f64::from(mu) - 1.0).abs() < 5e-3, "{share} for {mu}");
    }
}

/// Largest differences from Cattaneo and Mindlin at a depth of a quarter of the radius, relative to
/// mu N. The first uses the half-space's displacement to full slip, the second that of the patch's
/// own stiffness in stick.
fn off_partial(nodes: usize, mu: f32, turned: f64) -> [f64; 2] {
    const STEP_M: f64 = 1e-6;
    let depth_m = 2e-3;
    let along = heading(turned);
    let sticks = Bench::calibrated(nodes).with(|p| p.friction = 5.0);
    let stuck = dragged(&sticks, depth_m, &along, 1e-7, 200);
    // relative to mu N, per metre
    let stiffness = (stuck[199] - stuck[99]) / 1e-5 * 5.0 / f64::from(mu);
    let poisson_ratio = f64::from(sticks.params.poisson_ratio);
    let slips_m = [PartialSlip { friction: f64::from(mu), poisson_ratio, depth_m }.slips_m(), 1.5 / stiffness];
    let most_m = slips_m[0].max(slips_m[1]);
    let slid = dragged(&sticks.with(|p| p.friction = mu), depth_m, &along, STEP_M, (most_m / STEP_M) as u32 + 1);
    slips_m.map(|slips_m| {
        let ticks = (slips_m / STEP_M) as usize;
        let worst = slid.iter().take(ticks).enumerate().map(|(n, share)| {
            let way = (n + 1) as f64 * STEP_M / slips_m;
            share - PartialSlip::share(way)
        });
        worst.fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a })
    })
}

#[test]
fn partial_slip_is_near_cattaneo_and_mindlin() {
    for turned in HEADINGS {
        let [space, own] = off_partial(410, 0.3, turned);
        println!("410 nodes, heading {turned}: {space:.4} off the half-space, {own:.4} off the curve of its own stiffness");
        assert!(space.abs() < 0.065 && own.abs() < 0.045, "heading {turned}: {space}, {own}");
    }
}

/// Largest excess stiffness of partial slip for a given element width, relative to mu N. A node
/// carries the contact force of half an element around it, all of which slips at once. Nothing
/// slips until Cattaneo and Mindlin's slip zone has come half an element inward, to `a (1 - w)`.
/// Until then the force rises as in stick, to `1.5 (1 - (1 - w)^2)` in place of `1 - (1 - w)^3`.
/// The widest elements behave like a slider on a spring.
fn coarseness(element_m: f64, contact_m: f64) -> f64 {
    let slider = 1.0 - 1.0 / 3.0_f64.sqrt();
    let w = (0.5 * element_m / contact_m).min(slider);
    1.5 * w.powi(2) - w.powi(3)
}

/// Drag after a press *without* friction, as the closed form assumes: largest difference from
/// Cattaneo and Mindlin, relative to mu N, with the displacement to full slip that follows from the
/// patch's own stiffness in stick. A press with friction leaves tangential forces, which at mu 0.1
/// use up much of the friction limit.
fn off_partial_after_a_smooth_press(bench: &Bench, mu: f64, depth_m: f64, along: &Vector3<f64>) -> f64 {
    const STEP_M: f64 = 1e-6;
    let drag = |friction: f64, step_m: f64, ticks: u32| -> Vec<f64> {
        let bench = bench.clone().with(|p| p.friction = friction as f32);
        let model = bench.patch.wide_model();
        let (mut memory, mut node_step) = (bench.memory(), vec![NodeStep::ZERO; model.nodes.len()]);
        let smooth = Params { friction: 0.0, ..bench.params }.build(&model, &mut node_step).unwrap();
        let mut rig = Rig::new(&model, &bench.params, &mut memory);
        let rough = std::mem::replace(&mut rig.tuned, smooth);
        rig.pressed(depth_m);
        rig.tuned = rough;
        let at = |n: u32| along * (step_m * f64::from(n)) - Vector3::z() * depth_m;
        (1..=ticks).map(|n| parts(&rig.at(at(n)), along)).map(|[slides, push]| slides / (mu * push)).collect()
    };
    let stuck = drag(5.0, 1e-7, 200);
    let slips_m = 1.5 * 1e-5 / (stuck[199] - stuck[99]);
    let slid = drag(mu, STEP_M, (slips_m / STEP_M) as u32);
    let off = slid.iter().zip(1..).map(|(share, n)| share - PartialSlip::share(f64::from(n) * STEP_M / slips_m));
    off.fold(0.0, |worst: f64, off| if off.abs() > worst.abs() { off } else { worst })
}

/// At 130 nodes an element is wider than the contact radius. The tolerance is the unavoidable error
/// at this node spacing plus the error on fine elements.
#[test]
#[ignore = "long: other meshes and coefficients"]
fn partial_slip_is_as_coarse_as_the_elements() {
    /// Deviation from the closed form that `palpate accept` T5 finds on a block of 5000 nodes.
    const FINE: f64 = 0.03;
    let depth_m = 2e-3;
    let mut of_mesh = Vec::new();
    for nodes in [130, 410, 1020] {
        let bench = Bench::calibrated(nodes);
        let contact_m = (depth_m * f64::from(bench.params.probe.radius_m)).sqrt();
        let element_m = bench.patch.element_m();
        let most = FINE + coarseness(element_m, contact_m);
        println!("{nodes} nodes: {:.2} of the contact's radius wide, {most:.3} off at most", element_m / contact_m);
        let mut worst = 0.0_f64;
        for mu in [0.1, 0.3, 0.6] {
            for turned in HEADINGS {
                let off = off_partial_after_a_smooth_press(&bench, mu, depth_m, &heading(turned));
                println!("{nodes} nodes, mu {mu}, heading {turned}: {off:.4} off");
                assert!((-FINE..most).contains(&off), "{nodes} nodes, mu {mu}, heading {turned}: {off} of {most}");
                worst = worst.max(off.abs());
            }
        }
        of_mesh.push(worst);
    }
    assert!(of_mesh.is_sorted_by(|coarse, fine| fine < coarse), "finer elements are not nearer: {of_mesh:?}");
}

/// Tangential stiffness of a flat end that sticks, divided by that of the glued disc of finite
/// elements (1). It is a mean over directions, because the mesh is not isotropic.
fn stuck_over_glued(nodes: usize) -> f64 {
    let bench = Bench::calibrated(nodes).with(|p| (p.friction, p.probe.shape) = (5.0, ProbeShape::Flat));
    let answer = Answer::block();
    let glued = answer.glued.iter().find(|g| g.place_m == [0.0; 3] && g.direction == [1.0, 0.0, 0.0]).unwrap();
    assert!((glued.radius_m - f64::from(bench.params.probe.radius_m)).abs() < 1e-9);
    let right = glued.stiffness_over_e_m * f64::from(bench.params.youngs_modulus_pa);
    let model = bench.patch.wide_model();
    let of = |turned: f64| {
        let mut memory = bench.memory();
        let mut rig = Rig::new(&model, &bench.params, &mut memory);
        let along = heading(turned);
        let [before, _] = parts(&rig.pressed(2e-4), &along);
        let mut last = before;
        for n in 1..=1000 {
            let displacement_m = (2e-7 * f64::from(n)).min(2e-5);
            [last, _] = parts(&rig.at(along * displacement_m - Vector3::z() * 2e-4), &along);
        }
        (last - before) / 2e-5
    };
    HEADINGS.map(of).iter().sum::<f64>() / 3.0 / right
}

#[test]
fn a_probe_that_sticks_is_as_stiff_as_a_glued_disc() {
    for nodes in [130, 410, 1020] {
        let ratio = stuck_over_glued(nodes);
        println!("{nodes} nodes: {ratio:.4} of the glued disc");
        assert!((ratio - 1.0).abs() < 0.03, "{nodes} nodes: {ratio}");
    }
}

/// A probe that is pulled sideways with nine tenths of the friction limit does not move.
#[test]
fn a_hold_does_not_creep() {
    let bench = Bench::calibrated(130).with(|p| p.friction = 0.5);
    let model = bench.patch.wide_model();
    let mut memory = bench.memory();
    let mut rig = Rig::new(&model, &bench.params, &mut memory);
    let output = rig.pressed(2e-3);
    let pull_n = 0.9 * 0.5 * f64::from(output.force_n.z);
    // a massless handle with a damper of 1 N s/m, in double precision
    let (mut x_m, mut last_n, mut settled_m) = (0.0, 0.0, 0.0);
    let mut farthest_m = 0.0_f64;
    for n in 0..65_000 {
        x_m += 1e-3 * (pull_n * (f64::from(n) * 1e-3).min(1.0) + last_n);
        last_n = f64::from(rig.at(Vector3::new(x_m, 0.0, -2e-3)).force_n.x);
        if n == 5000 {
            settled_m = x_m;
        } else if n > 5000 {
            farthest_m = farthest_m.max((x_m - settled_m).abs());
        }
    }
    println!("{:.4} mm after 5 s, {:.4} um in the minute after", settled_m * 1e3, farthest_m * 1e6);
    assert!(settled_m > 1e-4 && farthest_m < 1e-6, "{farthest_m} m");
}

/// Root mean square variation of the force along the path, relative to its mean, while the probe
/// slides at 20 mm/s.
#[test]
fn a_slide_at_20_mm_per_s_is_smooth() {
    let bench = Bench::calibrated(410).with(|p| p.friction = 0.5);
    for turned in HEADINGS {
        let slid = dragged(&bench, 2e-3, &heading(turned), 2e-5, 700);
        let steady = &slid[300..];
        let mean = steady.iter().sum::<f64>() / steady.len() as f64;
        let ripple = (steady.iter().map(|s| (s / mean - 1.0).powi(2)).sum::<f64>() / steady.len() as f64).sqrt();
        println!("heading {turned}: mean {mean:.4} of mu N, ripple {:.2} %", ripple * 100.0);
        assert!(ripple < 0.05 && (mean - 1.0).abs() < 0.04, "heading {turned}: {mean}, {ripple}");
    }
}

/// Smallest work of a hand on the tissue since the start of a contact, and its largest total work,
/// over all ticks [J].
fn work_j(bench: &Bench, seed: u64, ticks: u32) -> [f64; 2] {
    let model = bench.patch.wide_model();
    let mut memory = bench.memory();
    let mut rig = Rig::new(&model, &bench.params, &mut memory);
    let mut noise = Noise::new(seed);
    let swings: [[[f64; 3]; 3]; 3] =
        std::array::from_fn(|_| std::array::from_fn(|_| [noise.uniform(), 1.5 + 1.4 * noise.uniform(), 3.2 * noise.uniform()]));
    let at = |n: u32| {
        let t_s = f64::from(n) * 1e-3;
        let swing = |axis: usize| -> f64 {
            swings[axis].iter().map(|[size, hertz, phase]| size * (std::f64::consts::TAU * hertz * t_s + phase).sin()).sum()
        };
        let begun = (t_s / 0.5).min(1.0);
        Vector3::new(3e-3 * swing(0), 3e-3 * swing(1), 3e-3 * (1.0 - begun) - begun * (1.5e-3 + 1.8e-3 * swing(2)))
    };
    let (mut before, mut work_j, mut range) = ((at(0), Vector3::zeros()), 0.0_f64, [0.0_f64; 2]);
    // from the start of each contact: a contact may not return energy that an earlier one took
    let mut touched_j = 0.0;
    for n in 0..ticks {
        let tip_m = at(n);
        let force_n = rig.at(tip_m).force_n.cast::<f64>();
        work_j -= 0.5 * (force_n + before.1).dot(&(tip_m - before.0));
        if force_n == Vector3::zeros() {
            touched_j = work_j;
        }
        before = (tip_m, force_n);
        range = [range[0].min(work_j - touched_j), range[1].max(work_j)];
    }
    range
}

/// Friction does not lower the stable step. A patch that is pressed to half the radius and dragged
/// there and back comes to rest at one step per tick in ticks that are 15 % longer, sticking or
/// sliding.
#[test]
fn a_dragged_patch_rests_at_a_longer_tick() {
    for (nodes, modulus_pa) in [(130, 3500.0), (130, 100e3), (410, 20e3)] {
        for mu in [0.5, 5.0] {
            let bench = Bench::calibrated(nodes).with(|p| {
                *p = with_tick(&Params { youngs_modulus_pa: modulus_pa, friction: mu, ..*p }, 1.15e-3);
            });
            let model = bench.patch.wide_model();
            let mut memory = bench.memory();
            let mut rig = Rig::new(&model, &bench.params, &mut memory);
            rig.pressed(4e-3);
            for n in 0..130 {
                rig.at(Vector3::new(6e-5 * f64::from(n), 0.0, -4e-3));
            }
            for n in 0..260 {
                rig.at(Vector3::new(7.8e-3 - 6e-5 * f64::from(n), 0.0, -4e-3));
            }
            (0..500).for_each(|_| _ = rig.at(Vector3::new(-7.8e-3, 0.0, -4e-3)));
            let fastest = rig.state.nodes().iter().map(|n| n.velocity_m_per_s().norm()).fold(0.0, f32::max);
            println!("{nodes} nodes, {modulus_pa} Pa, mu {mu}: fastest node {fastest} m/s");
            assert!(fastest < 1e-4, "{nodes} nodes, {modulus_pa} Pa, mu {mu}: {fastest} m/s");
        }
    }
}

const MEAT: [PronyTerm; MOST_TERMS] =
    [PronyTerm { share: 0.26, time_s: 0.4 }, PronyTerm { share: 0.31, time_s: 4.4 }, PronyTerm::NONE];

fn motions_take_energy(seeds: std::ops::Range<u64>, ticks: u32) {
    for (nodes, mu, relaxation) in
        [(60, 0.3, [PronyTerm::NONE; MOST_TERMS]), (129, 1.0, [PronyTerm::NONE; MOST_TERMS]), (60, 0.5, MEAT)]
    {
        let bench = Bench::block(nodes).with(|p| (p.friction, p.relaxation) = (mu, relaxation));
        for seed in seeds.clone() {
            let [least_j, most_j] = work_j(&bench, seed, ticks);
            println!("{nodes} nodes, mu {mu}, motion {seed}: {:.5} .. {:.3} mJ", least_j * 1e3, most_j * 1e3);
            assert!(most_j > 1e-5, "{nodes} nodes, motion {seed}: {most_j} J, nothing was pressed");
            assert!(least_j >= -1e-5, "{nodes} nodes, motion {seed}: {least_j} J");
        }
    }
}

/// A sticking probe that moves in a circle stretches and releases the bristles. Nothing slips, so
/// that no friction loss hides the energy that a cycle would create.
#[test]
fn a_probe_that_sticks_and_circles_gets_nothing() {
    const TICKS: u32 = 250;
    for nodes in [130, 410] {
        let bench = Bench::calibrated(nodes).with(|p| p.friction = 5.0);
        let model = bench.patch.wide_model();
        let mut memory = bench.memory();
        let mut rig = Rig::new(&model, &bench.params, &mut memory);
        rig.pressed(3e-3);
        let at = |n: u32| {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(n) / f64::from(TICKS)).sin_cos();
            Vector3::new(1.5e-4 * sin, 1.5e-4 * (1.0 - cos), -3e-3)
        };
        let mut before = (at(0), rig.at(at(0)).force_n.cast::<f64>());
        for cycle in 0..6 {
            let (mut work_j, mut largest_j) = (0.0_f64, 0.0_f64);
            for n in 1..=TICKS {
                let (tip_m, force_n) = (at(n), rig.at(at(n)).force_n.cast::<f64>());
                work_j -= 0.5 * (force_n + before.1).dot(&(tip_m - before.0));
                largest_j = largest_j.max(work_j.abs());
                before = (tip_m, force_n);
            }
            println!("{nodes} nodes, cycle {cycle}: {work_j:e} J of {largest_j:e} J");
            assert!(largest_j > 1e-8, "{nodes} nodes: {largest_j} J, nothing was stretched");
            assert!(cycle == 0 || work_j >= -0.01 * largest_j, "{nodes} nodes, cycle {cycle}: {work_j} J of {largest_j} J");
        }
    }
}

#[test]
fn random_motions_take_energy() {
    motions_take_energy(0..4, 6000);
}

#[test]
#[ignore = "long: a hundred motions"]
fn random_motions_take_energy_for_long() {
    motions_take_energy(100..200, 12_000);
}

#[test]
fn a_coefficient_that_cannot_be() {
    for (mu, says) in [
        (f32::NAN, "friction = NaN is outside 0 .. 5"),
        (-0.1, "friction = -0.1 is outside 0 .. 5"),
        (5.1, "friction = 5.1 is outside 0 .. 5"),
        (f32::INFINITY, "friction = inf is outside 0 .. 5"),
    ] {
        let refused = Params { friction: mu, ..Params::default() }.check().unwrap_err().to_string();
        assert!(refused.starts_with(says) && refused.contains("choose a value in that range"), "{refused}");
    }
    assert_eq!(Params { friction: 5.0, ..Params::default() }.check(), Ok(()));
}

#[test]
fn a_state_without_bristles_is_a_fault() {
    let bench = Bench::block(60).with(|p| p.friction = 0.5);
    let model = bench.patch.wide_model();
    let (mut nodes, mut candidates) = (vec![Node::ZERO; model.nodes.len()], vec![0; model.triangles.len()]);
    let mut shapes = vec![TetShapes::ZERO; TetShapes::count(&model)];
    let mut node_step = vec![NodeStep::ZERO; model.nodes.len()];
    let tuned = bench.params.build(&model, &mut node_step).unwrap();
    let mut state = State::new(&model, &mut nodes, &mut candidates, &mut shapes).unwrap();
    assert_eq!(tick(&model, &tuned, &mut state, ProbePose { tip_m: at_depth(-1e-3) }).fault, Some(Fault::SizeMismatch));
}

#[test]
fn a_term_that_is_off_leaves_every_bit() {
    let run = |bench: &Bench| {
        let model = bench.patch.wide_model();
        let mut memory = bench.memory();
        let mut rig = Rig::new(&model, &bench.params, &mut memory);
        rig.pressed(3e-3);
        let force_n = rig.at(Vector3::new(1e-3, 0.0, -3e-3)).force_n;
        (rig.state.hash(), force_n.map(f32::to_bits))
    };
    for relaxation in [[PronyTerm::NONE; MOST_TERMS], MEAT] {
        let bench = Bench::block(129).with(|p| p.relaxation = relaxation);
        let off = bench.clone().with(|p| (p.friction, p.terms.friction) = (0.5, false));
        assert_eq!(run(&bench), run(&off));
        assert_ne!(run(&bench), run(&bench.clone().with(|p| p.friction = 0.5)));
    }
}
