//! The unchanged images that are flashed on the real boards run on models of their chips'
//! registers (`tests/unicorn`). Each boots with its outputs off, feeds the watchdog, arms over the
//! frames of the link, and presses bit-identically to the desktop's controller. After a hang, a
//! hard fault, late ticks and an open stop circuit the pins are off.
//!
//! The models execute instructions and emulate registers. They do not measure time and do not
//! replace hardware.

use std::path::Path;

use palpate::Fault;
use palpate::haptic::cycle::Settings;
use palpate::haptic::device::{HapticDevice, SensorStatus};
use palpate::haptic::mode::Mode;
use palpate_board::desktop_board::DesktopBoard;
use palpate_controller::config::Profile;
use palpate_controller::controller::{Arming, Controller};
use palpate_controller::force_out::{DacCode, bridge::Bridge};
use palpate_controller::haptic_loop::HapticLoop;
use palpate_controller::link::inbox::Reply;
use palpate_controller::link::message::HostAsk;
use palpate_controller::link::{FromBoard, Inbox, Receiver, Record, Refusal, ToBoard};
use palpate_controller::patch::{Memory, Patch};
use palpate_controller::port::Port;
use palpate_controller::probe_in::{EncoderCounts, JointReading, Reading};
use palpate_controller::script;
use palpate_sim::port::device_file;
use palpate_tests::firmware_image::FirmwareImage;
use palpate_tests::joint_hand::counts_at;
use palpate_tests::palpate_command::repository;
use palpate_tests::register_model::{Flashed, Journal, Period, Row, Scenario, run};
use palpate_tests::share::long;
use serde_json::{Value, json};

use crate::flashed_periods::{self, TRACED};

/// Periods between two heartbeats of the host.
const HEARTBEAT: u32 = 5;
/// Period in which the host declares the home pose of a board without a profile, and period in
/// which the hand leaves that pose for the script's start.
const SHOWN_AT: u32 = 12;
const LEAVES_AT: u32 = 20;
/// Period in which the host requests the force.
const ARM_AT: u32 = 40;
/// Ticks outside the tissue: arming, force ramp, and the transfer of the bytes.
const LEAD_TICKS: u32 = script::LEAD_TICKS + 50;
/// Ticks up to the hold of the tap. The long form of the test continues through the slide.
pub const PRESSED_TICKS: u32 = LEAD_TICKS + 100;
/// Longest time that a force may act after the last completed tick [ms].
const OFF_MS: u32 = 5;

pub fn target() -> &'static Path {
    Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap()
}

/// Message of a host that sends heartbeats, reads the log and requests the force once.
fn host(period: u32, arm_at: u32) -> Option<ToBoard<'static>> {
    match period {
        _ if period == arm_at => Some(ToBoard::Ask(HostAsk::Arm)),
        _ if period.is_multiple_of(10 * HEARTBEAT) => Some(ToBoard::Listen(true)),
        _ if period.is_multiple_of(HEARTBEAT) => Some(ToBoard::Heartbeat),
        _ => None,
    }
}

/// Input of the scripted hand on three axes with counts of 10 um.
pub fn axes(periods: u32) -> Vec<Period> {
    let counts = |period: u32| {
        let share = period.saturating_sub(LEAVES_AT).min(10) as i32;
        script::counts(period, LEAD_TICKS).map(|axis| axis.0 * share / 10)
    };
    let says = |period| if period == SHOWN_AT { Some(ToBoard::Home) } else { host(period, ARM_AT) };
    (0..periods).map(|period| Period { counts: counts(period), says: says(period), late: 0 }).collect()
}

/// Runs the desktop's controller on the bytes that the image received on its UART, tick by tick.
fn on_desktop(board: Flashed, profile: Option<&Profile>, periods: &[Period], rows: &[Row]) -> Vec<Record> {
    let mut memory = Box::new(Memory::RESERVED);
    let mut patch = Patch::open(board.patch(), &mut memory, None).unwrap();
    let unknown = || (Settings::safe(&Port::DESKTOP.limits()), Port::DESKTOP.without_home());
    let (settings, port) = profile.map_or_else(unknown, Profile::split);
    let controller = Controller::build(&settings, port, Arming::OnRequest).unwrap();
    let mut haptic = HapticLoop::new(DesktopBoard::default(), controller);
    let (mut receiver, mut inbox) = (Receiver::NEW, Inbox::default());
    let mut records = Vec::new();
    for ((period, row), sequence) in periods.iter().zip(rows).zip(1..) {
        let (_, command) = inbox.clear();
        let newest =
            Reading::Joints(JointReading { counts: period.counts.map(EncoderCounts), sequence, status: SensorStatus::Good });
        records.push(haptic.tick(&mut patch, newest, command, None));
        patch.settle(haptic.controller.in_contact());
        // a board reads its link after it has written the force
        for byte in &row.taken {
            let message = match receiver.push::<ToBoard<'_>>(*byte) {
                Some(Ok(message)) => message,
                Some(Err(_)) if profile.is_some() => continue, // cut by the restart
                Some(Err(error)) => panic!("{error:?}"),
                None => continue,
            };
            match inbox.take(&message, &mut haptic.controller, None) {
                Reply::None | Reply::Listen(_) => {}
                Reply::Home => assert!(haptic.controller.show_home(&newest)),
                other => panic!("{other:?}"),
            }
        }
    }
    records
}

/// Runs the image through a scenario without further events; `None` if the model is not available.
fn press(board: Flashed, periods: &[Period]) -> Option<Journal> {
    run(target(), board, &Scenario { periods, more: Value::Null })
}

/// Checks that the image's pins and records equal the desktop's to the bit, from the restart on in
/// which it stored a profile, if there was one. Returns the desktop's records and the image's other
/// messages.
fn agree(board: Flashed, profile: Option<&Profile>, periods: &[Period], journal: &Journal) -> (Vec<Record>, Vec<FromBoard>) {
    let (started, resets) = (&journal.started, 1 + u64::from(profile.is_some()));
    // the start-up belongs to the row after the one of the reset
    let first = journal.rows.iter().position(|row| row.resets == resets).unwrap() + usize::from(profile.is_some());
    let (before, rows) = journal.rows.split_at(first);
    let periods = &periods[first..];
    assert!(before.iter().all(Row::is_off));
    assert!(started.is_off() && started.fed > 0, "start-up drives nothing and begins to feed the watchdog");
    assert_eq!(started.lost, 0, "a peripheral is written only once it has its clock");
    assert!((4.0..=f64::from(OFF_MS)).contains(&journal.watchdog_ms), "{} ms", journal.watchdog_ms);
    let records = on_desktop(board, profile, periods, rows);
    let mut last = [Bridge { steps: 0, reverse: false }; 3];
    for (n, (row, record)) in rows.iter().zip(&records).enumerate() {
        assert_eq!((row.enable, row.main_output), (record.enabled, record.enabled), "period {n}");
        let bridges = record.codes.map(|code| Bridge::of(DacCode(code), journal.period_steps));
        for (axis, bridge) in bridges.iter().enumerate() {
            let there = (row.steps[axis], row.reverse[axis]);
            assert_eq!(there, (bridge.steps.into(), bridge.reverse), "period {n}, axis {axis}");
        }
        let ended = last.iter().zip(bridges).filter(|(last, next)| last.passes_zero(*next)).count() as u64;
        // a timer of an STM32 carries three axes, so a restart would cut the pulses of the others
        let restarts = if board == Flashed::Pico2 { ended } else { 0 };
        let of_start = u64::from(n == 0 && profile.is_some());
        assert_eq!(row.restarts, restarts + of_start, "period {n}: {ended} pulses had to end");
        last = bridges;
        assert!(row.fed > 0 && row.resets == resets, "period {n}");
        assert!(record.enabled || row.is_off(), "period {n}: something drove the pins meanwhile");
    }
    // and the records that it sent over its UART
    let (mut told, mut others) = (0, Vec::new());
    for message in Journal::messages(rows) {
        match message {
            FromBoard::Record(there) => {
                let here = records.iter().find(|record| record.tick == there.tick).unwrap();
                assert_eq!(there.first_difference(here), None, "tick {}", there.tick);
                told += 1;
            }
            FromBoard::Log(_) => {} // see `begins`
            other => others.push(other),
        }
    }
    assert!(told > rows.len() / 2 - 5, "{told} records");
    (records, others)
}

/// Checks that the first lines of the log contain the given words, one entry per line.
pub fn begins(lines: &[String], words: &[&str]) {
    let agree = lines.len() >= words.len() && lines.iter().zip(words).all(|(line, words)| line.contains(words));
    assert!(agree, "{lines:#?} do not begin with {words:#?}");
}

fn felt(records: &[Record]) -> f32 {
    let largest_n = records.iter().map(|record| record.applied_n[2]).fold(0.0, f32::max);
    assert_eq!(records.last().unwrap().mode(), Some(Mode::Active));
    assert!(largest_n > 0.05, "the press of 4 mm was not felt: {largest_n} N");
    largest_n
}

/// Boots, arms and presses.
fn presses_like_the_desktop(board: Flashed) {
    let periods = axes(if long() { LEAD_TICKS + 2_000 } else { PRESSED_TICKS });
    let more = json!({"trace": periods.len() - TRACED});
    let Some(journal) = run(target(), board, &Scenario { periods: &periods, more }) else { return };
    let (records, others) = agree(board, None, &periods, &journal);
    assert_eq!(others, [FromBoard::Homed]);
    let told = [
        "started after power-on or the reset button",
        "no profile found: three axes, not homed",
        "patch opened: ",
        "mode self-test, was boot",
        "mode idle, was self-test",
        "home pose taken",
        "mode arming, was idle",
        "mode active, was arming",
    ];
    begins(&journal.log(&journal.rows), &told);
    let armed = records.iter().position(|record| record.enabled).unwrap();
    assert!(armed as u32 > ARM_AT, "armed in tick {armed}, before the host asked");
    println!("{board:?}: {} ticks, armed in tick {armed}, {:.4} N at most", records.len(), felt(&records));
    flashed_periods::judge(board, &journal, &periods);
}

#[test]
fn the_h743_presses_like_the_desktop_to_the_bit() {
    presses_like_the_desktop(Flashed::H743);
}

#[test]
fn the_f446_presses_like_the_desktop_to_the_bit() {
    presses_like_the_desktop(Flashed::F446);
}

#[test]
fn the_g474_presses_like_the_desktop_to_the_bit() {
    presses_like_the_desktop(Flashed::G474);
}

#[test]
fn the_pico_2_presses_like_the_desktop_to_the_bit() {
    presses_like_the_desktop(Flashed::Pico2);
}

/// Erratum ES0392 2.2.9: on revision Y, reads from AXI SRAM, in which uploaded patches are, may
/// return wrong data unless its port issues one read at a time.
#[test]
fn the_first_revision_of_the_h743_reads_its_axi_sram_one_word_at_a_time_and_runs_slower() {
    const AXI_SRAM_READ_ISSUING: u32 = 0x5100_8108;
    const PLL1_DIVIDERS: u32 = 0x5802_4430;
    for (revision, issuing, times) in [(0x1003_6450_u32, Some(1), 50), (0x2003_6450, None, 60)] {
        let more = json!({"values": {"0x5c001000": revision}});
        let scenario = Scenario { periods: &axes(2), more };
        let Some(journal) = run(target(), Flashed::H743, &scenario) else { return };
        assert_eq!(journal.register(AXI_SRAM_READ_ISSUING), issuing, "{revision:x}");
        assert_eq!(journal.register(PLL1_DIVIDERS).unwrap() & 0x1FF, times - 1, "{revision:x}");
    }
}

/// The window watchdog of the F446 acts after 3.6 ms, which is 655 000 cycles. An instruction takes
/// up to two of them with flash wait states.
#[test]
fn the_watchdog_is_fed_often_while_a_patch_opens() {
    const MOST_INSTRUCTIONS: u64 = 120_000;
    let scenario = Scenario { periods: &axes(2), more: json!({"count": true}) };
    let Some(journal) = run(target(), Flashed::F446, &scenario) else { return };
    let longest = journal.longest_unfed();
    println!("{longest} instructions at most between two feedings");
    assert!((10_000..=MOST_INSTRUCTIONS).contains(&longest), "{longest}");
}

/// A paddle on the pins: its profile and home pose are sent over the link, then the script presses.
#[test]
fn a_paddle_is_pressed_like_the_desktop_to_the_bit() {
    const STORE_AT: u32 = 10;
    const HOME_AT: u32 = 60;
    const MOVE_AT: u32 = 80;
    const THERE_AT: u32 = MOVE_AT + 400;
    const POWER_ON_COUNTS: i32 = -4_321;
    let file = repository().join("firmware/controller/devices/paddle.toml");
    let profile = device_file::load(file.to_str().unwrap()).unwrap().1;
    let mechanism = profile.mechanism.unwrap();
    let from_home = |tick: u32| {
        let place_m = script::counts(tick, LEAD_TICKS).map(|axis| f64::from(axis.0) * 1e-5);
        counts_at(&mechanism, place_m.into())[0]
    };
    let first = i64::from(from_home(0));
    let periods: Vec<Period> = (0..THERE_AT + PRESSED_TICKS)
        .map(|period| {
            let share = i64::from(period.clamp(MOVE_AT, THERE_AT) - MOVE_AT);
            let approach = (first * share / i64::from(THERE_AT - MOVE_AT)) as i32;
            let joint = if period < THERE_AT { approach } else { from_home(period - THERE_AT) };
            let says = match period {
                STORE_AT => Some(ToBoard::Store(profile)),
                HOME_AT => Some(ToBoard::Home),
                _ => host(period, THERE_AT + ARM_AT),
            };
            Period { counts: [POWER_ON_COUNTS + joint, 0, 0], says, late: 0 }
        })
        .collect();
    let more = json!({"events": [{"at": STORE_AT, "how": "restart"}]});
    let Some(journal) = run(target(), Flashed::G474, &Scenario { periods: &periods, more }) else { return };
    let (records, others) = agree(Flashed::G474, Some(&profile), &periods, &journal);
    assert!(matches!(others[..], [FromBoard::Stored(_), FromBoard::Homed]), "{others:?}");
    let codes = records.iter().map(|record| record.codes);
    assert!(codes.clone().any(|codes| codes[0] > 100) && codes.into_iter().all(|codes| codes[1..] == [0, 0]));
    println!("{} ticks, {:.4} N at most", records.len(), felt(&records));
}

#[test]
fn a_hang_under_force_ends_with_the_pins_off() {
    let at = PRESSED_TICKS - 20;
    let after = 220;
    // late enough after the reset for the loop to be idle, and early enough to arm before the end
    let again = at + 100;
    let hangs = [
        (Flashed::H743, json!({"at": at, "how": "loop", "symbol": "7palpate4tick4tick17h"})),
        (Flashed::F446, json!({"at": at, "how": "no ticks"})),
        (Flashed::Pico2, json!({"at": at, "how": "no ticks"})),
    ];
    for (board, event) in hangs {
        let mut periods = axes(at + after);
        periods[again as usize].says = Some(ToBoard::Ask(HostAsk::Arm));
        let scenario = Scenario { periods: &periods, more: json!({"events": [event]}) };
        let Some(journal) = run(target(), board, &scenario) else { return };
        let rows = &journal.rows;
        let hung = at as usize;
        let off = off_after(board, rows, hung);
        println!("{board:?} {event}: off within {off} periods after the last tick");
        assert!(rows[hung..hung + off].iter().all(|row| row.fed == 0), "nothing feeds the watchdog");
        let after = &rows[hung + off..];
        let refused = Journal::messages(after).contains(&FromBoard::Refused(Refusal::NotHomed));
        begins(&journal.log(after), &["WARN started after a crash or the watchdog's reset"]);
        assert!(refused, "asked for the force again, it lacks its home pose: it forgot what it was");
    }
}

/// Periods from an event under force until the watchdog has turned the pins off and reset the
/// board, which stays off.
fn off_after(board: Flashed, rows: &[Row], at: usize) -> usize {
    assert!(rows[at - 1].enable && rows[at - 1].steps[2] > 0, "{board:?}: a force acts before");
    let off = (at..rows.len()).find(|n| rows[*n].resets == 2).expect("the watchdog acts") - at;
    assert!(off < OFF_MS as usize, "{board:?}: {off} periods");
    for row in &rows[at + off + 1..] {
        assert!(row.is_off() && row.resets == 2, "{board:?} starts anew and arms nothing by itself");
    }
    assert!(rows.last().unwrap().fed > 0, "{board:?} runs again");
    off
}

/// One late tick costs half of the next force, two in a row end it. Nothing was wrong with them but
/// their time.
#[test]
fn late_ticks_under_force_release_it_and_tell_the_fault() {
    const ONCE: usize = PRESSED_TICKS as usize - 60;
    const TWICE: usize = ONCE + 40;
    for board in [Flashed::H743, Flashed::F446, Flashed::Pico2] {
        let mut periods = axes(PRESSED_TICKS + 20);
        for late in [ONCE, TWICE, TWICE + 1] {
            periods[late].late = 1;
        }
        let Some(journal) = press(board, &periods) else { return };
        let rows = &journal.rows;
        let force = |n: usize| if rows[n].enable && rows[n].main_output { rows[n].steps[2] } else { 0 };
        let (before, after) = (force(ONCE), force(ONCE + 1));
        assert!(before > 20 && after > 0 && 2 * after <= before + 1, "{board:?}: {before}, then {after} steps");
        assert!(force(TWICE - 1) > 20 && force(TWICE) > 0, "{board:?}: it has returned, and one more late tick is no fault");
        assert_eq!(last_fault(&rows[..=TWICE]), None, "{board:?}");
        for row in &rows[TWICE + 1..] {
            assert!(!row.enable && !row.main_output && row.resets == 1, "{board:?}: off in the second late tick");
        }
        assert!(rows[TWICE + 2..].iter().all(Row::is_off), "{board:?}");
        assert_eq!(last_fault(rows), Some(Fault::DeadlineMissed), "{board:?}");
    }
}

#[test]
fn an_open_stop_circuit_ends_the_force_in_the_tick_in_which_it_opens() {
    for board in [Flashed::F446, Flashed::G474, Flashed::Pico2] {
        let at = PRESSED_TICKS - 20;
        let scenario = Scenario { periods: &axes(PRESSED_TICKS + 40), more: json!({"events": [{"at": at, "how": "stop"}]}) };
        let Some(journal) = run(target(), board, &scenario) else { return };
        let rows = &journal.rows;
        assert!(rows[at as usize - 1].enable && rows[at as usize - 1].steps[2] > 0, "{board:?}: a force acts before");
        for row in &rows[at as usize..] {
            assert!(!row.enable && !row.main_output && row.resets == 1, "{board:?}");
        }
        assert_eq!(last_fault(rows), Some(Fault::EmergencyStop), "{board:?}: latched, although it has closed again");
    }
}

/// An STM32 receives nothing while the flag of a lost byte is set, and a DMA with the flag of an
/// error sends nothing.
#[test]
fn a_board_and_its_host_hear_each_other_again_after_an_error_of_the_link() {
    let lost = [Flashed::H743, Flashed::F446, Flashed::G474].map(|board| (board, "overrun"));
    let stopped = [Flashed::F446, Flashed::G474].map(|board| (board, "transfer error"));
    for (board, how) in lost.into_iter().chain(stopped) {
        let mut periods = axes(ARM_AT);
        periods[30].says = Some(ToBoard::Report);
        let scenario = Scenario { periods: &periods, more: json!({"events": [{"at": 20, "how": how}]}) };
        let Some(journal) = run(target(), board, &scenario) else { return };
        let is_state = |message: &FromBoard| matches!(message, FromBoard::State { .. });
        assert!(Journal::whole_messages(&journal.rows[20..]).iter().any(is_state), "{board:?}: {how}");
    }
}

/// The report of a crash outlives the reset: what it was and where.
#[test]
fn a_hard_fault_under_force_ends_with_the_pins_off_and_is_reported_after_the_reset() {
    const BUS_ERROR: u32 = 1 << 9 | 1 << 15;
    const NOWHERE: u32 = 0x6000_0000;
    let at = PRESSED_TICKS - 20;
    let asked = at + 100;
    for board in [Flashed::F446, Flashed::Pico2] {
        let mut periods = axes(at + 220);
        periods[asked as usize].says = Some(ToBoard::Report);
        let symbol = "7palpate4tick4tick17h";
        let event = json!({"at": at, "how": "hard fault", "symbol": symbol, "cfsr": BUS_ERROR, "bfar": NOWHERE});
        let scenario = Scenario { periods: &periods, more: json!({"events": [event]}) };
        let Some(journal) = run(target(), board, &scenario) else { return };
        let rows = &journal.rows;
        let off = off_after(board, rows, at as usize);
        assert!(!rows[at as usize].enable && !rows[at as usize].main_output, "{board:?}: off before the watchdog acts");
        let mut crashes = Journal::messages(&rows[at as usize + off..]).into_iter().filter_map(|message| match message {
            FromBoard::Crashed(crash) => Some(crash),
            _ => None,
        });
        let crash = crashes.next_back().expect("a report of the crash");
        println!("{board:?}: {crash}");
        let image = std::fs::read(&journal.image).unwrap();
        let image = FirmwareImage::parse(&image).unwrap();
        assert_eq!(image.function_at(crash.pc).map(|found| found.name.as_str()), Some("palpate::tick::tick"));
        assert!(image.function_at(crash.lr).is_some());
        assert_eq!((crash.cfsr, crash.address), (BUS_ERROR, NOWHERE));
        assert!(crash.to_string().contains("bus error in accessing data, address 0x60000000"), "{crash}");
    }
}

/// The model's cycle counter advances by a fixed number at each reading, so the tick of the patch
/// and the loop around it take as many cycles.
#[test]
fn a_board_whose_measured_tick_is_too_long_does_not_arm_and_tells_the_fault() {
    for (board, period_cycles) in [(Flashed::F446, 180_000), (Flashed::Pico2, 150_000)] {
        for (percent, armed) in [(42, true), (43, false)] {
            let mut periods = axes(220);
            periods[20].says = Some(ToBoard::Identify);
            let more = json!({"cycles_per_reading": period_cycles / 100 * percent});
            let scenario = Scenario { periods: &periods, more };
            let Some(journal) = run(target(), board, &scenario) else { return };
            let fault = (!armed).then_some(Fault::DeadlineMissed);
            assert_eq!((last_fault(&journal.rows), journal.rows.last().unwrap().enable), (fault, armed), "{board:?} {percent}");
            let told = Journal::messages(&journal.rows).into_iter().find_map(|message| match message {
                FromBoard::Identity(identity) => Some(identity.longest_counts),
                _ => None,
            });
            assert_eq!(told, Some(2 * period_cycles / 100 * percent), "{board:?}: the identity says how long");
        }
    }
}

/// Fault in the newest record.
pub fn last_fault(rows: &[Row]) -> Option<Fault> {
    let mut records = Journal::messages(rows).into_iter().filter_map(|message| match message {
        FromBoard::Record(record) => Some(record),
        _ => None,
    });
    records.next_back().and_then(|record| record.fault())
}
