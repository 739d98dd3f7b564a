//! How far long work is: a bar on a terminal, a line now and then where there is none.

use std::io::IsTerminal;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Work that is done sooner says nothing.
const QUIET: Duration = Duration::from_secs(2);
/// Between two lines [s].
const LINE_S: u64 = 20;

/// Counts steps on standard error.
pub(super) struct Progress {
    bar: ProgressBar,
    what: &'static str,
    length: u64,
    done: AtomicU64,
    began: Instant,
    /// When the last line was written [s]; unused on a terminal.
    told_s: AtomicU64,
    terminal: bool,
}

impl Progress {
    /// Of so many steps; `what` is their plural.
    pub(super) fn new(length: u64, what: &'static str) -> Self {
        let bar = ProgressBar::with_draw_target(Some(length), ProgressDrawTarget::hidden());
        if let Ok(style) = ProgressStyle::with_template(&format!("{{bar:30}} {{pos}}/{{len}} {what}, {{eta}} left")) {
            bar.set_style(style);
        }
        let terminal = std::io::stderr().is_terminal();
        Self { bar, what, length, done: AtomicU64::new(0), began: Instant::now(), told_s: AtomicU64::new(0), terminal }
    }

    /// So many more are done.
    pub(super) fn inc(&self, steps: u64) {
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

    /// Leaves the terminal clean.
    pub(super) fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

/// Work whose length nobody knows; on a terminal only.
#[derive(Default)]
pub(super) struct Spinner {
    began: Option<Instant>,
    bar: Option<ProgressBar>,
}

impl Spinner {
    /// One turn, beside a message.
    pub(super) fn show(&mut self, message: impl FnOnce() -> String) {
        if self.began.get_or_insert_with(Instant::now).elapsed() < QUIET {
            return;
        }
        let bar = self.bar.get_or_insert_with(|| {
            let style = ProgressStyle::with_template("{spinner} {msg}");
            ProgressBar::new_spinner().with_style(style.unwrap_or_else(|_| ProgressStyle::default_spinner()))
        });
        bar.set_message(message());
        bar.tick();
    }

    /// Leaves the terminal clean.
    pub(super) fn clear(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

/// Work that says in words what it is doing; on a terminal only.
#[cfg(feature = "full")]
pub(super) struct Status(ProgressBar);

#[cfg(feature = "full")]
impl Status {
    pub(super) fn start() -> Self {
        let style = ProgressStyle::with_template("{spinner} {elapsed} {msg}");
        let bar = ProgressBar::new_spinner().with_style(style.unwrap_or_else(|_| ProgressStyle::default_spinner()));
        bar.enable_steady_tick(Duration::from_millis(200));
        Self(bar)
    }

    /// The work goes on with this.
    pub(super) fn say(&self, doing: impl Into<String>) {
        self.0.set_message(doing.into());
    }

    /// Prints above the line.
    pub(super) fn above(&self, print: impl FnOnce()) {
        self.0.suspend(print);
    }

    /// Leaves the terminal clean.
    pub(super) fn clear(&self) {
        self.0.finish_and_clear();
    }
}

/// Work that names each of its steps; on a terminal only.
#[cfg(feature = "full")]
#[derive(Default)]
pub(super) struct Bar {
    began: Option<Instant>,
    bar: Option<ProgressBar>,
}

#[cfg(feature = "full")]
impl Bar {
    /// So many steps of `total` are done; `what` is the next one.
    pub(super) fn show(&mut self, done: usize, total: usize, what: impl Into<String>) {
        if self.began.get_or_insert_with(Instant::now).elapsed() < QUIET {
            return;
        }
        let bar = self.bar.get_or_insert_with(|| {
            let style = ProgressStyle::with_template("{bar:30} {pos}/{len} {msg} {elapsed}");
            ProgressBar::new(0).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
        });
        bar.set_length(total as u64);
        bar.set_position(done as u64);
        bar.set_message(what.into());
    }

    /// Leaves the terminal clean.
    pub(super) fn clear(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
