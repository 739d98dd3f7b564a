//! The bound on the energy given that the loop states and the one that the watch derives are the
//! same, on any device.

use palpate::haptic::account::{AccountSettings, EnergyAccount};
use palpate::haptic::device::DeviceSpec;
use palpate_loop::closed_loop::watch::PortBound;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

const TICK_S: f32 = 1e-3;

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, rng_seed: RngSeed::Fixed(11), cases: 2000, ..ProptestConfig::default() })]

    #[test]
    fn the_bound_that_is_stated_and_the_bound_that_is_watched_agree(
        max_force_n in 0.01_f32..20.0, count_m in 0.0_f32..1e-3, delay_ticks in 0_u8..=7, lag_s in 0.0_f32..10e-3, mass_kg in 1e-3_f32..5.0,
    ) {
        let device = DeviceSpec { max_force_n, count_m, delay_ticks, lag_s, mass_kg, ..DeviceSpec::STYLUS };
        let settings = AccountSettings::DEFAULT;
        let stated = EnergyAccount::bound(&settings, &device, TICK_S, 0);
        let watched = PortBound::of(&device);
        let close = |a: f32, b: f64| (f64::from(a) - b).abs() <= 1e-5 * b;
        prop_assert!(close(stated.at_once_j, watched.at_once_j), "{stated:?}, {watched:?}");
        prop_assert!(close(stated.lasting_w, watched.lasting_w), "{stated:?}, {watched:?}");
    }
}
