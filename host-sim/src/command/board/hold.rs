//! The commands `palpate board arm`, `watch`, `stop` and `clear`.

mod stream;
mod writer;

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use palpate::haptic::mode::Mode;
use palpate_controller::link::message::HostAsk;
use palpate_controller::link::{FromBoard, Record, ToBoard};
use palpate_controller::words;
use palpate_tissue::Error as TissueError;

use self::stream::Files;
use self::writer::{Writer, Written};
use super::log::{LISTENING, Log};
use super::status;
use crate::command::options::board::{PortArgs, Stream};
use crate::command::progress::Spinner;
use crate::error::Error;
use crate::port::session::{force_words, released_by_itself};
use crate::port::{PortError, Session};

/// Longest wait until a fault is cleared, which needs good poses first.
const CLEARED: Duration = Duration::from_secs(2);
/// Ticks after which a board that is still idle has refused to arm. It leaves idle in the tick
/// after the request, but records from before the request may still be on the line.
const STAYS_IDLE_TICKS: u32 = 2_000;
/// Longest wait for the state of the device.
const TOLD: Duration = Duration::from_millis(500);
/// Longest wait for a record before the keep-alive messages are checked again.
const STEP: Duration = LISTENING;

impl Stream {
    fn until(&self) -> Result<Option<Duration>, Error> {
        let Some(seconds) = self.seconds else { return Ok(None) };
        Duration::try_from_secs_f64(seconds).ok().filter(|time| !time.is_zero()).map(Some).ok_or_else(|| {
            TissueError::Usage(format!("--seconds {seconds}: give a number above zero, or leave it out and end with Ctrl-C"))
                .into()
        })
    }
}

/// Set by Ctrl-C, or by the system's request to end.
pub(super) static ENDED: AtomicBool = AtomicBool::new(false);

pub(super) fn end_at_ctrl_c() -> Result<(), Error> {
    ctrlc::set_handler(|| ENDED.store(true, Ordering::Relaxed)).map_err(|cause| {
        TissueError::Usage(format!("Ctrl-C cannot be caught ({cause}): start this command from another shell")).into()
    })
}

/// Totals over a run.
#[derive(Default)]
struct Seen {
    records: u64,
    first: Option<Record>,
    largest_n: f32,
    deepest_m: f32,
}

impl Seen {
    fn take(&mut self, record: &Record) {
        self.records += 1;
        self.first.get_or_insert(*record);
        self.largest_n = self.largest_n.max(record.applied_n.iter().map(|n| n * n).sum::<f32>().sqrt());
        self.deepest_m = self.deepest_m.max(record.depth_m);
    }

    /// Time on the board since the first record [s].
    fn board_s(&self, last: &Record) -> f64 {
        f64::from(self.first.map_or(0, |first| last.tick.wrapping_sub(first.tick))) * 1e-3
    }
}

pub(super) fn watch(port: &PortArgs, stream: &Stream) -> Result<(), Error> {
    run(port, stream, false)
}

pub(super) fn arm(port: &PortArgs, stream: &Stream) -> Result<(), Error> {
    run(port, stream, true)
}

fn run(port: &PortArgs, stream: &Stream, arm: bool) -> Result<(), Error> {
    let until = stream.until()?;
    end_at_ctrl_c()?;
    let (mut session, mut log) = port.open()?;
    let outcome = hold(&mut session, &mut log, (stream, until), arm);
    log.end(&mut session);
    outcome
}

fn hold(session: &mut Session, log: &mut Log, (stream, until): (&Stream, Option<Duration>), arm: bool) -> Result<(), Error> {
    if arm {
        armable(session)?;
        let commissioned = session.ask(&ToBoard::Report, TOLD, |message| match message {
            FromBoard::State { commissioned, .. } => Some(commissioned),
            _ => None,
        })?;
        if commissioned == Some(false) {
            eprintln!("{}", status::device(false));
        }
    }
    // an earlier stream is kept if there is no board that would write another
    let mut files = Writer::start(Files::begin(stream.out.as_deref(), stream.stream.as_deref())?);
    if arm {
        session.send(&ToBoard::Ask(HostAsk::Arm))?;
        session.keep_alive = true;
        eprintln!("arming: hold the tip still, outside the tissue; Ctrl-C stops. If this command dies, {}", released_by_itself());
    }
    let (mut seen, mut held) = (Seen::default(), None);
    let ended = follow((session, log), until, arm, &mut files, &mut seen, &mut held);
    let lost = matches!(ended, Err(Error::Port(PortError::Lost { .. })));
    let stopped = if arm && !lost { session.stop() } else { Ok(()) };
    // from here on no force acts that a slow disk could end
    let written = files.end();
    stopped?;
    if let Some(gap) = written.as_ref().ok().and_then(Written::gap) {
        eprintln!("{gap}");
    }
    if matches!(ended, Ok(()) | Err(Error::Tissue(TissueError::Check(_)))) {
        println!(
            "{} records over {:.2} s of the board, {} lost; force at most {:.3} N, depth at most {:.2} mm",
            seen.records,
            seen.board_s(&session.record),
            session.counts().lost,
            seen.largest_n,
            seen.deepest_m * 1e3
        );
        for path in written?.sink.publish()? {
            println!("wrote {}", path.display());
        }
        if arm {
            tell_stopped(session);
        }
    }
    ended
}

/// Refuses a board that is not idle: it would not arm, and would not say so.
fn armable(session: &Session) -> Result<(), Error> {
    let record = &session.record;
    match record.mode() {
        Some(Mode::Idle) => Ok(()),
        Some(Mode::Fault) => Err(undone(
            session,
            format!(
                "not armed: {}: see to the cause, then `palpate board clear --port {}`",
                status::fault(record),
                session.port()
            ),
        )),
        _ => Err(undone(session, format!("not armed: the board is not idle ({}): try again", status::mode(record)))),
    }
}

fn undone(session: &Session, what: String) -> Error {
    PortError::Undone { port: session.port().into(), what }.into()
}

/// Reads records until the end. If the board was armed, also checks that it stays armed.
fn follow(
    (session, log): (&mut Session, &mut Log),
    until: Option<Duration>,
    arm: bool,
    files: &mut Writer<Files>,
    seen: &mut Seen,
    held: &mut Option<Mode>,
) -> Result<(), Error> {
    let begun = Instant::now();
    let mut asked = begun;
    let mut lines = Spinner::default();
    let outcome = loop {
        if ENDED.load(Ordering::Relaxed) || until.is_some_and(|until| begun.elapsed() >= until) {
            break Ok(());
        }
        if asked.elapsed() >= LISTENING {
            session.send(&ToBoard::Listen(true))?;
            asked = Instant::now();
        }
        let left = until.map_or(STEP, |until| until.saturating_sub(begun.elapsed()).min(STEP));
        let record = match session.next(left)? {
            Some(FromBoard::Record(record)) => record,
            Some(FromBoard::Refused(refusal)) if arm => {
                break Err(PortError::Refused { port: session.port().into(), refusal }.into());
            }
            Some(FromBoard::Log(_)) => {
                let told = log.lines(session);
                lines.above(|| told.iter().for_each(|line| eprintln!("log: {line}")));
                continue;
            }
            _ => continue,
        };
        seen.take(&record);
        if !files.add(&record, &session.identity) {
            break Ok(()); // the reason is given at the end
        }
        lines.show(|| {
            let [x, y, z] = record.position_m.map(|m| m * 1e3);
            let force = force_words(&record);
            format!("{}; {force}, {:.2} mm deep, tip at {x:.1}, {y:.1}, {z:.1} mm", status::mode(&record), record.depth_m * 1e3)
        });
        if arm {
            let mode = record.mode();
            if let Some(ended) = ended_by_board(&record, *held) {
                break Err(TissueError::Check(format!("{}: {ended}", session.port())).into());
            }
            // the first records may be older than the request
            if mode.is_some_and(|mode| mode != Mode::Idle) {
                *held = mode;
            }
            let ticks = seen.first.map_or(0, |first| record.tick.wrapping_sub(first.tick));
            if held.is_none() && ticks > STAYS_IDLE_TICKS {
                break Err(undone(
                    session,
                    "not armed: the board stays idle. Hold the operator's switch, if its profile has one, and try again".into(),
                ));
            }
        }
    };
    lines.clear();
    outcome
}

/// Says why the force has ended, if the board has ended it.
fn ended_by_board(record: &Record, before: Option<Mode>) -> Option<String> {
    match (before, record.mode()?) {
        (_, Mode::Fault) => Some(format!("the board ended the force: {}; no force acts", status::fault(record))),
        (Some(_), Mode::SafeRamp | Mode::Idle | Mode::Boot | Mode::SelfTest) => Some(
            "the board ended the force by itself: the operator's switch was released, or it did not hear this command for 20 ms (a busy machine, a poor line); arm it again"
                .into(),
        ),
        _ => None,
    }
}

pub(super) fn stop(session: &mut Session) -> Result<(), Error> {
    session.stop()?;
    tell_stopped(session);
    Ok(())
}

fn tell_stopped(session: &Session) {
    let mode = session.record.mode().map_or("mode of another version", words::mode);
    println!("stopped: {mode}, {}", force_words(&session.record));
}

pub(super) fn clear(session: &mut Session) -> Result<(), Error> {
    if session.record.mode() != Some(Mode::Fault) {
        println!("no fault is latched: mode {}", status::mode(&session.record));
        return Ok(());
    }
    let was = status::fault(&session.record);
    let cleared = session.ask(&ToBoard::Ask(HostAsk::Clear), CLEARED, |message| match message {
        FromBoard::Record(record) => (record.mode() == Some(Mode::Idle)).then_some(()),
        _ => None,
    })?;
    if cleared.is_none() {
        let what = format!("not cleared: {}: its cause is still there; see to it and try again", status::fault(&session.record));
        return Err(undone(session, what));
    }
    println!("cleared: {was}; mode {}", status::mode(&session.record));
    Ok(())
}
