//! A host on the link of a mock board.

use std::future::Future;
use std::pin::pin;
use std::task::{Context, Poll, Waker};

use palpate::haptic::account::{AccountSettings, EnergyAccount};
use palpate::haptic::device::HapticDevice;
use palpate::haptic::mode::Mode;
use palpate_controller::config::Profile;
use palpate_controller::controller::Arming;
use palpate_controller::force_out::Outputs;
use palpate_controller::haptic_loop::HapticLoop;
use palpate_controller::link::frame::decode;
use palpate_controller::link::message::HostAsk;
use palpate_controller::link::{FromBoard, Refusal, ToBoard, Upload, encode, upload};
use palpate_controller::patch::{Memory, WordAligned};
use palpate_controller::port::Port;
use palpate_controller::serve::{Pace, run};

use super::mock::{Mock, haptic_loop};

/// A patch with masses relative to neighbours: opening it takes 128 passes over its springs, twice.
static RELATIVE: &WordAligned<[u8]> = &WordAligned(*include_bytes!("../../../patches/block-m7-480.patch"));
pub static BLOCK: &WordAligned<[u8]> = &WordAligned(*include_bytes!("../../../patches/block-m4f-168.patch"));

/// Serves a host that sends `messages` and then disconnects; returns the answers and the board.
pub fn answers(messages: &[ToBoard<'_>]) -> (Vec<Vec<u8>>, Mock) {
    answers_of(haptic_loop(Arming::OnRequest), messages)
}

fn answers_of(mut haptic: HapticLoop<Mock>, messages: &[ToBoard<'_>]) -> (Vec<Vec<u8>>, Mock) {
    for (n, message) in messages.iter().enumerate() {
        let mut out = [0; palpate_controller::link::FRAME_BYTES];
        let frame = encode(n as u16 + 1, message, &mut out).unwrap();
        haptic.board.from_host.push_back(frame.to_vec());
    }
    let (mut memory, mut upload) = (Box::new(Memory::RESERVED), Box::new(Upload::RESERVED));
    {
        let service = pin!(run(&mut haptic, &BLOCK.0, &mut memory, &mut upload, Pace::LockStep));
        assert_eq!(
            service.poll(&mut Context::from_waker(Waker::noop())),
            Poll::Ready(()),
            "in lock-step nothing is waited for but the host"
        );
    }
    (std::mem::take(&mut haptic.board.to_host), haptic.board)
}

pub fn pose(sequence: u32, z_m: f32) -> ToBoard<'static> {
    ToBoard::Pose { position_m: [0.0, 0.0, z_m], sequence, good: true }
}

pub fn decoded<T>(mut frame: Vec<u8>, then: impl FnOnce(FromBoard) -> T) -> T {
    // without the zero byte that ends a frame
    let end = frame.iter().position(|byte| *byte == 0).unwrap_or(frame.len());
    then(decode(&mut frame[..end]).unwrap().1)
}

#[test]
fn every_pose_is_answered_by_a_record_and_the_outputs_are_off_when_the_host_goes() {
    let mut messages: Vec<ToBoard> = (1..=3).map(|n| pose(n, 2e-3)).collect();
    messages.push(ToBoard::Ask(HostAsk::Arm));
    messages.extend((4..=800).map(|n| pose(n, 2e-3)));
    let (frames, board) = answers(&messages);
    assert_eq!(frames.len(), 800);
    let modes: Vec<Option<Mode>> = frames
        .into_iter()
        .map(|frame| decoded(frame, |message| if let FromBoard::Record(record) = message { record.mode() } else { None }))
        .collect();
    assert_eq!(modes.last(), Some(&Some(Mode::Active)), "armed by the host's request");
    assert!(!board.pins.enabled, "nobody is there any more");
    assert_eq!(board.milliseconds, 800);
}

#[test]
fn a_report_tells_the_state_and_a_modulus_out_of_range_is_refused() {
    let mut messages: Vec<ToBoard> = (1..=3).map(|n| pose(n, 2e-3)).collect();
    messages.extend([ToBoard::Report, ToBoard::YoungsModulus(1e9), pose(4, 2e-3)]);
    let (frames, _) = answers(&messages);
    let kinds: Vec<&str> = frames
        .into_iter()
        .map(|frame| {
            decoded(frame, |message| match message {
                FromBoard::Record(_) => "record",
                FromBoard::State { stack_used_bytes, nodes, bad_frames, at_once_j, lasting_w, .. } => {
                    assert_eq!((stack_used_bytes, nodes, bad_frames), (4321, 56, 0));
                    let bound = EnergyAccount::bound(&AccountSettings::DEFAULT, &Port::DESKTOP.limits(), 1e-3, 0);
                    assert_eq!((at_once_j, lasting_w), (bound.at_once_j, bound.lasting_w));
                    "state"
                }
                FromBoard::Refused(Refusal::ModulusOutOfRange) => "refused",
                other => panic!("{other:?}"),
            })
        })
        .collect();
    assert_eq!(kinds[2..], ["record", "state", "refused", "record"]);
}

#[test]
fn under_a_force_a_modulus_is_answered_as_well() {
    let mut messages: Vec<ToBoard> = (1..=3).map(|n| pose(n, 2e-3)).collect();
    messages.push(ToBoard::Ask(HostAsk::Arm));
    messages.extend((4..=800).map(|n| pose(n, 2e-3)));
    messages.extend([ToBoard::YoungsModulus(4e3), pose(801, 2e-3), ToBoard::YoungsModulus(9e3), pose(802, 2e-3)]);
    let (frames, _) = answers(&messages);
    let said = |frame: &Vec<u8>| decoded(frame.clone(), |message| message);
    assert!(matches!(said(&frames[799]), FromBoard::Record(record) if record.mode() == Some(Mode::Active)));
    let answers: Vec<FromBoard> = frames.iter().map(said).filter(|message| !matches!(message, FromBoard::Record(_))).collect();
    assert_eq!(answers, [FromBoard::Modulus(4e3), FromBoard::Refused(Refusal::ModulusOutOfRange)]);
}

#[test]
fn damaged_bytes_are_counted_and_the_next_frame_is_taken() {
    let mut haptic = haptic_loop(Arming::OnRequest);
    haptic.board.from_host.push_back(vec![7, 7, 7, 0]);
    let mut out = [0; palpate_controller::link::FRAME_BYTES];
    haptic.board.from_host.push_back(encode(1, &pose(1, 2e-3), &mut out).unwrap().to_vec());
    haptic
        .board
        .from_host
        .push_back(encode(2, &ToBoard::Report, &mut [0; palpate_controller::link::FRAME_BYTES]).unwrap().to_vec());
    let (mut memory, mut upload) = (Box::new(Memory::RESERVED), Box::new(Upload::RESERVED));
    {
        let service = pin!(run(&mut haptic, &BLOCK.0, &mut memory, &mut upload, Pace::LockStep));
        assert_eq!(service.poll(&mut Context::from_waker(Waker::noop())), Poll::Ready(()));
    }
    let state = haptic.board.to_host.pop().unwrap();
    decoded(state, |message| assert!(matches!(message, FromBoard::State { bad_frames: 1, .. }), "{message:?}"));
}

/// Messages that transfer a patch over the link, after three ticks in which the board starts up.
fn bring(bytes: &[u8]) -> Vec<ToBoard<'_>> {
    let started = (1..=9).map(|n| pose(n, 2e-3));
    started.chain(upload::messages(bytes)).chain([pose(10, 2e-3)]).collect()
}

/// At 480 MHz all passes together take longer than the watchdog's time, and one pass over the
/// springs takes 0.1 ms.
#[test]
fn opening_a_large_patch_feeds_the_watchdog_while_the_outputs_are_off() {
    let (frames, board) = answers(&bring(&RELATIVE.0));
    let taken = frames.into_iter().find_map(|frame| {
        decoded(frame, |message| match message {
            FromBoard::PatchTaken(nodes) => Some(nodes),
            FromBoard::Refused(refusal) => panic!("{refusal:?}"),
            _ => None,
        })
    });
    assert_eq!(taken, Some(138));
    assert!(board.fed >= 10 + 2 * 128, "fed {} times", board.fed);
    // the pins never went off, so the outputs may be on, and the watchdog has to act
    let mut stuck = haptic_loop(Arming::OnRequest);
    stuck.board.stuck = Some(Outputs { enabled: true, ..Outputs::OFF });
    let (_, board) = answers_of(stuck, &bring(&RELATIVE.0));
    assert_eq!(board.fed, 0);
}

/// A profile of the desktop stylus with this stiffness ceiling.
fn with_ceiling(stiffness_ceiling_n_per_m: f32) -> ToBoard<'static> {
    ToBoard::Store(Profile { stiffness_ceiling_n_per_m, ..Profile::desktop() })
}

/// Answers of a board to these messages, apart from records.
fn said(messages: &[ToBoard<'_>]) -> Vec<FromBoard> {
    let (frames, _) = answers(messages);
    let said = frames.into_iter().map(|frame| decoded(frame, |message| message));
    said.filter(|message| !matches!(message, FromBoard::Record(_))).collect()
}

/// The patch of 3.5 kPa is 60 N/m stiff at its depth limit, that for the other board 55 N/m.
#[test]
fn a_contact_beyond_the_profile_in_force_is_refused_as_a_profile_as_a_modulus_and_as_a_patch() {
    let mut messages: Vec<ToBoard> = (1..=9).map(|n| pose(n, 2e-3)).collect();
    messages.extend([with_ceiling(40.0), with_ceiling(70.0), pose(10, 2e-3)]);
    // the controller starts anew
    messages.extend((11..=20).map(|n| pose(n, 2e-3)));
    messages.extend([ToBoard::YoungsModulus(4.5e3), ToBoard::YoungsModulus(3.8e3), pose(21, 2e-3)]);
    let told = said(&messages);
    let [profile, FromBoard::Stored(_), modulus, FromBoard::PatchTaken(56)] = &told[..] else { panic!("{told:?}") };
    let FromBoard::Refused(Refusal::ContactStiff(why)) = profile else { panic!("{profile:?}") };
    assert_eq!((why.n_per_m, why.ceiling_n_per_m), (60, 40));
    let FromBoard::Refused(Refusal::ContactStiff(why)) = modulus else { panic!("{modulus:?}") };
    assert_eq!((why.n_per_m, why.ceiling_n_per_m), (78, 70));
    let softer_pa = why.softer_pa as f32;
    assert!((3.8e3..4.1e3).contains(&softer_pa), "{why}");

    // what the refusal names is taken
    messages.extend([ToBoard::YoungsModulus(softer_pa), pose(22, 2e-3)]);
    assert_eq!(said(&messages)[4..], [FromBoard::PatchTaken(56)]);

    // another patch meets the same profile, and the one before it is gone
    let mut other = messages[..9].to_vec();
    other.extend([ToBoard::YoungsModulus(1.75e3), with_ceiling(31.0), pose(10, 2e-3)]);
    other.extend((11..=20).map(|n| pose(n, 2e-3)));
    other.extend(upload::messages(&RELATIVE.0));
    other.extend([ToBoard::Ask(HostAsk::Arm), pose(21, 2e-3)]);
    let told = said(&other);
    assert!(matches!(told[..2], [FromBoard::PatchTaken(56), FromBoard::Stored(_)]), "{told:?}");
    assert!(matches!(told[2], FromBoard::Refused(Refusal::ContactStiff(_))), "{told:?}");
    assert_eq!(told[3..], [FromBoard::Refused(Refusal::NoPatch)]);
}

#[test]
fn a_modulus_under_a_force_is_held_to_the_ceiling() {
    let mut messages: Vec<ToBoard> = (1..=9).map(|n| pose(n, 2e-3)).collect();
    messages.extend([with_ceiling(70.0), pose(10, 2e-3)]);
    messages.extend((11..=20).map(|n| pose(n, 2e-3)));
    messages.push(ToBoard::Ask(HostAsk::Arm));
    messages.extend((21..=800).map(|n| pose(n, 2e-3)));
    messages.extend([ToBoard::YoungsModulus(4.5e3), pose(801, 2e-3), ToBoard::YoungsModulus(3.9e3), pose(802, 2e-3)]);
    let told = said(&messages);
    let [FromBoard::Stored(_), FromBoard::Refused(Refusal::ContactStiff(why)), FromBoard::Modulus(taken_pa)] = told[..] else {
        panic!("{told:?}")
    };
    assert_eq!((why.n_per_m, why.ceiling_n_per_m, why.shallower_um, taken_pa), (78, 70, 0, 3.9e3));
}

/// The modulus set for the previous patch does not apply to the refused one.
#[test]
fn a_patch_that_is_refused_after_another_modulus_is_refused_once() {
    let mut messages: Vec<ToBoard> = (1..=9).map(|n| pose(n, 2e-3)).collect();
    messages.extend([ToBoard::YoungsModulus(4e3), pose(10, 2e-3)]);
    messages.extend(bring(&[1; 16]).split_off(9));
    messages.extend([ToBoard::Ask(HostAsk::Arm), pose(11, 2e-3)]);
    let (frames, _) = answers(&messages);
    let mut told: Vec<String> = Vec::new();
    for frame in frames {
        decoded(frame, |message| match message {
            FromBoard::Record(_) => {}
            other => told.push(format!("{other:?}")),
        });
    }
    assert_eq!(told, ["PatchTaken(56)", "Refused(PatchVersion)", "Refused(NoPatch)"]);
}
