//! Hosts of a board in timed mode: requests that are refused while a force may act, and the
//! sequence numbers with which a host may return.

use std::future::Future;
use std::pin::pin;
use std::task::{Context, Poll, Waker};

use palpate::Fault;
use palpate::haptic::mode::Mode;
use palpate_controller::controller::Arming;
use palpate_controller::link::message::HostAsk;
use palpate_controller::link::{FRAME_BYTES, FromBoard, Refusal, ToBoard, Upload, encode};
use palpate_controller::patch::Memory;
use palpate_controller::serve::{Pace, run};

use super::mock::haptic_loop;
use super::served::{BLOCK, decoded, pose};

/// Ticks until the full force: start-up, calm ticks and ramp-in.
const START_UP_TICKS: u32 = 700;

/// A message with its sequence number.
type Numbered = (u16, ToBoard<'static>);

/// The board's answers other than records, with the period of each, to the messages that a host
/// sends in each period.
fn answers(ticks: &[Vec<Numbered>]) -> Vec<(u32, String)> {
    let mut haptic = haptic_loop(Arming::OnRequest);
    haptic.board.last_period = Some(ticks.len() as u32);
    for messages in ticks {
        for (sequence, message) in messages {
            haptic.board.from_host.push_back(encode(*sequence, message, &mut [0; FRAME_BYTES]).unwrap().to_vec());
        }
        // nothing more arrives in this period
        haptic.board.from_host.push_back(Vec::new());
    }
    let (mut memory, mut upload) = (Box::new(Memory::RESERVED), Box::new(Upload::RESERVED));
    {
        let service = pin!(run(&mut haptic, &BLOCK.0, &mut memory, &mut upload, Pace::Timed));
        assert_eq!(service.poll(&mut Context::from_waker(Waker::noop())), Poll::Pending, "the timer stops");
    }
    let frames = std::mem::take(&mut haptic.board.to_host).into_iter().zip(haptic.board.sent_at);
    let told = frames.map(|(frame, period)| {
        let said = decoded(frame, |message| match message {
            FromBoard::Record(_) => None,
            FromBoard::State { .. } => Some("state".to_owned()),
            FromBoard::Identity(_) => Some("identity".to_owned()),
            other => Some(format!("{other:?}")),
        });
        (period, said)
    });
    told.filter_map(|(period, said)| said.map(|said| (period, said))).collect()
}

#[test]
fn a_report_and_a_name_wait_until_no_force_may_act() {
    let mut sequence = 0;
    let mut next = |message| {
        sequence += 1;
        (sequence, message)
    };
    let mut ticks = Vec::new();
    for tick in 1..=START_UP_TICKS + 220 {
        let mut messages = vec![next(pose(tick, 5e-3))];
        messages.extend((tick == 8).then(|| next(ToBoard::Ask(HostAsk::Arm))));
        messages.extend((tick == START_UP_TICKS + 5).then(|| next(ToBoard::Ask(HostAsk::Stop))));
        if [4, START_UP_TICKS, START_UP_TICKS + 215].contains(&tick) {
            messages.extend([next(ToBoard::Report), next(ToBoard::Identify)]);
        }
        ticks.push(messages);
    }
    let refused = format!("{:?}", FromBoard::Refused(Refusal::NotIdle));
    let told = answers(&ticks);
    // the link is read after the force of a period, before the next one begins
    let expected = [
        (3, "state"),
        (3, "identity"),
        (START_UP_TICKS - 1, refused.as_str()),
        (START_UP_TICKS - 1, refused.as_str()),
        (START_UP_TICKS + 214, "state"),
        (START_UP_TICKS + 214, "identity"),
    ];
    assert_eq!(told.iter().map(|(period, said)| (*period, said.as_str())).collect::<Vec<_>>(), expected);
}

/// The mock's clock advances by the same step at each reading, so the tick of the patch and the
/// tick around it take one step each.
#[test]
fn a_board_does_not_arm_if_its_measured_tick_takes_more_than_85_percent_of_a_period() {
    const PERIOD_COUNTS: u32 = 1_000;
    for (step, armed) in [(0, true), (1, true), (425, true), (426, false), (PERIOD_COUNTS, false)] {
        let mut haptic = haptic_loop(Arming::OnRequest);
        haptic.board.clock_step = step;
        haptic.board.last_period = Some(300);
        for tick in 1..=300 {
            let mut messages = vec![pose(tick, 5e-3)];
            messages.extend((tick == 8).then_some(ToBoard::Ask(HostAsk::Arm)));
            messages.extend((tick == 6).then_some(ToBoard::Identify));
            for (n, message) in messages.iter().enumerate() {
                let number = 2 * tick as u16 + n as u16;
                haptic.board.from_host.push_back(encode(number, message, &mut [0; FRAME_BYTES]).unwrap().to_vec());
            }
            haptic.board.from_host.push_back(Vec::new());
        }
        let (mut memory, mut upload) = (Box::new(Memory::RESERVED), Box::new(Upload::RESERVED));
        {
            let service = pin!(run(&mut haptic, &BLOCK.0, &mut memory, &mut upload, Pace::Timed));
            assert_eq!(service.poll(&mut Context::from_waker(Waker::noop())), Poll::Pending, "the timer stops");
        }
        let expected = if armed { (Mode::Active, None) } else { (Mode::Fault, Some(Fault::DeadlineMissed)) };
        assert_eq!((haptic.seen().mode, haptic.seen().fault), expected, "{step}");
        let told = std::mem::take(&mut haptic.board.to_host).into_iter().find_map(|frame| {
            decoded(frame, |message| match message {
                FromBoard::Identity(identity) => Some((identity.longest_counts, identity.predicted_cycles)),
                _ => None,
            })
        });
        let (longest_counts, predicted_cycles) = told.unwrap();
        assert_eq!(longest_counts, 2 * step, "the identity says it");
        assert!((50e3..126e3).contains(&predicted_cycles), "{predicted_cycles} beside it");
    }
}

#[test]
fn a_host_that_was_silent_for_a_hundred_ticks_may_begin_with_any_number() {
    for (silent_ticks, answered) in [(50, false), (99, false), (100, true), (101, true), (150, true)] {
        let mut ticks = vec![vec![(500, ToBoard::Heartbeat)]];
        ticks.extend(std::iter::repeat_n(Vec::new(), silent_ticks));
        ticks.push(vec![(7, ToBoard::Report)]);
        let told = answers(&ticks);
        assert_eq!(told.len(), usize::from(answered), "{silent_ticks}: {told:?}");
    }
    // a host that is heard from time to time is not forgotten
    let mut ticks = vec![vec![(500, ToBoard::Heartbeat)]];
    ticks.extend(std::iter::repeat_n(Vec::new(), 60));
    ticks.push(vec![(501, ToBoard::Heartbeat)]);
    ticks.extend(std::iter::repeat_n(Vec::new(), 60));
    ticks.push(vec![(7, ToBoard::Report)]);
    assert!(answers(&ticks).is_empty());
}
