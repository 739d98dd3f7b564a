//! Effects of one tick on the pins and on the watchdog.

use palpate::Fault;
use palpate::haptic::cycle::{Ask, Command};
use palpate::haptic::mode::Mode;
use palpate_controller::controller::Arming;
use palpate_controller::force_out::{DacCode, Outputs};
use palpate_controller::haptic_loop::HapticLoop;
use palpate_controller::link::Record;
use palpate_controller::port::Port;

use super::mock::{Mock, Slab, at, haptic_loop, haptic_loop_on};

/// Ticks until the full force: start-up, calm ticks and ramp-in.
const START_UP_TICKS: u32 = 700;

struct Bench {
    haptic: HapticLoop<Mock>,
    tick: u32,
}

impl Bench {
    /// A loop with the force enabled and the tip a millimetre above the surface.
    fn active() -> Self {
        let mut bench = Self { haptic: haptic_loop(Arming::ByItself), tick: 0 };
        for _ in 0..START_UP_TICKS {
            bench.tick(1e-3);
        }
        assert_eq!(bench.haptic.controller.mode(), Mode::Active);
        bench
    }

    /// An active loop that presses 2 mm deep with some 0.6 N.
    fn pressing() -> Self {
        let mut bench = Self::active();
        for n in 0..200 {
            bench.tick(1e-3 - 3e-3 * (n as f32 / 200.0));
        }
        let pressed = bench.tick(-2e-3);
        assert!(pressed.enabled && pressed.applied_n[2] > 0.3, "{pressed:?}");
        bench
    }

    fn tick(&mut self, z_m: f32) -> Record {
        self.ask(z_m, Command::HEARD)
    }

    fn ask(&mut self, z_m: f32, command: Command) -> Record {
        self.tick += 1;
        self.haptic.board.period = self.tick;
        self.haptic.tick(&mut Slab, at(z_m, self.tick), command, Some(self.tick))
    }
}

#[test]
fn only_the_self_test_waits_for_the_board_s_check() {
    let checks = Bench::active().haptic.board.checks.get();
    assert!((1..=5).contains(&checks), "{checks} checks");
}

#[test]
fn a_tick_puts_the_force_on_the_pins_and_feeds_the_watchdog() {
    let mut bench = Bench::pressing();
    let fed = bench.haptic.board.fed;
    let record = bench.tick(-2e-3);
    assert_eq!(bench.haptic.board.pins, Outputs { enabled: true, codes: record.codes.map(DacCode) });
    assert_eq!(bench.haptic.board.fed, fed + 1);
    assert_eq!(bench.haptic.board.milliseconds, bench.tick);
    assert_eq!((bench.haptic.seen().ticks, bench.haptic.seen().overruns), (bench.tick, 0));
}

#[test]
fn pins_that_do_not_hold_what_they_were_told_are_off_unfed_and_a_fault_in_the_next_tick() {
    let stuck = [
        Outputs { enabled: true, codes: [DacCode(1_000); 3] },
        Outputs { enabled: true, codes: Outputs::UNKNOWN },
        Outputs { enabled: false, codes: [DacCode(0), DacCode(0), DacCode(1)] },
    ];
    for pins in stuck {
        let mut bench = Bench::pressing();
        let fed = bench.haptic.board.fed;
        bench.haptic.board.stuck = Some(pins);
        let record = bench.tick(-2e-3);
        assert_eq!(bench.haptic.board.pins, Outputs::OFF, "{pins:?}");
        assert_eq!((record.enabled, record.codes), (false, [0; 3]), "{pins:?}");
        assert_eq!(bench.haptic.board.fed, fed, "{pins:?}");
        bench.haptic.board.stuck = None;
        let next = bench.tick(-2e-3);
        assert_eq!((next.mode(), next.fault(), next.enabled), (Some(Mode::Fault), Some(Fault::SelfTestFailed), false));
        assert_eq!(bench.haptic.board.fed, fed + 1, "off and as told: the watchdog is fed again");
    }
}

#[test]
fn pins_that_stay_on_starve_the_watchdog_for_ever() {
    let mut bench = Bench::pressing();
    bench.haptic.board.stuck = Some(Outputs { enabled: true, codes: [DacCode(1_000); 3] });
    let fed = bench.haptic.board.fed;
    for _ in 0..50 {
        bench.tick(-2e-3);
        assert_eq!(bench.haptic.board.pins, Outputs::OFF, "it keeps trying to turn them off");
    }
    assert_eq!(bench.haptic.board.fed, fed);
}

#[test]
fn one_late_tick_halves_the_next_force_and_two_in_a_row_turn_the_outputs_off() {
    let mut bench = Bench::pressing();
    let before = bench.tick(-2e-3);
    bench.haptic.board.late = 1;
    let late = bench.tick(-2e-3);
    assert!(late.enabled, "a late force is fresher than the one on the pins");
    assert_eq!((bench.haptic.board.dropped, bench.haptic.seen().overruns), (1, 1));
    bench.haptic.board.late = 0;
    let next = bench.tick(-2e-3);
    assert!(next.enabled && next.applied_n[2] <= 0.51 * before.applied_n[2], "{before:?}\n{next:?}");

    let mut bench = Bench::pressing();
    bench.haptic.board.late = 1;
    bench.tick(-2e-3);
    let second = bench.tick(-2e-3);
    assert!(!second.enabled && bench.haptic.board.pins == Outputs::OFF, "{second:?}");
    bench.haptic.board.late = 0;
    let next = bench.tick(-2e-3);
    assert_eq!((next.mode(), next.fault()), (Some(Mode::Fault), Some(Fault::DeadlineMissed)));
}

#[test]
fn periods_without_a_tick_are_counted_by_their_numbers() {
    let mut bench = Bench::active();
    bench.tick += 3;
    bench.tick(1e-3);
    assert_eq!(bench.haptic.seen().missed_periods, 3);
    assert_eq!(bench.haptic.seen().starts, Some([7, 7]), "counts from the timer's edge to the tick");
}

#[test]
fn every_fault_of_the_board_is_no_force_in_the_same_tick() {
    type Happens = fn(&mut Mock);
    let faults: [(Happens, Fault); 2] = [
        (|board| board.supply_low = true, Fault::SupplyLow),
        (|board| board.stop = Some(Fault::EmergencyStop), Fault::EmergencyStop),
    ];
    for (happens, fault) in faults {
        let mut bench = Bench::pressing();
        happens(&mut bench.haptic.board);
        let record = bench.tick(-2e-3);
        assert_eq!((record.mode(), record.fault(), record.enabled), (Some(Mode::Fault), Some(fault), false));
        assert_eq!(bench.haptic.board.pins, Outputs::OFF);
    }
}

#[test]
fn a_board_that_is_not_healthy_never_arms() {
    let mut bench = Bench { haptic: haptic_loop(Arming::ByItself), tick: 0 };
    bench.haptic.board.healthy = false;
    for _ in 0..START_UP_TICKS {
        assert!(!bench.tick(1e-3).enabled);
    }
    assert_eq!(bench.haptic.seen().fault, Some(Fault::SelfTestFailed));
}

#[test]
fn a_released_operator_switch_of_the_board_ends_the_force_and_without_its_pin_the_host_s_word_counts() {
    for pin in [Some(true), None] {
        let port = Port::DESKTOP.with_operator_switch(true);
        let mut bench = Bench { haptic: haptic_loop_on(port, Arming::OnRequest), tick: 0 };
        let absent = Command { operator_absent: pin.is_none(), ..Command::HEARD };
        bench.haptic.board.operator_absent = pin.map(|_| false);
        for n in 0..START_UP_TICKS {
            let asked = (n == 100).then_some(Ask::Arm);
            bench.ask(1e-3, Command { asked, ..Command::HEARD });
        }
        for n in 0..200 {
            bench.tick(1e-3 - 3e-3 * (n as f32 / 200.0));
        }
        assert!(bench.tick(-2e-3).applied_n[2] > 0.3, "{pin:?}");
        bench.haptic.board.operator_absent = pin;
        let ramped = (0..200).map(|_| bench.ask(-2e-3, absent)).last().unwrap();
        assert_eq!((ramped.applied_n, ramped.enabled), ([0.0; 3], false), "{pin:?}");
        assert_ne!(bench.haptic.controller.mode(), Mode::Active);
    }
}
