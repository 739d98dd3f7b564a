//! The stable step that the desktop computes is correct: within it taps and presses return to rest,
//! and beyond it they do not.
//!
//! `--nocapture` prints the distance between this bound and the step at which a press fails.

use palpate_tests::bench::Bench;
use palpate_tests::share::Share;
use palpate_tests::tap::{Outcome, Tap};
use palpate_tissue::stable_step::{StableStep, substeps_for_taps};

fn bench(nodes: usize, youngs_modulus_pa: f32, depth_limit_m: f32) -> Bench {
    let mut bench = Bench::block(nodes).with(|p| p.youngs_modulus_pa = youngs_modulus_pa);
    bench.patch.set_depth_limit_m(depth_limit_m);
    bench
}

fn measured(bench: &Bench) -> StableStep {
    let model = bench.patch.wide_model();
    StableStep::measure(&model, &bench.params, bench.patch.site_m()).unwrap().expect("a patch that survives being measured")
}

/// Number of substeps that a session chooses for the patch.
fn asked(bench: &Bench) -> u16 {
    let least = measured(bench).substeps(1e-3) as u16;
    let model = bench.patch.wide_model();
    substeps_for_taps(&model, &bench.params, bench.patch.site_m(), least).unwrap().expect("a patch that stands taps")
}

/// Presses to the depth limit, holds and moves out.
fn press(bench: &Bench, speed_m_per_s: f64) -> Outcome {
    let deep_m = bench.patch.model().depth_limit_m.into();
    Tap { deep_m, speed_m_per_s, jitter: 0.0 }.run(bench, &bench.params)
}

const TAP_M_PER_S: f64 = 0.5;
const SLOW_M_PER_S: f64 = 0.04;

#[test]
fn within_the_step_taps_and_presses_end_as_they_began() {
    let mut share = Share::one_in(5);
    for nodes in [60, 129, 410] {
        for youngs_modulus_pa in [3.5e3, 100e3] {
            for depth_limit_m in [4e-3, 5e-3, 6e-3, 8e-3] {
                if !share.takes() {
                    continue;
                }
                let bench = bench(nodes, youngs_modulus_pa, depth_limit_m);
                let stable = measured(&bench);
                let substeps = asked(&bench);
                let bench = bench.with(|p| p.substeps = substeps);
                let label = format!("{nodes} nodes, {youngs_modulus_pa} Pa, {depth_limit_m} m: {stable:?}, {substeps} substeps");
                for speed_m_per_s in [TAP_M_PER_S, SLOW_M_PER_S] {
                    let outcome = press(&bench, speed_m_per_s);
                    println!("{label}, {speed_m_per_s} m/s: J down to {:.3}", outcome.lowest_j);
                    assert_eq!(outcome.wrong, None, "{label}, {speed_m_per_s} m/s");
                    assert!(outcome.lowest_j > 0.0, "{label}, {speed_m_per_s} m/s: J = {}", outcome.lowest_j);
                }
            }
        }
    }
}

#[test]
fn pressed_tissue_needs_a_shorter_step() {
    // tets are stiffer under a probe that is pressed as deep as its radius
    for nodes in [60, 129, 410] {
        let stable = measured(&bench(nodes, 3.5e3, 8e-3));
        assert!(stable.pressed_s < 0.95 * stable.rest_s, "{nodes} nodes: {stable:?}");
    }
}

/// Lighter nodes have a shorter stable step, while the number of substeps stays one per tick. The
/// step at which the press fails is the dynamic limit.
#[test]
fn past_the_step_they_do_not() {
    let mut share = Share::one_in(5);
    for (nodes, youngs_modulus_pa, depth_limit_m) in
        [(60, 3.5e3, 5e-3), (410, 3.5e3, 4e-3), (410, 3.5e3, 8e-3), (129, 100e3, 8e-3), (129, 3.5e3, 5e-3)]
    {
        if !share.takes() {
            continue;
        }
        let with_floor = |mass_floor: f32| {
            bench(nodes, youngs_modulus_pa, depth_limit_m).with(|p| {
                p.mass_floor = mass_floor;
                p.density_kg_per_m3 = 1.0;
            })
        };
        let wrong = |bench: &Bench| press(bench, TAP_M_PER_S).wrong.or_else(|| press(bench, SLOW_M_PER_S).wrong);
        let (mut good, mut bad) = (16.0_f32, 0.05_f32);
        assert_eq!(wrong(&with_floor(good)), None);
        assert!(wrong(&with_floor(bad)).is_some(), "{nodes} nodes stand a mass floor of {bad}");
        while good / bad > 1.02 {
            let middle = (good * bad).sqrt();
            match wrong(&with_floor(middle)) {
                None => good = middle,
                Some(_) => bad = middle,
            }
        }
        let (at_limit, with_room) = (asked(&with_floor(bad)), asked(&with_floor(4.0 * good)));
        let why = wrong(&with_floor(bad)).unwrap_or_default();
        println!(
            "{nodes} nodes, {youngs_modulus_pa} Pa, {depth_limit_m} m: 1 ms goes wrong at mass floor {bad:.2} ({why}): {at_limit} substeps asked, {with_room} at four times that floor; bound there {:.3} ms",
            measured(&with_floor(bad)).pressed_s * 1e3
        );
        assert!(at_limit > 1, "{nodes} nodes: {why} with the one substep that is asked for");
        // the bound must not be more than a factor of two too low, or it would waste substeps
        assert_eq!(with_room, 1, "{nodes} nodes: more than one substep at four times the floor at which one goes wrong");
    }
}
