//! Profiles that the flashed images store. A board sets a profile aside, lets its watchdog reset
//! it, and stores the profile before the watchdog runs, with everything off. Whenever the power
//! fails meanwhile, the board starts with the profile before or with the new one.

use std::path::Path;

use palpate_controller::config::Profile;
use palpate_controller::link::{FromBoard, ToBoard};
use palpate_tests::register_model::{Flashed, Journal, Period, Scenario, run};
use serde_json::{Value, json};

/// Periods in which the host sends the first and the second profile and asks for the state, and in
/// which the power fails.
const FIRST_AT: usize = 5;
const SECOND_AT: usize = 90;
const REPORT_AT: usize = 170;
const POWER_AT: usize = 220;
const REPORT_AGAIN_AT: usize = 260;
const PERIODS: usize = 320;

/// Runs an image that stores a profile without the day of a commissioning, then one with it.
/// Returns the generations that it stored, and whether it has the second profile before and after
/// the power failed; `None` if the model is not available.
fn stored(board: Flashed, fails_in: u32) -> Option<(Vec<u32>, Vec<bool>)> {
    let first = Profile { commissioned_day: 0, ..Profile::desktop() };
    let second = Profile { commissioned_day: 20_000, ..first };
    let says = |period: usize| match period {
        FIRST_AT => Some(ToBoard::Store(first)),
        SECOND_AT => Some(ToBoard::Store(second)),
        REPORT_AT | REPORT_AGAIN_AT => Some(ToBoard::Report),
        _ => None,
    };
    let periods: Vec<Period> = (0..PERIODS).map(|n| Period { counts: [0; 3], says: says(n), late: 0 }).collect();
    let events: [Value; 3] = [
        json!({"at": FIRST_AT, "how": "restart"}),
        json!({"at": SECOND_AT, "how": "restart", "power_fails_in": fails_in}),
        json!({"at": POWER_AT, "how": "power"}),
    ];
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap();
    let journal = run(target, board, &Scenario { periods: &periods, more: json!({"events": events}) })?;
    // the pins of a chip in reset float
    let on = journal.rows.iter().position(|row| row.enable || row.driven);
    assert!(journal.started.is_off() && on.is_none(), "{board:?}: something could act in period {on:?}");
    let (mut generations, mut has_second) = (Vec::new(), Vec::new());
    // a reset may cut a frame
    let mut restarts: Vec<usize> =
        (1..journal.rows.len()).filter(|n| journal.rows[*n].resets > journal.rows[n - 1].resets).collect();
    restarts.push(journal.rows.len());
    let mut begun = 0;
    for end in restarts {
        for message in Journal::whole_messages(&journal.rows[begun..end]) {
            match message {
                FromBoard::Stored(generation) => generations.push(generation),
                FromBoard::State { commissioned, .. } => has_second.push(commissioned),
                _ => {}
            }
        }
        begun = end;
    }
    Some((generations, has_second))
}

#[test]
fn a_profile_outlives_the_power_on_every_board() {
    for board in [Flashed::H743, Flashed::F446, Flashed::G474, Flashed::Pico2] {
        let Some((generations, has_second)) = stored(board, 0) else { return };
        assert_eq!((generations, has_second), (vec![1, 2], vec![true; 2]), "{board:?}");
    }
}

#[test]
fn when_the_power_fails_while_a_profile_is_stored_the_one_before_stays() {
    // erasing is the first operation
    let cuts = [(Flashed::F446, 1), (Flashed::F446, 30), (Flashed::G474, 2), (Flashed::H743, 4), (Flashed::Pico2, 2)];
    for (board, fails_in) in cuts {
        let Some((generations, has_second)) = stored(board, fails_in) else { return };
        assert_eq!((generations, has_second), (vec![1], vec![false; 2]), "{board:?}, operation {fails_in}");
    }
}
