//! Runs the unchanged image that is flashed on a real board on a model of its chip's registers
//! (`tests/unicorn`), which executes instructions and does not measure time.

use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use palpate_board::defmt_log::{self, LogTable};
use palpate_controller::link::{FRAME_BYTES, FromBoard, Receiver, ToBoard, encode};
use serde_json::{Value, json};

use crate::emulator::build_flashed;
use crate::packed;
use crate::palpate_command::repository;

/// Board whose image is run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flashed {
    /// NUCLEO-H743ZI and ZI2.
    H743,
    /// NUCLEO-F446RE.
    F446,
    /// NUCLEO-G474RE.
    G474,
    /// Raspberry Pi Pico 2.
    Pico2,
}

impl Flashed {
    /// Name of the board's alias, after `fw-`.
    pub fn name(self) -> &'static str {
        match self {
            Self::H743 => "h743",
            Self::F446 => "f446",
            Self::G474 => "g474",
            Self::Pico2 => "pico2",
        }
    }

    /// The patch in the board's image.
    pub fn patch(self) -> &'static [u8] {
        packed::on_words(&packed::shipped(if self == Self::Pico2 { "liver-m4f-168.patch" } else { "block-m4f-168.patch" }))
    }
}

/// Input of a period: encoder counts and the host's message, if any.
#[derive(Clone, Copy)]
pub struct Period {
    /// Counts of the three encoders.
    pub counts: [i32; 3],
    /// Messages that the host sends.
    pub says: Option<ToBoard<'static>>,
    /// Number of periods that begin before the tick of this one ends.
    pub late: u32,
}

/// Events at the board.
pub struct Scenario<'a> {
    /// Input of each period of the tick timer.
    pub periods: &'a [Period],
    /// Further keys of a scenario, as `tests/unicorn/run.py` lists them; null if there are none.
    pub more: Value,
}

/// A row of the journal, which the model writes once per period.
pub struct Row {
    /// Level of the enable line.
    pub enable: bool,
    /// Whether the main output is on.
    pub main_output: bool,
    /// Steps of the pulses.
    pub steps: [u64; 3],
    /// Levels of the direction pins.
    pub reverse: [bool; 3],
    /// Bytes that the image read from its UART.
    pub taken: Vec<u8>,
    /// Bytes that it sent.
    pub sent: Vec<u8>,
    /// Number of times that it fed a watchdog.
    pub fed: u64,
    /// Number of times that it restarted a timer of the pulses.
    pub restarts: u64,
    /// Number of writes to a peripheral whose clock did not run yet.
    pub lost: u64,
    /// Whether a force could act in between.
    pub driven: bool,
    /// Number of resets so far, with the one at power-on.
    pub resets: u64,
    /// Address and size [bytes] of each executed block, if the scenario traces this period; zeros
    /// stand for the entry of an interrupt.
    pub trace: Vec<[u32; 2]>,
}

impl Row {
    fn of(row: &Value) -> Self {
        let pin = |n: usize| number(&row["pins"][n]);
        let bytes = |key: &str| {
            let text = row[key].as_str().unwrap_or_default();
            (0..text.len() / 2).filter_map(|n| u8::from_str_radix(&text[2 * n..2 * n + 2], 16).ok()).collect()
        };
        Self {
            enable: pin(0) == 1,
            main_output: pin(1) == 1,
            steps: [2, 3, 4].map(pin),
            reverse: [5, 6, 7].map(|n| pin(n) == 1),
            taken: bytes("taken"),
            sent: bytes("sent"),
            fed: number(&row["fed"]),
            restarts: number(&row["restart"]),
            lost: number(&row["lost"]),
            driven: row["driven"] == true,
            resets: number(&row["resets"]),
            trace: serde_json::from_value::<Vec<u32>>(row["trace"].clone()).unwrap_or_default().as_chunks().0.to_vec(),
        }
    }

    /// Whether no force could act, now or in between.
    pub fn is_off(&self) -> bool {
        !self.enable && !self.main_output && !self.driven
    }
}

/// Report of the model about a run.
pub struct Journal {
    /// The image that was run.
    pub image: PathBuf,
    /// Steps of the timer per period of the pulses.
    pub period_steps: u16,
    /// Shortest time of the board's watchdogs [ms].
    pub watchdog_ms: f64,
    /// Row of the start-up.
    pub started: Row,
    /// Row of each period.
    pub rows: Vec<Row>,
    told: Value,
}

impl Journal {
    /// Register at the end of the run; `None` if the image never wrote it.
    pub fn register(&self, address: u32) -> Option<u64> {
        self.told["registers"].get(format!("{address:#x}")).map(number)
    }

    /// Most instructions between two feedings of the watchdog during start-up, if the scenario
    /// counts them.
    pub fn longest_unfed(&self) -> u64 {
        number(&self.told["longest_unfed"])
    }

    /// Messages in these rows.
    ///
    /// # Panics
    /// Panics if a frame is damaged.
    pub fn messages(rows: &[Row]) -> Vec<FromBoard> {
        let mut receiver = Receiver::NEW;
        let bytes = rows.iter().flat_map(|row| &row.sent);
        bytes.filter_map(|byte| receiver.push::<FromBoard>(*byte)).map(|message| message.expect("a good frame")).collect()
    }

    /// Messages in these rows, without frames that a reset has cut.
    pub fn whole_messages(rows: &[Row]) -> Vec<FromBoard> {
        let mut receiver = Receiver::NEW;
        let bytes = rows.iter().flat_map(|row| &row.sent);
        bytes.filter_map(|byte| receiver.push::<FromBoard>(*byte)?.ok()).collect()
    }

    /// Lines of the log that the image sent in these rows, decoded with its ELF file.
    ///
    /// # Panics
    /// Panics if the image cannot decode them, or some are lost.
    pub fn log(&self, rows: &[Row]) -> Vec<String> {
        let elf = std::fs::read(&self.image).expect("an image");
        let image = defmt_log::checksum(&elf).expect("the checksum of the image");
        let table = LogTable::of_board(self.image.clone(), image).expect("a table of the log's words");
        let pieces = Self::messages(rows).into_iter().filter_map(|message| match message {
            FromBoard::Log(log) => Some(log),
            _ => None,
        });
        let lines = pieces.flat_map(|log| {
            assert_eq!(log.lost, 0, "lines are lost");
            table.lines(log.frames.bytes())
        });
        lines.collect()
    }
}

/// Runs the image of a board; `None` if the model is not available.
///
/// # Panics
/// Panics if the image cannot be built, or the model finds no way on.
pub fn run(target: &Path, board: Flashed, scenario: &Scenario) -> Option<Journal> {
    let mut periods = scenario.periods.iter();
    lock_step(target, board, &scenario.more, |_| periods.next().copied())
}

/// Runs the image of a board in lock-step: `input` gives the input of a period after the row of the
/// last one, and ends the run with `None`.
///
/// # Panics
/// As [`run`].
pub fn lock_step(target: &Path, board: Flashed, more: &Value, input: impl FnMut(&Row) -> Option<Period>) -> Option<Journal> {
    lock_step_image(target, board, board.name(), more, input)
}

/// As [`lock_step`], with the image of the alias `fw-IMAGE`.
///
/// # Panics
/// As [`run`].
pub fn lock_step_image(
    target: &Path,
    board: Flashed,
    image: &str,
    more: &Value,
    mut input: impl FnMut(&Row) -> Option<Period>,
) -> Option<Journal> {
    let python = python(target)?;
    let image = build_flashed(target, image).expect("the image builds");
    let mut model = Command::new(python)
        .arg(repository().join("tests/unicorn/run.py"))
        .arg(board.name())
        .arg(&image)
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("python runs");
    let mut given = model.stdin.take().expect("a pipe");
    let mut told = BufReader::new(model.stdout.take().expect("a pipe")).lines();
    let mut answer = || -> Value {
        let line = told.next().expect("the model goes on; above is why it does not").expect("a pipe");
        serde_json::from_str(&line).expect("JSON")
    };
    let mut sequence = 0;
    let mut frame = |message: &ToBoard<'_>| {
        sequence += 1;
        let mut out = [0; FRAME_BYTES];
        let bytes = encode(sequence, message, &mut out).expect("a message fits its frame");
        bytes.iter().map(|byte| format!("{byte:02x}")).collect::<String>()
    };
    let scenario = if more.is_null() { json!({}) } else { more.clone() };
    writeln!(given, "{scenario}").expect("a pipe");
    let mut rows = vec![Row::of(&answer())];
    while let Some(period) = rows.last().and_then(&mut input) {
        let bytes = period.says.as_ref().map_or_else(String::new, &mut frame);
        writeln!(given, "{}", json!({"counts": period.counts, "bytes": bytes, "late": period.late})).expect("a pipe");
        rows.push(Row::of(&answer()));
    }
    drop(given);
    let told = answer();
    assert!(model.wait().expect("python ends").success());
    Some(Journal {
        image,
        period_steps: u16::try_from(number(&told["period_steps"])).expect("16 bits"),
        watchdog_ms: told["watchdog_ms"].as_f64().unwrap_or_default(),
        started: rows.remove(0),
        rows,
        told,
    })
}

fn number(value: &Value) -> u64 {
    value.as_u64().unwrap_or_default()
}

/// Python with the packages of the model in a virtual environment of its own; `None` if that is not
/// possible.
fn python(target: &Path) -> Option<PathBuf> {
    static MAKING: std::sync::Mutex<()> = std::sync::Mutex::new(());
    let _one_at_a_time = MAKING.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    let model = repository().join("tests/unicorn");
    let environment = target.join("unicorn-env");
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
