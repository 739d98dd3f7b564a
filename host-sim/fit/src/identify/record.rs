//! A measured indentation: columns of a table by name and unit, first contact, and the segments of
//! the motion. Every error is one sentence: the fault, its place, the remedy.

mod columns;
mod motion;
mod signal;
mod touch;

pub use self::columns::{Table, known};
pub use self::motion::Segments;
pub(super) use self::motion::{quantile, repeats};
use self::signal::{Signal, UPWARDS};
use self::touch::{FEWEST_BEFORE, LEAST_APPROACH, Touch};

/// Half of the range in which first contact is fitted, over the depth of the press (1).
pub(super) const CONTACT_RANGE: f64 = 0.2;
/// Mean speeds of a press that are believed [mm/s].
const SPEEDS_MM_PER_S: std::ops::RangeInclusive<f64> = 0.01..=1000.0;

/// One test, from the surface on.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// File, and test within it.
    pub name: String,
    /// Times [s].
    pub time_s: Vec<f64>,
    /// Depths that grow into the tissue [m].
    pub depth_m: Vec<f64>,
    /// Forces [N].
    pub force_n: Vec<f64>,
    /// Standard deviation of the force from point to point [N].
    pub noise_n: f64,
    /// Depth of the surface [m]; a fit may move it.
    pub contact_m: f64,
    /// Range of the depth of first contact [m].
    pub contact_range_m: [f64; 2],
    /// Depth at which contact was found first [m].
    found_m: f64,
    /// Whether the tip is known to be in air before contact.
    pub starts_before: bool,
    /// Rows until the depth no longer grows, while it is held, and while it falls.
    pub segments: Segments,
    /// Force in air that was taken off all forces [N].
    pub zero_n: f64,
    /// Notes on how the test was read.
    pub notes: Vec<String>,
}

/// Range [m] in which first contact is fitted, around where it was found; without rows before
/// contact, the first row may be as far below the surface as the tip then moves.
fn contact_range_m(contact_m: f64, span_m: f64, starts_before: bool) -> [f64; 2] {
    [contact_m - if starts_before { CONTACT_RANGE } else { 1.0 } * span_m, contact_m + CONTACT_RANGE * span_m]
}

impl Record {
    /// Points without a file: times [s], depths [m] and forces [N], of which one may be missing
    /// (NaN) where only the motion is known. First contact is at depth zero, or within a range [m].
    #[must_use]
    pub fn of_points(time_s: Vec<f64>, depth_m: Vec<f64>, force_n: Vec<f64>, contact_range_m: [f64; 2]) -> Self {
        let deepest_m = depth_m.iter().copied().fold(0.0, f64::max);
        let press = depth_m.iter().position(|d| *d == deepest_m).map_or(0, |n| n + 1);
        let segments = Segments { press: 0..press, hold: press..depth_m.len(), retreat: depth_m.len()..depth_m.len() };
        Self {
            name: String::new(),
            time_s,
            depth_m,
            force_n,
            noise_n: 0.0,
            contact_m: 0.0,
            contact_range_m,
            found_m: 0.0,
            starts_before: false,
            segments,
            zero_n: 0.0,
            notes: Vec::new(),
        }
    }

    /// Checks a test and finds contact and segments.
    ///
    /// # Errors
    /// One sentence on what makes the test unusable.
    pub fn of(name: &str, rows: &[[f64; 3]], thickness_m: f64) -> Result<Self, String> {
        Self::read(name, rows, thickness_m).map_err(|what| format!("{name}: {what}"))
    }

    fn read(name: &str, rows: &[[f64; 3]], thickness_m: f64) -> Result<Self, String> {
        let mut signal = Signal::of(rows)?;
        let peak = signal.peak()?;
        let touch = Touch::find(signal.first_rows(&peak));
        let span_m = signal.depth_m[peak.deepest] - touch.depth_m;
        if span_m <= 0.0 || signal.depth_m[peak.row] <= signal.depth_m[touch.row] {
            return Err(UPWARDS.into());
        }
        let segments = Segments::of(&signal.depth_m, touch.row, touch.depth_m);
        let starts_before = touch.in_air(&signal.depth_m, signal.depth_m[peak.deepest]);
        let zero_n = if starts_before { touch.zero_n } else { 0.0 };
        let peak_n = signal.force_n[peak.row] - if starts_before { zero_n } else { peak.first_n };
        signal.refuse_drift(&touch, &segments, &peak, peak_n)?;
        signal.rows.iter_mut().for_each(|row| row[2] -= zero_n);
        signal.refuse_what_is_no_press(&touch, &segments, peak_n, [span_m, thickness_m])?;
        let mut notes = Vec::new();
        if signal.left_out > 0 {
            let counted = signal.left_out + signal.rows.len();
            notes.push(format!("{name}: {} of {counted} rows stand out of their neighbours and are left out", signal.left_out));
        }
        if let Some(row) = signal.rows.get(segments.retreat.end) {
            let at_s = row[0] - signal.rows[0][0];
            notes.push(format!("{name}: the tip comes in again after {at_s:.2} s; the rows after that are left out"));
        }
        let (points, segments, noise_n) = signal.points(&touch, &segments, span_m);
        let [time_s, depth_m, force_n] = [0, 1, 2].map(|k| points.iter().map(|point| point[k]).collect());
        Ok(Self {
            name: name.into(),
            time_s,
            depth_m,
            force_n,
            noise_n,
            contact_m: touch.depth_m,
            contact_range_m: contact_range_m(touch.depth_m, span_m, starts_before),
            found_m: touch.depth_m,
            starts_before,
            zero_n,
            notes,
            segments,
        })
    }

    /// Depths below a surface [m] so long before each row [s], by which the forces come late.
    #[must_use]
    pub fn delayed_m(&self, delay_s: f64, surface_m: f64) -> Vec<f64> {
        let last = self.time_s.len() - 1;
        let at = |t: &f64| {
            let n = self.time_s.partition_point(|other| *other < t - delay_s).clamp(1, last);
            let share = (t - delay_s - self.time_s[n - 1]) / (self.time_s[n] - self.time_s[n - 1]);
            self.depth_m[n - 1] + share.clamp(0.0, 1.0) * (self.depth_m[n] - self.depth_m[n - 1])
        };
        let depths: Vec<f64> = if delay_s == 0.0 { self.depth_m.clone() } else { self.time_s.iter().map(at).collect() };
        depths.into_iter().map(|depth_m| depth_m - surface_m).collect()
    }

    /// Moves first contact to where a fit would have it. Nothing moves, and the result is false, if
    /// it need not, is well within its range, and the fit says no more of the tip in air.
    pub fn move_contact(&mut self, to_m: f64, has_to: bool) -> bool {
        let [low, high] = self.contact_range_m;
        let edge = 0.02 * (high - low);
        let rows = self.depth_m.iter().take_while(|depth_m| **depth_m < to_m);
        let approach_m = to_m - rows.clone().copied().fold(to_m, f64::min);
        let comes_down = rows.count() >= FEWEST_BEFORE && approach_m > LEAST_APPROACH * self.span_m();
        let moves = has_to || to_m < low + edge || to_m > high - edge || comes_down && !self.starts_before;
        if moves {
            self.contact_m = to_m;
            self.starts_before |= comes_down;
            self.contact_range_m = contact_range_m(to_m, self.span_m(), self.starts_before);
        }
        moves
    }

    /// Keeps first contact within this depth of the deepest row [m].
    pub fn limit_depth(&mut self, most_m: f64) {
        let [low_m, high_m] = self.contact_range_m;
        let low_m = low_m.max(self.contact_m + self.span_m() - most_m);
        self.contact_m = self.contact_m.max(low_m);
        self.contact_range_m = [low_m, high_m.max(low_m)];
    }

    /// Depth [m] of a press from the upper end of the range that first contact has in a test that
    /// shows the tip in air.
    #[must_use]
    pub fn least_depth_m(&self) -> f64 {
        let span_m = self.span_m();
        self.contact_m + span_m - contact_range_m(self.found_m, span_m, true)[0]
    }

    /// Depth of the deepest row below first contact [m].
    #[must_use]
    pub fn span_m(&self) -> f64 {
        self.depth_m.iter().copied().fold(f64::MIN, f64::max) - self.contact_m
    }

    /// Duration of the hold [s].
    #[must_use]
    pub fn hold_s(&self) -> f64 {
        let hold = &self.time_s[self.segments.hold.clone()];
        hold.last().zip(hold.first()).map_or(0.0, |(end, start)| end - start)
    }

    /// Mean speed of the press [m/s].
    #[must_use]
    pub fn speed_m_per_s(&self) -> f64 {
        let end = self.segments.press.end.min(self.time_s.len() - 1);
        let touched = self.depth_m[..end].iter().rposition(|d| *d < self.contact_m).unwrap_or(0);
        (self.depth_m[end] - self.depth_m[touched]) / (self.time_s[end] - self.time_s[touched]).max(1e-9)
    }

    /// Reason why a test does not show the tip in air, with its remedy.
    #[must_use]
    pub fn why_no_air(&self) -> &'static str {
        let lowest_m = self.depth_m.iter().copied().fold(f64::MAX, f64::min);
        match self.contact_m - lowest_m > LEAST_APPROACH * self.span_m() {
            true => "too few rows show the tip in air before contact; record at a higher rate or come down more slowly",
            false => "the tip does not come down to the surface in the rows; start recording 1 mm above it",
        }
    }

    /// A sentence on a speed that neither hands nor test machines have, as a wrong unit gives it.
    #[must_use]
    pub fn odd_speed(&self) -> Option<String> {
        let speed_mm_per_s = self.speed_m_per_s() * 1e3;
        (!SPEEDS_MM_PER_S.contains(&speed_mm_per_s))
            .then(|| format!("{}: the tip moves in at {speed_mm_per_s:.5} mm/s: check the units of time and depth", self.name))
    }
}
