//! Late ticks: one is tolerated with half the force, more are a fault.

use palpate::haptic::cycle::Command;
use palpate::haptic::deadline::Deadline;
use palpate::haptic::mode::Mode;
use palpate::{ClampFlags, Fault, Vector3};

use crate::bench::{Bench, set};

#[test]
fn the_fifth_late_tick_within_a_second_is_a_fault() {
    let faults_at = |every: u32| {
        let mut deadline = Deadline::default();
        (0..6_000).find(|n| deadline.judge(u16::from(n % every == 0)).is_err())
    };
    assert_eq!(faults_at(2), Some(8));
    assert_eq!(faults_at(249), Some(996));
    assert_eq!(faults_at(250), None, "four among any thousand");
}

#[test]
fn two_missed_periods_in_a_row_are_a_fault_together_or_one_by_one() {
    for (late, fault) in [([2, 0], true), ([9, 0], true), ([1, 1], true), ([1, 0], false), ([0, 1], false)] {
        let mut deadline = Deadline::default();
        let answers = late.map(|ticks| deadline.judge(ticks));
        assert_eq!(answers.contains(&Err(Fault::DeadlineMissed)), fault, "{late:?}");
        for (ticks, answer) in late.iter().zip(answers) {
            assert!(answer.is_err() || answer == Ok(*ticks == 1), "{late:?}");
        }
    }
}

#[test]
fn a_late_tick_leaves_half_of_the_force() {
    let mut bench = Bench::new(400.0).active();
    assert!((bench.press_n(2.0).applied_n.z - 2.0).abs() < 1e-3);
    let record = bench.late(1);
    assert!((record.applied_n.z - 1.0).abs() < 1e-3, "{}", record.applied_n);
    assert!(set(&record, ClampFlags::GAIN) && record.mode == Mode::Active);
    assert!((bench.tick().applied_n.z - 1.5).abs() < 1e-3, "back at the slew");
    assert!((bench.tick().applied_n.z - 2.0).abs() < 1e-3);
    // a force that falls is not held at half of the last one
    let mut bench = Bench::new(400.0).active();
    bench.press_n(2.0);
    bench.device.sensed.position_m.z = -2.5e-3;
    assert!(bench.late(1).applied_n.z <= 0.4);
}

#[test]
fn late_ticks_count_only_while_the_patch_runs() {
    let mut bench = Bench::new(400.0).idle();
    assert!((0..20).all(|_| bench.late(3).fault.is_none()));
    let mut bench = Bench::new(400.0).active();
    let record = bench.late(2);
    assert_eq!((record.fault, record.applied_n, bench.device.drive_n), (Some(Fault::DeadlineMissed), Vector3::zeros(), None));
}

#[test]
fn after_a_late_tick_the_hand_may_have_come_as_much_further() {
    for (late_ticks, held) in [(1, false), (0, true)] {
        let mut bench = Bench::new(100.0).active();
        bench.press_n(1.0);
        // 2.6 mm: two periods at 1.3 m/s, or one at a speed that no hand has
        bench.device.sensed.position_m.x += 2.6e-3;
        let record = bench.run(Command { late_ticks, ..Command::HEARD });
        assert_eq!(set(&record, ClampFlags::HELD), held, "{late_ticks} periods missed");
        assert_eq!(record.fault, None);
    }
}
