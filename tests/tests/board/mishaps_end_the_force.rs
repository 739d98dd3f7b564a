//! Mishaps at a bench: a supply drops, the power fails, a debugger halts the core, a profile is for
//! another device. The flashed images turn the pins off, and the next connection tells why.

use palpate::Fault;
use palpate_controller::config::Profile;
use palpate_controller::link::message::HostAsk;
use palpate_controller::link::{FromBoard, Refusal, ToBoard};
use palpate_tests::register_model::{Flashed, Journal, Row, Scenario, run};
use serde_json::{Value, json};

use super::flashed_image_runs::{PRESSED_TICKS, axes, begins, last_fault, target};

/// Period of the press in which something happens.
const AT: usize = PRESSED_TICKS as usize - 20;

#[test]
fn a_drop_of_the_amplifiers_supply_ends_the_force_for_good() {
    // the pins of the F446 are those of the G474
    for board in [Flashed::H743, Flashed::G474, Flashed::Pico2] {
        let more = json!({"events": [{"at": AT, "how": "supply"}]});
        let Some(journal) = run(target(), board, &Scenario { periods: &axes(PRESSED_TICKS + 40), more }) else { return };
        let rows = &journal.rows;
        assert!(rows[AT - 1].enable && rows[AT - 1].steps[2] > 0, "{board:?}: a force acts before");
        assert!(!rows[AT].enable && !rows[AT].main_output && rows[AT + 1..].iter().all(Row::is_off), "{board:?}");
        assert_eq!(last_fault(rows), Some(Fault::SupplyLow), "{board:?}: latched, although the supply has returned");
        assert!(Fault::SupplyLow.to_string().contains("supply"), "{}", Fault::SupplyLow);
    }
}

/// A brown-out of the chip is a reset like the one at power-on, with random RAM.
#[test]
fn a_board_that_loses_its_power_under_force_starts_off_and_waits_for_its_home_pose() {
    for board in [Flashed::F446, Flashed::Pico2] {
        let asked = AT + 60;
        let mut periods = axes(AT as u32 + 200);
        periods[asked].says = Some(ToBoard::Ask(HostAsk::Arm));
        let more = json!({"events": [{"at": AT, "how": "power"}]});
        let Some(journal) = run(target(), board, &Scenario { periods: &periods, more }) else { return };
        let rows = &journal.rows;
        assert!(rows[AT - 1].enable && rows[AT - 1].steps[2] > 0, "{board:?}: a force acts before");
        assert!(rows[AT..].iter().all(Row::is_off), "{board:?}");
        begins(&journal.log(&rows[AT..]), &["started after power-on or the reset button"]);
        let told = Journal::whole_messages(&rows[asked..]); // the first one may have begun before
        assert!(told.contains(&FromBoard::Refused(Refusal::NotHomed)), "{board:?}: {told:?}");
    }
}

/// A halt stops the timer of the pulses, whose outputs are then off, and the watchdogs that would
/// otherwise reset the chip under the debugger. The F446's window watchdog and the Pico 2's
/// watchdog go on, so that a halt ends in a reset (`a_hang_under_force_ends_with_the_pins_off`).
#[test]
fn a_debugger_s_halt_ends_the_pulses_or_in_a_reset() {
    let bit = |at: u32| 1_u64 << at;
    // register, bits that are set, bits that are not
    let frozen = [
        (Flashed::H743, 0x5C00_104C, bit(0), 0),                             // TIM1
        (Flashed::H743, 0x5C00_1054, bit(18), 0),                            // IWDG1
        (Flashed::F446, 0xE004_200C, bit(0), 0),                             // TIM1
        (Flashed::F446, 0xE004_2008, bit(12), bit(11)),                      // IWDG, and not WWDG
        (Flashed::G474, 0xE004_2010, bit(11), 0),                            // TIM1
        (Flashed::G474, 0xE004_2008, bit(12), 0),                            // IWDG
        (Flashed::Pico2, 0x400D_8000, bit(30), bit(24) | bit(25) | bit(26)), // the watchdog is on and never paused
    ];
    for board in [Flashed::H743, Flashed::F446, Flashed::G474, Flashed::Pico2] {
        let Some(journal) = run(target(), board, &Scenario { periods: &axes(3), more: Value::Null }) else { return };
        for (_, register, set, clear) in frozen.iter().filter(|row| row.0 == board) {
            let found = journal.register(*register).unwrap_or(0);
            assert_eq!((found & set, found & clear), (*set, 0), "{board:?} {register:x}: {found:x}");
        }
    }
}

/// Its force is beyond what the board's converters stand for.
#[test]
fn a_profile_of_another_device_is_refused_and_changes_nothing() {
    const STORE_AT: usize = 30;
    let other = Profile { max_force_n: 1e3, ..Profile::desktop() };
    for board in [Flashed::F446, Flashed::Pico2] {
        let mut periods = axes(PRESSED_TICKS);
        periods[STORE_AT].says = Some(ToBoard::Store(other));
        let Some(journal) = run(target(), board, &Scenario { periods: &periods, more: Value::Null }) else { return };
        let rows = &journal.rows;
        let told = Journal::messages(rows);
        assert!(told.contains(&FromBoard::Refused(Refusal::ProfileRange)), "{board:?}: {told:?}");
        let last = rows.last().unwrap();
        assert!(last.resets == 1 && last.enable && last.steps[2] > 0, "{board:?} presses as if nothing had been asked");
        assert!(rows[..STORE_AT + 10].iter().all(Row::is_off), "{board:?}");
    }
}
