//! Limits are numbers in a range: they act at their stated values and can only be lowered.

use palpate::BuildError;
use palpate::haptic::account::{AccountSettings, EnergyAccount};
use palpate::haptic::cycle::ArmingSettings;
use palpate::haptic::damping::{Damping, DampingSettings, MOST_N_S_PER_M};
use palpate::haptic::device::DeviceSpec;
use palpate::haptic::limits::{LoopLimitSettings, LoopLimits};

use crate::bench::{Bench, TICK_S, limits, stylus};

/// The parameter that an error names.
fn named<T>(answer: Result<T, BuildError>) -> Option<&'static str> {
    match answer {
        Ok(_) => None,
        Err(BuildError::OutOfRange { parameter, .. }) => Some(parameter),
        Err(other) => panic!("{other}"),
    }
}

/// Fails unless `check` accepts `low` and `high`, refuses what lies just outside, and names the
/// parameter.
fn bounds(name: &str, low: f32, high: f32, check: impl Fn(f32) -> Option<&'static str>) {
    let out = 1e-4 * (high - low);
    for inside in [low, high, 0.5 * (low + high)] {
        assert_eq!(check(inside), None, "{name} = {inside}");
    }
    for outside in [low - out, high + out, f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        assert_eq!(check(outside), Some(name), "{name} = {outside}");
    }
}

#[test]
fn every_number_of_a_device_has_its_range() {
    let check = |change: &dyn Fn(&mut DeviceSpec)| {
        let mut device = stylus();
        change(&mut device);
        named(device.check())
    };
    bounds("device.max_force_n", 0.01, 20.0, |x| check(&|d| d.max_force_n = x));
    bounds("device.count_m", 0.0, 1e-3, |x| check(&|d| d.count_m = x));
    bounds("device.lag_s", 0.0, DeviceSpec::MOST_LAG_S, |x| check(&|d| d.lag_s = x));
    for axis in 0..3 {
        let corner = "device.workspace_low_m";
        bounds(corner, -2.0, 2.0, |x| {
            check(&|d| {
                d.workspace_low_m[axis] = x;
                d.workspace_high_m[axis] = x + 0.1;
            })
        });
        let size = "device.workspace size in m";
        bounds(size, 1e-3, 2.0, |x| {
            check(&|d| {
                d.workspace_low_m[axis] = 0.0;
                d.workspace_high_m[axis] = x;
            })
        });
    }
    assert_eq!(check(&|d| d.delay_ticks = 7), None);
    assert_eq!(check(&|d| d.delay_ticks = 8), Some("device.delay_ticks"));
}

#[test]
fn the_delay_is_whole_ticks_and_the_lag() {
    let device = DeviceSpec { delay_ticks: 3, lag_s: 0.5e-3, ..stylus() };
    assert!((device.delay_s(2e-3) - 6.5e-3).abs() < 1e-9);
}

#[test]
fn no_limit_is_higher_than_the_highest() {
    let highest = LoopLimitSettings { max_force_n: 3.3, ..LoopLimitSettings::HIGHEST };
    let built = LoopLimits::build(&highest, &stylus(), TICK_S).unwrap();
    assert_eq!(built.values(), &highest);
    let strong = DeviceSpec { max_force_n: 20.0, ..stylus() };
    assert!(LoopLimits::build(&LoopLimitSettings::HIGHEST, &strong, TICK_S).is_ok());
    let check = |change: &dyn Fn(&mut LoopLimitSettings)| {
        let mut values = highest;
        change(&mut values);
        named(LoopLimits::build(&values, &stylus(), TICK_S))
    };
    bounds("limits.max_force_n", 1e-6, 3.3, |x| check(&|v| v.max_force_n = x));
    bounds("limits.max_slew_n_per_s", 1e-6, 5_000.0, |x| check(&|v| v.max_slew_n_per_s = x));
    bounds("limits.max_speed_m_per_s", 1e-6, 3.0, |x| check(&|v| v.max_speed_m_per_s = x));
    bounds("limits.workspace_margin", 0.0, 0.25, |x| check(&|v| v.workspace_margin = x));
    bounds("limits.implausible_ratio", 1.0, 10.0, |x| check(&|v| v.implausible_ratio = x));
    let counts: [(&str, u16, fn(&mut LoopLimitSettings) -> &mut u16); 4] = [
        ("limits.odd_poses", 3, |v| &mut v.odd_poses),
        ("limits.max_age_ticks", 5, |v| &mut v.max_age_ticks),
        ("limits.implausible_ticks", 20, |v| &mut v.implausible_ticks),
        ("limits.saturated_ticks", 1_000, |v| &mut v.saturated_ticks),
    ];
    for (name, most, pick) in counts {
        for (count, refused) in [(0, true), (1, false), (most, false), (most + 1, true)] {
            assert_eq!(check(&|v| *pick(v) = count), refused.then_some(name), "{count}");
        }
    }
    bounds("tick_s", 1e-4, 1e-2, |x| named(LoopLimits::build(&LoopLimitSettings::DESKTOP, &stylus(), x)));
    let no_device = DeviceSpec { lag_s: -1.0, ..stylus() };
    assert_eq!(named(LoopLimits::build(&LoopLimitSettings::DESKTOP, &no_device, TICK_S)), Some("device.lag_s"));
}

#[test]
fn lowered_limits_keep_the_device_and_the_tick() {
    let lower = LoopLimitSettings { max_force_n: 1.0, workspace_margin: 0.0, ..LoopLimitSettings::DESKTOP };
    let limits = LoopLimits::build(&LoopLimitSettings::DESKTOP, &stylus(), 2e-3).unwrap();
    let lowered = limits.lowered(&lower).unwrap();
    assert_eq!(lowered.values(), &lower);
    assert!((lowered.ticks_per_s() - 500.0).abs() < 1e-3);
    assert_eq!(named(lowered.lowered(&LoopLimitSettings::DESKTOP)), Some("limits.max_force_n"));
    assert_eq!(LoopLimitSettings::default(), LoopLimitSettings::DESKTOP);
}

#[test]
fn every_number_of_the_damping_has_its_range() {
    let check = |change: &dyn Fn(&mut DampingSettings)| {
        let mut settings = DampingSettings::safe(1e-3, TICK_S);
        change(&mut settings);
        named(settings.check()).or(named(Damping::build(&settings, TICK_S, 0.0)))
    };
    bounds("damping.tau_s", 0.0, 0.05, |x| check(&|s| s.tau_s = x));
    bounds("damping.constant_n_s_per_m", 0.0, MOST_N_S_PER_M, |x| check(&|s| s.constant_n_s_per_m = x));
    bounds("damping.velocity_share", 1e-3, 1.0, |x| check(&|s| s.velocity_share = x));
    bounds("tick_s", 1e-4, 1e-2, |x| named(Damping::build(&DampingSettings::NONE, x, 0.0)));
    bounds("device.count_m", 0.0, 1e-3, |x| named(Damping::build(&DampingSettings::NONE, TICK_S, x)));
}

#[test]
fn every_number_of_the_account_has_its_range() {
    let check = |change: &dyn Fn(&mut AccountSettings)| {
        let mut settings = AccountSettings::DEFAULT;
        change(&mut settings);
        named(EnergyAccount::build(&settings, &stylus(), 1e-3))
    };
    bounds("account.allowance_j", 0.0, 1e3, |x| check(&|s| s.allowance_j = x));
    bounds("account.refill_w", 0.0, 1e3, |x| check(&|s| s.refill_w = x));
    bounds("account.acceleration_m_per_s2", 0.0, 200.0, |x| check(&|s| s.acceleration_m_per_s2 = x));
    bounds("account.handle_share", 0.0, 1.0, |x| check(&|s| s.handle_share = x));
    let slow = DeviceSpec { delay_ticks: 8, ..stylus() };
    assert_eq!(named(EnergyAccount::build(&AccountSettings::DEFAULT, &slow, 1e-3)), Some("device.delay_ticks"));
}

#[test]
fn every_number_of_arming_has_its_range() {
    let check = |change: &dyn Fn(&mut ArmingSettings)| {
        let mut settings = ArmingSettings::default();
        change(&mut settings);
        named(settings.check())
    };
    bounds("arming.weak_n", f32::MIN_POSITIVE, 0.5, |x| check(&|s| s.weak_n = x));
    bounds("arming.slow_m_per_s", f32::MIN_POSITIVE, 0.5, |x| check(&|s| s.slow_m_per_s = x));
    bounds("arming.ramp_in_per_tick", 1e-5, 0.02, |x| check(&|s| s.ramp_in_per_tick = x));
    bounds("arming.relief_per_tick", 1e-5, 0.02, |x| check(&|s| s.relief_per_tick = x));
    bounds("arming.least_relief", 0.0, 0.9, |x| check(&|s| s.least_relief = x));
    let counts: [(&str, [u16; 2], fn(&mut ArmingSettings) -> &mut u16); 3] = [
        ("arming.calm_ticks", [4, 10_000], |s| &mut s.calm_ticks),
        ("arming.silence_ticks", [1, 20], |s| &mut s.silence_ticks),
        ("arming.ramp_ticks", [1, 125], |s| &mut s.ramp_ticks),
    ];
    for (name, [least, most], pick) in counts {
        for (count, refused) in [(least - 1, true), (least, false), (most, false), (most + 1, true)] {
            assert_eq!(check(&|s| *pick(s) = count), refused.then_some(name), "{count}");
        }
    }
}

#[test]
fn an_error_carries_the_value_and_the_range() {
    let values = LoopLimitSettings { max_force_n: 9.0, ..LoopLimitSettings::DESKTOP };
    let least = match limits().lowered(&values) {
        Err(BuildError::OutOfRange { parameter: "limits.max_force_n", value: 9.0, min, max: 3.0 }) => min,
        other => panic!("{other:?}"),
    };
    assert!(least > 0.0 && least < 1e-3);
    assert_eq!(limits().values().max_force_n, 3.0, "nothing has changed");
}

#[test]
fn a_device_that_was_not_commissioned_pushes_with_half_a_newton_at_most_and_is_still_felt() {
    let unknown = DeviceSpec { commissioned: false, ..stylus() };
    let mut bench = Bench::with(400.0, unknown, |_| ()).active();
    let mut most_n = 0.0_f32;
    // up to 6 N of the wall, far beyond five times half a newton
    for n in 0..600_u16 {
        let record = bench.at(-15e-3 * f32::from(n) / 600.0);
        assert_eq!(record.fault, None, "tick {n}");
        most_n = most_n.max(record.applied_n.norm());
    }
    assert!(most_n > 0.4 && most_n <= 0.5 + 1e-6, "{most_n} N");
    assert!(bench.cycle.lower_limits(&LoopLimitSettings { max_force_n: 1.0, ..*bench.cycle.limits() }).is_err());
}
