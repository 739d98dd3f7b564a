//! Progress of a run: its current part, and the completed share of the annealing.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::paper::Progress;

/// Displays the completed share of the annealing; several threads may count at the same time.
pub struct AnnealingProgress<'a> {
    display: &'a dyn Progress,
    doing: Mutex<String>,
    tried: AtomicUsize,
    trials: usize,
}

impl<'a> AnnealingProgress<'a> {
    /// Starts the display for an annealing of `trials` trials.
    pub fn new(display: &'a dyn Progress, trials: usize) -> Self {
        Self { display, doing: Mutex::default(), tried: AtomicUsize::new(0), trials }
    }

    /// Shows that another part of the run begins.
    pub fn say(&self, doing: impl Into<String>) {
        *self.doing.lock().unwrap_or_else(std::sync::PoisonError::into_inner) = doing.into();
        self.show();
    }

    /// Adds to the number of completed trials.
    pub fn tried(&self, trials: usize) {
        self.tried.fetch_add(trials, Ordering::Relaxed);
        self.show();
    }

    fn show(&self) {
        let doing = self.doing.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let pct = 100 * self.tried.load(Ordering::Relaxed) / self.trials.max(1);
        self.display.say(format!("{doing}; {pct} % of the annealing"));
    }
}
