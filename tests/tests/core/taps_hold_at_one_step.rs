//! One step per tick is enough for taps of 0.5 m/s to a depth of the probe's radius, held and
//! released, on patches of 130 to 1020 nodes, with a margin of 15 %.
//!
//! `--nocapture` prints the table.

use palpate::stages::probe::ProbePose;
use palpate::{ClampFlags, GuardLimits, Output, Params, tick};
use palpate_tests::bench::{Bench, at_depth};
use palpate_tests::share::Share;
use palpate_tests::tap::{Outcome, Tap};
use palpate_tissue::stable_step::{StableStep, substeps_for_taps, with_tick};

const SIZES: [usize; 3] = [130, 410, 1020];
const DEEP_M: f32 = 8e-3;
const TAP_M_PER_S: f32 = 0.5;
/// Speed of the fastest tap of a hand that holds a stylus [m/s].
const FASTEST_M_PER_S: f32 = 1.0;
const SLOW_M_PER_S: f32 = 0.1;
/// Largest allowed ratio of the peak force to the static force (1).
const PEAK: f64 = 3.0;

fn bench(nodes: usize, youngs_modulus_pa: f32) -> Bench {
    deep(Bench::block(nodes), youngs_modulus_pa)
}

fn deep(bench: Bench, youngs_modulus_pa: f32) -> Bench {
    let mut bench = bench.with(|p| p.youngs_modulus_pa = youngs_modulus_pa);
    bench.patch.set_depth_limit_m(DEEP_M);
    bench
}

fn press(bench: &Bench, params: &Params, speed_m_per_s: f32) -> Outcome {
    Tap { deep_m: DEEP_M.into(), speed_m_per_s: speed_m_per_s.into(), jitter: 0.0 }.run(bench, params)
}

#[test]
fn taps_and_presses_hold_with_a_margin() {
    let mut share = Share::one_in(7);
    for nodes in SIZES {
        for youngs_modulus_pa in [3.5e3, 20e3] {
            for bench in [bench(nodes, youngs_modulus_pa), deep(Bench::calibrated(nodes), youngs_modulus_pa)] {
                let fitted = bench.patch.fitted_places();
                assert_eq!(bench.params.substeps, 1);
                for tick_s in [1e-3, 1.15e-3] {
                    for speed_m_per_s in [SLOW_M_PER_S, TAP_M_PER_S] {
                        if !share.takes() {
                            continue;
                        }
                        let outcome = press(&bench, &with_tick(&bench.params, tick_s), speed_m_per_s);
                        let label = format!(
                            "{nodes} nodes fitted over {fitted} places, {youngs_modulus_pa} Pa, tick {tick_s} s, {speed_m_per_s} m/s: {outcome:?}"
                        );
                        println!("{label}");
                        assert_eq!(outcome.wrong, None, "{label}");
                        assert!(outcome.lowest_j > 0.0, "{label}");
                        assert!(outcome.peak_n <= PEAK * outcome.static_n, "{label}");
                    }
                }
            }
        }
    }
}

#[test]
fn a_session_asks_for_one_step() {
    for nodes in SIZES {
        let bench = bench(nodes, 3.5e3);
        let model = bench.patch.wide_model();
        let stable = StableStep::measure(&model, &bench.params, bench.patch.site_m()).unwrap().unwrap();
        let least = stable.substeps(1e-3) as u16;
        let asked = substeps_for_taps(&model, &bench.params, bench.patch.site_m(), least).unwrap();
        println!("{nodes} nodes: {stable:?}");
        assert_eq!(asked, Some(1), "{nodes} nodes: {stable:?}");
    }
}

#[test]
fn without_the_limit_into_tissue_a_tap_crushes_fine_meshes() {
    let bench = bench(1020, 3.5e3).with(|p| p.limits = GuardLimits::HIGHEST);
    let outcome = press(&bench, &bench.params, FASTEST_M_PER_S);
    assert!(outcome.wrong.is_some() || outcome.lowest_j < 0.0, "the tap is stood without the limit: {outcome:?}");
}

/// The patch receives the depth of a fast tap with a delay during loading, but never during the
/// retreat.
#[test]
fn the_limit_holds_into_the_tissue_only() {
    let bench = bench(1020, 3.5e3);
    let model = bench.patch.wide_model();
    let mut memory = bench.memory();
    let (tuned, mut state) = memory.start(&model, &bench.params).unwrap();
    let step_m = 0.8 * FASTEST_M_PER_S * bench.params.tick_s;
    let most_m = bench.params.limits.max_sink_m_per_s * bench.params.tick_s;
    assert!(most_m < 0.6 * step_m, "the tap is not fast for this patch");
    let mut at = |depth_m: f32| -> Output { tick(&model, &tuned, &mut state, ProbePose { tip_m: at_depth(depth_m) }) };
    let way = (0..300).map(|n| (step_m * n as f32 - 1e-3).min(DEEP_M));
    let shown: Vec<Output> = way.map(&mut at).collect();
    let first = shown.iter().position(|o| o.depth_m > 0.0).expect("a tap that touches");
    assert!(shown[first + 5].limiters.contains(ClampFlags::SPEED));
    // the depth is measured along a normal that tilts as the tissue yields
    let sunk_m = shown[first + 12].depth_m - shown[first + 2].depth_m;
    assert!(sunk_m < 1.1 * 10.0 * most_m, "{sunk_m} m in 10 ticks of at most {most_m}");
    assert!(sunk_m > 0.8 * 10.0 * most_m, "{sunk_m} m in 10 ticks of at most {most_m}");
    let last = shown.last().unwrap();
    assert!((last.depth_m - DEEP_M).abs() < 0.05e-3 && !last.limiters.contains(ClampFlags::SPEED), "it arrives: {last:?}");
    for n in 1..=4 {
        let wanted_m = DEEP_M - step_m * n as f32;
        let out = at(wanted_m);
        assert!(
            !out.limiters.contains(ClampFlags::SPEED) && out.depth_m < wanted_m + 0.1e-3,
            "on the way out at {wanted_m} m: {out:?}"
        );
    }
}
