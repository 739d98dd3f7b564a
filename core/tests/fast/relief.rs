//! The force after saturation, or without a count of the encoder, until the contact is over.

use palpate::ClampFlags;
use palpate::haptic::account::AccountSettings;
use palpate::haptic::mode::Mode;

use crate::bench::{Bench, CLEAR_M, pushing, set, stylus};

#[test]
fn a_force_at_its_limit_is_relieved_to_a_half_and_comes_back_with_the_next_contact() {
    let mut bench = Bench::new(400.0).active();
    bench.move_to(-8e-3, 0.05);
    let at_limit = bench.tick();
    assert!((at_limit.applied_n.z - 3.0).abs() < 1e-3 && set(&at_limit, ClampFlags::FORCE), "{}", at_limit.applied_n);
    let degraded = (0..300).find(|_| bench.tick().mode == Mode::Degraded);
    assert!(degraded.is_some_and(|ticks| ticks < 201), "{degraded:?}");
    let mut last_n = bench.tick().applied_n.z;
    assert!(last_n > 2.98, "{last_n}");
    for _ in 0..600 {
        let record = bench.tick();
        assert!(record.applied_n.z <= last_n, "{} after {last_n}", record.applied_n.z);
        assert!(last_n - record.applied_n.z < 3.1e-3 + 1e-5, "evenly, a thousandth per tick");
        last_n = record.applied_n.z;
    }
    assert!((last_n - 1.5).abs() < 1e-3, "{last_n}");
    // a smaller force does not restore the gain, which stays reduced for the whole contact
    bench.move_to(-2e-3, 0.05);
    let record = bench.ticks(300);
    assert!((record.applied_n.z - 0.4).abs() < 1e-3 && record.mode == Mode::Degraded, "{}", record.applied_n);
    assert!(set(&record, ClampFlags::GAIN));
    bench.move_to(CLEAR_M, 0.05);
    assert_eq!(bench.tick().mode, Mode::Active);
    let record = bench.press_n(1.0);
    assert!((record.applied_n.z - 1.0).abs() < 1e-3 && !set(&record, ClampFlags::GAIN));
}

#[test]
fn relief_begins_after_two_hundred_ticks_and_not_below_the_limit() {
    let mut bench = Bench::new(400.0).active();
    bench.wall.answer = Some(pushing(5e-3, 2.9));
    let record = bench.ticks(500);
    assert_eq!((record.mode, set(&record, ClampFlags::GAIN)), (Mode::Active, false));
    bench.wall.answer = Some(pushing(5e-3, 3.1));
    assert!(!set(&bench.ticks(200), ClampFlags::GAIN));
    assert!(set(&bench.tick(), ClampFlags::GAIN), "from the next tick on");
}

#[test]
fn a_strong_force_without_any_motion_of_the_encoder_is_gone_after_six_seconds() {
    let mut bench = Bench::new(400.0).active();
    let still_n = bench.press_n(2.0).applied_n.z;
    let record = bench.ticks(4_800);
    assert_eq!((record.applied_n.z, record.mode), (still_n, Mode::Active));
    let mut last_n = still_n;
    for _ in 0..1_200 {
        let record = bench.tick();
        assert!(record.applied_n.z <= last_n);
        last_n = record.applied_n.z;
    }
    assert_eq!((last_n, bench.cycle.mode()), (0.0, Mode::Degraded));
    // motion in contact does not restore the force, a new contact does
    bench.move_to(-4e-3, 0.05);
    assert_eq!(bench.tick().applied_n.z, 0.0);
    bench.move_to(CLEAR_M, 0.05);
    assert_eq!(bench.cycle.mode(), Mode::Active);
    assert!((bench.press_n(1.0).applied_n.z - 1.0).abs() < 1e-3);
}

#[test]
fn a_force_that_swings_at_rest_becomes_its_lowest_until_the_next_count() {
    let mut bench = Bench::with(400.0, stylus(), |settings| settings.account = AccountSettings::HIGHEST).active();
    let wanted = |n: u16| Some(pushing(1e-3, if (n / 9).is_multiple_of(2) { 0.3 } else { 1.2 }));
    let mut most_n = 0.0_f32;
    for n in 0..800_u16 {
        bench.wall.answer = wanted(n);
        let record = bench.at(if n < 20 { CLEAR_M + 1e-5 * f32::from(n) } else { CLEAR_M });
        if n >= 400 {
            most_n = most_n.max(record.applied_n.z);
        }
    }
    assert!((0.3..0.302).contains(&most_n), "{most_n}");
    assert_eq!(bench.cycle.mode(), Mode::Active, "nothing is taken away for the rest of the contact");
}
