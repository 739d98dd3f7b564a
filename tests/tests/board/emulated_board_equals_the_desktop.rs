//! The image in the emulator and the controller on this machine run in lock-step over the link.
//! They compute the same bits in every tick through presses, faults and recovery. Bad frames are
//! dropped, and bad patches are refused with an error message. An increase of the longest tick is
//! detected.
//!
//! To accept an intended longer tick, run `cargo test --release --package palpate-tests --test
//! board emulated_board_equals_the_desktop -- --ignored rewrite` and give the reason in the commit.

use std::path::{Path, PathBuf};

use palpate::haptic::mode::Mode;
use palpate::{Fault, Vector3};
use palpate_board::timing::Spread;
use palpate_board::twin::Reading;
use palpate_board::{Board, EmulateError, EmulatedBoard, Lockstep, campaign};
use palpate_controller::config::Profile;
use palpate_controller::link::message::HostAsk;
use palpate_controller::link::{FromBoard, Refusal, ToBoard};
use palpate_controller::patch::Memory;
use palpate_controller::wire_limits::WireLimits;
use palpate_tests::emulator::build_firmware;
use palpate_tests::packed;

/// Instructions per tick of every patch shipped for a board, haptic cycle included. An increase of
/// the longest tick by more than 3 % must be deliberate.
const GOLDEN: &str = "golden/tick-instructions.csv";
const GROWTH: f64 = 0.03;
const SHIPPED: [(&str, EmulatedBoard); 3] = [
    ("block-m4f-168.patch", EmulatedBoard::M4f),
    ("liver-m4f-168.patch", EmulatedBoard::M7),
    ("block-m7-480.patch", EmulatedBoard::M7),
];
const TICKS: u32 = 8_000;
const OUTSIDE_M: Vector3<f32> = Vector3::new(0.0, 0.0, 2e-3);

fn image() -> PathBuf {
    build_firmware(Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap(), &[]).unwrap()
}

fn equal_through_faults(patch: &str, machine: EmulatedBoard) -> Vec<u64> {
    let mut memory = Box::new(Memory::RESERVED);
    let board = Board::start(&image(), machine, None).unwrap();
    let mut twin = Lockstep::new(board, packed::on_words(&packed::shipped(patch)), &mut memory).unwrap();
    let met = campaign::run(&mut twin, TICKS, 4e-3, |_| ()).unwrap();
    let (_, stack_bytes) = twin.state_hash().unwrap();
    assert_eq!(twin.difference, None);
    println!("{patch}: {met:?}, faults {:?}, stack {stack_bytes} bytes", twin.faults);
    for fault in
        [Fault::PoseNotFinite, Fault::SensorFault, Fault::OverSpeed, Fault::PoseStale, Fault::OutOfWorkspace, Fault::SupplyLow]
    {
        assert!(twin.faults.contains(&fault), "{fault} was not met: {:?}", twin.faults);
    }
    assert!(met.felt > 500 && met.faulted > 300 && met.ramping > 50 && met.recovered > 3, "{met:?}");
    assert!(stack_bytes <= 8 * 1024, "{stack_bytes} of 16384 bytes of stack");
    twin.instructions.clone()
}

fn golden_file() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(GOLDEN)
}

/// Recorded median and maximum of a patch's ticks.
fn written(text: &str, patch: &str) -> Option<[f64; 2]> {
    let row = text.lines().find(|line| line.split(',').next() == Some(patch))?;
    let mut numbers = row.split(',').skip(2).map(str::parse);
    Some([numbers.next()?.ok()?, numbers.next()?.ok()?])
}

/// Checks that the longest tick differs from the recorded one by at most `GROWTH` in either
/// direction.
fn growth(patch: &str, spread: &Spread, text: &str) -> Result<(), String> {
    let Some([_, worst]) = written(text, patch) else { return Err(format!("{patch} is not in {GOLDEN}: rewrite it")) };
    let ratio = spread.max as f64 / worst;
    if (ratio - 1.0).abs() <= GROWTH {
        Ok(())
    } else {
        Err(format!("{patch}: the longest tick takes {} instructions, {ratio:.3} of {worst}", spread.max))
    }
}

fn keeps_its_ticks((patch, machine): (&str, EmulatedBoard)) {
    let spread = Spread::of(&equal_through_faults(patch, machine));
    println!("{spread:?}");
    growth(patch, &spread, &std::fs::read_to_string(golden_file()).unwrap()).unwrap();
    assert!(spread.worst_over_median <= 1.15, "{spread:?}");
}

#[test]
fn the_default_block() {
    keeps_its_ticks(SHIPPED[0]);
}

#[test]
fn a_liver_on_the_other_core() {
    keeps_its_ticks(SHIPPED[1]);
}

#[test]
fn the_larger_block_on_the_other_core() {
    keeps_its_ticks(SHIPPED[2]);
}

#[test]
fn a_lump_in_the_block() {
    equal_through_faults("nodule-m7-480.patch", EmulatedBoard::M7);
}

#[test]
fn a_longer_tick_does_not_pass_the_gate() {
    let text = "patch,board,median,longest\na.patch,M4f,70000,74000\n";
    let spread = |max| Spread { median: 70_000, max, worst_over_median: 1.0, without_patch: 0 };
    assert_eq!(growth("a.patch", &spread(76_000), text), Ok(()));
    for (patch, max) in [("a.patch", 76_300), ("a.patch", 71_000), ("b.patch", 74_000)] {
        assert!(growth(patch, &spread(max), text).is_err(), "{patch} {max}");
    }
}

#[test]
#[ignore = "rewrites the golden file: for changes that are meant"]
fn rewrite() {
    let mut text = String::from("patch,board,median,longest\n");
    for (patch, machine) in SHIPPED {
        let spread = Spread::of(&equal_through_faults(patch, machine));
        text.push_str(&format!("{patch},{machine:?},{},{}\n", spread.median, spread.max));
    }
    std::fs::write(golden_file(), text).unwrap();
}

#[test]
fn bad_frames_are_counted_and_the_next_good_one_is_taken() {
    let mut memory = Box::new(Memory::RESERVED);
    let board = Board::start(&image(), EmulatedBoard::M4f, None).unwrap();
    let mut twin = Lockstep::new(board, packed::on_words(&packed::shipped("block-m4f-168.patch")), &mut memory).unwrap();
    twin.arm(OUTSIDE_M).unwrap();
    let rubbish: Vec<u8> = (0..700_u32).map(|n| (n * 89 % 255 + 1) as u8).collect();
    for sent in [&b"\x03\x01\x00"[..], &rubbish, &[0, 0, 0], &[7, 7, 7, 0]] {
        twin.board().send_bytes(sent).unwrap();
        twin.board().send_bytes(&[0]).unwrap();
        twin.tick(Reading::at(OUTSIDE_M), None).unwrap();
    }
    twin.board().send(&ToBoard::Report).unwrap();
    let FromBoard::State { bad_frames, .. } = twin.board().receive().unwrap() else { panic!("no report") };
    assert_eq!(bad_frames, 3);
    assert_eq!(twin.difference, None);
}

#[test]
fn bad_patches_and_raised_limits_are_refused_in_words() {
    let mut board = Board::start(&image(), EmulatedBoard::M4f, None).unwrap();
    let good = std::fs::read(packed::shipped("block-m4f-168.patch")).unwrap();
    let refused = |answer: Result<u32, EmulateError>| match answer {
        Err(EmulateError::Refused(refusal)) => refusal,
        other => panic!("not refused: {other:?}"),
    };
    assert_eq!(refused_begin(&mut board), Refusal::NotIdle, "before it is idle");
    for sequence in 1..=3 {
        board.send(&ToBoard::Pose { position_m: OUTSIDE_M.into(), sequence, good: true }).unwrap();
        board.receive().unwrap();
    }
    let mut flipped = good.clone();
    flipped[5_000] ^= 4;
    assert_eq!(refused(board.upload(&flipped)), Refusal::PatchDamaged);
    assert_eq!(nodes_of(&mut board), 0, "nobody arms on a tissue that was not asked for");
    board.send(&ToBoard::Ask(HostAsk::Arm)).unwrap();
    assert_eq!(board.receive().unwrap(), FromBoard::Refused(Refusal::NoPatch));
    let mut old = good.clone();
    old[8] ^= 1;
    assert_eq!(refused(board.upload(&old)), Refusal::PatchVersion);
    assert_eq!(refused(board.upload(&good[..4_000])), Refusal::PatchDamaged);
    let mut slow = palpate::PatchFile::open(packed::on_words(&packed::shipped("block-m4f-168.patch"))).unwrap();
    slow.stable_dt_s = 0.5e-3;
    let mut bytes = Vec::new();
    slow.write(|piece| bytes.extend_from_slice(piece));
    assert_eq!(refused(board.upload(&bytes)), Refusal::PatchStep);
    board.send(&ToBoard::PatchBegin(70_000)).unwrap();
    assert_eq!(board.receive().unwrap(), FromBoard::Refused(Refusal::PatchTooLong));

    let nodes = board.upload(&good).unwrap();
    assert!(nodes > 40, "{nodes} nodes");
    board.send(&ToBoard::PatchBegin(70_000)).unwrap();
    assert_eq!(board.receive().unwrap(), FromBoard::Refused(Refusal::PatchTooLong));
    assert_eq!(nodes_of(&mut board), nodes, "what was there stays");
    let ask = |board: &mut Board, message: &ToBoard<'_>| {
        board.send(message).unwrap();
        board.receive().unwrap()
    };
    assert_eq!(ask(&mut board, &ToBoard::YoungsModulus(1e5)), FromBoard::Refused(Refusal::ModulusOutOfRange));
    assert_eq!(ask(&mut board, &ToBoard::YoungsModulus(5e3)), FromBoard::PatchTaken(nodes));
    let raised = WireLimits { scalars: [19.0, 500.0, 1.5, 0.1, 5.0], counts: [2, 2, 10, 200] };
    assert_eq!(ask(&mut board, &ToBoard::LowerLimits(raised)), FromBoard::Refused(Refusal::LimitRises));
    let mut profile = Profile::desktop();
    assert_eq!(ask(&mut board, &ToBoard::Store(profile)), FromBoard::Stored(1));
    // storing a profile restarted the board, so it is not idle yet
    assert_eq!(ask(&mut board, &ToBoard::Store(profile)), FromBoard::Refused(Refusal::NotIdle));
    for sequence in 1..=3 {
        let answer = ask(&mut board, &ToBoard::Pose { position_m: OUTSIDE_M.into(), sequence, good: true });
        assert!(matches!(answer, FromBoard::Record(record) if record.tick == sequence), "{answer:?}");
    }
    assert_eq!(ask(&mut board, &ToBoard::Store(profile)), FromBoard::Stored(2));
    for sequence in 1..=3 {
        ask(&mut board, &ToBoard::Pose { position_m: OUTSIDE_M.into(), sequence, good: true });
    }
    // more than the converters can output, and more than any hand could resist
    for max_force_n in [16.5, 1e3] {
        profile.max_force_n = max_force_n;
        assert_eq!(ask(&mut board, &ToBoard::Store(profile)), FromBoard::Refused(Refusal::ProfileRange));
    }
    for refusal in [Refusal::NotIdle, Refusal::PatchDamaged, Refusal::PatchStep, Refusal::LimitRises] {
        assert!(refusal.to_string().contains(": "), "{refusal}: what, and how to mend it");
    }
}

/// Number of nodes of the board's present patch.
fn nodes_of(board: &mut Board) -> u32 {
    board.send(&ToBoard::Report).unwrap();
    match board.receive().unwrap() {
        FromBoard::State { nodes, .. } => nodes,
        other => panic!("no report: {other:?}"),
    }
}

#[test]
fn a_stop_is_not_taken_back_by_what_comes_behind_it() {
    for behind in [HostAsk::Arm, HostAsk::Clear] {
        let mut memory = Box::new(Memory::RESERVED);
        let board = Board::start(&image(), EmulatedBoard::M4f, None).unwrap();
        let mut twin = Lockstep::new(board, packed::on_words(&packed::shipped("block-m4f-168.patch")), &mut memory).unwrap();
        twin.arm(OUTSIDE_M).unwrap();
        twin.ask(HostAsk::Stop).unwrap();
        twin.tick(Reading::at(OUTSIDE_M), Some(behind)).unwrap();
        assert!(matches!(twin.mode(), Mode::SafeRamp | Mode::Idle), "{behind:?}: {:?}", twin.mode());
        assert_eq!(twin.difference, None);
    }
}

#[test]
fn a_modulus_that_is_refused_leaves_the_one_before() {
    let mut memory = Box::new(Memory::RESERVED);
    let board = Board::start(&image(), EmulatedBoard::M4f, None).unwrap();
    let mut twin = Lockstep::new(board, packed::on_words(&packed::shipped("block-m4f-168.patch")), &mut memory).unwrap();
    let board = twin.board();
    board.send(&ToBoard::YoungsModulus(5e3)).unwrap();
    assert!(matches!(board.receive().unwrap(), FromBoard::PatchTaken(_)));
    board.send(&ToBoard::YoungsModulus(1e6)).unwrap();
    assert_eq!(board.receive().unwrap(), FromBoard::Refused(Refusal::ModulusOutOfRange));
    // the desktop's tissue keeps its modulus of 3.5 kPa, so the board's is stiffer by the requested
    // factor
    twin.arm(OUTSIDE_M).unwrap();
    let way = |n: u32| Vector3::new(0.0, 0.0, (2e-3 - 5e-5 * n as f32).max(-1e-3));
    let there_n = (0..200).map(|n| twin.tick(Reading::at(way(n)), None).unwrap().model_n[2]).last().unwrap();
    let here_n = twin.difference.as_ref().map(|d| d.values);
    println!("{there_n} N there, first difference {here_n:?}");
    assert!(there_n > 0.0 && twin.difference.is_some(), "the modulus is the packed one again");
}

fn refused_begin(board: &mut Board) -> Refusal {
    board.send(&ToBoard::PatchBegin(100)).unwrap();
    match board.receive().unwrap() {
        FromBoard::Refused(refusal) => refusal,
        other => panic!("not refused: {other:?}"),
    }
}

#[test]
fn nothing_in_active_accepts_a_mesh() {
    let mut memory = Box::new(Memory::RESERVED);
    let board = Board::start(&image(), EmulatedBoard::M4f, None).unwrap();
    let mut twin = Lockstep::new(board, packed::on_words(&packed::shipped("block-m4f-168.patch")), &mut memory).unwrap();
    twin.arm(OUTSIDE_M).unwrap();
    assert_eq!(refused_begin(twin.board()), Refusal::NotIdle);
    twin.tick(Reading::at(OUTSIDE_M), Some(HostAsk::Stop)).unwrap();
    assert_eq!(twin.difference, None);
}

#[test]
fn a_softer_tissue_comes_at_once_and_a_stiffer_one_when_nothing_touches() {
    let mut memory = Box::new(Memory::RESERVED);
    let board = Board::start(&image(), EmulatedBoard::M4f, None).unwrap();
    let mut twin = Lockstep::new(board, packed::on_words(&packed::shipped("block-m4f-168.patch")), &mut memory).unwrap();
    twin.arm(OUTSIDE_M).unwrap();
    // from outside to a depth of 3 mm at 0.05 m/s, and back
    let way = |n: u32| Vector3::new(0.0, 0.0, (2e-3 - 5e-5 * n as f32).max(-3e-3));
    let hold = |twin: &mut Lockstep<'_>, ticks: std::ops::Range<u32>| {
        ticks.map(|n| twin.tick(Reading::at(way(n)), None).unwrap().model_n[2]).last().unwrap()
    };
    let first_n = hold(&mut twin, 0..300);
    twin.modulus(0.5).unwrap();
    let softer_n = hold(&mut twin, 300..400);
    twin.modulus(1.5).unwrap();
    let asked_n = hold(&mut twin, 400..600);
    let out: Vec<u32> = (0..150).rev().collect();
    for n in out {
        twin.tick(Reading::at(way(n)), None).unwrap();
    }
    let stiffer_n = hold(&mut twin, 0..300);
    println!("{first_n} N, {softer_n} N softer, {asked_n} N asked to be stiffer, {stiffer_n} N after leaving");
    let near = |force_n: f32, ratio: f32| (force_n / (first_n * ratio) - 1.0).abs() < 0.02;
    assert!(near(softer_n, 0.5) && near(asked_n, 0.5) && near(stiffer_n, 1.5));
    twin.board().send(&ToBoard::YoungsModulus(1e6)).unwrap();
    assert_eq!(twin.board().receive().unwrap(), FromBoard::Refused(Refusal::ModulusOutOfRange));
    assert_eq!(twin.difference, None);
}
