//! Progress of long work: a bar on a terminal, or a line every few seconds without one.

use std::io::IsTerminal;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Duration up to which work prints no progress.
const QUIET: Duration = Duration::from_secs(2);
/// Time between two lines without a terminal [s].
const LINE_S: u64 = 10;
/// Time between two lines that name a step.
const STEP_LINE: Duration = Duration::from_secs(4);

/// Counts steps of work, on standard error.
pub struct Progress {
    bar: ProgressBar,
    what: &'static str,
    length: u64,
    done: AtomicU64,
    began: Instant,
    /// Time of the last line [s]; unused on a terminal.
    told_s: AtomicU64,
    terminal: bool,
}

impl Progress {
    /// Begins a count up to `length`; `what` is the plural of its steps.
    pub fn new(length: u64, what: &'static str) -> Self {
        let bar = ProgressBar::with_draw_target(Some(length), ProgressDrawTarget::hidden());
        if let Ok(style) = ProgressStyle::with_template(&format!("{{bar:30}} {{pos}}/{{len}} {what}, {{eta}} left")) {
            bar.set_style(style);
        }
        let terminal = std::io::stderr().is_terminal();
        Self { bar, what, length, done: AtomicU64::new(0), began: Instant::now(), told_s: AtomicU64::new(0), terminal }
    }

    /// Adds this many steps to the count.
    pub fn inc(&self, steps: u64) {
        let done = self.done.fetch_add(steps, Ordering::Relaxed) + steps;
        let spent = self.began.elapsed();
        if self.terminal {
            if self.bar.is_hidden() && spent > QUIET {
                self.bar.set_draw_target(ProgressDrawTarget::stderr());
            }
            self.bar.inc(steps);
            return;
        }
        let (now_s, told_s) = (spent.as_secs(), self.told_s.load(Ordering::Relaxed));
        let mine = || self.told_s.compare_exchange(told_s, now_s, Ordering::Relaxed, Ordering::Relaxed).is_ok();
        if now_s >= told_s + LINE_S && mine() {
            eprintln!("{done} of {} {} after {now_s} s", self.length, self.what);
        }
    }

    /// Removes the bar from the terminal.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

/// Progress of work of unknown length.
#[derive(Default)]
pub struct Spinner {
    began: Option<Instant>,
    /// Time of the last line [s]; `None` before the first, and on a terminal.
    told_s: Option<u64>,
    bar: Option<ProgressBar>,
}

impl Spinner {
    /// Turns the spinner by one step, with a message beside it.
    pub fn show(&mut self, message: impl FnOnce() -> String) {
        let spent = self.began.get_or_insert_with(Instant::now).elapsed();
        if spent < QUIET {
            return;
        }
        if !std::io::stderr().is_terminal() {
            let now_s = spent.as_secs();
            if self.told_s.is_none_or(|told_s| now_s >= told_s + LINE_S) {
                self.told_s = Some(now_s);
                eprintln!("after {now_s} s: {}", message());
            }
            return;
        }
        let bar = self.bar.get_or_insert_with(|| {
            let style = ProgressStyle::with_template("{spinner} {msg}");
            ProgressBar::new_spinner().with_style(style.unwrap_or_else(|_| ProgressStyle::default_spinner()))
        });
        bar.set_message(message());
        bar.tick();
    }

    /// Removes the spinner from the terminal.
    pub fn clear(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

/// Time between two turns of the spinner beside work that cannot turn it.
const TURN: Duration = Duration::from_millis(200);

/// Does work that does not count its steps, and names it from the third second on.
pub fn told<T>(doing: &str, work: impl FnOnce() -> T) -> T {
    let (end, ended) = channel::<()>();
    std::thread::scope(|scope| {
        scope.spawn(move || {
            let mut spinner = Spinner { began: Some(Instant::now()), ..Spinner::default() };
            while ended.recv_timeout(TURN) == Err(RecvTimeoutError::Timeout) {
                spinner.show(|| doing.to_owned());
            }
            spinner.clear();
        });
        let result = work();
        drop(end);
        result
    })
}

/// Progress of work that lasts until it is ended: beside a spinner on a terminal, or in a line
/// every few seconds without one.
pub struct Lines {
    spinner: Spinner,
    began: Instant,
    written: Instant,
    terminal: bool,
}

impl Default for Lines {
    fn default() -> Self {
        let now = Instant::now();
        Self { spinner: Spinner::default(), began: now, written: now, terminal: std::io::stderr().is_terminal() }
    }
}

impl Lines {
    /// Sets the description of the present state.
    pub fn say(&mut self, how: impl FnOnce() -> String) {
        if self.terminal {
            self.spinner.show(how);
        } else if self.written.elapsed() >= STEP_LINE {
            self.written = Instant::now();
            eprintln!("after {:.0} s: {}", self.began.elapsed().as_secs_f64(), how());
        }
    }

    /// Prints a line above the spinner.
    pub fn above(&self, print: impl FnOnce()) {
        match &self.spinner.bar {
            Some(bar) => bar.suspend(print),
            None => print(),
        }
    }

    /// Removes the spinner from the terminal.
    pub fn clear(&self) {
        self.spinner.clear();
    }
}

/// Progress of work that describes its current activity.
pub struct Status {
    bar: ProgressBar,
    /// Prints the activity if there is no terminal.
    teller: Option<Teller>,
}

/// Writes a line every few seconds, even while a single step takes longer.
struct Teller {
    doing: Arc<Mutex<String>>,
    /// The thread ends when this sender is dropped.
    end: Sender<()>,
    thread: JoinHandle<()>,
}

impl Teller {
    fn start() -> Self {
        let (end, ended) = channel();
        let doing = Arc::new(Mutex::new(String::new()));
        let shared = Arc::clone(&doing);
        let began = Instant::now();
        let thread = std::thread::spawn(move || {
            let mut wait = QUIET;
            while ended.recv_timeout(wait) == Err(RecvTimeoutError::Timeout) {
                wait = Duration::from_secs(LINE_S);
                let doing = shared.lock().unwrap_or_else(PoisonError::into_inner);
                if !doing.is_empty() {
                    eprintln!("after {} s: {doing}", began.elapsed().as_secs());
                }
            }
        });
        Self { doing, end, thread }
    }

    fn say(&self, doing: String) {
        *self.doing.lock().unwrap_or_else(PoisonError::into_inner) = doing;
    }

    fn stop(self) {
        drop(self.end);
        // a thread that panicked has already reported it
        let _ = self.thread.join();
    }
}

impl Status {
    /// Begins work of unknown length.
    #[must_use]
    pub fn start() -> Self {
        if !std::io::stderr().is_terminal() {
            return Self { bar: ProgressBar::hidden(), teller: Some(Teller::start()) };
        }
        let style = ProgressStyle::with_template("{spinner} {elapsed} {msg}");
        let bar = ProgressBar::new_spinner().with_style(style.unwrap_or_else(|_| ProgressStyle::default_spinner()));
        bar.enable_steady_tick(Duration::from_millis(200));
        Self { bar, teller: None }
    }

    /// Sets the description of the next part of the work.
    pub fn say(&self, doing: impl Into<String>) {
        match &self.teller {
            Some(teller) => teller.say(doing.into()),
            None => self.bar.set_message(doing.into()),
        }
    }

    /// Removes the bar from the terminal.
    pub fn clear(&self) {
        self.bar.finish_and_clear();
        if let Some(teller) = &self.teller {
            teller.say(String::new());
        }
    }
}

impl Drop for Status {
    fn drop(&mut self) {
        if let Some(teller) = self.teller.take() {
            teller.stop();
        }
    }
}

/// Progress of work that names each of its steps.
pub struct Steps {
    stage: &'static str,
    began: Instant,
    /// The bar on a terminal; `None` without one.
    bar: Option<ProgressBar>,
    count: Mutex<Count>,
}

struct Count {
    done: usize,
    total: usize,
    /// Time at which the last line was written.
    written: Instant,
}

impl Steps {
    /// Begins a stage of `total` steps.
    pub fn new(stage: &'static str, total: usize) -> Self {
        let bar = std::io::stderr().is_terminal().then(|| {
            let style = ProgressStyle::with_template("{prefix} {bar:30} {pos}/{len} {msg} {elapsed}");
            let style = style.unwrap_or_else(|_| ProgressStyle::default_bar());
            let bar = ProgressBar::new(total as u64).with_style(style).with_prefix(stage);
            bar.enable_steady_tick(Duration::from_millis(200));
            bar
        });
        let now = Instant::now();
        Self { stage, began: now, bar, count: Mutex::new(Count { done: 0, total, written: now }) }
    }

    /// Counts one more step as done; `step` names it.
    pub fn one(&self, step: &str) {
        self.update(|count| count.done += 1, step);
    }

    /// Names the position that the next step has reached.
    pub fn at(&self, place: &str) {
        self.update(|_| (), place);
    }

    /// Sets the count to `done` steps of `total`; `next` names the next one.
    pub fn show(&self, done: usize, total: usize, next: &str) {
        self.update(|count| (count.done, count.total) = (done, total), next);
    }

    fn update(&self, change: impl FnOnce(&mut Count), message: &str) {
        // another thread may have panicked between a count and its line: the count is still valid
        let mut count = self.count.lock().unwrap_or_else(PoisonError::into_inner);
        change(&mut count);
        if let Some(bar) = &self.bar {
            bar.set_length(count.total as u64);
            bar.set_position(count.done as u64);
            bar.set_message(message.to_owned());
        } else if count.written.elapsed() >= STEP_LINE {
            count.written = Instant::now();
            let (done, total, spent_s) = (count.done, count.total, self.began.elapsed().as_secs_f64());
            eprintln!("{}: {done} of {total} after {spent_s:.0} s, {message}", self.stage);
        }
    }

    /// Removes the bar from the terminal.
    pub fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
