//! A measured indentation: columns of a table by name and unit, first contact, and the segments of
//! the motion. Every error is one sentence: the fault, its place, the remedy.

mod columns;
mod motion;
mod touch;

pub use self::columns::{Table, known};
pub use self::motion::Segments;
use self::motion::{between_readings, driven, lasting, mean, merged, noise, spikes, thinned};
pub(super) use self::motion::{quantile, repeats};
use self::touch::{FEWEST_BEFORE, LEAST_APPROACH, MOST_DRIFT, Touch, UNSURE};

/// Fewest rows of a test.
const FEWEST_ROWS: usize = 20;
/// Change of the force, in standard deviations of its noise, that counts as contact.
const LEAST_NOISES: f64 = 12.0;
/// Share of the depth by which it may grow in a hold in which the force must not (1).
const LEVEL: f64 = 0.005;
/// Share of the way up to which the tip hardly moves, and share of the force that no tissue gives
/// until then (1).
const STILL: f64 = 0.03;
const MOST_EARLY: f64 = 0.1;
/// Share of the rise of the force up to which rows are used to find contact (1).
const CONTACT_SHARE: f64 = 0.5;
/// Mean speeds of a press that are believed [mm/s].
const SPEEDS_MM_PER_S: std::ops::RangeInclusive<f64> = 0.01..=1000.0;
/// Fewest equal readings that count as a step of the converter, or as saturation.
const LEVEL_ROWS: usize = 6;
/// Number of saturated readings over that of the level below, and the way over which they stay over
/// that of the largest step of the converter (1).
const SATURATED: f64 = 2.0;
/// Exponent of force over depth below which a loading is none of a ball on tissue (1).
const LEAST_EXPONENT: f64 = 0.6;
/// Largest number of points of a press that are fitted; more are averaged.
const MOST_POINTS: usize = 600;
/// Largest number of points of a hold, and of a retreat.
const MOST_LATER: usize = 3 * MOST_POINTS;

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
    [contact_m - if starts_before { 0.2 } else { 1.0 } * span_m, contact_m + 0.2 * span_m]
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
        let bad = |what: String| Err(format!("{name}: {what}"));
        if let Some(n) = rows.windows(2).position(|w| w[1][0] < w[0][0]) {
            let [a, b] = [rows[n][0], rows[n + 1][0]];
            return bad(format!(
                "time runs backwards, from {a} to {b} s after row {}: sort the rows, or add a column test that numbers the tests",
                n + 1
            ));
        }
        let mut rows = merged(rows);
        if rows.len() < FEWEST_ROWS {
            return bad(format!(
                "{} rows at different times: a test needs at least {FEWEST_ROWS}; record force and depth while the tip moves in",
                rows.len()
            ));
        }
        let column = |rows: &[[f64; 3]], k: usize| rows.iter().map(|row| row[k]).collect::<Vec<f64>>();
        let [far, also] = [1, 2].map(|k| spikes(&column(&rows, k)));
        let (counted, mut stands_out) = (rows.len(), far.iter().zip(also).map(|(far, also)| *far || also));
        rows.retain(|_| stands_out.next() != Some(true));
        let mut notes = Vec::new();
        if rows.len() < counted {
            notes.push(format!(
                "{name}: {} of {counted} rows stand out of their neighbours and are left out",
                counted - rows.len()
            ));
        }
        let [time, mut depth, force] = [0, 1, 2].map(|k| column(&rows, k));
        between_readings(&mut depth);
        let noise_n = noise(&force);
        let largest = |values: &[f64]| (0..values.len()).fold(0, |most, n| if values[n] > values[most] { n } else { most });
        let first_n = mean(&force[..5]);
        let changes: Vec<f64> = force.iter().map(|force_n| (force_n - first_n).abs()).collect();
        let deepest = largest(&depth);
        let at_peak = largest(&changes[..=deepest]);
        if changes[largest(&changes)] <= LEAST_NOISES * noise_n {
            return bad(
                "no contact: the force never rises out of its noise; press deeper, or check the column of the force".into()
            );
        }
        let upwards = "the depth does not grow while the force does: the depth must be positive into the tissue; change its sign";
        if changes[at_peak] <= LEAST_NOISES * noise_n {
            return bad(upwards.into());
        }
        if force[at_peak] < first_n {
            return bad(
                "the force is negative where it is largest: give the force on the tip, positive when it pushes back".into()
            );
        }
        let moves_m = depth[0] + STILL * (depth[deepest] - depth[0]) + 2.0 * noise(&depth);
        let still = depth.iter().position(|d| *d > moves_m).unwrap_or(0);
        let early_n = if still > 5 { mean(&force[still - 5..still]) - first_n } else { 0.0 };
        if early_n.abs() > MOST_EARLY * changes[at_peak] {
            return bad(format!(
                "the force changes by {:.0} % of its peak before the tip moves: the sensor drifts, or depth and force are swapped; let the sensor warm up, or correct the names of the columns",
                100.0 * early_n.abs() / changes[at_peak]
            ));
        }
        let rises = |n: &usize| force[*n] - first_n > CONTACT_SHARE * changes[at_peak];
        let begins = (0..at_peak).rev().find(|n| !rises(n)).map_or(0, |n| n + 1);
        let touch = Touch::find(&rows[..(begins + 1).max(FEWEST_ROWS).min(rows.len())]);
        let span = depth[deepest] - touch.depth_m;
        if span <= 0.0 || depth[at_peak] <= depth[touch.row] {
            return bad(upwards.into());
        }
        let segments = Segments::of(&depth, touch.row, touch.depth_m);
        let (press, hold) = (segments.press.clone(), segments.hold.clone());
        let starts_before = touch.in_air(&depth, depth[deepest]);
        let zero_n = if starts_before { touch.zero_n } else { 0.0 };
        let peak_n = force[at_peak] - if starts_before { zero_n } else { first_n };
        let (until_s, lasts) = (time[at_peak] - time[0], lasting(&force[hold.clone()], touch.row / 3));
        if let Some(drift_n_per_s) = touch.drift(&rows, until_s, peak_n, noise_n, lasts) {
            return bad(format!(
                "the force changes by {drift_n_per_s:.3} N per second before contact, {:.0} % of its peak until the peak: the sensor drifts, or depth and force are swapped; let the sensor warm up, or correct the names of the columns",
                100.0 * (drift_n_per_s * until_s / peak_n).abs()
            ));
        }
        let quarter = hold.len() / 4;
        let rise = |of: &[f64]| mean(&of[hold.end - quarter..hold.end]) - mean(&of[hold.start..hold.start + quarter]);
        let [rise_m, rise_n] = [&depth, &force].map(|of| rise(of));
        if rise_m < LEVEL * span && rise_n > (MOST_DRIFT * peak_n).max(UNSURE * lasts * noise_n * (2.0 / quarter as f64).sqrt()) {
            return bad(format!(
                "the force rises by {:.0} % of its peak while the depth is held, which no tissue does: the sensor drifts; let the sensor warm up",
                100.0 * rise_n / peak_n
            ));
        }
        rows.iter_mut().for_each(|row| row[2] -= zero_n);
        if span > 0.8 * thickness_m {
            return bad(format!(
                "the depth grows by {:.4} mm, where the tissue is {} mm thick: check the unit of the depth and --thickness",
                span * 1e3,
                thickness_m * 1e3
            ));
        }
        if press.end - touch.row < 8 {
            return bad(format!(
                "{} rows between contact and the deepest point: too few to see how the force grows; record at a higher rate or press more slowly",
                press.end - touch.row
            ));
        }
        let exponent = exponent(&rows[touch.row..press.end], touch.depth_m, peak_n);
        if let Some(exponent) = exponent.filter(|exponent| *exponent < LEAST_EXPONENT) {
            return bad(format!(
                "the force grows only like depth to the power of {exponent:.2}, where tissue gives 1 to 3: the columns of depth and force seem to be swapped; check their names and units"
            ));
        }
        if let Some((row, level_n)) = saturation(&depth, &force, press.end, noise_n.max(noise(&force[..touch.row]))) {
            return bad(format!(
                "the force stays at exactly {} N from {:.2} s on: the sensor is saturated, or the machine holds the force; press less deep, and hold the depth",
                (level_n * 1e6).round() / 1e6,
                time[row]
            ));
        }
        driven(&mut depth, &segments, span);
        rows.iter_mut().zip(depth).for_each(|(row, depth)| row[1] = depth);
        let Segments { press, hold, retreat } = segments;
        // rows long before contact say nothing more
        let from = touch.row.saturating_sub(press.end - touch.row);
        let step = ((press.end - from) / MOST_POINTS).max(1);
        if retreat.end < rows.len() {
            let at_s = time[retreat.end] - time[0];
            notes.push(format!("{name}: the tip comes in again after {at_s:.2} s; the rows after that are left out"));
        }
        let parts =
            [thinned(from..press.end, step, usize::MAX), thinned(hold, step, MOST_LATER), thinned(retreat, step, MOST_LATER)];
        let (press, hold) = (parts[0].len(), parts[0].len() + parts[1].len());
        let points = parts.concat();
        let averaged = |k: usize| -> Vec<f64> { points.iter().map(|at| mean(&column(&rows[at.clone()], k))).collect() };
        let depth_m = averaged(1);
        Ok(Self {
            name: name.into(),
            time_s: averaged(0),
            force_n: averaged(2),
            noise_n: noise_n / (step as f64).sqrt(),
            contact_m: touch.depth_m,
            contact_range_m: contact_range_m(touch.depth_m, span, starts_before),
            found_m: touch.depth_m,
            starts_before,
            zero_n,
            notes,
            segments: Segments { press: 0..press, hold: press..hold, retreat: hold..depth_m.len() },
            depth_m,
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
    /// it is well within its range and the fit says no more of the tip in air.
    pub fn move_contact(&mut self, to_m: f64) -> bool {
        let [low, high] = self.contact_range_m;
        let edge = 0.02 * (high - low);
        let rows = self.depth_m.iter().take_while(|depth_m| **depth_m < to_m);
        let approach_m = to_m - rows.clone().copied().fold(to_m, f64::min);
        let comes_down = rows.count() >= FEWEST_BEFORE && approach_m > LEAST_APPROACH * self.span_m();
        let moves = to_m < low + edge || to_m > high - edge || comes_down && !self.starts_before;
        if moves {
            self.contact_m = to_m;
            self.starts_before |= comes_down;
            self.contact_range_m = contact_range_m(to_m, self.span_m(), self.starts_before);
        }
        moves
    }

    /// Keeps first contact within this depth of the deepest row [m], but no nearer than the range
    /// that it has first in a test that starts before contact.
    pub fn limit_depth(&mut self, most_m: f64) {
        let span_m = self.span_m();
        let [near, _] = contact_range_m(self.found_m, span_m, true);
        let lowest_m = (self.contact_m + span_m - most_m).min(near);
        self.contact_range_m[0] = self.contact_range_m[0].max(lowest_m);
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

/// Slope of ln force over ln depth, between a tenth of the peak and the deepest row.
fn exponent(rows: &[[f64; 3]], surface_m: f64, peak_n: f64) -> Option<f64> {
    let points: Vec<[f64; 2]> = rows
        .iter()
        .filter(|row| row[2] > 0.1 * peak_n && row[1] > surface_m)
        .map(|row| [(row[1] - surface_m).ln(), row[2].ln()])
        .collect();
    let n = points.len() as f64;
    let sum = |of: fn(&[f64; 2]) -> f64| points.iter().map(of).sum::<f64>();
    let (x, y, xx, xy) = (sum(|p| p[0]), sum(|p| p[1]), sum(|p| p[0] * p[0]), sum(|p| p[0] * p[1]));
    (points.len() > 4).then(|| (n * xy - x * y) / (n * xx - x * x))
}

/// First row and force [N] of readings that a sensor cuts off: with noise, more of them are equal
/// to the largest than to the one below; else they are equal over a longer way than that of any
/// step of the converter in the press's upper half.
fn saturation(depth_m: &[f64], force_n: &[f64], press: usize, noise_n: f64) -> Option<(usize, f64)> {
    let equal = |level_n: f64| (0..force_n.len()).filter(|n| force_n[*n] == level_n).collect::<Vec<usize>>();
    let most_n = force_n.iter().copied().fold(f64::MIN, f64::max);
    let below_n = force_n.iter().copied().filter(|f| *f < most_n).fold(f64::MIN, f64::max);
    let [top, next] = [most_n, below_n].map(equal);
    // a converter coarser than the noise has equal readings too
    let step_n = force_n.windows(2).map(|w| (w[1] - w[0]).abs()).filter(|step| *step > 0.0).fold(f64::MAX, f64::min);
    if noise_n > step_n && top.len() >= LEVEL_ROWS.max(SATURATED as usize * next.len()) {
        return Some((top[0], most_n));
    }
    let (depth_m, force_n) = (&depth_m[..press], &force_n[..press]);
    let top_n = quantile(force_n, 1.0 - LEVEL_ROWS as f64 / force_n.len() as f64);
    let way_m = |level: &[usize]| depth_m[level[level.len() - 1]] - depth_m[level[0]];
    let rows: Vec<usize> = (0..force_n.len()).filter(|n| force_n[*n] > 0.5 * top_n).collect();
    let levels = || rows.chunk_by(|a, b| force_n[*a] == force_n[*b]).filter(|level| level.len() >= LEVEL_ROWS);
    let longest = levels().max_by(|a, b| way_m(a).total_cmp(&way_m(b)))?;
    let others = levels().filter(|level| level[0] != longest[0]);
    let step_m = others.map(way_m).fold(1e-3 * (depth_m[depth_m.len() - 1] - depth_m[0]), f64::max);
    (way_m(longest) > SATURATED * step_m).then_some((longest[0], force_n[longest[0]]))
}
