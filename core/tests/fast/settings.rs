//! Settings that are safe on any device.

use palpate::haptic::cycle::{ArmingSettings, Cycle, Settings};
use palpate::haptic::damping::DampingSettings;
use palpate::haptic::device::DeviceSpec;
use palpate::haptic::limits::LoopLimitSettings;

use crate::bench::stylus;

#[test]
fn safe_settings_stay_within_the_device() {
    for (device_n, limit_n) in [(3.3, 3.0), (12.0, 3.0), (3.0, 3.0), (0.9, 0.9)] {
        let device = DeviceSpec { max_force_n: device_n, ..stylus() };
        let settings = Settings::safe(&device);
        assert_eq!(settings.limits, LoopLimitSettings { max_force_n: limit_n, ..LoopLimitSettings::DESKTOP });
        assert!(Cycle::build(&settings, &device).is_ok());
    }
    let settings = Settings::safe(&stylus());
    assert_eq!((settings.tick_s, settings.arming), (1e-3, ArmingSettings::DEFAULT));
}

#[test]
fn safe_damping_follows_the_delay() {
    for (delay_ticks, lag_s, tau_s, constant) in
        [(0, 0.0, 1e-3, 0.3), (1, 0.0, 3e-3, 0.3), (2, 0.0, 5e-3, 0.6), (1, 2e-3, 7e-3, 0.9)]
    {
        let damping = Settings::safe(&DeviceSpec { delay_ticks, lag_s, ..stylus() }).damping;
        assert!((damping.tau_s - tau_s).abs() < 1e-8, "{delay_ticks} ticks and {lag_s} s: tau {}", damping.tau_s);
        assert!((damping.constant_n_s_per_m - constant).abs() < 1e-6, "{delay_ticks} ticks and {lag_s} s");
        assert_eq!(damping.velocity_share, DampingSettings::SHARE_30_HZ);
    }
}

#[test]
fn a_cycle_is_not_built_from_a_setting_out_of_range() {
    let bad: [fn(&mut Settings); 5] = [
        |s| s.arming.calm_ticks = 3,
        |s| s.damping.tau_s = 1.0,
        |s| s.account.handle_share = 1.1,
        |s| s.limits.max_force_n = 3.4,
        |s| s.tick_s = 0.1,
    ];
    for change in bad {
        let mut settings = Settings::safe(&stylus());
        change(&mut settings);
        assert!(Cycle::build(&settings, &stylus()).is_err(), "{settings:?}");
    }
}
