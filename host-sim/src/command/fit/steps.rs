//! Progress of one stage: a bar on a terminal, a line every few seconds where there is none.

use std::io::IsTerminal;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

/// Between two lines.
const LINE: Duration = Duration::from_secs(4);

/// So many steps of a stage.
pub(super) struct Steps {
    stage: &'static str,
    total: u64,
    began: Instant,
    /// On a terminal.
    bar: Option<ProgressBar>,
    /// Steps done, and when the last line was written.
    told: Mutex<(u64, Instant)>,
}

impl Steps {
    pub(super) fn new(stage: &'static str, total: u64) -> Self {
        let bar = std::io::stderr().is_terminal().then(|| {
            let style = ProgressStyle::with_template("{prefix} {bar:30} {pos}/{len} {msg} {elapsed}");
            let bar =
                ProgressBar::new(total).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar())).with_prefix(stage);
            bar.enable_steady_tick(Duration::from_millis(200));
            bar
        });
        let now = Instant::now();
        Self { stage, total, began: now, bar, told: Mutex::new((0, now)) }
    }

    /// One more is done; `what` it was.
    pub(super) fn one(&self, what: &str) {
        // a step is only counted: what another thread left half done is as good
        let mut told = self.told.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        told.0 += 1;
        self.tell(&mut told, what);
    }

    /// Where the next one is.
    pub(super) fn at(&self, what: &str) {
        let mut told = self.told.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        self.tell(&mut told, what);
    }

    fn tell(&self, (done, last): &mut (u64, Instant), what: &str) {
        if let Some(bar) = &self.bar {
            bar.set_position(*done);
            bar.set_message(what.to_owned());
        } else if last.elapsed() >= LINE {
            *last = Instant::now();
            eprintln!("{}: {done} of {} after {:.0} s, {what}", self.stage, self.total, self.began.elapsed().as_secs_f64());
        }
    }

    /// Leaves the terminal clean.
    pub(super) fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
