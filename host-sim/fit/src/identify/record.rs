//! A measured indentation: columns of a table by name and unit, first contact, and the segments of
//! the motion. Every error is one sentence: the fault, its place, the remedy.

mod columns;

use std::ops::Range;

use nalgebra::{Matrix3, Vector3};

pub use columns::{Table, known};

/// Fewest rows of a test.
const FEWEST_ROWS: usize = 20;
/// Rise of the force, in standard deviations of its noise, and over its level (1), that counts as
/// contact.
const LEAST_NOISES: f64 = 12.0;
const LEAST_RISE: f64 = 0.2;
/// Share of the rise of the force up to which rows are used to find contact (1).
const CONTACT_SHARE: f64 = 0.5;
/// Powers of the depth that are tried: Hertz's, and those of thin or stiffening tissue.
const POWERS: [f64; 4] = [1.5, 2.0, 2.75, 4.0];
/// Largest number of rows among which contact is looked for.
const MOST_TRIED: usize = 200;
/// Number of rows before contact from which the zero of the force and its drift are known.
const FEWEST_BEFORE: usize = 8;
/// Way of the tip before contact, as a share of the depth (1), without which it may have been at
/// rest on the tissue.
const LEAST_APPROACH: f64 = 0.05;
/// Largest change of the force by drift until the peak, as a share of the peak (1).
const MOST_DRIFT: f64 = 0.05;
/// Smallest drift that is believed, in standard errors of a line through the rows before contact
/// (1). With three, one in a hundred tests of a quiet sensor was refused, since contact is found
/// from the same noise.
const UNSURE: f64 = 4.5;
/// Share of the deepest depth by which it must fall to count as a retreat (1).
const FALL: f64 = 0.015;
/// Mean speeds of a press that are believed [mm/s].
const SPEEDS_MM_PER_S: std::ops::RangeInclusive<f64> = 0.01..=1000.0;
/// Number of equal largest readings while the depth rises that count as saturation.
const SATURATED: usize = 6;
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
    /// Times [s], depths that grow into the tissue [m] and forces [N].
    pub time_s: Vec<f64>,
    /// Depths [m].
    pub depth_m: Vec<f64>,
    /// Forces [N].
    pub force_n: Vec<f64>,
    /// Standard deviation of the force from point to point [N].
    pub noise_n: f64,
    /// Depth of the row at which contact was found [m], and its range.
    pub contact_m: f64,
    /// Range of the depth of first contact [m].
    pub contact_range_m: [f64; 2],
    /// Whether the file has rows before contact.
    pub starts_before: bool,
    /// Rows until the depth no longer grows, while it is held, and while it falls.
    pub segments: Segments,
}

/// Rows of the segments of a test.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Segments {
    /// The tip moves in, from the first row on.
    pub press: Range<usize>,
    /// The depth is held.
    pub hold: Range<usize>,
    /// The tip moves out; may be empty.
    pub retreat: Range<usize>,
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Standard deviation of the noise from second differences, which a smooth signal hardly has.
fn noise(values: &[f64]) -> f64 {
    let mut second: Vec<f64> = values.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).abs()).collect();
    second.sort_by(f64::total_cmp);
    // median of a normal variable's size is 0.6745 deviations; the variance of the difference is 6
    second.get(second.len() / 2).map_or(0.0, |median| median / 0.6745 / 6_f64.sqrt())
}

/// Ranges of `step` rows, at most `most` of them. Where there are more, the distance between two
/// grows with the time since the first row, as what relaxes changes ever more slowly. Each point
/// averages as many rows, so that all have the same noise.
fn thinned(rows: Range<usize>, step: usize, most: usize) -> Vec<Range<usize>> {
    let count = rows.len().div_ceil(step);
    let chosen = |growth: f64| -> Vec<usize> {
        let next = |at: &usize| Some(at + 1.max((*at as f64 * growth) as usize)).filter(|at| *at < count);
        std::iter::successors((count > 0).then_some(0), next).collect()
    };
    let growths = std::iter::successors(Some(0.0), |growth: &f64| Some((2.0 * growth).max(1.0 / 512.0)));
    let places = growths.take(16).map(chosen).find(|places| places.len() <= most).unwrap_or_default();
    let start = |at: usize| (rows.start + at * step).min(rows.end);
    places.into_iter().map(|at| start(at)..start(at + 1)).collect()
}

/// Range [m] in which first contact is fitted, around where it was found; without rows before
/// contact, the first row may be as far below the surface as the tip then moves.
fn contact_range_m(contact_m: f64, span_m: f64, starts_before: bool) -> [f64; 2] {
    [contact_m - if starts_before { 0.2 } else { 1.0 } * span_m, contact_m + 0.2 * span_m]
}

/// First contact, and the force before it.
struct Touch {
    row: usize,
    zero_n: f64,
    drift_n_per_s: f64,
}

impl Touch {
    /// Finds the row from which a drifting level and a power of the depth after the row are nearest
    /// to the forces.
    fn find(rows: &[[f64; 3]]) -> Self {
        let stride = rows.len().div_ceil(MOST_TRIED);
        let rows: Vec<[f64; 3]> = rows.iter().step_by(stride).copied().collect();
        let mut best = (f64::MAX, Self { row: 0, zero_n: 0.0, drift_n_per_s: 0.0 });
        for (row, power) in (0..rows.len() - 4).flat_map(|row| POWERS.map(|power| (row, power))) {
            let level = if row < FEWEST_BEFORE { 0.0 } else { 1.0 };
            let span_m = (rows[rows.len() - 1][1] - rows[row][1]).max(f64::MIN_POSITIVE);
            let basis = |[t, d, _]: &[f64; 3]| {
                Vector3::new(level, level * (t - rows[0][0]), ((d - rows[row][1]).max(0.0) / span_m).powf(power))
            };
            let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
            for at in &rows {
                normal += basis(at) * basis(at).transpose();
                right += basis(at) * at[2];
            }
            if level == 0.0 {
                normal += Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 0.0));
            }
            let Some(found) = normal.lu().solve(&right) else { continue };
            let off: f64 = rows.iter().map(|at| (found.dot(&basis(at)) - at[2]).powi(2)).sum();
            if off < best.0 && found.z > 0.0 {
                best = (off, Self { row: row * stride, zero_n: found.x, drift_n_per_s: found.y });
            }
        }
        best.1
    }
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
            starts_before: false,
            segments,
        }
    }

    /// Checks a test and finds contact and segments.
    ///
    /// # Errors
    /// One sentence on what makes the test unusable.
    pub fn of(name: &str, mut rows: Vec<[f64; 3]>, thickness_m: f64) -> Result<Self, String> {
        let bad = |what: String| Err(format!("{name}: {what}"));
        if rows.len() < FEWEST_ROWS {
            return bad(format!(
                "{} rows: a test needs at least {FEWEST_ROWS}; record force and depth while the tip moves in",
                rows.len()
            ));
        }
        if let Some(n) = rows.windows(2).position(|w| w[1][0] <= w[0][0]) {
            let [a, b] = [rows[n][0], rows[n + 1][0]];
            return bad(format!(
                "time runs backwards or stands still, from {a} to {b} s after row {}: sort the rows, or add a column test that numbers the tests",
                n + 1
            ));
        }
        let column = |rows: &[[f64; 3]], k: usize| rows.iter().map(|row| row[k]).collect::<Vec<f64>>();
        let force = column(&rows, 2);
        let noise_n = noise(&force);
        let (low, peak) = force.iter().fold((f64::MAX, f64::MIN), |(low, high), f| (low.min(*f), high.max(*f)));
        let depth = column(&rows, 1);
        let at_peak = force.iter().position(|f| *f == peak).unwrap_or(0);
        let first_n = mean(&force[..5]);
        if peak - low <= LEAST_NOISES * noise_n || peak - low <= LEAST_RISE * low.abs() {
            return bad(
                "no contact: the force never rises out of its noise; press deeper, or check the column of the force".into()
            );
        }
        if -low > peak {
            return bad(
                "the force is negative where it is largest: give the force on the tip, positive when it pushes back".into()
            );
        }
        let begins = (0..=at_peak).find(|n| force[*n] - first_n > CONTACT_SHARE * (peak - first_n)).unwrap_or(at_peak);
        let Touch { row: touch, zero_n, drift_n_per_s } = Touch::find(&rows[..(begins + 1).max(FEWEST_ROWS).min(rows.len())]);
        // a level force before the press is that of air only if the tip moves meanwhile
        let lowest_m = depth[..touch].iter().copied().fold(f64::MAX, f64::min);
        let deepest_m = depth.iter().copied().fold(f64::MIN, f64::max);
        let starts_before = touch >= FEWEST_BEFORE && depth[touch] - lowest_m > LEAST_APPROACH * (deepest_m - depth[touch]);
        if starts_before {
            let drift_n = drift_n_per_s * (rows[at_peak][0] - rows[0][0]);
            // a saturated sensor has no noise later on; the noise of few rows alone is uncertain
            let noise_n = noise_n.max(noise(&force[..touch]));
            let unsure_n = UNSURE * noise_n * 12_f64.sqrt() / (touch as f64).sqrt() * (at_peak as f64 / touch as f64);
            if drift_n.abs() > (MOST_DRIFT * peak).max(unsure_n) {
                return bad(format!(
                    "the force changes by {drift_n_per_s:.3} N per second before contact, {:.0} % of its peak until the peak: the sensor drifts, or depth and force are swapped; let the sensor warm up, or correct the names of the columns",
                    100.0 * drift_n.abs() / peak
                ));
            }
            rows.iter_mut().for_each(|row| row[2] -= zero_n);
        }
        let runs_out = column(&rows, 1);
        let (mut highest, wanders_m) = (f64::MIN, 4.0 * noise(&runs_out));
        let span = runs_out.iter().copied().fold(f64::MIN, f64::max) - runs_out[touch];
        let fall = rows.iter().enumerate().skip(touch).find(|(_, row)| {
            highest = highest.max(row[1]);
            row[1] < highest - FALL * span.max(0.0) - wanders_m
        });
        let retreat = fall.map_or(rows.len(), |(n, _)| n);
        if span <= 0.0 || runs_out[at_peak] <= runs_out[touch] {
            return bad(
                "the depth does not grow while the force does: the depth must be positive into the tissue; change its sign"
                    .into(),
            );
        }
        if span > 0.8 * thickness_m {
            return bad(format!(
                "the depth grows by {:.4} mm, where the tissue is {} mm thick: check the unit of the depth and --thickness",
                span * 1e3,
                thickness_m * 1e3
            ));
        }
        let reached = (touch..retreat).find(|n| runs_out[*n] - runs_out[touch] >= (1.0 - 0.6 * FALL) * span).unwrap_or(retreat);
        let exponent = exponent(&rows[touch..reached.max(touch + 1)], peak);
        if let Some(exponent) = exponent.filter(|exponent| *exponent < LEAST_EXPONENT) {
            return bad(format!(
                "the force grows only like depth to the power of {exponent:.2}, where tissue gives 1 to 3: the columns of depth and force seem to be swapped; check their names and units"
            ));
        }
        let flat = force.windows(SATURATED).position(|w| w.iter().all(|f| *f == peak));
        if let Some(n) = flat.filter(|n| depth[n + SATURATED - 1] - depth[*n] > 1e-3 * span) {
            return bad(format!(
                "the force stays at exactly {} N from row {} on while the depth grows: the sensor is saturated; press less deep, or leave those rows out",
                (peak * 1e6).round() / 1e6,
                n + 1
            ));
        }
        if reached - touch < 8 {
            return bad(format!(
                "{} rows between contact and the deepest point: too few to see how the force grows; record at a higher rate or press more slowly",
                reached - touch
            ));
        }
        // rows long before contact say nothing more
        let from = touch.saturating_sub(reached - touch);
        let step = ((reached - from) / MOST_POINTS).max(1);
        let parts = [
            thinned(from..reached, step, usize::MAX),
            thinned(reached..retreat, step, MOST_LATER),
            thinned(retreat..rows.len(), step, MOST_LATER),
        ];
        let (press, hold) = (parts[0].len(), parts[0].len() + parts[1].len());
        let points = parts.concat();
        let averaged = |k: usize| -> Vec<f64> { points.iter().map(|at| mean(&column(&rows[at.clone()], k))).collect() };
        let depth_m = averaged(1);
        let contact_m = runs_out[touch];
        Ok(Self {
            name: name.into(),
            time_s: averaged(0),
            force_n: averaged(2),
            noise_n: noise_n / (step as f64).sqrt(),
            contact_m,
            contact_range_m: contact_range_m(contact_m, span, starts_before),
            starts_before,
            segments: Segments { press: 0..press, hold: press..hold, retreat: hold..depth_m.len() },
            depth_m,
        })
    }

    /// Moves first contact to where a fit would have it; false if it is within its range already,
    /// and the tip is known to be in air before it or not to be.
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
    /// of a test that starts before contact.
    pub fn limit_depth(&mut self, most_m: f64) {
        let span_m = self.span_m();
        let [near, _] = contact_range_m(self.contact_m, span_m, true);
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
        let touched = self.depth_m.iter().position(|d| *d >= self.contact_m).unwrap_or(0);
        let end = self.segments.press.end.min(self.time_s.len() - 1);
        (self.depth_m[end] - self.depth_m[touched]) / (self.time_s[end] - self.time_s[touched]).max(1e-9)
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
fn exponent(rows: &[[f64; 3]], peak_n: f64) -> Option<f64> {
    let start = rows.first()?[1];
    let points: Vec<[f64; 2]> = rows
        .iter()
        .filter(|row| row[2] > 0.1 * peak_n && row[1] > start)
        .map(|row| [(row[1] - start).ln(), row[2].ln()])
        .collect();
    let n = points.len() as f64;
    let sum = |of: fn(&[f64; 2]) -> f64| points.iter().map(of).sum::<f64>();
    let (x, y, xx, xy) = (sum(|p| p[0]), sum(|p| p[1]), sum(|p| p[0] * p[0]), sum(|p| p[0] * p[1]));
    (points.len() > 4).then(|| (n * xy - x * y) / (n * xx - x * x))
}
