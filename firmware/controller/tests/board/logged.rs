//! The log of a serving board: pieces are sent between the records, never in place of one, and only
//! to a host that reads the log.

use std::future::Future;
use std::pin::pin;
use std::task::{Context, Poll, Waker};

use palpate::Fault;
use palpate::haptic::mode::Mode;
use palpate_controller::controller::Arming;
use palpate_controller::link::log::LOG_BYTES;
use palpate_controller::link::{FRAME_BYTES, FromBoard, Log, Record, Refusal, ToBoard, encode, upload};
use palpate_controller::log::Event;
use palpate_controller::patch::Memory;
use palpate_controller::serve::{LISTENS_TICKS, LOG_TICKS, Pace, RECORD_TICKS, run};

use super::mock::{Mock, haptic_loop};
use super::served::{BLOCK, decoded, pose};

/// Periods of a flood of lines: as many as the host, which asks in the first tick, reads the log
/// for.
const FLOOD: u32 = LISTENS_TICKS;

/// Runs a board in timed mode for `ticks` ticks; `set` prepares it, and the host sends its messages
/// in the first tick.
fn timed(ticks: u32, messages: &[ToBoard<'_>], set: impl FnOnce(&mut Mock)) -> Mock {
    let mut haptic = haptic_loop(Arming::OnRequest);
    haptic.board.last_period = Some(ticks);
    set(&mut haptic.board);
    for (n, message) in messages.iter().enumerate() {
        let mut out = [0; FRAME_BYTES];
        haptic.board.from_host.push_back(encode(n as u16 + 1, message, &mut out).unwrap().to_vec());
    }
    let (mut memory, mut upload) = (Box::new(Memory::RESERVED), Box::new(upload::Upload::RESERVED));
    {
        let service = pin!(run(&mut haptic, &BLOCK.0, &mut memory, &mut upload, Pace::Timed));
        assert_eq!(service.poll(&mut Context::from_waker(Waker::noop())), Poll::Pending, "the timer stands still");
    }
    haptic.board
}

/// Messages, each with the period in which it was sent.
type Sent<T> = Vec<(u32, T)>;

/// Records and pieces of the log that the board sent.
fn sent(board: Mock) -> (Sent<Record>, Sent<Log>) {
    let (mut records, mut logs) = (Vec::new(), Vec::new());
    for (period, frame) in board.sent_at.iter().zip(board.to_host) {
        assert!(frame.len() <= FRAME_BYTES);
        decoded(frame, |message| match message {
            FromBoard::Record(record) => records.push((*period, record)),
            FromBoard::Log(log) => logs.push((*period, log)),
            other => panic!("{other:?}"),
        });
    }
    (records, logs)
}

#[test]
fn a_flood_of_lines_neither_delays_nor_replaces_a_record() {
    let (quiet, _) = sent(timed(FLOOD, &[ToBoard::Listen(true)], |_| {}));
    let (records, logs) = sent(timed(FLOOD, &[ToBoard::Listen(true)], |board| board.chatty = true));
    assert_eq!(records, quiet, "the same records in the same periods");
    let periods: Vec<u32> = records.iter().map(|(period, _)| *period).collect();
    assert_eq!(periods, (1..=FLOOD).filter(|period| period % RECORD_TICKS == 0).collect::<Vec<_>>());
    let at: Vec<u32> = logs.iter().map(|(period, _)| *period).collect();
    assert_eq!(at, (1..=FLOOD).filter(|period| period % LOG_TICKS == 11).collect::<Vec<_>>(), "one piece between two records");
    assert!(logs.iter().all(|(_, log)| (1..=LOG_BYTES).contains(&log.frames.bytes().len())));
    assert!(logs.iter().all(|(_, log)| log.frames.bytes().last() == Some(&0)), "whole frames");
    // 41 bytes per line, two lines per piece, twelve lines in the ring
    let lines = logs.iter().map(|(_, log)| log.frames.bytes().iter().filter(|byte| **byte == 0).count()).sum::<usize>();
    let (_, last) = logs.last().unwrap();
    assert!(lines == 2 * logs.len() && last.lost > 180, "{lines} lines, {} lost", last.lost);
    assert!(logs.is_sorted_by_key(|(_, log)| log.lost));
}

#[test]
fn a_link_without_room_to_spare_carries_records_alone() {
    let (quiet, _) = sent(timed(200, &[ToBoard::Listen(true)], |_| {}));
    let narrow = |room| {
        sent(timed(200, &[ToBoard::Listen(true)], |board| {
            (board.chatty, board.room) = (true, room);
        }))
    };
    let (records, logs) = narrow(2 * FRAME_BYTES + LOG_BYTES - 1);
    assert_eq!((records, logs.len()), (quiet.clone(), 0));
    let (records, logs) = narrow(2 * FRAME_BYTES + LOG_BYTES);
    assert_eq!((records, logs.len()), (quiet, 5));
}

#[test]
fn a_host_that_asks_is_told_once_that_nothing_waits() {
    let (_, logs) = sent(timed(200, &[ToBoard::Listen(true)], |_| {}));
    let empty: Vec<u32> = logs.iter().filter(|(_, log)| *log == Log::NOTHING).map(|(period, _)| *period).collect();
    let (last, _) = logs.last().unwrap();
    assert!(empty.is_empty() && *last > 11, "the lines of the start answer: {logs:?}");
    let asked = |board: &mut Mock| board.quiet = true;
    let (_, logs) = sent(timed(200, &[ToBoard::Listen(true)], asked));
    assert_eq!(logs, [(11, Log::NOTHING)]);
    let (_, logs) = sent(timed(200, &[ToBoard::Listen(true), ToBoard::Listen(false)], asked));
    assert!(logs.is_empty());
}

#[test]
fn the_log_stays_on_the_board_until_a_host_listens_and_when_it_does_not_any_more() {
    for messages in [&[][..], &[ToBoard::Heartbeat, ToBoard::Identify], &[ToBoard::Listen(true), ToBoard::Listen(false)]] {
        let mut board = timed(400, messages, |board| board.chatty = true);
        assert!(board.events.len() > 400 && board.ring.take().is_some(), "it waits");
        board.to_host.retain(|frame| !decoded(frame.clone(), |message| matches!(message, FromBoard::Identity(_))));
        let (records, logs) = sent(board);
        assert_eq!((records.len(), logs.len()), (400 / RECORD_TICKS as usize, 0), "{messages:?}: nobody listens");
    }
    let (records, logs) = sent(timed(LISTENS_TICKS + 400, &[ToBoard::Listen(true)], |board| board.chatty = true));
    assert_eq!(records.len() as u32, (LISTENS_TICKS + 400) / RECORD_TICKS);
    let (last, _) = logs.last().unwrap();
    assert!((LISTENS_TICKS - LOG_TICKS..=LISTENS_TICKS).contains(last), "the last piece in period {last}");
}

#[test]
fn in_lock_step_events_are_logged_and_none_is_sent() {
    let mut messages: Vec<ToBoard<'_>> = (1..=9).map(|n| pose(n, 2e-3)).collect();
    messages.extend([ToBoard::YoungsModulus(1e9), ToBoard::Home, pose(10, 2e-3)]);
    messages.extend(upload::messages(&BLOCK.0));
    messages.push(pose(11, 2e-3));
    let (frames, board) = super::served::answers(&messages);
    for frame in frames {
        decoded(frame, |message| assert!(!matches!(message, FromBoard::Log(_)), "{message:?}"));
    }
    let opened = board.events[0];
    assert!(matches!(opened, Event::PatchOpened { nodes: 56, youngs_modulus_pa: 3500.0, .. }), "{opened:?}");
    let expected = [
        opened,
        Event::Mode { to: Mode::SelfTest, from: Mode::Boot },
        Event::Mode { to: Mode::Idle, from: Mode::SelfTest },
        Event::Refused(Refusal::ModulusOutOfRange),
        opened, // reopened with its modulus unchanged
        Event::Refused(Refusal::NoEncoders),
        Event::UploadBegun(BLOCK.0.len() as u32),
        opened,
    ];
    assert_eq!(board.events, expected);
}

#[test]
fn a_fault_and_late_ticks_are_logged_with_their_numbers() {
    let board = timed(60, &[ToBoard::Listen(true)], |board| board.stop = Some(Fault::EmergencyStop));
    let faults: Vec<&Event> = board.events.iter().filter(|event| matches!(event, Event::Fault(_))).collect();
    assert_eq!(faults, [&Event::Fault(Fault::EmergencyStop)], "once");
    let board = timed(60, &[ToBoard::Listen(true)], |board| board.late = 1);
    let late: Vec<&Event> = board.events.iter().filter(|event| matches!(event, Event::Late { .. })).collect();
    // every tick is late; the log reports it once per piece, not once per tick
    assert_eq!(late, [&Event::Late { overruns: 11, missed_periods: 0 }, &Event::Late { overruns: 51, missed_periods: 0 }]);
}
