//! The force limiter bounds length, growth and plausibility of the force.

use palpate::haptic::account::{AccountSettings, EnergyAccount};
use palpate::haptic::cycle::ArmingSettings;
use palpate::haptic::force_limits::{Longest, Plausible, Slew};
use palpate::haptic::gains::Gains;
use palpate::haptic::seen::{Monitor, Seen, Shaper};
use palpate::haptic::stillness::Stillness;
use palpate::{ClampFlags, Fault, Output, Vector3};

use crate::bench::limits;

/// A loop of one stage, the limiter, with the force that it sent last [N].
struct Limiter(Vector3<f32>);

/// Runs one tick of the limiter with this cap [N].
fn capped(limiter: &mut Limiter, wanted_n: [f32; 3], cap_n: f32) -> (Vector3<f32>, ClampFlags) {
    let (limits, mut flags) = (limits(), ClampFlags::default());
    let seen = Seen { sent_n: limiter.0, cap_n, ..Seen::none(&limits) };
    limiter.0 = Slew::build(1e-3).shape(wanted_n.into(), &seen, &mut flags);
    (limiter.0, flags)
}

/// Runs one tick of the limiter with the limit as its cap.
fn limit(limiter: &mut Limiter, wanted_n: [f32; 3]) -> (Vector3<f32>, ClampFlags) {
    capped(limiter, wanted_n, 3.0)
}

/// A limiter whose last force was this one [N], reached at the slew rate.
fn holding(force_n: [f32; 3]) -> Limiter {
    let mut limiter = Limiter(Vector3::zeros());
    (0..20).for_each(|_| _ = limit(&mut limiter, force_n));
    assert!((limiter.0 - Vector3::from(force_n)).norm() < 1e-6);
    limiter
}

/// View of a monitor when the model answers with this force [N].
fn answered(monitor: &mut impl Monitor, force_n: Vector3<f32>) -> Result<(), Fault> {
    let limits = limits();
    monitor.judge(&Seen { output: Output { force_n, ..Output::NONE }, ..Seen::none(&limits) })
}

#[test]
fn a_force_within_every_limit_leaves_as_it_is_and_unflagged() {
    let mut limiter = Limiter(Vector3::zeros());
    assert_eq!(limit(&mut limiter, [0.5, 0.0, 0.0]), (Vector3::new(0.5, 0.0, 0.0), ClampFlags::default()), "growth of one slew");
    let mut at_limit = holding([0.0, 3.0, 0.0]);
    assert_eq!(
        limit(&mut at_limit, [0.0, 3.0, 0.0]),
        (Vector3::new(0.0, 3.0, 0.0), ClampFlags::default()),
        "as long as the limit"
    );
}

#[test]
fn growth_is_limited_and_flagged_in_every_direction() {
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let mut wanted_n = [0.0; 3];
            wanted_n[axis] = 2.0 * sign;
            let mut limiter = Limiter(Vector3::zeros());
            for n in 1..=4_u8 {
                let (force_n, limiters) = limit(&mut limiter, wanted_n);
                assert!(
                    (force_n[axis] - 0.5 * sign * f32::from(n)).abs() < 1e-6
                        && (force_n.norm() - 0.5 * f32::from(n)).abs() < 1e-6
                );
                assert_eq!(limiters.contains(ClampFlags::SLEW), n < 4, "tick {n}");
            }
        }
    }
}

#[test]
fn a_force_that_turns_keeps_what_lies_along_the_new_one_and_grows_from_there() {
    // of the last 2 N along x, as much is kept as the new force along (1, 1) has along x
    let mut limiter = holding([2.0, 0.0, 0.0]);
    let (force_n, limiters) = limit(&mut limiter, [1.0, 1.0, 0.0]);
    assert!((force_n - Vector3::new(1.0, 0.5, 0.0)).norm() < 1e-6, "{force_n}: 1 N along x is kept, 0.5 N are new");
    assert!(limiters.contains(ClampFlags::SLEW) && !limiters.contains(ClampFlags::FORCE));
    // a force opposed to the last one keeps nothing of it
    let mut limiter = holding([2.0, 0.0, 0.0]);
    let (force_n, _) = limit(&mut limiter, [-2.0, 0.0, 0.0]);
    assert!((force_n - Vector3::new(-0.5, 0.0, 0.0)).norm() < 1e-6, "{force_n}");
    // and the kept part is never longer than the last force
    let mut limiter = holding([1.0, 0.0, 0.0]);
    let (force_n, _) = limit(&mut limiter, [2.9, 0.0, 0.0]);
    assert!((force_n.x - 1.5).abs() < 1e-6, "{force_n}");
}

#[test]
fn a_force_that_is_no_longer_wanted_goes_at_once() {
    let mut limiter = holding([0.0, -1.5, 2.0]);
    assert_eq!(limit(&mut limiter, [0.0, -0.75, 1.0]).0, Vector3::new(0.0, -0.75, 1.0));
    assert_eq!(limit(&mut limiter, [0.0; 3]), (Vector3::zeros(), ClampFlags::default()));
}

#[test]
fn the_limit_and_the_cap_keep_the_direction() {
    let mut limiter = holding([2.0, 1.0, 2.0]);
    let (force_n, limiters) = limit(&mut limiter, [4.0, 2.0, 4.0]);
    assert!((force_n - Vector3::new(2.0, 1.0, 2.0)).norm() < 1e-6 && limiters.contains(ClampFlags::FORCE), "{force_n}");
    let (force_n, limiters) = capped(&mut limiter, [2.0, 1.0, 2.0], 1.5);
    assert!((force_n - Vector3::new(1.0, 0.5, 1.0)).norm() < 1e-6 && limiters.contains(ClampFlags::FORCE));
    assert_eq!(capped(&mut limiter, [2.0, 1.0, 2.0], 0.0).0, Vector3::zeros(), "no force");
}

#[test]
fn the_model_force_is_shortened_beyond_the_limit_only() {
    let limits = limits();
    let longest = |force_n: [f32; 3]| {
        let mut flags = ClampFlags::default();
        (Longest.shape(force_n.into(), &Seen::none(&limits), &mut flags), flags.contains(ClampFlags::FORCE))
    };
    assert_eq!(longest([2.0, 1.0, 2.0]), (Vector3::new(2.0, 1.0, 2.0), false));
    let (force_n, shortened) = longest([0.0, -30.0, 40.0]);
    assert!(shortened && (force_n - Vector3::new(0.0, -1.8, 2.4)).norm() < 1e-6, "{force_n}");
}

#[test]
fn an_implausible_force_is_a_fault_only_ten_ticks_in_a_row() {
    let mut plausible = Plausible::default();
    let (implausible_n, large_n) = (Vector3::new(10.0, 0.0, -13.3), Vector3::new(0.0, 9.9, -13.2));
    for _ in 0..3 {
        for _ in 0..9 {
            assert_eq!(answered(&mut plausible, implausible_n), Ok(()));
        }
        assert_eq!(answered(&mut plausible, large_n), Ok(()), "five times the force of the device is plausible");
    }
    assert!((0..20).all(|_| answered(&mut plausible, large_n).is_ok()));
    let borne = (0..20).take_while(|_| answered(&mut plausible, implausible_n).is_ok()).count();
    assert_eq!(borne, 9);
    plausible.reset();
    assert_eq!((0..20).take_while(|_| answered(&mut plausible, implausible_n).is_ok()).count(), 9);
}

#[test]
fn a_force_that_is_not_finite_is_a_fault_at_once() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 3e38] {
        for axis in 0..3 {
            let mut force_n = Vector3::zeros();
            force_n[axis] = bad;
            assert_eq!(answered(&mut Plausible::default(), force_n), Err(Fault::ForceNotFinite), "{bad}");
        }
    }
}

#[test]
fn strain_begins_after_two_hundred_ticks_at_the_limit_and_ends_below_it() {
    let mut gains = Gains::new(&ArmingSettings::DEFAULT);
    let mut strained_after = |force_n: f32| {
        answered(&mut gains, Vector3::zeros()).unwrap();
        (1..400).find(|_| answered(&mut gains, Vector3::new(0.0, 0.0, force_n)).map(|()| gains.strained()) == Ok(true))
    };
    assert_eq!(strained_after(3.0), Some(201));
    assert_eq!(strained_after(2.9985), Some(201), "a model that is limited to the same force rounds below it");
    assert_eq!(strained_after(2.99), None);
}

/// The next of a sequence of numbers between -1 and 1.
fn random(state: &mut u32) -> f32 {
    *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    (*state >> 8) as f32 / 8_388_608.0 - 1.0
}

#[test]
fn after_damping_no_shaper_lengthens_a_force() {
    let (limits, mut seed) = (limits(), 46);
    let device = crate::bench::stylus();
    let mut gains = Gains::new(&ArmingSettings::DEFAULT);
    let (mut stillness, mut slew) = (Stillness::new(&ArmingSettings::DEFAULT, 1e-3), Slew::build(1e-3));
    let mut account = EnergyAccount::build(&AccountSettings::DEFAULT, &device, 1e-3).unwrap();
    let mut changed = [0; 4];
    let (mut position_m, mut last_n) = (Vector3::zeros(), Vector3::zeros());
    for tick in 0..20_000_u32 {
        let mut draw = |scale: f32| Vector3::from_fn(|_, _| random(&mut seed) * scale);
        // now and then the probe rests for so long that a strong force fades
        let rests = tick % 8_000 > 1_500;
        let displacement_m = if rests { Vector3::zeros() } else { draw(0.2e-3) };
        position_m += displacement_m;
        let force_n = draw(4.0);
        let normal = force_n.normalize();
        let touched = tick % 500 > 50;
        let output = Output { force_n, normal, depth_m: 2e-3, ..Output::NONE };
        let cap_n = 1.5 + 1.5 * random(&mut seed);
        let sent_n = if rests { normal * 2.0 } else { last_n };
        let seen = Seen { position_m, displacement_m, output, touched, sent_n, cap_n, ..Seen::none(&limits) };
        account.charge(0, Some(position_m), false);
        let monitors: [&mut dyn Monitor; 3] = [&mut account, &mut gains, &mut stillness];
        let sound = monitors.into_iter().all(|monitor| monitor.judge(&seen).is_ok());
        if !sound {
            account = EnergyAccount::build(&AccountSettings::DEFAULT, &device, 1e-3).unwrap();
        }
        let shapers: [&mut dyn Shaper; 4] = [&mut gains, &mut stillness, &mut slew, &mut account];
        let mut shaped_n = force_n;
        for (shaper, changed) in shapers.into_iter().zip(&mut changed) {
            let before_n = shaped_n;
            shaped_n = shaper.shape(before_n, &seen, &mut ClampFlags::default());
            assert!(shaped_n.norm() <= before_n.norm() * (1.0 + 1e-6), "tick {tick}: {before_n} became {shaped_n}");
            *changed += u32::from(shaped_n != before_n);
        }
        account.sent(shaped_n);
        last_n = shaped_n;
    }
    assert!(changed.iter().all(|ticks| *ticks > 100), "every shaper acted: {changed:?}");
}
