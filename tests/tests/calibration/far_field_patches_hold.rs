//! Calibrated patches with a far field withstand presses and taps at one step per tick, with a
//! stability margin, with jitter and with nodules, and return to rest.
//!
//! `--nocapture` prints the table.

use palpate_tests::bench::Bench;
use palpate_tests::far_patch::FarPatch;
use palpate_tests::share::Share;
use palpate_tests::tap::{Outcome, Tap};
use palpate_tissue::budget::MACHINES;
use palpate_tissue::scene::Inclusion;
use palpate_tissue::session::Session;
use palpate_tissue::stable_step::with_tick;

const DEEP_M: f32 = 8e-3;
/// Patch radius and element size [m], which give 68 and 117 nodes.
const SIZES: [(f64, f64); 2] = [(0.017, 0.0052), (0.018, 0.0039)];
const MODULI_PA: [f32; 3] = [3.5e3, 20e3, 100e3];
const SPEEDS_M_PER_S: [f64; 2] = [0.1, 0.5];
const MARGIN: f32 = 1.15;
/// Largest allowed ratio of the peak force to the static force (1).
const PEAK: f64 = 3.0;
/// A nodule 12 mm below the site, and one that crosses the rim.
const INSIDE: Inclusion = Inclusion { center_m: [0.0, 0.0, -0.012], radius_m: 0.006, stiffness_ratio: 10.0, stiffening_b: None };
const ACROSS: Inclusion =
    Inclusion { center_m: [0.012, 0.0, -0.012], radius_m: 0.006, stiffness_ratio: 10.0, stiffening_b: None };

fn tap(speed_m_per_s: f64, jitter: f64) -> Tap {
    Tap { deep_m: DEEP_M.into(), speed_m_per_s, jitter }
}

fn check(bench: &Bench, tap: &Tap, margin: f32, what: &str) -> Outcome {
    let outcome = tap.run(bench, &with_tick(&bench.params, margin * bench.params.tick_s));
    let nodes = bench.patch.model().nodes.len();
    let e = bench.params.youngs_modulus_pa;
    println!("{nodes} nodes {what}, {e} Pa, {} m/s, jitter {}, margin {margin}: {outcome:?}", tap.speed_m_per_s, tap.jitter);
    outcome
}

fn holds(bench: &Bench, tap: &Tap, margin: f32, what: &str) {
    let outcome = check(bench, tap, margin, what);
    assert_eq!(outcome.wrong, None, "{what}: {tap:?} at {margin} ms");
    assert!(outcome.peak_n <= PEAK * outcome.static_n, "{what}: {outcome:?}");
}

#[test]
fn presses_and_taps_hold_with_a_margin_and_jitter() {
    let mut share = Share::one_in(5);
    for (radius_m, fine_m) in SIZES {
        let patch = FarPatch::quick(radius_m, fine_m);
        for youngs_modulus_pa in MODULI_PA {
            let bench = patch.bench(DEEP_M).with(|p| p.youngs_modulus_pa = youngs_modulus_pa);
            for speed_m_per_s in SPEEDS_M_PER_S {
                for (margin, jitter) in [(1.0, 0.5), (MARGIN, 0.0), (MARGIN, 0.5)] {
                    if !share.takes() {
                        continue;
                    }
                    holds(&bench, &tap(speed_m_per_s, jitter), margin, "homogeneous");
                }
            }
        }
    }
}

#[test]
fn lumps_inside_and_across_the_rim_hold() {
    let mut share = Share::one_in(5);
    for (radius_m, fine_m) in SIZES {
        let patch = FarPatch::quick(radius_m, fine_m);
        for (what, lump) in [("lump inside", INSIDE), ("lump across the rim", ACROSS)] {
            let (soft, _) = patch.with_balls(&[lump], DEEP_M);
            for youngs_modulus_pa in MODULI_PA {
                let bench = soft.clone().with(|p| p.youngs_modulus_pa = youngs_modulus_pa);
                for speed_m_per_s in SPEEDS_M_PER_S {
                    if !share.takes() {
                        continue;
                    }
                    holds(&bench, &tap(speed_m_per_s, 0.5), MARGIN, what);
                }
            }
        }
    }
}

#[test]
fn a_session_asks_for_one_step() {
    for (radius_m, fine_m) in SIZES {
        let bench = FarPatch::quick(radius_m, fine_m).bench(DEEP_M);
        let session = Session::of_fitted(&MACHINES[0], bench.patch, bench.params).unwrap();
        println!("{radius_m} m: {:?}", session.stable);
        assert_eq!(session.params.substeps, 1, "{:?}", session.stable);
    }
}

/// Negative control: at twice the step a tap is not stable, so the tests above do detect a step
/// that is too long.
#[test]
fn a_step_twice_as_long_does_not_hold() {
    let (radius_m, fine_m) = SIZES[0];
    let bench = FarPatch::quick(radius_m, fine_m).bench(DEEP_M);
    let outcome = check(&bench, &tap(SPEEDS_M_PER_S[1], 0.0), 2.0, "homogeneous");
    assert!(outcome.wrong.is_some(), "{outcome:?}");
}
