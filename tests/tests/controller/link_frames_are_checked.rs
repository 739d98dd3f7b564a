//! The link under disturbance: random bytes, mutated frames and flipped bits are counted and
//! dropped. No frame is accepted that was not sent, and nothing crashes.
//!
//! `cargo test -p palpate-tests --release --test controller link_frames_are_checked -- --ignored`
//! runs the long form: ten million frames with flipped bits, ten million random or mutated frames.

use palpate::haptic::cycle::Settings;
use palpate::haptic::device::HapticDevice;
use palpate::haptic::mode::Mode;
use palpate_controller::controller::{Arming, Controller};
use palpate_controller::link::frame::FRAME_BYTES;
use palpate_controller::link::inbox::Reply;
use palpate_controller::link::message::HostAsk;
use palpate_controller::link::upload::{UPLOAD_WORDS, Upload};
use palpate_controller::link::{Change, Inbox, Receiver, ToBoard, encode};
use palpate_controller::port::Port;
use palpate_controller::wire_limits::WireLimits;

/// A simple random number generator: xorshift (Marsaglia 2003).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    fn below(&mut self, end: usize) -> usize {
        (self.next() >> 16) as usize % end
    }
}

/// A host's message of kind `n`.
fn message<'a>(n: usize, bytes: &'a [u8], random: &mut Random) -> ToBoard<'a> {
    let word = random.next();
    let real = f32::from_bits(word as u32);
    match n % 9 {
        0 => ToBoard::Heartbeat,
        1 => ToBoard::Pose { position_m: [real, 0.01, -2e-3], sequence: word as u32, good: word & 1 == 0 },
        2 => ToBoard::Ask([HostAsk::Arm, HostAsk::Stop, HostAsk::Clear][word as usize % 3]),
        3 => ToBoard::LowerLimits(WireLimits { scalars: [real, 500.0, 1.5, 0.1, 5.0], counts: [2, word as u16, 10, 200] }),
        4 => ToBoard::YoungsModulus(real),
        5 => ToBoard::PatchBegin(word as u32),
        6 => ToBoard::PatchPart { at: word as u32, bytes },
        7 => ToBoard::PatchEnd,
        _ => ToBoard::Report,
    }
}

/// Flips one to four bits of valid frames; returns the number of frames that were still accepted
/// and the number tried.
fn flips_taken(tries: usize) -> usize {
    let mut random = Random(0x9E37_79B9_7F4A_7C15);
    let bytes: Vec<u8> = (0..192).map(|n| (n * 37) as u8).collect();
    let mut taken = 0;
    for n in 0..tries {
        let mut out = [0; FRAME_BYTES];
        let length = encode(n as u16, &message(n, &bytes[..n % 193], &mut random), &mut out).unwrap().len();
        let mut flipped = out;
        for _ in 0..=random.below(4) {
            let bit = random.below(8 * length);
            flipped[bit / 8] ^= 1 << (bit % 8);
        }
        if flipped == out {
            continue; // all flips cancelled each other
        }
        let mut receiver = Receiver::NEW;
        for byte in flipped[..length].iter().chain(&[0]) {
            taken += usize::from(matches!(receiver.push::<ToBoard<'_>>(*byte), Some(Ok(_))));
        }
    }
    taken
}

/// Feeds random and mutated frames to receiver, inbox and upload; returns the numbers of frames
/// accepted and dropped.
fn storm(frames: usize) -> (u32, u32) {
    let mut random = Random(42);
    let mut controller = Controller::build(&Settings::safe(&Port::DESKTOP.limits()), Port::DESKTOP, Arming::OnRequest).unwrap();
    let (mut receiver, mut inbox) = (Receiver::NEW, Inbox::default());
    let mut upload = Box::new(Upload::RESERVED);
    let bytes = [0x5A_u8; 192];
    for n in 0..frames {
        let mut out = [0; FRAME_BYTES];
        let length =
            encode(n as u16, &message(random.below(9), &bytes[..random.below(193)], &mut random), &mut out).unwrap().len();
        let mut sent = out[..length].to_vec();
        match random.below(5) {
            0 => sent.truncate(random.below(length)),
            1 => {
                let at = random.below(length);
                sent[at] = random.next() as u8;
            }
            2 => sent = (0..random.below(2 * FRAME_BYTES)).map(|_| random.next() as u8).collect(),
            3 => sent.extend_from_within(..length / 2),
            _ => {}
        }
        for byte in sent {
            let Some(Ok(message)) = receiver.push::<ToBoard<'_>>(byte) else { continue };
            let reply = inbox.take(&message, &mut controller, (n % 2 == 0).then_some(&mut *upload));
            assert!(!matches!(reply, Reply::Change(_)), "in {:?} no patch and no parameter is taken", controller.mode());
        }
        if n % 97 == 0 {
            receiver.forget(); // so that any sequence number is accepted next
        }
        inbox.clear();
    }
    assert_eq!(controller.mode(), Mode::Boot, "messages alone move nothing");
    (receiver.counts().good, receiver.counts().bad)
}

#[test]
fn flipped_bits_are_never_taken() {
    assert_eq!(flips_taken(1_000_000), 0);
}

#[test]
fn a_storm_of_bad_frames_is_dropped() {
    let (good, bad) = storm(200_000);
    println!("{good} frames taken, {bad} dropped");
    assert!(good > 20_000 && bad > 20_000, "{good} and {bad}");
}

#[test]
#[ignore = "minutes"]
fn ten_million_flips_and_frames() {
    assert_eq!(flips_taken(10_000_000), 0);
    let (good, bad) = storm(10_000_000);
    assert!(good > 1_000_000 && bad > 1_000_000, "{good} and {bad}");
}

#[test]
fn a_patch_comes_in_order_or_not_at_all() {
    let mut upload = Box::new(Upload::RESERVED);
    assert!(upload.begin(4 * UPLOAD_WORDS as u32 + 1).is_err());
    let patch: Vec<u8> = (0..1_000_u32).map(|n| (n * 7) as u8).collect();
    for (skip, twice) in [(Some(2), None), (None, Some(3))] {
        upload.begin(1_000).unwrap();
        let sent = patch.chunks(192).enumerate().filter(|(n, _)| Some(*n) != skip);
        let mut refused = false;
        for (n, piece) in sent {
            refused |= upload.part(192 * n as u32, piece).is_err();
            if Some(n) == twice {
                refused |= upload.part(192 * n as u32, piece).is_err();
            }
        }
        assert!(refused && upload.whole().is_err());
    }
    upload.begin(1_000).unwrap();
    for (n, piece) in patch.chunks(192).enumerate() {
        assert!(upload.whole().is_err());
        upload.part(192 * n as u32, piece).unwrap();
    }
    assert_eq!(upload.whole().unwrap(), patch);
    assert!(upload.part(1_000, &[1]).is_err(), "more than was announced");
}

#[test]
fn a_mesh_is_taken_when_idle_and_never_when_active() {
    use palpate::haptic::cycle::Command;
    use palpate::haptic::device::{Sensed, SensorStatus};
    use palpate::{Output, ProbePose, Vector3};

    struct Air;
    impl palpate::haptic::cycle::Renderer for Air {
        fn render(&mut self, _: ProbePose) -> Output {
            Output::NONE
        }
        fn reset(&mut self) {}
    }
    let mut controller = Controller::build(&Settings::safe(&Port::DESKTOP.limits()), Port::DESKTOP, Arming::OnRequest).unwrap();
    let mut inbox = Inbox::default();
    let mut seen = Vec::new();
    for sequence in 0..300 {
        let sensed = Sensed { position_m: Vector3::zeros(), sequence, status: SensorStatus::Good };
        let asked = (sequence > 20).then_some(palpate::haptic::cycle::Ask::Arm);
        controller.tick(&mut Air, sensed, Command { asked, ..Command::HEARD }, true);
        let taken = inbox.take(&ToBoard::PatchBegin(100), &mut controller, None) == Reply::Change(Change::MakeRoom(100));
        assert_eq!(taken, controller.mode() == Mode::Idle, "{:?}", controller.mode());
        seen.push(controller.mode());
    }
    assert!(seen.contains(&Mode::Idle) && seen.contains(&Mode::Active));
}
