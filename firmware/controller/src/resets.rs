//! Detects repeated crashes and watchdog resets: a board that armed after each of them would jerk
//! the hand every time, so it stays `Idle`.

/// Number of crashes within [`WINDOW_MS`] after which arming is barred until power-on or the reset
/// button.
pub const TOO_MANY: usize = 3;
/// Time within which crashes are counted together [ms].
pub const WINDOW_MS: u32 = 60_000;
/// Marks memory that has kept its content during a reset; after power-on the mark is missing.
const MAGIC: u32 = 0x5A1E_0B07;

/// Why the board started.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// Power-on, or the reset button.
    Power,
    /// The watchdog, a panic or a hard fault.
    Crash,
    /// The board restarted itself to store a profile, which neither counts nor ends a bar.
    Restart,
}

/// Times of the last crashes, in memory that start-up does not clear.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct Resets {
    magic: u32,
    /// Time under power, counted on across crashes [ms]; wraps after 49 days.
    now_ms: u32,
    /// Times of the last crashes, newest last; the first `crashes` entries are valid.
    crashed_at_ms: [u32; TOO_MANY],
    crashes: u32,
    /// Exclusive or of all fields above, most of them rotated.
    check: u32,
}

impl Resets {
    /// State after power-on.
    pub const POWER_ON: Self = Self { magic: MAGIC, now_ms: 0, crashed_at_ms: [0; TOO_MANY], crashes: 0, check: MAGIC };

    fn sum(&self) -> u32 {
        let [a, b, c] = self.crashed_at_ms;
        self.magic ^ self.now_ms ^ a ^ b.rotate_left(1) ^ c.rotate_left(2) ^ self.crashes.rotate_left(3)
    }

    /// Records a start of the board. Contents with a wrong checksum mean power-on. Returns true if
    /// arming is barred.
    #[must_use]
    pub fn start(&mut self, cause: Cause) -> bool {
        if cause == Cause::Power || self.magic != MAGIC || self.check != self.sum() || self.crashes as usize > TOO_MANY {
            *self = Self::POWER_ON;
        }
        if cause == Cause::Crash {
            self.crashed_at_ms.rotate_left(1);
            if let Some(newest) = self.crashed_at_ms.last_mut() {
                *newest = self.now_ms;
            }
            self.crashes = (self.crashes + 1).min(TOO_MANY as u32);
        }
        self.check = self.sum();
        let [oldest, ..] = self.crashed_at_ms;
        self.crashes as usize == TOO_MANY && self.now_ms.wrapping_sub(oldest) < WINDOW_MS
    }

    /// Adds a millisecond to the time under power.
    pub fn count(&mut self) {
        self.now_ms = self.now_ms.wrapping_add(1);
        self.check = self.sum();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether the last start bars arming, with `apart_ms` before each crash.
    fn bars(crashes: usize, apart_ms: u32) -> bool {
        let mut resets = Resets { magic: 7, now_ms: 9, crashed_at_ms: [1; 3], crashes: 99, check: 0 };
        let mut barred = resets.start(Cause::Power);
        for _ in 0..crashes {
            (0..apart_ms).for_each(|_| resets.count());
            barred = resets.start(Cause::Crash);
        }
        barred
    }

    #[test]
    fn a_restart_that_is_meant_neither_counts_nor_ends_a_bar() {
        let mut resets = Resets::POWER_ON;
        for _ in 0..5 {
            assert!(!resets.start(Cause::Restart));
        }
        assert_eq!([Cause::Crash, Cause::Crash, Cause::Crash].map(|cause| resets.start(cause)), [false, false, true]);
        assert!(resets.start(Cause::Restart));
        assert!(!resets.start(Cause::Power));
    }

    #[test]
    fn three_crashes_within_a_minute_bar_and_fewer_or_slower_ones_do_not() {
        assert!(!bars(0, 0) && !bars(2, 10));
        assert!(bars(3, 10) && bars(3, 29_999) && bars(30, 10));
        assert!(!bars(3, 30_000) && !bars(10, 30_000));
        assert!(bars(4, 10) && bars(5, 10), "every one beyond the third");
    }

    #[test]
    fn more_crashes_than_are_kept_are_lost_memory_whatever_its_sum_says() {
        let mut resets = Resets { crashes: TOO_MANY as u32 + 1, ..Resets::POWER_ON };
        resets.check = resets.sum();
        assert!(!resets.start(Cause::Crash));
    }

    #[test]
    fn power_off_forgives_and_memory_that_lost_its_content_is_power_on() {
        let mut resets = Resets::POWER_ON;
        assert!(!resets.start(Cause::Crash) && !resets.start(Cause::Crash) && resets.start(Cause::Crash));
        assert!(!resets.clone().start(Cause::Power));
        let words: [fn(&mut Resets) -> &mut u32; 6] = [
            |resets| &mut resets.magic,
            |resets| &mut resets.now_ms,
            |resets| &mut resets.crashed_at_ms[0],
            |resets| &mut resets.crashed_at_ms[1],
            |resets| &mut resets.crashed_at_ms[2],
            |resets| &mut resets.crashes,
        ];
        for (number, word) in words.into_iter().enumerate() {
            for flip in 0..32 {
                let mut damaged = resets;
                *word(&mut damaged) ^= 1 << flip;
                assert!(!damaged.start(Cause::Crash), "word {number}, bit {flip}");
            }
        }
    }
}
