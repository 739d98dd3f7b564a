//! After any failure the device receives no force, and the reason is reported until a reset.
//! Whatever is commanded, the force stays within the limit.

use palpate::stages::probe::ProbePose;
use palpate::{BuildError, ClampFlags, Fault, GuardLimits, Output, Params, State, Tuned, Vector3, tick};
use palpate_tests::bench::{Bench, at_depth};
use palpate_tissue::patch::Memory;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

fn pose(tip_m: Vector3<f32>) -> ProbePose {
    ProbePose { tip_m }
}

/// Starts a patch: `start!(bench => model, tuned, state)`.
macro_rules! start {
    ($bench:expr => $model:ident, $tuned:ident, $state:ident) => {
        let $model = $bench.patch.wide_model();
        let mut memory = $bench.memory();
        let ($tuned, mut $state) = memory.start(&$model, &$bench.params).unwrap();
    };
}

/// Presses from outside to a depth at 40 mm/s and holds; 200 ticks in all.
fn press(bench: &Bench, tuned: &Tuned, state: &mut State, depth_m: f32) -> Output {
    let model = bench.patch.wide_model();
    (0..200_u8)
        .fold(Output::NONE, |_, n| tick(&model, tuned, state, pose(at_depth((-0.5e-3 + 40e-6 * f32::from(n)).min(depth_m)))))
}

/// Checks that the fault is reported with its number and without a force, that it remains for good
/// poses, and that a reset clears it.
fn latched_until_reset(bench: &Bench, tuned: &Tuned, state: &mut State, output: Output, fault: Fault, number: u8) {
    let model = bench.patch.wide_model();
    assert_eq!(fault as u8, number);
    assert!(fault.to_string().starts_with(&format!("fault {number}: ")));
    let silent = Output { fault: Some(fault), ..Output::NONE };
    assert_eq!(output, silent);
    for depth_m in [1e-3, 0.0, -0.1] {
        assert_eq!(tick(&model, tuned, state, pose(at_depth(depth_m))), silent);
        assert_eq!(state.fault(), Some(fault));
    }
    state.reset(&model);
    assert_eq!(state.fault(), None);
    let output = press(bench, tuned, state, 1e-3);
    assert_eq!((output.fault, output.limiters), (None, ClampFlags::default()));
    assert!(output.force_n.z > 0.01, "{output:?}");
}

#[test]
fn a_pose_that_is_no_number() {
    let bench = Bench::block(129);
    start!(bench => model, tuned, state);
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for axis in 0..3 {
            assert!(press(&bench, &tuned, &mut state, 2e-3).force_n.z > 0.01);
            let mut tip_m = at_depth(2e-3);
            tip_m[axis] = bad;
            let output = tick(&model, &tuned, &mut state, pose(tip_m));
            latched_until_reset(&bench, &tuned, &mut state, output, Fault::PoseNotFinite, 1);
            state.reset(&model);
        }
    }
}

#[test]
fn a_node_that_is_no_number_or_too_fast() {
    let bench = Bench::block(129);
    start!(bench => model, tuned, state);
    // a free node under the probe; its position and its velocity are corrupted in turn
    let under = (0..model.nodes.len()).min_by(|a, b| {
        let away = |n: usize| Vector3::from(model.nodes[n].rest_m).norm();
        away(*a).total_cmp(&away(*b))
    });
    let under = under.unwrap();
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30, -3e38] {
        for place in [true, false] {
            press(&bench, &tuned, &mut state, 2e-3);
            let node = &state.nodes()[under];
            let (mut x, mut v) = (node.position_m(), node.velocity_m_per_s());
            *(if place { &mut x } else { &mut v }) = Vector3::new(0.0, bad, 0.0);
            state.place(under, x, v);
            let output = tick(&model, &tuned, &mut state, pose(at_depth(2e-3)));
            assert_eq!(output.force_n, Vector3::zeros(), "{bad}, place {place}: {output:?}");
            latched_until_reset(&bench, &tuned, &mut state, output, Fault::Diverged, 2);
            state.reset(&model);
        }
    }
}

#[test]
fn an_anchor_that_is_no_number() {
    let bench = Bench::block(129);
    start!(bench => model, tuned, state);
    press(&bench, &tuned, &mut state, 2e-3);
    // it pulls its neighbours to infinity, while it does not move itself
    state.place(model.anchors[0].into(), Vector3::repeat(f32::NAN), Vector3::zeros());
    let output = tick(&model, &tuned, &mut state, pose(at_depth(2e-3)));
    assert_eq!(output, Output { fault: Some(Fault::Diverged), ..Output::NONE });
}

#[test]
fn state_parameters_and_model_of_different_sizes() {
    let (small, large) = (Bench::block(60), Bench::block(129));
    start!(small => small_model, small_tuned, small_state);
    let large_model = large.patch.wide_model();
    let mut large_memory = Memory::for_model(&large_model);
    let (large_tuned, mut large_state) = large_memory.start(&large_model, &large.params).unwrap();
    let tip = pose(at_depth(1e-3));
    for output in
        [tick(&large_model, &large_tuned, &mut small_state, tip), tick(&small_model, &small_tuned, &mut large_state, tip)]
    {
        assert_eq!(output, Output { fault: Some(Fault::SizeMismatch), ..Output::NONE });
    }
    large_state.reset(&large_model);
    assert_eq!(tick(&large_model, &small_tuned, &mut large_state, tip).fault, Some(Fault::SizeMismatch));
    small_state.reset(&small_model);
    let output = tick(&small_model, &large_tuned, &mut small_state, tip);
    latched_until_reset(&small, &small_tuned, &mut small_state, output, Fault::SizeMismatch, 4);
}

#[test]
fn a_probe_that_starts_inside_gives_no_force_before_it_has_been_outside() {
    let bench = Bench::block(129);
    start!(bench => model, tuned, state);
    for n in 0..50 {
        let output = tick(&model, &tuned, &mut state, pose(at_depth(3e-3)));
        assert_eq!((output.force_n, output.depth_m), (Vector3::zeros(), 0.0), "tick {n}");
        assert!(output.limiters.contains(ClampFlags::BURIED) && output.fault.is_none());
    }
    // out at 0.1 m/s, and in again
    for n in 0..40_u8 {
        let output = tick(&model, &tuned, &mut state, pose(at_depth(3e-3 - 1e-4 * f32::from(n))));
        assert_eq!(output.force_n, Vector3::zeros(), "on the way out");
    }
    let output = press(&bench, &tuned, &mut state, 3e-3);
    assert_eq!(output.limiters, ClampFlags::default());
    assert!(output.force_n.z > 0.01);
}

#[test]
fn a_teleport_in_free_space_is_followed_and_one_into_the_tissue_is_walked_at_the_speed_limit() {
    let bench = Bench::block(129);
    start!(bench => model, tuned, state);
    tick(&model, &tuned, &mut state, pose(at_depth(-1e-3)));
    for away in
        [Vector3::new(0.0, 0.0, -1e3), Vector3::new(1e3, 0.0, 0.0), Vector3::new(0.0, 3e38, -3e38), Vector3::new(0.0, 0.0, 1e3)]
    {
        for n in 0..50 {
            let output = tick(&model, &tuned, &mut state, pose(away));
            assert!(output.fault.is_none() && output.outside && output.apart_m == 0.0, "{away:?} tick {n}: {output:?}");
            assert!(output.force_n == Vector3::zeros() && output.point_m == away, "{output:?}");
        }
    }
    // distances beyond the range of single precision
    state.reset(&model);
    for far in [3e38, -3e38] {
        let output = tick(&model, &tuned, &mut state, pose(Vector3::repeat(far)));
        assert!(output.fault.is_none() && output.point_m == Vector3::repeat(far), "{output:?}");
    }
    // the speed limit is 1 mm per tick; without contact, the reported point is the tip that the
    // patch was given
    state.reset(&model);
    tick(&model, &tuned, &mut state, pose(at_depth(-3e-3)));
    for n in 1..=2_u8 {
        let output = tick(&model, &tuned, &mut state, pose(at_depth(4e-3)));
        assert!(output.limiters.contains(ClampFlags::SPEED) && output.force_n == Vector3::zeros(), "{output:?}");
        assert!((output.point_m.z - (3e-3 - 1e-3 * f32::from(n))).abs() < 1e-6, "tick {n}: {output:?}");
        assert!((output.apart_m - (7e-3 - 1e-3 * f32::from(n))).abs() < 1e-6, "tick {n}: {output:?}");
    }
    // a jump by more than a radius passes the surface without contact: no force until a fresh
    // approach
    state.reset(&model);
    tick(&model, &tuned, &mut state, pose(at_depth(-0.01)));
    tick(&model, &tuned, &mut state, pose(at_depth(5e-3)));
    for n in 0..50 {
        let output = tick(&model, &tuned, &mut state, pose(at_depth(5e-3)));
        assert!(output.limiters.contains(ClampFlags::BURIED) && output.force_n == Vector3::zeros(), "tick {n}: {output:?}");
    }
}

#[test]
fn the_probe_is_held_at_the_depth_limit() {
    let bench = Bench::block(129);
    start!(bench => model, tuned, state);
    let limit_m = model.depth_limit_m;
    let at_limit = press(&bench, &tuned, &mut state, limit_m);
    let mut deepest = at_limit;
    for n in 0..400_u16 {
        deepest = tick(&model, &tuned, &mut state, pose(at_depth((limit_m + 40e-6 * f32::from(n)).min(3.0 * limit_m))));
        // the limit acts along the previous tick's contact normal, which comes from a rounded point
        // on the undeformed surface
        assert!(deepest.depth_m - deepest.apart_m <= limit_m * 1.001, "{n}: {deepest:?}");
    }
    assert!(deepest.limiters.contains(ClampFlags::DEPTH) && !at_limit.limiters.contains(ClampFlags::DEPTH));
    let more = deepest.force_n.norm() / at_limit.force_n.norm();
    assert!(more > 1.5, "beyond the limit the force goes on rising, to {more} of that at the limit");
}

#[test]
fn the_force_limit_shortens_and_does_not_turn() {
    let free = Bench::block(129);
    let limited = Bench::block(129).with(|p| p.limits.max_force_n = 0.02);
    let off_axis = |n: u8| Vector3::new(1e-5 * f32::from(n), -2e-5 * f32::from(n), 0.5e-3 - 2e-5 * f32::from(n));
    start!(free => model, tuned, state);
    let mut limited_memory = limited.memory();
    let (limited_tuned, mut limited_state) = limited_memory.start(&model, &limited.params).unwrap();
    let mut shortened = 0;
    for n in 0..200 {
        let whole = tick(&model, &tuned, &mut state, pose(off_axis(n)));
        let short = tick(&model, &limited_tuned, &mut limited_state, pose(off_axis(n)));
        // the tissue is in the same state: only the output is limited
        assert_eq!(whole.normal, short.normal);
        if whole.force_n.norm() > 0.02 {
            shortened += 1;
            assert!(short.limiters.contains(ClampFlags::FORCE));
            // a product and a norm: a few ulp
            assert!((short.force_n.norm() - 0.02).abs() < 1e-8, "{short:?}");
            assert!(short.force_n.cross(&whole.force_n).norm() < 1e-6 * short.force_n.norm() * whole.force_n.norm());
            assert!(short.force_n.dot(&whole.force_n) > 0.0);
        } else {
            assert_eq!((short.force_n, short.limiters), (whole.force_n, whole.limiters));
        }
    }
    assert!((50..190).contains(&shortened), "{shortened}");
}

#[test]
fn nothing_raises_the_limits() {
    let bench = Bench::block(60);
    let model = bench.patch.wide_model();
    let mut memory = bench.memory();
    let highest = GuardLimits::HIGHEST;
    for bad in [1.000_001, 2.0, f32::INFINITY, f32::NAN, -1.0] {
        for speed in [true, false] {
            let (max_speed_m_per_s, max_force_n) = match speed {
                true => (highest.max_speed_m_per_s * bad, highest.max_force_n),
                false => (highest.max_speed_m_per_s, highest.max_force_n * bad),
            };
            let params = Params { limits: GuardLimits { max_speed_m_per_s, max_force_n, ..highest }, ..bench.params };
            let refused = memory.start(&model, &params).map(|_| ()).unwrap_err();
            let wanted = if speed { "limits.max_speed_m_per_s" } else { "limits.max_force_n" };
            assert!(matches!(refused, BuildError::OutOfRange { parameter, .. } if parameter == wanted), "{refused}");
        }
    }
}

/// A broken device: any finite pose, jumps, jitter, sometimes near the tissue.
fn poses() -> impl Strategy<Value = Vec<[f32; 3]>> {
    let any = prop_oneof![
        6 => [-0.03_f32..0.03, -0.03..0.03, -0.02..0.01],
        2 => [-1e-4_f32..1e-4, -1e-4..1e-4, -8e-3..2e-3],
        1 => [-1e3_f32..1e3, -1e3..1e3, -1e3..1e3],
        1 => [finite(), finite(), finite()],
    ];
    prop::collection::vec((any, 1_usize..12), 1..40)
        .prop_map(|legs| legs.into_iter().flat_map(|(pose, ticks)| vec![pose; ticks]).collect())
}

fn finite() -> impl Strategy<Value = f32> {
    any::<f32>().prop_filter("finite", |x| x.is_finite())
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, rng_seed: RngSeed::Fixed(9), cases: 120, ..ProptestConfig::default() })]

    #[test]
    fn no_stream_of_poses_gives_more_than_the_limit(poses in poses(), stiff: bool) {
        let bench = Bench::block(60).with(|p| {
            p.youngs_modulus_pa = if stiff { 100e3 } else { 3.5e3 };
            p.limits.max_force_n = 1.5;
        });
        start!(bench => model, tuned, state);
        // a distant probe is outside
        tick(&model, &tuned, &mut state, pose(at_depth(-0.03)));
        for tip in poses {
            let output = tick(&model, &tuned, &mut state, pose(tip.into()));
            let length = output.force_n.norm();
            // normalised and multiplied: three roundings
            prop_assert!(length <= 1.5 * (1.0 + 1e-6), "{output:?}");
            prop_assert!(output.depth_m.is_finite() && output.point_m.iter().all(|c| c.is_finite()) && output.normal.iter().all(|c| c.is_finite()));
            prop_assert_eq!(output.fault.is_some(), state.fault().is_some());
            prop_assert!(output.fault.is_none() || length == 0.0);
        }
    }
}
