//! The force limiter bounds length, growth and plausibility of the force.

use palpate::haptic::limits::ForceLimiter;
use palpate::{ClampFlags, Fault, Vector3};

use crate::bench::limits;

/// Runs one tick of the limiter with a cap that never acts.
fn limit(limiter: &mut ForceLimiter, wanted_n: [f32; 3]) -> (Vector3<f32>, ClampFlags) {
    let limited = limiter.limit(&limits(), wanted_n.into(), 20.0).unwrap();
    (limited.force_n, limited.limiters)
}

/// A limiter whose last force was this one [N], reached at the slew rate.
fn holding(force_n: [f32; 3]) -> ForceLimiter {
    let mut limiter = ForceLimiter::default();
    (0..20).for_each(|_| _ = limit(&mut limiter, force_n));
    assert!((limiter.last_n() - Vector3::from(force_n)).norm() < 1e-6);
    limiter
}

#[test]
fn a_force_within_every_limit_leaves_as_it_is_and_unflagged() {
    let mut limiter = ForceLimiter::default();
    assert_eq!(limit(&mut limiter, [0.5, 0.0, 0.0]), (Vector3::new(0.5, 0.0, 0.0), ClampFlags::default()), "growth of one slew");
    assert_eq!(limiter.last_n(), Vector3::new(0.5, 0.0, 0.0));
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
            let mut limiter = ForceLimiter::default();
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
    let capped = limiter.limit(&limits(), Vector3::new(2.0, 1.0, 2.0), 1.5).unwrap();
    assert!((capped.force_n - Vector3::new(1.0, 0.5, 1.0)).norm() < 1e-6 && capped.limiters.contains(ClampFlags::FORCE));
    assert_eq!(limiter.limit(&limits(), Vector3::new(2.0, 1.0, 2.0), 0.0).unwrap().force_n, Vector3::zeros(), "no force");
}

#[test]
fn the_model_force_is_shortened_beyond_the_limit_only() {
    let limits = limits();
    assert_eq!(ForceLimiter::shorten(&limits, &Vector3::new(2.0, 1.0, 2.0)), (Vector3::new(2.0, 1.0, 2.0), false));
    let (force_n, shortened) = ForceLimiter::shorten(&limits, &Vector3::new(0.0, -30.0, 40.0));
    assert!(shortened && (force_n - Vector3::new(0.0, -1.8, 2.4)).norm() < 1e-6, "{force_n}");
}

#[test]
fn release_forgets_the_last_force() {
    let mut limiter = holding([0.0, 0.0, 3.0]);
    limiter.release();
    assert_eq!(limiter.last_n(), Vector3::zeros());
    assert!((limit(&mut limiter, [0.0, 0.0, 3.0]).0.z - 0.5).abs() < 1e-6, "it grows from nothing");
}

#[test]
fn an_implausible_force_is_a_fault_only_ten_ticks_in_a_row() {
    let (limits, mut limiter) = (limits(), ForceLimiter::default());
    let implausible_n = Vector3::new(9.1, 0.0, -12.1);
    for _ in 0..3 {
        for _ in 0..9 {
            assert_eq!(limiter.judge(&limits, &implausible_n), Ok(()));
        }
        assert_eq!(limiter.judge(&limits, &Vector3::new(0.0, 9.0, -12.0)), Ok(()), "five times the limit is plausible");
    }
    assert!((0..20).all(|_| limiter.judge(&limits, &Vector3::new(0.0, 9.0, -12.0)).is_ok()));
    let borne = (0..20).take_while(|_| limiter.judge(&limits, &implausible_n).is_ok()).count();
    assert_eq!(borne, 9);
}

#[test]
fn a_force_that_is_not_finite_is_a_fault_at_once() {
    let limits = limits();
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 3e38] {
        for axis in 0..3 {
            let mut force_n = Vector3::zeros();
            force_n[axis] = bad;
            assert_eq!(ForceLimiter::default().judge(&limits, &force_n), Err(Fault::ForceNotFinite), "judged {bad}");
            assert_eq!(ForceLimiter::default().limit(&limits, force_n, 1.0), Err(Fault::ForceNotFinite), "limited {bad}");
        }
        if bad > 1e38 || bad.is_nan() {
            let capped = ForceLimiter::default().limit(&limits, Vector3::x(), bad);
            assert_eq!(capped.is_err(), !bad.is_finite(), "a cap of {bad}");
        }
    }
}

#[test]
fn strain_begins_after_two_hundred_ticks_at_the_limit_and_ends_below_it() {
    let (limits, mut limiter) = (limits(), ForceLimiter::default());
    let mut strained_after = |force_n: f32| {
        limiter.judge(&limits, &Vector3::zeros()).unwrap();
        (1..400)
            .find(|_| limiter.judge(&limits, &Vector3::new(0.0, 0.0, force_n)).map(|()| limiter.strained(&limits)) == Ok(true))
    };
    assert_eq!(strained_after(3.0), Some(201));
    assert_eq!(strained_after(2.9985), Some(201), "a model that is limited to the same force rounds below it");
    assert_eq!(strained_after(2.9), None);
}
