//! The unchanged image that is flashed on a NUCLEO-H743ZI runs on a model of the chip's registers
//! (`tests/unicorn`). It boots with its outputs off, feeds the watchdog, arms over the frames of
//! the link, and presses bit-identically to the desktop's controller. After a hang the pins are
//! off.
//!
//! The model executes instructions and emulates registers. It does not measure time and does not
//! replace hardware.

use std::path::{Path, PathBuf};
use std::process::Command;

use palpate::haptic::cycle::Settings;
use palpate::haptic::device::{HapticDevice, SensorStatus};
use palpate::haptic::mode::Mode;
use palpate_board::defmt_log::{self, LogTable};
use palpate_board::desktop_board::DesktopBoard;
use palpate_controller::controller::{Arming, Controller};
use palpate_controller::force_out::{DacCode, bridge::Bridge};
use palpate_controller::haptic_loop::HapticLoop;
use palpate_controller::link::inbox::Reply;
use palpate_controller::link::message::HostAsk;
use palpate_controller::link::{FRAME_BYTES, FromBoard, Inbox, Receiver, Record, Refusal, ToBoard, encode};
use palpate_controller::patch::{Memory, Patch};
use palpate_controller::port::Port;
use palpate_controller::probe_in::{EncoderCounts, JointReading, Reading};
use palpate_controller::script;
use palpate_sim::port::device_file;
use palpate_tests::emulator::build_nucleo;
use palpate_tests::flash_patch::in_flash;
use palpate_tests::joint_hand::counts_at;
use palpate_tests::palpate_command::repository;
use palpate_tests::share::long;
use serde_json::{Value, json};

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
const PRESSED_TICKS: u32 = LEAD_TICKS + 100;
/// Longest time that a force may act after the last completed tick [ms].
const OFF_MS: u32 = 5;

fn target() -> &'static Path {
    Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap()
}

/// Python with the packages of the model in a virtual environment of its own; `None` if that is not
/// possible.
fn python() -> Option<PathBuf> {
    let model = repository().join("tests/unicorn");
    let environment = target().join("unicorn-env");
    let python = environment.join("bin/python");
    let runs = |program: &Path, arguments: &[&str]| {
        Command::new(program).args(arguments).output().is_ok_and(|output| output.status.success())
    };
    let check = ["-c", "import elftools, unicorn; assert unicorn.__version__ == '2.1.4'"];
    if runs(&python, &check) {
        return Some(python);
    }
    let (place, wanted) = (environment.to_str()?, model.join("requirements.txt"));
    let made = runs(Path::new("python3"), &["-m", "venv", place])
        && runs(&python, &["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "-r", wanted.to_str()?])
        && runs(&python, &check);
    if !made {
        println!("skipped: python3 with venv, and unicorn and pyelftools from PyPI, cannot be had here");
    }
    made.then_some(python)
}

/// A row of the journal, which the model writes once per period.
struct Row {
    enable: bool,
    main_output: bool,
    steps: [u64; 3],
    reverse: [bool; 3],
    taken: Vec<u8>,
    sent: Vec<u8>,
    fed: u64,
    driven: bool,
    resets: u64,
}

impl Row {
    fn of(row: &Value) -> Self {
        let pin = |n: usize| row["pins"][n].as_u64().unwrap();
        let bytes = |key: &str| {
            let text = row[key].as_str().unwrap();
            (0..text.len() / 2).map(|n| u8::from_str_radix(&text[2 * n..2 * n + 2], 16).unwrap()).collect()
        };
        Self {
            enable: pin(0) == 1,
            main_output: pin(1) == 1,
            steps: [2, 3, 4].map(pin),
            reverse: [5, 6, 7].map(|n| pin(n) == 1),
            taken: bytes("taken"),
            sent: bytes("sent"),
            fed: row["fed"].as_u64().unwrap(),
            driven: row["driven"].as_bool().unwrap(),
            resets: row["resets"].as_u64().unwrap(),
        }
    }

    fn is_off(&self) -> bool {
        !self.enable && !self.main_output && !self.driven
    }
}

struct Journal {
    image: PathBuf,
    period_steps: u16,
    watchdog_ms: f64,
    /// Rows of the journal; the first describes the start-up.
    rows: Vec<Row>,
}

/// Input of a period: encoder counts and the host's message, if any.
struct Period {
    counts: [i32; 3],
    says: Option<ToBoard<'static>>,
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
fn axes(periods: u32) -> Vec<Period> {
    let counts = |period: u32| {
        let share = period.saturating_sub(LEAVES_AT).min(10) as i32;
        script::counts(period, LEAD_TICKS).map(|axis| axis.0 * share / 10)
    };
    let says = |period| if period == SHOWN_AT { Some(ToBoard::Home) } else { host(period, ARM_AT) };
    (0..periods).map(|period| Period { counts: counts(period), says: says(period) }).collect()
}

/// Runs the image; `None` if the model is not available.
fn run(name: &str, periods: &[Period], hang: &Value) -> Option<Journal> {
    let python = python()?;
    let image = build_nucleo(target()).unwrap();
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let [scenario, journal] = ["scenario", "journal"].map(|what| folder.join(format!("{name}-{what}.json")));
    let mut sequence = 0;
    let mut frame = |message: &ToBoard<'_>| {
        sequence += 1;
        let mut out = [0; FRAME_BYTES];
        encode(sequence, message, &mut out).unwrap().iter().map(|byte| format!("{byte:02x}")).collect::<String>()
    };
    let rows: Vec<Value> = periods
        .iter()
        .map(|period| json!({"counts": period.counts, "bytes": period.says.as_ref().map_or_else(String::new, &mut frame)}))
        .collect();
    std::fs::write(&scenario, json!({"periods": rows, "hang": hang}).to_string()).unwrap();
    let run = Command::new(python)
        .arg(repository().join("tests/unicorn/run.py"))
        .args([&image, &scenario, &journal])
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .output()
        .unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let read: Value = serde_json::from_slice(&std::fs::read(&journal).unwrap()).unwrap();
    Some(Journal {
        image,
        period_steps: u16::try_from(read["period_steps"].as_u64().unwrap()).unwrap(),
        watchdog_ms: read["watchdog_ms"].as_f64().unwrap(),
        rows: read["rows"].as_array().unwrap().iter().map(Row::of).collect(),
    })
}

/// Runs the desktop's controller on the bytes that the image received on its UART, tick by tick.
fn on_desktop(periods: &[Period], rows: &[Row]) -> Vec<Record> {
    let mut memory = Box::new(Memory::RESERVED);
    let mut patch = Patch::open(in_flash(), &mut memory, None).unwrap();
    let controller =
        Controller::build(&Settings::safe(&Port::DESKTOP.limits()), Port::DESKTOP.without_home(), Arming::OnRequest).unwrap();
    let mut haptic = HapticLoop::new(DesktopBoard::default(), controller);
    let (mut receiver, mut inbox, mut sequence) = (Receiver::NEW, Inbox::default(), 0);
    let joints = |counts: [i32; 3], sequence| {
        Reading::Joints(JointReading { counts: counts.map(EncoderCounts), sequence, status: SensorStatus::Good })
    };
    let mut newest = joints([0; 3], 0);
    let mut records = Vec::new();
    for (period, row) in periods.iter().zip(rows) {
        for byte in &row.taken {
            let Some(message) = receiver.push::<ToBoard<'_>>(*byte) else { continue };
            match inbox.take(&message.unwrap(), &mut haptic.controller, None) {
                Reply::None | Reply::Listen(_) => {}
                Reply::Store(profile) => {
                    let (settings, port) = profile.split();
                    haptic.controller.restart(&settings, port).unwrap();
                }
                Reply::Home => assert!(haptic.controller.show_home(&newest)),
                other => panic!("{other:?}"),
            }
        }
        let (_, command) = inbox.clear();
        sequence += 1;
        newest = joints(period.counts, sequence);
        records.push(haptic.tick(&mut patch, newest, command, None));
        patch.settle(haptic.controller.in_contact());
    }
    records
}

/// Checks that the image's pins and records equal the desktop's to the bit. Returns the desktop's
/// records and the image's other messages.
fn agree(periods: &[Period], journal: &Journal) -> (Vec<Record>, Vec<FromBoard>) {
    let (started, rows) = journal.rows.split_first().unwrap();
    assert!(started.is_off() && started.fed > 0, "start-up drives nothing and begins to feed the watchdog");
    assert!((4.0..=f64::from(OFF_MS)).contains(&journal.watchdog_ms), "{} ms", journal.watchdog_ms);
    let records = on_desktop(periods, rows);
    for (n, (row, record)) in rows.iter().zip(&records).enumerate() {
        assert_eq!((row.enable, row.main_output), (record.enabled, record.enabled), "period {n}");
        for axis in 0..3 {
            let bridge = Bridge::of(DacCode(record.codes[axis]), journal.period_steps);
            let there = (row.steps[axis], row.reverse[axis]);
            assert_eq!(there, (bridge.steps.into(), bridge.reverse), "period {n}, axis {axis}");
        }
        assert!(row.fed > 0 && row.resets == 1, "period {n}");
        assert!(record.enabled || row.is_off(), "period {n}: something drove the pins meanwhile");
    }
    // and the records that it sent over its UART
    let (mut receiver, mut told, mut others) = (Receiver::NEW, 0, Vec::new());
    for byte in journal.rows.iter().flat_map(|row| &row.sent) {
        match receiver.push::<FromBoard>(*byte) {
            Some(Ok(FromBoard::Record(there))) => {
                let here = records.iter().filter(|record| record.tick == there.tick);
                // a new profile restarts the tick numbers, so several records may have this one
                assert!(here.into_iter().any(|here| there.first_difference(here).is_none()), "tick {}", there.tick);
                told += 1;
            }
            Some(Ok(FromBoard::Log(_))) => {} // see `log`
            Some(Ok(other)) => others.push(other),
            Some(Err(error)) => panic!("{error}"),
            None => {}
        }
    }
    assert!(told > rows.len() / 20 - 5, "{told} records");
    (records, others)
}

/// Log lines that the image sent in these rows, decoded with its ELF file.
fn log(journal: &Journal, rows: &[Row]) -> Vec<String> {
    let elf = std::fs::read(&journal.image).unwrap();
    let image = defmt_log::checksum(&elf).unwrap();
    let table = LogTable::of_board(journal.image.clone(), image).unwrap();
    let (mut receiver, mut lines) = (Receiver::NEW, Vec::new());
    for byte in rows.iter().flat_map(|row| &row.sent) {
        if let Some(Ok(FromBoard::Log(log))) = receiver.push::<FromBoard>(*byte) {
            assert_eq!(log.lost, 0);
            lines.extend(table.lines(log.frames.bytes()));
        }
    }
    lines
}

/// Checks that the first lines contain the given words, one entry per line.
fn begins(lines: &[String], words: &[&str]) {
    let agree = lines.len() >= words.len() && lines.iter().zip(words).all(|(line, words)| line.contains(words));
    assert!(agree, "{lines:#?} do not begin with {words:#?}");
}

fn felt(records: &[Record]) -> f32 {
    let largest_n = records.iter().map(|record| record.applied_n[2]).fold(0.0, f32::max);
    assert_eq!(records.last().unwrap().mode(), Some(Mode::Active));
    assert!(largest_n > 0.1, "the press of 4 mm was not felt: {largest_n} N");
    largest_n
}

#[test]
fn it_boots_arms_and_presses_like_the_desktop_to_the_bit() {
    let periods = axes(if long() { LEAD_TICKS + 2_000 } else { PRESSED_TICKS });
    let Some(journal) = run("press", &periods, &Value::Null) else { return };
    let (records, others) = agree(&periods, &journal);
    assert_eq!(others, [FromBoard::Homed]);
    let told = [
        "started after power-on or the reset button",
        "no profile found: three axes, not homed",
        "patch opened: 56 nodes, checksum ",
        "mode self-test, was boot",
        "mode idle, was self-test",
        "home pose taken",
        "mode arming, was idle",
        "mode active, was arming",
    ];
    begins(&log(&journal, &journal.rows), &told);
    let armed = records.iter().position(|record| record.enabled).unwrap();
    assert!(armed as u32 > ARM_AT, "armed in tick {armed}, before the host asked");
    println!("{} ticks, armed in tick {armed}, {:.4} N at most", records.len(), felt(&records));
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
            Period { counts: [POWER_ON_COUNTS + joint, 0, 0], says }
        })
        .collect();
    let Some(journal) = run("paddle", &periods, &Value::Null) else { return };
    let (records, others) = agree(&periods, &journal);
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
    for hang in [json!({"at": at, "how": "loop", "symbol": "7palpate4tick4tick17h"}), json!({"at": at, "how": "no ticks"})] {
        let mut periods = axes(at + after);
        periods[again as usize].says = Some(ToBoard::Ask(HostAsk::Arm));
        let Some(journal) = run("hang", &periods, &hang) else { return };
        let rows = &journal.rows[1..];
        let hung = at as usize;
        assert!(rows[hung - 1].enable && rows[hung - 1].steps[2] > 0, "a force acts before");
        let off = (hung..).find(|n| rows[*n].resets == 2).expect("the watchdog acts") - hung;
        println!("{hang}: off within {off} periods after the last tick");
        assert!(rows[hung..hung + off].iter().all(|row| row.fed == 0), "nothing feeds the watchdog");
        assert!(off < OFF_MS as usize, "{off} periods");
        for row in &rows[hung + off + 1..] {
            assert!(row.is_off() && row.resets == 2, "it starts anew and arms nothing by itself");
        }
        assert!(rows.last().unwrap().fed > 0, "it runs again");
        let (mut receiver, mut refused) = (Receiver::NEW, false);
        for byte in rows[again as usize..].iter().flat_map(|row| &row.sent) {
            let said = receiver.push::<FromBoard>(*byte);
            refused |= matches!(said, Some(Ok(FromBoard::Refused(Refusal::NotHomed))));
        }
        begins(&log(&journal, &rows[hung + off..]), &["WARN started after a crash or the watchdog's reset"]);
        assert!(refused, "asked for the force again, it lacks its home pose: it forgot what it was");
    }
}
