//! Progress of long work: a bar or a spinner on a terminal, or a line every few seconds without
//! one. Nothing is printed about work that ends within two seconds.

use std::io::IsTerminal;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

/// Duration up to which work prints no progress.
const QUIET: Duration = Duration::from_secs(2);
/// Time between two lines without a terminal [s].
const LINE_S: u64 = 10;
/// Time between two turns of a spinner.
const TURN: Duration = Duration::from_millis(200);

/// Progress of work, on standard error. A thread of its own prints it, also while a single step
/// takes long.
pub struct Progress {
    shared: Arc<Shared>,
    /// The thread, which ends when the sender is dropped.
    thread: Option<(Sender<()>, JoinHandle<()>)>,
}

struct Shared {
    what: &'static str,
    /// The bar on a terminal; `None` without one.
    bar: Option<ProgressBar>,
    count: Mutex<Count>,
}

#[derive(Default)]
struct Count {
    done: u64,
    /// Number of steps; zero while it is unknown.
    of: u64,
    doing: String,
    /// Whether there is something to print.
    shown: bool,
}

impl Progress {
    /// Begins a count up to `of`; `what` names the work or, in the plural, its steps.
    pub fn new(of: u64, what: &'static str) -> Self {
        Self::of(what, Count { of, shown: of > 0, ..Count::default() })
    }

    /// Begins work that only describes its current activity.
    pub fn start() -> Self {
        Self::of("", Count::default())
    }

    fn of(what: &'static str, count: Count) -> Self {
        let bar = std::io::stderr().is_terminal().then(ProgressBar::no_length);
        let shared = Arc::new(Shared { what, bar, count: Mutex::new(count) });
        let (end, ended) = channel();
        let told = Arc::clone(&shared);
        let thread = std::thread::spawn(move || told.tell(&ended));
        Self { shared, thread: Some((end, thread)) }
    }

    /// Adds this many steps to the count.
    pub fn inc(&self, steps: u64) {
        self.update(|count| count.done += steps);
    }

    /// Describes the current activity.
    pub fn say(&self, doing: impl Into<String>) {
        self.update(|count| count.doing = doing.into());
    }

    /// Counts one more step as done; `step` names it.
    pub fn one(&self, step: &str) {
        self.update(|count| (count.done, count.doing) = (count.done + 1, step.to_owned()));
    }

    /// Sets the count to `done` steps of `of`; `next` names the next one.
    pub fn show(&self, done: usize, of: usize, next: &str) {
        self.update(|count| (count.done, count.of, count.doing) = (done as u64, of as u64, next.to_owned()));
    }

    fn update(&self, change: impl FnOnce(&mut Count)) {
        let mut count = self.shared.count();
        change(&mut count);
        count.shown = true;
    }

    /// Removes the bar from the terminal, until something is said again.
    pub fn finish(&self) {
        // the thread draws while it holds the lock
        self.shared.count().shown = false;
        self.shared.bar.iter().for_each(ProgressBar::finish_and_clear);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some((end, thread)) = self.thread.take() {
            drop(end);
            // a thread that panicked has already reported it
            let _ = thread.join();
        }
        self.finish();
    }
}

impl Shared {
    fn count(&self) -> MutexGuard<'_, Count> {
        // a worker may have panicked: the count is still valid
        self.count.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn tell(&self, ended: &Receiver<()>) {
        let (began, mut told_s) = (Instant::now(), None);
        while ended.recv_timeout(TURN) == Err(RecvTimeoutError::Timeout) {
            let spent = began.elapsed();
            let count = self.count();
            if spent < QUIET || !count.shown {
                continue;
            }
            match &self.bar {
                Some(bar) => self.draw(bar, &count),
                None if told_s.is_none_or(|told_s| spent.as_secs() >= told_s + LINE_S) => {
                    told_s = Some(spent.as_secs());
                    self.line(&count, spent.as_secs());
                }
                None => {}
            }
        }
    }

    fn draw(&self, bar: &ProgressBar, count: &Count) {
        let style = ProgressStyle::with_template(match count.of {
            0 => "{spinner} {prefix} {msg} {elapsed}",
            _ => "{prefix} {bar:30} {pos}/{len} {msg}, {eta} left",
        });
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_spinner()));
        bar.set_prefix(self.what);
        bar.set_length(count.of);
        bar.set_position(count.done);
        bar.set_message(count.doing.clone());
        bar.tick();
    }

    fn line(&self, count: &Count, spent_s: u64) {
        let Count { done, of, doing, .. } = count;
        match (of, doing.as_str()) {
            (0, doing) => eprintln!("after {spent_s} s: {doing}"),
            (of, "") => eprintln!("{}: {done} of {of} after {spent_s} s", self.what),
            (of, doing) => eprintln!("{}: {done} of {of} after {spent_s} s, {doing}", self.what),
        }
    }
}

/// Does work that does not count its steps, and names it from the third second on.
pub fn told<T>(doing: &str, work: impl FnOnce() -> T) -> T {
    let progress = Progress::start();
    progress.say(doing);
    work()
}

/// Progress of work that must not share the processor with another thread: it turns the spinner
/// itself.
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

    /// Prints lines above the spinner.
    #[cfg(feature = "full")]
    pub fn above(&self, print: impl FnOnce()) {
        match &self.bar {
            Some(bar) => bar.suspend(print),
            None => print(),
        }
    }

    /// Removes the spinner from the terminal.
    pub fn clear(&self) {
        self.bar.iter().for_each(ProgressBar::finish_and_clear);
    }
}
