//! State of the followed file: rows in order, gaps between them, and the age of the last row.

use palpate_loop::board_trace::{RECORD_TICKS, Row};

use super::tail::Found;
use crate::message::SILENCE_S;

/// Largest number of rows that are shown from one read: those of the last second. More arrive at
/// once if the file is older than the window, or if the window was busy.
const MOST_ROWS: usize = 1_000 / RECORD_TICKS as usize;
/// A tick at least this far ahead of the last one comes from a board that has restarted.
const FAR_TICKS: u32 = 1 << 31;

/// State of the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Phase {
    /// There is no file.
    #[default]
    Absent,
    /// The file has no record yet.
    Begun,
    /// Records of the board arrive in time.
    Live,
    /// No record has arrived for a while.
    Silent,
    /// The file is not a table of a board's records, for this reason.
    Bad(String),
}

/// A row, and the time since the row before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Record of the board in this row.
    pub row: Row,
    /// Ticks since the row before; `None` for the first row of a file or of a board that has
    /// restarted, and after rows that are not shown.
    pub ticks: Option<u32>,
}

impl Step {
    /// Number of records that are missing between this row and the one before.
    #[must_use]
    pub fn lost(&self) -> u32 {
        self.ticks.map_or(0, |ticks| ticks.saturating_sub(1) / RECORD_TICKS)
    }
}

/// Accumulated result of all reads of a file.
#[derive(Debug, Default)]
pub struct Following {
    last: Option<Row>,
    /// Time at which the last row was written [s].
    written_s: f64,
    bad: Option<String>,
    begun: bool,
    /// Number of records read from this file.
    pub records: u64,
    /// Number of records that are missing in this file.
    pub lost: u64,
    /// Number of times that a file began.
    pub files: u64,
}

impl Following {
    /// Adds the result of a read of the file; returns the rows to show, in their order.
    pub fn take(&mut self, found: Found, now_s: f64) -> Vec<Step> {
        let rows = match found {
            Found::Absent => {
                *self = Self { files: self.files, ..Self::default() };
                return Vec::new();
            }
            Found::Bad(why) => {
                *self = Self { bad: Some(why), files: self.files, ..Self::default() };
                return Vec::new();
            }
            Found::Rows(rows) => rows,
        };
        if rows.anew {
            *self = Self { files: self.files + 1, ..Self::default() };
        }
        (self.begun, self.bad) = (true, None);
        let mut steps = Vec::with_capacity(rows.rows.len());
        for row in rows.rows {
            let ticks = self.last.map(|last| row.tick.wrapping_sub(last.tick)).filter(|ticks| (1..FAR_TICKS).contains(ticks));
            let step = Step { row, ticks };
            self.records += 1;
            self.lost += u64::from(step.lost());
            self.last = Some(row);
            self.written_s = now_s - rows.age.as_secs_f64();
            steps.push(step);
        }
        let hidden = steps.len().saturating_sub(MOST_ROWS);
        let mut shown = steps.split_off(hidden);
        if let (1.., Some(first)) = (hidden, shown.first_mut()) {
            // the rows before it are not shown, so the path of the tip to it is unknown
            first.ticks = None;
        }
        shown
    }

    /// State of the file.
    #[must_use]
    pub fn phase(&self, now_s: f64) -> Phase {
        match (&self.bad, self.last) {
            (Some(why), _) => Phase::Bad(why.clone()),
            (None, None) if self.begun => Phase::Begun,
            (None, None) => Phase::Absent,
            (None, Some(_)) if self.silent_s(now_s) > SILENCE_S => Phase::Silent,
            (None, Some(_)) => Phase::Live,
        }
    }

    /// Age of the last record [s]; zero without one.
    #[must_use]
    pub fn silent_s(&self, now_s: f64) -> f64 {
        self.last.map_or(0.0, |_| (now_s - self.written_s).max(0.0))
    }

    /// The last record, however old it is.
    #[must_use]
    pub fn last(&self) -> Option<&Row> {
        self.last.as_ref()
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::super::tail::Rows;
    use super::*;

    fn rows(ticks: &[u32]) -> Rows {
        let rows = ticks.iter().map(|tick| Row { tick: *tick, ..Row::default() }).collect();
        Rows { rows, ..Rows::default() }
    }

    fn found(ticks: &[u32]) -> Found {
        Found::Rows(rows(ticks))
    }

    fn anew(ticks: &[u32], age_s: u64) -> Found {
        Found::Rows(Rows { anew: true, age: Duration::from_secs(age_s), ..rows(ticks) })
    }

    #[test]
    fn a_file_is_absent_then_begun_then_live_then_silent() {
        let mut following = Following::default();
        assert_eq!(following.phase(0.0), Phase::Absent);
        following.take(Found::Absent, 1.0);
        assert_eq!(following.phase(1.0), Phase::Absent);
        following.take(anew(&[], 0), 2.0);
        assert_eq!(following.phase(9.0), Phase::Begun);
        following.take(found(&[20]), 10.0);
        assert_eq!(following.phase(10.0 + 0.9 * SILENCE_S), Phase::Live);
        // reads that find nothing new do not count as records
        following.take(found(&[]), 10.7);
        assert_eq!(following.phase(10.0 + 1.1 * SILENCE_S), Phase::Silent);
        assert!((following.silent_s(17.5) - 7.5).abs() < 1e-12);
        following.take(found(&[40]), 18.0);
        assert_eq!(following.phase(18.0), Phase::Live, "and goes on");
        following.take(Found::Absent, 19.0);
        assert_eq!((following.phase(19.0), following.last()), (Phase::Absent, None));
    }

    #[test]
    fn a_file_of_yesterday_is_silent_at_once() {
        let mut following = Following::default();
        let steps = following.take(anew(&[20, 40], 86_400), 0.5);
        assert_eq!((steps.len(), following.phase(0.5)), (2, Phase::Silent));
        assert!(following.silent_s(0.5) >= 86_400.0);
    }

    #[test]
    fn ticks_between_rows_are_counted_and_lost_records_told() {
        let mut following = Following::default();
        let steps = following.take(anew(&[4_294_967_295, 1, 3, 11, 2, 4], 0), 0.0);
        let ticks: Vec<_> = steps.iter().map(|step| step.ticks).collect();
        // the counter wraps, three records are lost, and the board restarts
        assert_eq!(ticks, [None, Some(2), Some(2), Some(8), None, Some(2)]);
        assert_eq!(steps.iter().map(Step::lost).collect::<Vec<_>>(), [0, 0, 0, 3, 0, 0]);
        assert_eq!((following.records, following.lost), (6, 3));
        // a gap between two reads of the file is counted as well
        assert_eq!(following.take(found(&[8]), 0.1)[0].ticks, Some(4));
        assert_eq!(following.lost, 4);
    }

    #[test]
    fn a_file_that_begins_anew_has_nothing_of_the_one_before() {
        let mut following = Following::default();
        following.take(anew(&[20, 100], 0), 0.0);
        let steps = following.take(anew(&[120], 0), 1.0);
        assert_eq!(steps[0].ticks, None);
        assert_eq!((following.records, following.lost, following.files), (1, 0, 2));
    }

    #[test]
    fn of_a_long_file_the_last_second_is_shown_and_all_is_counted() {
        let ticks: Vec<u32> = (1..=3000).map(|n| n * RECORD_TICKS).collect();
        let mut following = Following::default();
        let steps = following.take(anew(&ticks, 0), 0.0);
        assert_eq!((steps.len(), following.records), (MOST_ROWS, 3000));
        assert_eq!(
            (steps[0].row.tick, steps[MOST_ROWS - 1].row.tick),
            ((3001 - MOST_ROWS as u32) * RECORD_TICKS, 3000 * RECORD_TICKS)
        );
        assert_eq!((steps[0].ticks, steps[1].ticks), (None, Some(RECORD_TICKS)), "the way to the first is unknown");
    }

    #[test]
    fn a_bad_file_is_told_and_shows_nothing_of_before() {
        let mut following = Following::default();
        following.take(anew(&[20], 0), 0.0);
        following.take(Found::Bad("felt.csv:3: why".into()), 0.1);
        assert_eq!((following.phase(0.1), following.last()), (Phase::Bad("felt.csv:3: why".into()), None));
        following.take(anew(&[20], 0), 0.2);
        assert_eq!(following.phase(0.2), Phase::Live);
    }
}
