//! `palpate board` with the emulated board on a pseudo-terminal: its commands, and every way in
//! which the host can be lost while a force acts.

use std::fs::{File, OpenOptions};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use palpate::haptic::cycle::ArmingSettings;
use palpate::haptic::mode::Mode;
use palpate_board::EmulatedBoard;
use palpate_loop::board_trace::RECORD_TICKS;
use palpate_tests::board_on_a_port::{BoardOnAPort, Pace};
use palpate_tests::emulator::build_firmware;
use palpate_tests::palpate_command::{Desk, Outcome, binary, palpate, repository};
use palpate_tests::pseudo_terminal::PseudoTerminal;

const SCRATCH: &str = env!("CARGO_TARGET_TMPDIR");
/// Three times real time, a pace at which no host loses its board on a busy machine.
const PATIENT: Pace = Pace::ByHost(15);
/// Ticks from the host's last message until the force must be zero, including a margin of two
/// records.
const GONE_TICKS: u64 = ArmingSettings::DEFAULT.silence_ticks as u64 + ArmingSettings::DEFAULT.ramp_ticks as u64 + 40;

fn image() -> &'static Path {
    static IMAGE: OnceLock<PathBuf> = OnceLock::new();
    IMAGE.get_or_init(|| build_firmware(Path::new(SCRATCH).parent().unwrap(), &[]).unwrap())
}

fn started(pace: Pace) -> BoardOnAPort {
    let _built = (binary(SCRATCH), image());
    BoardOnAPort::start(image(), EmulatedBoard::M4f, pace)
}

/// Runs `palpate board` on a port.
fn board(desk: &Desk, port: &str, arguments: &[&str]) -> Outcome {
    palpate(SCRATCH, desk.folder(), &[&["board"], arguments, &["--port", port]].concat())
}

/// Output of a command that must succeed.
fn done(desk: &Desk, port: &str, arguments: &[&str]) -> String {
    let outcome = board(desk, port, arguments);
    assert_eq!(outcome.code, Some(0), "{arguments:?}: {}{}", outcome.stdout, outcome.stderr);
    outcome.stdout
}

/// Checks that a command was refused with one line that contains `says`.
fn refused(outcome: &Outcome, says: &str) {
    assert_eq!(outcome.code, Some(2), "{}{}", outcome.stdout, outcome.stderr);
    let lines: Vec<&str> = outcome.stderr.lines().filter(|line| line.starts_with("palpate: ")).collect();
    assert!(lines.len() == 1 && lines[0].contains(says), "\"{says}\" is not in {:?}", outcome.stderr);
}

/// A running `palpate board arm`.
struct Arming(Option<Child>);

impl Arming {
    fn start(desk: &Desk, port: &str, arguments: &[&str]) -> Self {
        let mut command = Command::new(binary(SCRATCH));
        command.args(["board", "arm", "--port", port]).args(arguments).current_dir(desk.folder());
        Self(Some(command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()))
    }

    fn signal(&self, name: &str) {
        assert!(Command::new("kill").args([name, &self.0.as_ref().unwrap().id().to_string()]).status().unwrap().success());
    }

    fn outcome(mut self) -> Outcome {
        let output = self.0.take().unwrap().wait_with_output().unwrap();
        let [stdout, stderr] = [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
        Outcome { code: output.status.code(), stdout, stderr }
    }
}

impl Drop for Arming {
    fn drop(&mut self) {
        // ends the process of a test that failed
        if let Some(mut child) = self.0.take() {
            let _ = child.kill(); // the process that `start` started
            println!("arm was still to be looked at: {:?}", child.wait_with_output());
        }
    }
}

/// A column of a CSV file.
fn column(csv: &str, name: &str) -> Vec<f64> {
    let at = csv.lines().next().unwrap().split(',').position(|head| head == name).unwrap();
    csv.lines().skip(1).map(|row| row.split(',').nth(at).unwrap().parse().unwrap()).collect()
}

/// The part of a growing file up to the end of its last complete line.
fn whole_lines(csv: &str) -> &str {
    csv.rfind('\n').map_or("", |end| &csv[..=end])
}

#[test]
fn a_board_is_found_told_of_and_given_another_patch_without_a_force() {
    let (desk, on) = (Desk::default(), started(PATIENT));
    let port = on.port();
    let list = palpate(SCRATCH, desk.folder(), &["board", "list", port]);
    assert!(list.code == Some(0) && list.stdout.contains(port) && list.stdout.contains("mps2 0.1.0, built "), "{list:?}");
    let status = done(&desk, port, &["status", "--image", image().to_str().unwrap()]);
    for says in [
        "mode    idle",
        "fault   none",
        "force   0.000 N, outputs off",
        "patch   56 nodes, checksum ",
        "3500 Pa",
        " MHz",
        " % of a period, measured in a tap when the patch was opened; above 85 % the board does not arm (predicted",
        "stack   ",
        "error   calibrated to finite elements of scene block at 100 places: 4.2 % rms off, -34.1 % at worst",
    ] {
        assert!(status.contains(says), "\"{says}\" is not in {status}");
    }
    let watched = done(&desk, port, &["watch", "--seconds", "1", "--out", "new/watched.csv"]);
    assert!(watched.contains("wrote new/watched.csv") && watched.contains("force at most 0.000 N"), "{watched}");
    let csv = std::fs::read_to_string(desk.folder().join("new/watched.csv")).unwrap();
    assert!(column(&csv, "outputs_on").iter().all(|on| *on == 0.0) && csv.lines().count() > 1, "{csv}");
    let ping = done(&desk, port, &["ping", "--count", "20"]);
    assert!(ping.contains("20 of 20 came back, 0 lost"), "{ping}");
    assert!(done(&desk, port, &["modulus", "4000"]).contains("4000 Pa, was 3500 Pa; 56 nodes"));
    refused(&board(&desk, port, &["modulus", "9000"]), "half and twice");
    assert!(done(&desk, port, &["status"]).contains("4000 Pa"), "a refused modulus changes nothing");
    let patch = repository().join("firmware/patches/liver-m4f-168.patch");
    let sent = done(&desk, port, &["upload", patch.to_str().unwrap()]);
    assert!(sent.contains("the board holds 42 nodes") && sent.contains("no record of its fit"), "{sent}");
    let other = done(&desk, port, &["status", "--image", image().to_str().unwrap()]);
    assert!(other.contains("patch   42 nodes") && other.contains("error   unknown: "), "{other}");
    desk.put("cut.patch", &std::fs::read(&patch).unwrap()[..5_000]);
    refused(&board(&desk, port, &["upload", "cut.patch"]), "checksum");
    assert!(done(&desk, port, &["stop"]).contains("stopped: idle, 0.000 N, outputs off"));
    let kept = done(&desk, port, &["profile", "--device", "falcon"]);
    assert!(
        kept.contains("Novint Falcon: at most 8 N, workspace 100 x 100 x 100 mm, a count of 60 um; profile number 1"),
        "{kept}"
    );
    refused(&board(&desk, port, &["profile", "--device", "falcno"]), "is no profile");
    assert!(done(&desk, port, &["clear"]).contains("no fault is latched"));
    let truth = on.truth();
    assert_eq!((truth.mode(), truth.record.fault, truth.largest_n), (Some(Mode::Idle), 0, 0.0), "nothing was enabled");
}

#[test]
fn a_press_is_streamed_and_a_held_port_is_refused() {
    let (desk, on) = (Desk::default(), started(PATIENT));
    let arming = Arming::start(&desk, on.port(), &["--out", "press.csv", "--stream", "growing.csv"]);
    on.wait_for_force();
    let growing = || std::fs::read_to_string(desk.folder().join("growing.csv")).unwrap();
    let felt_n = || column(whole_lines(&growing()), "applied_z_n").into_iter().fold(0.0, f64::max);
    on.wait_for("its row in the file that grows", |_| felt_n() > 0.05);
    refused(&board(&desk, on.port(), &["status"]), "another program has this port open");
    assert!(on.truth().record.enabled, "who may not have the port disturbs nobody");
    assert!(!desk.listing().contains(&"press.csv".to_owned()), "it appears when it is done");
    arming.signal("-INT");
    let outcome = arming.outcome();
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    assert!(outcome.stdout.contains("stopped: idle, 0.000 N, outputs off"), "{outcome:?}");
    assert!(outcome.stderr.contains("has none after 140"), "{outcome:?}");
    assert_eq!((on.truth().mode(), on.truth().force_n()), (Some(Mode::Idle), 0.0));
    let csv = std::fs::read_to_string(desk.folder().join("press.csv")).unwrap();
    let force_n = column(&csv, "applied_z_n").into_iter().fold(0.0, f64::max);
    assert!((force_n - f64::from(on.truth().largest_n)).abs() < 0.05, "{force_n} of {}", on.truth().largest_n);
    assert!(column(&csv, "tick").windows(2).all(|pair| pair[1] - pair[0] == f64::from(RECORD_TICKS)), "a row for each record");
    assert_eq!(growing(), csv, "the file that grew has the same rows");
    assert_eq!(column(&csv, "youngs_modulus_pa").first(), Some(&3500.0));
    assert_eq!(desk.listing(), ["growing.csv", "press.csv"]);
}

/// A pipe that nobody reads accepts some hundred records and then blocks, like a disk that stalls.
#[test]
fn a_disk_that_stalls_ends_no_force() {
    let (desk, on) = (Desk::default(), started(PATIENT));
    let pipe = desk.folder().join("slow.csv");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    // opened for reading and writing, since opening one end waits for the other
    let unread = OpenOptions::new().read(true).write(true).open(&pipe).unwrap();
    let arming = Arming::start(&desk, on.port(), &["--stream", "slow.csv"]);
    let at = on.wait_for_force().records;
    on.wait_for("a full pipe", |truth| truth.records > at + 450 || !truth.record.enabled);
    assert!(on.truth().record.enabled, "{:?}", on.truth());
    arming.signal("-INT");
    let mut reader = File::open(&pipe).unwrap();
    drop(unread);
    let mut csv = String::new();
    reader.read_to_string(&mut csv).unwrap();
    let outcome = arming.outcome();
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    let ticks = column(&csv, "tick");
    assert!(ticks.len() > 450 && csv.len() > 1 << 16, "{} rows of {} bytes: it was never full", ticks.len(), csv.len());
    assert!(ticks.windows(2).all(|pair| pair[1] - pair[0] == f64::from(RECORD_TICKS)), "and no row is missing");
}

#[test]
fn a_force_ends_when_its_host_is_killed_or_its_cable_pulled() {
    let (desk, on) = (Desk::default(), started(PATIENT));
    let killed = Arming::start(&desk, on.port(), &["--out", "killed.csv", "--stream", "growing.csv"]);
    on.wait_for_force();
    let growing = || std::fs::read_to_string(desk.folder().join("growing.csv")).unwrap();
    let felt = || column(whole_lines(&growing()), "applied_z_n").iter().any(|n| *n > 0.05);
    on.wait_for("its row in the file that grows", |_| felt());
    killed.signal("-KILL");
    assert_eq!(killed.outcome().code, None);
    on.host_is_gone();
    let took = on.wait_for_no_force(GONE_TICKS);
    println!("killed: no force {took} ticks later");
    assert!(!desk.listing().contains(&"killed.csv".to_owned()));
    assert!(felt(), "what came before the kill is there");
    on.wait_for("idle", |truth| truth.mode() == Some(Mode::Idle));

    let cut = Arming::start(&desk, on.port(), &["--out", "cut.csv"]);
    on.wait_for_force();
    on.unplug();
    let outcome = cut.outcome();
    refused(&outcome, "the port has gone");
    assert!(outcome.stderr.contains("a force of 0.") && outcome.stderr.contains("has none after 140"), "{outcome:?}");
    on.wait_for_no_force(GONE_TICKS);
    assert!(!desk.listing().contains(&"cut.csv".to_owned()), "{:?}", desk.listing());
}

#[test]
fn a_fault_is_told_in_words_until_it_is_cleared() {
    let (desk, on) = (Desk::default(), started(PATIENT));
    let arming = Arming::start(&desk, on.port(), &["--out", "fault.csv"]);
    on.wait_for_force();
    on.hand_astray(true);
    let outcome = arming.outcome();
    let words = "fault 8: the probe moved too fast under force";
    assert_eq!(outcome.code, Some(1), "a promise that did not hold: {outcome:?}");
    assert!(outcome.stderr.contains(words) && outcome.stderr.contains("no force acts"), "{outcome:?}");
    let csv = std::fs::read_to_string(desk.folder().join("fault.csv")).unwrap();
    assert_eq!(column(&csv, "fault").last(), Some(&8.0), "what ends with a fault is whole");
    assert_eq!((on.truth().force_n(), on.truth().record.enabled), (0.0, false));
    let status = done(&desk, on.port(), &["status"]);
    assert!(status.contains(words) && status.contains("mode    fault: no force"), "{status}");
    refused(&board(&desk, on.port(), &["arm", "--seconds", "1"]), words);
    refused(&board(&desk, on.port(), &["modulus", "4000"]), "clear its fault");
    refused(&board(&desk, on.port(), &["clear"]), "its cause is still there");
    on.hand_astray(false);
    let cleared = done(&desk, on.port(), &["clear"]);
    assert!(cleared.contains(words) && cleared.contains("mode idle"), "{cleared}");
    assert_eq!(on.truth().mode(), Some(Mode::Idle), "nothing is enabled by it");
}

#[test]
fn a_board_that_crashed_too_often_refuses_to_arm_in_words() {
    let _built = (binary(SCRATCH), image());
    let (desk, on) = (Desk::default(), BoardOnAPort::start_after_crashes(image(), EmulatedBoard::M4f, PATIENT));
    refused(&board(&desk, on.port(), &["arm", "--seconds", "60"]), "the board refuses: the board crashed three times");
    assert_eq!((on.truth().mode(), on.truth().largest_n), (Some(Mode::Idle), 0.0));
    // it has left no record of a crash, so its watchdog ended a hang
    let status = done(&desk, on.port(), &["status"]);
    assert!(status.contains("crash   since power-on: ticks did not complete, and the watchdog acted"), "{status}");
}

/// Runs a command against a peer that is not a Palpate board. Returns its outcome and the bytes
/// that it sent.
fn peer(says: Option<&'static [u8]>, echoes: bool, arguments: &[&str]) -> (Outcome, Vec<u8>) {
    let mut terminal = PseudoTerminal::open().unwrap();
    let (desk, port) = (Desk::default(), terminal.name().to_owned());
    let told = std::thread::scope(|scope| {
        let running = scope.spawn(|| board(&desk, &port, arguments));
        let mut told = Vec::new();
        while !running.is_finished() {
            let came = terminal.take().unwrap();
            let answer = if echoes { &came } else { says.unwrap_or_default() };
            if terminal.unread_bytes().unwrap() < 1_000 {
                terminal.ours.write_all(answer).unwrap();
            }
            told.extend(came);
            std::thread::sleep(Duration::from_millis(5));
        }
        (running.join().unwrap(), told)
    });
    assert_eq!(desk.listing(), [""; 0], "nothing is left behind");
    told
}

#[test]
fn whatever_is_no_board_of_ours_is_refused_in_a_line_and_told_nothing() {
    let _built = binary(SCRATCH);
    let garbage: &[u8] = b"AT+GMR\r\nOK\r\n\0\x07\x11garbage\0";
    let arm = ["arm", "--out", "x.csv"];
    for (says, echoes, words) in [
        (None, false, "nothing is heard"),
        (None, true, "nothing is heard"),
        (Some(garbage), false, "no frame of ours among them"),
    ] {
        let (outcome, told) = peer(says, echoes, &arm);
        refused(&outcome, words);
        assert_eq!(told, b"", "bytes went to a stranger");
    }
    let (outcome, told) = peer(Some(garbage), false, &["self-test"]);
    refused(&outcome, "no report of a self-test image among them");
    assert_eq!(told, b"", "bytes went to a stranger");
    let desk = Desk::default();
    desk.put("a.file", "text");
    refused(&board(&desk, "/dev/no-such-port", &["status"]), "there is no such port");
    refused(&board(&desk, "a.file", &["status"]), "no serial port");
    refused(&board(&desk, "/dev/no-such-port", &["arm", "--seconds", "-1"]), "--seconds -1");
}

/// Arms, presses and streams for this many ticks of the board's time, all in one run.
fn held_for(ticks: u64) {
    let (desk, on) = (Desk::default(), started(PATIENT));
    let arming = Arming::start(&desk, on.port(), &["--out", "long.csv"]);
    on.wait_for_force();
    let (begun, at) = (Instant::now(), on.truth().records);
    while on.truth().records < at + ticks / u64::from(RECORD_TICKS) {
        assert!(
            on.truth().record.enabled,
            "{:?} after {} ticks",
            on.truth(),
            (on.truth().records - at) * u64::from(RECORD_TICKS)
        );
        std::thread::sleep(Duration::from_millis(50));
    }
    arming.signal("-TERM");
    let outcome = arming.outcome();
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    println!("{} ticks in {:.1} s; {}", ticks, begun.elapsed().as_secs_f64(), outcome.stdout);
    let csv = std::fs::read_to_string(desk.folder().join("long.csv")).unwrap();
    let (ticks_of, mode) = (column(&csv, "tick"), column(&csv, "mode"));
    assert!(ticks_of.last().unwrap() - ticks_of[0] >= ticks as f64);
    let felt = mode.iter().filter(|mode| **mode == f64::from(Mode::Active as u8)).count() as u64;
    assert!(felt >= ticks / u64::from(RECORD_TICKS) - 1, "{felt} records under force");
    assert_eq!((on.truth().mode(), on.truth().force_n()), (Some(Mode::Idle), 0.0));
}

#[test]
fn a_force_is_held_for_seconds() {
    held_for(6_000);
}

#[test]
#[ignore = "long: 600 000 ticks of the board at three times real time"]
fn a_force_is_held_for_ten_minutes() {
    held_for(600_000);
}
