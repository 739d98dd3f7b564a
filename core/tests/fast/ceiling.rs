//! A contact that is stiffer than the device renders.

use palpate::ClampFlags;
use palpate::haptic::ceiling::gain;
use palpate::haptic::device::DeviceSpec;

use super::bench::{Bench, set, stylus};

/// Force and flag of a press of 1 mm on a wall of 800 N/m, on a device with this ceiling [N/m].
fn pressed(stiffness_ceiling_n_per_m: f32, stiffness_n_per_m: f32) -> (f32, bool) {
    let mut bench = Bench::with(800.0, DeviceSpec { stiffness_ceiling_n_per_m, ..stylus() }, |_| ());
    bench.wall.stiffness_n_per_m = stiffness_n_per_m;
    let mut bench = bench.active();
    for n in 0..200_u8 {
        bench.at(-5e-6 * f32::from(n));
    }
    bench.at(-1e-3);
    let record = bench.ticks(300);
    (record.applied_n.z, set(&record, ClampFlags::GAIN))
}

#[test]
fn it_is_weakened_to_the_ceiling_and_the_record_says_so() {
    for (ceiling, stiffness, force_n) in [(400.0, 800.0, 0.4), (200.0, 800.0, 0.2), (400.0, 1_600.0, 0.2)] {
        let (found_n, gained) = pressed(ceiling, stiffness);
        assert!((found_n - force_n).abs() < 1e-3 && gained, "{ceiling} {stiffness}: {found_n} N");
    }
    for (ceiling, stiffness) in [(800.0, 800.0), (1e5, 800.0), (400.0, 0.0)] {
        let (found_n, gained) = pressed(ceiling, stiffness);
        assert!((found_n - 0.8).abs() < 1e-3 && !gained, "{ceiling} {stiffness}: {found_n} N");
    }
}

#[test]
fn a_contact_is_weakened_and_never_stiffened() {
    for (stiffness, most, right) in [(400.0, 200.0, 0.5), (200.0, 400.0, 1.0), (400.0, 400.0, 1.0), (0.0, 400.0, 1.0)] {
        assert_eq!(gain(stiffness, most), right, "{stiffness} of {most}");
    }
}

#[test]
fn what_is_on_its_way_lowers_the_ceiling_of_a_light_handle() {
    let ceiling = |delay_ticks, lag_s, mass_kg, count_m| {
        let device =
            DeviceSpec { delay_ticks, lag_s, mass_kg, count_m, stiffness_ceiling_n_per_m: 1_000.0, ..DeviceSpec::STYLUS };
        device.ceiling_n_per_m(1e-3)
    };
    for (delay_ticks, lag_s, mass_kg, count_m, right) in [
        (1, 1e-3, 0.045, 0.0, 1_000.0),
        (7, 2e-3, 0.045, 0.0, 150.0),
        (7, 2e-3, 0.09, 0.0, 300.0),
        (4, 5e-3, 0.09, 0.0, 300.0),
        (3, 0.0, 0.03, 0.0, 625.0),
        (3, 0.0, 0.03, 100e-6, 600.0),
        (7, 2e-3, 0.045, 100e-6, 150.0),
        (1, 1e-3, 0.045, 100e-6, 600.0),
    ] {
        let found = ceiling(delay_ticks, lag_s, mass_kg, count_m);
        assert!((found / right - 1.0_f32).abs() < 1e-4, "{delay_ticks} ticks, {lag_s} s, {mass_kg} kg: {found} N/m");
    }
}

#[test]
fn the_gain_does_not_follow_a_stiffness_that_changes_under_the_hand() {
    let mut bench = Bench::with(800.0, DeviceSpec { stiffness_ceiling_n_per_m: 400.0, ..stylus() }, |_| ());
    bench.wall.stiffness_n_per_m = 800.0;
    let mut bench = bench.active();
    for n in 0..=200_u8 {
        bench.at(-5e-6 * f32::from(n));
    }
    for changed in [100.0, 8_000.0] {
        bench.wall.stiffness_n_per_m = changed;
        let force_n = bench.ticks(300).applied_n.z;
        assert!((force_n - 0.4).abs() < 1e-3, "{changed} N/m: {force_n} N");
    }
}
