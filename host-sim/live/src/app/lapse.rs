//! Time that was dropped because the loop could not keep up. It is shown for some seconds and then
//! forgotten.

/// How long dropped time is shown after the last dropped tick [s].
const TOLD_S: f64 = 5.0;
/// Dropped time up to which no sentence is shown; it is counted all the same [ms].
const WORTH_A_SENTENCE_MS: u64 = 200;

/// Ticks that were dropped recently.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Lapse {
    /// Number of ticks that were dropped since the start.
    counted: u64,
    /// Dropped time that is shown [ms].
    ms: u64,
    until_s: f64,
}

impl Lapse {
    /// Updates the count to `dropped` ticks since the start.
    pub fn count(&mut self, dropped: u64, now_s: f64) {
        let more = dropped.saturating_sub(self.counted);
        self.counted = dropped;
        if more > 0 {
            self.ms = more + self.ms(now_s).unwrap_or(0);
            self.until_s = now_s + TOLD_S;
        }
    }

    /// Dropped time [ms]; `None` once it is no longer shown.
    #[must_use]
    pub fn ms(&self, now_s: f64) -> Option<u64> {
        (now_s < self.until_s).then_some(self.ms)
    }

    /// A sentence about the dropped time, if it is still shown and is long enough to be felt.
    #[must_use]
    pub fn sentence(&self, now_s: f64) -> Option<String> {
        let ms = self.ms(now_s).filter(|ms| *ms > WORTH_A_SENTENCE_MS)?;
        Some(format!("{ms} ms of the tissue's time were dropped: machine busy or asleep."))
    }
}
