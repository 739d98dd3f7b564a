//! Time that the loop could not keep up with. It is shown for some seconds and then forgotten.

/// Time for which dropped time is shown after the last dropped tick [s].
const TOLD_S: f64 = 5.0;
/// Shorter lapses are counted, but are not worth a sentence [ms].
const WORTH_A_SENTENCE_MS: u64 = 200;

/// Ticks that were dropped recently.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Lapse {
    /// Ticks that were dropped since the start.
    counted: u64,
    /// Dropped time that is shown [ms].
    ms: u64,
    until_s: f64,
}

impl Lapse {
    /// Counts on to `dropped` ticks since the start.
    pub fn count(&mut self, dropped: u64, now_s: f64) {
        let more = dropped.saturating_sub(self.counted);
        self.counted = dropped;
        if more > 0 {
            self.ms = more + self.ms(now_s).unwrap_or(0);
            self.until_s = now_s + TOLD_S;
        }
    }

    /// Dropped time, as long as it is shown [ms].
    #[must_use]
    pub fn ms(&self, now_s: f64) -> Option<u64> {
        (now_s < self.until_s).then_some(self.ms)
    }

    /// A sentence about the dropped time, as long as it is shown and if it is long enough to be
    /// felt.
    #[must_use]
    pub fn sentence(&self, now_s: f64) -> Option<String> {
        let ms = self.ms(now_s).filter(|ms| *ms > WORTH_A_SENTENCE_MS)?;
        Some(format!("{ms} ms of the tissue's time were dropped: machine busy or asleep."))
    }
}
