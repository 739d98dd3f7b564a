//! The thread that reads the file and runs this machine's patch.

use std::path::Path;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use palpate_loop::board_trace::{RECORD_TICKS, Row};

use super::following::{Following, Phase, Step};
use super::patches::Given;
use super::tail::Tail;
use super::twin::{Answer, Twin};
use super::words::length;
use crate::message::{Body, Frame};

/// Time between two reads of the file.
const LOOK: Duration = Duration::from_millis(10);

/// A message to the screen.
#[derive(Clone, Debug)]
pub enum Heard {
    /// Another patch is shown: its body and its name.
    Body(Box<Body>, String),
    /// Why the requested patch cannot be shown.
    NoPatch(String),
    /// State after a read of the file.
    State(Box<State>),
}

/// State after a read of the file.
#[derive(Clone, Debug, Default)]
pub struct State {
    /// State of the file.
    pub phase: Phase,
    /// Age of the last record [s].
    pub silent_s: f64,
    /// The last record, however old it is.
    pub row: Option<Row>,
    /// Answer of this machine's patch to that record.
    pub answer: Option<Answer>,
    /// Picture of the newest record; `None` if there is no new record since the last read.
    pub frame: Option<Frame>,
    /// Points of the strips since the last read.
    pub dots: Vec<Dot>,
    /// Whether the file was started again: earlier points then belong to another recording.
    pub anew: bool,
    /// Number of records that were read from this file, and number that are missing in it.
    pub records: [u64; 2],
}

/// One record in the strips.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dot {
    /// Time on the board's clock since the first record [s].
    pub t_s: f64,
    /// Force on the device [N].
    pub applied_n: f32,
    /// Force of the board's patch [N].
    pub model_n: f32,
    /// Force of this machine's patch [N].
    pub twin_n: Option<f32>,
    /// Depth of the tip [m].
    pub depth_m: f32,
    /// Duration of the tick [us].
    pub tick_us: Option<f32>,
}

/// The window's end of the connection to the thread.
pub struct Feed {
    heard: Receiver<Heard>,
    refused: Arc<Mutex<Option<String>>>,
}

impl Feed {
    /// Starts the thread, which ends when this value is dropped.
    #[must_use]
    pub fn start(path: &Path, given: Given) -> Self {
        let (telling, heard) = channel();
        let refused = Arc::new(Mutex::new(None));
        let follower = Follower::of(path, given);
        let told = Arc::clone(&refused);
        std::thread::spawn(move || run(follower, &telling, &told));
        Self { heard, refused }
    }

    /// Returns all messages that came since the last call.
    pub fn poll(&self) -> Vec<Heard> {
        self.heard.try_iter().collect()
    }

    /// Closes the connection, so that no message arrives any more.
    #[cfg(test)]
    pub fn silenced(self) -> Self {
        Self { heard: channel().1, ..self }
    }

    /// The line that says why the file is not a table of a board's records, as long as it is not.
    #[must_use]
    pub fn refused(&self) -> Arc<Mutex<Option<String>>> {
        Arc::clone(&self.refused)
    }
}

fn run(mut follower: Follower, telling: &Sender<Heard>, refused: &Mutex<Option<String>>) {
    let begun = Instant::now();
    loop {
        for heard in follower.look(begun.elapsed().as_secs_f64()) {
            if let Heard::State(state) = &heard {
                let why = if let Phase::Bad(why) = &state.phase { Some(why.clone()) } else { None };
                *refused.lock().unwrap_or_else(PoisonError::into_inner) = why;
            }
            if telling.send(heard).is_err() {
                return;
            }
        }
        std::thread::sleep(LOOK);
    }
}

/// Reads the file and runs the patch beside it.
pub struct Follower {
    tail: Tail,
    following: Following,
    given: Given,
    twin: Option<Twin>,
    /// Checksum of the board's patch for which the twin was chosen.
    chosen_for: Option<u32>,
    body: u32,
    answer: Option<Answer>,
    /// Time of the last dot, on the board's clock [s].
    t_s: f64,
}

impl Follower {
    /// Starts to follow a file that may not exist yet.
    #[must_use]
    pub fn of(path: &Path, given: Given) -> Self {
        Self {
            tail: Tail::of(path),
            following: Following::default(),
            given,
            twin: None,
            chosen_for: None,
            body: 0,
            answer: None,
            t_s: 0.0,
        }
    }

    /// Reads the file once and returns the messages for the screen.
    pub fn look(&mut self, now_s: f64) -> Vec<Heard> {
        let files = self.following.files;
        let steps = self.following.take(self.tail.read(), now_s);
        let mut heard = Vec::new();
        let mut state = State { anew: files != self.following.files, ..State::default() };
        for step in &steps {
            heard.extend(self.choose(&step.row));
            state.dots.push(self.go(step));
        }
        state.row = self.following.last().copied();
        if state.row.is_none() {
            self.answer = None;
        }
        if let (Some(twin), Some(row), false) = (&self.twin, &state.row, steps.is_empty()) {
            state.frame = Some(twin.frame(row, self.body));
        }
        (state.phase, state.silent_s) = (self.following.phase(now_s), self.following.silent_s(now_s));
        (state.answer, state.records) = (self.answer, [self.following.records, self.following.lost]);
        heard.push(Heard::State(Box::new(state)));
        heard
    }

    /// Chooses the patch for the board of a record, unless it is already chosen.
    fn choose(&mut self, row: &Row) -> Option<Heard> {
        if self.chosen_for == Some(row.patch_checksum) {
            return None;
        }
        let first = self.chosen_for.replace(row.patch_checksum).is_none();
        if !first && !matches!(self.given, Given::Nothing) {
            return None;
        }
        self.twin = None;
        match self.given.chosen(row.patch_checksum) {
            Ok(chosen) => {
                self.body += 1;
                let body = Body::of(&chosen.tissue, self.body, chosen.choice.as_ref());
                let name = chosen.name.clone();
                self.twin = Some(Twin::of(chosen));
                Some(Heard::Body(Box::new(body), name))
            }
            Err(why) => Some(Heard::NoPatch(why)),
        }
    }

    fn go(&mut self, step: &Step) -> Dot {
        self.answer = self.twin.as_mut().map(|twin| twin.go(step));
        // the time axis continues when a board has restarted
        self.t_s += f64::from(step.ticks.unwrap_or(RECORD_TICKS)) * 1e-3;
        let row = &step.row;
        Dot {
            t_s: self.t_s,
            applied_n: length(row.applied_n),
            model_n: length(row.model_n),
            twin_n: self.answer.and_then(|answer| answer.force_n).map(length),
            depth_m: row.depth_m,
            tick_us: row.tick_us,
        }
    }
}

#[cfg(test)]
mod tests;
