//! The thread that reads the file and runs this machine's patch.

use std::path::Path;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use palpate_loop::board_trace::Row;

use super::following::{Following, Phase, RECORD_TICKS, Step};
use super::patches::Given;
use super::tail::Tail;
use super::twin::{Answer, Twin};
use super::words::length;
use crate::message::{Body, Frame};

/// Time between two looks at the file: shorter than that between two records.
const LOOK: Duration = Duration::from_millis(10);

/// A message to the screen.
#[derive(Clone, Debug)]
pub enum Heard {
    /// Another patch is shown: its body and its name.
    Body(Box<Body>, String),
    /// Why the patch that was asked for cannot be shown.
    NoPatch(String),
    /// State after a look.
    State(Box<State>),
}

/// State after a look at the file.
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
    /// The picture of the newest record; none if nothing came since the last look.
    pub frame: Option<Frame>,
    /// Points of the strips since the last look.
    pub dots: Vec<Dot>,
    /// The file began anew: earlier dots belong to another recording.
    pub anew: bool,
    /// Records of this file that were read, and records that are missing in it.
    pub records: [u64; 2],
}

/// A record in the strips.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dot {
    /// Time of the board since the first record [s].
    pub t_s: f64,
    /// Force on the device [N].
    pub applied_n: f32,
    /// Force of the board's patch [N].
    pub model_n: f32,
    /// Force of this machine's patch [N].
    pub twin_n: Option<f32>,
    /// Depth [m].
    pub depth_m: f32,
    /// Time of the tick [us].
    pub tick_us: Option<f32>,
}

/// The thread's end in the window.
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

    /// Returns all that came since the last call.
    pub fn poll(&self) -> Vec<Heard> {
        self.heard.try_iter().collect()
    }

    /// Hears nothing any more.
    #[cfg(test)]
    pub fn silenced(self) -> Self {
        Self { heard: channel().1, ..self }
    }

    /// Line that says why the file is no table of a board's records, while it is none.
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

/// File and patch together.
pub struct Follower {
    tail: Tail,
    following: Following,
    given: Given,
    twin: Option<Twin>,
    /// Checksum of the board's patch that the twin was chosen for.
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

    /// Looks at the file once.
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

    /// Makes the patch for the board of a record, unless it is there.
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
        // a board that has started anew goes on beside what it did before
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
