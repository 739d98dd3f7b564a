//! The columns of a test, and what makes them unusable.

use super::motion::{Segments, between_readings, driven, lasting, mean, merged, noise, quantile, spikes, thinned};
use super::touch::{FEWEST_BEFORE, LEAST_APPROACH, MOST_DRIFT, Touch, UNSURE};

/// Fewest rows of a test.
const FEWEST_ROWS: usize = 20;
/// Fewest rows between contact and the deepest point.
const FEWEST_OF_PRESS: usize = 8;
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
/// Largest depth over the thickness of the tissue (1).
const MOST_PRESSED: f64 = 0.8;
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

pub const UPWARDS: &str =
    "the depth does not grow while the force does: the depth must be positive into the tissue; change its sign";

/// Rows of a test at different times, without those that stand out of their neighbours.
pub struct Signal {
    /// Times [s], depths [m] and forces [N] as they were read.
    pub rows: Vec<[f64; 3]>,
    /// Depths [m], on lines between readings.
    pub depth_m: Vec<f64>,
    /// Forces as they were read [N].
    pub force_n: Vec<f64>,
    /// Number of rows that were left out.
    pub left_out: usize,
    noise_n: f64,
}

/// Largest change of the force until the tip is deepest.
pub struct Peak {
    /// Row of the largest change.
    pub row: usize,
    /// Row of the largest depth.
    pub deepest: usize,
    /// Force in the first rows [N].
    pub first_n: f64,
    /// Largest change [N].
    change_n: f64,
}

fn column(rows: &[[f64; 3]], k: usize) -> Vec<f64> {
    rows.iter().map(|row| row[k]).collect()
}

impl Signal {
    /// Rows in the order of their times, equal ones merged, without spikes.
    pub fn of(rows: &[[f64; 3]]) -> Result<Self, String> {
        if let Some(n) = rows.windows(2).position(|w| w[1][0] < w[0][0]) {
            let [a, b] = [rows[n][0], rows[n + 1][0]];
            return Err(format!(
                "time runs backwards, from {a} to {b} s after row {}: sort the rows, or add a column test that numbers the tests",
                n + 1
            ));
        }
        let mut rows = merged(rows);
        let counted = rows.len();
        if counted < FEWEST_ROWS {
            return Err(format!(
                "number of rows at different times is {counted}: a test needs at least {FEWEST_ROWS}; record force and depth while the tip moves in"
            ));
        }
        let [far, also] = [1, 2].map(|k| spikes(&column(&rows, k)));
        let mut stands_out = far.iter().zip(also).map(|(far, also)| *far || also);
        rows.retain(|_| stands_out.next() != Some(true));
        let [mut depth_m, force_n] = [1, 2].map(|k| column(&rows, k));
        between_readings(&mut depth_m);
        Ok(Self { left_out: counted - rows.len(), noise_n: noise(&force_n), rows, depth_m, force_n })
    }

    /// The peak of the force, which must rise out of its noise where the tip moves in.
    pub fn peak(&self) -> Result<Peak, String> {
        let (depth_m, force_n) = (&self.depth_m, &self.force_n);
        let largest = |values: &[f64]| (0..values.len()).fold(0, |most, n| if values[n] > values[most] { n } else { most });
        let first_n = mean(&force_n[..5]);
        let changes: Vec<f64> = force_n.iter().map(|force_n| (force_n - first_n).abs()).collect();
        let deepest = largest(depth_m);
        let row = largest(&changes[..=deepest]);
        if changes[largest(&changes)] <= LEAST_NOISES * self.noise_n {
            return Err(
                "no contact: the force never rises out of its noise; press deeper, or check the column of the force".into()
            );
        }
        if changes[row] <= LEAST_NOISES * self.noise_n {
            return Err(UPWARDS.into());
        }
        if force_n[row] < first_n {
            return Err(
                "the force is negative where it is largest: give the force on the tip, positive when it pushes back".into()
            );
        }
        let moves_m = depth_m[0] + STILL * (depth_m[deepest] - depth_m[0]) + 2.0 * noise(depth_m);
        let still = depth_m.iter().position(|d| *d > moves_m).unwrap_or(0);
        let early_n = if still > 5 { mean(&force_n[still - 5..still]) - first_n } else { 0.0 };
        if early_n.abs() > MOST_EARLY * changes[row] {
            return Err(format!(
                "the force changes by {:.0} % of its peak before the tip moves: the sensor drifts, or depth and force are swapped; let the sensor warm up, or correct the names of the columns",
                100.0 * early_n.abs() / changes[row]
            ));
        }
        Ok(Peak { row, deepest, first_n, change_n: changes[row] })
    }

    /// Rows among which first contact is found: until the force has risen by a part of its peak.
    pub fn first_rows(&self, peak: &Peak) -> &[[f64; 3]] {
        let rises = |n: &usize| self.force_n[*n] - peak.first_n > CONTACT_SHARE * peak.change_n;
        let begins = (0..peak.row).rev().find(|n| !rises(n)).map_or(0, |n| n + 1);
        &self.rows[..(begins + 1).max(FEWEST_ROWS).min(self.rows.len())]
    }

    /// Refuses a sensor that drifts in air or in a hold. `peak_n` is the peak over the zero.
    pub fn refuse_drift(&self, touch: &Touch, segments: &Segments, peak: &Peak, peak_n: f64) -> Result<(), String> {
        let hold = segments.hold.clone();
        let until_s = self.rows[peak.row][0] - self.rows[0][0];
        let lasts = lasting(&self.force_n[hold.clone()], touch.row / 3);
        if let Some(drift_n_per_s) = touch.drift(&self.rows, until_s, peak_n, self.noise_n, lasts) {
            return Err(format!(
                "the force changes by {drift_n_per_s:.3} N per second before contact, {:.0} % of its peak until the peak: the sensor drifts, or depth and force are swapped; let the sensor warm up, or correct the names of the columns",
                100.0 * (drift_n_per_s * until_s / peak_n).abs()
            ));
        }
        let deepest_m = self.depth_m[peak.deepest];
        let is_out = |n: &usize| self.depth_m[*n] < touch.depth_m - LEAST_APPROACH * (deepest_m - touch.depth_m);
        let after: Vec<f64> = segments.retreat.clone().filter(is_out).map(|n| self.force_n[n]).collect();
        // a sticky tissue pulls at first
        let after = &after[after.len() / 2..];
        if touch.in_air(&self.depth_m, deepest_m) && after.len() >= FEWEST_BEFORE {
            let change_n = mean(after) - touch.zero_n;
            if change_n.abs() > (MOST_DRIFT * peak_n).max(UNSURE * lasts * self.noise_n / (after.len() as f64).sqrt()) {
                return Err(format!(
                    "the force after the tip has left differs by {:+.0} % of its peak from that before contact: the sensor drifts, or the tissue sticks to the tip; let the sensor warm up, or wet the tip and retreat further",
                    100.0 * change_n / peak_n
                ));
            }
        }
        let quarter = hold.len() / 4;
        let rise = |of: &[f64]| mean(&of[hold.end - quarter..hold.end]) - mean(&of[hold.start..hold.start + quarter]);
        let [rise_m, rise_n] = [&self.depth_m, &self.force_n].map(|of| rise(of));
        let least_n = (MOST_DRIFT * peak_n).max(UNSURE * lasts * self.noise_n * (2.0 / quarter as f64).sqrt());
        if rise_m < LEVEL * (deepest_m - touch.depth_m) && rise_n > least_n {
            return Err(format!(
                "the force rises by {:.0} % of its peak while the depth is held, which no tissue does: the sensor drifts; let the sensor warm up",
                100.0 * rise_n / peak_n
            ));
        }
        Ok(())
    }

    /// Refuses what is no press of a tip into tissue, by depth and thickness [m] and by the force.
    pub fn refuse_what_is_no_press(
        &self,
        touch: &Touch,
        segments: &Segments,
        peak_n: f64,
        [span_m, thickness_m]: [f64; 2],
    ) -> Result<(), String> {
        let press = segments.press.clone();
        if span_m > MOST_PRESSED * thickness_m {
            return Err(format!(
                "the depth grows by {:.4} mm, where the tissue is {} mm thick: check the unit of the depth and --thickness",
                span_m * 1e3,
                thickness_m * 1e3
            ));
        }
        if press.end - touch.row < FEWEST_OF_PRESS {
            return Err(format!(
                "{} rows between contact and the deepest point: too few to see how the force grows; record at a higher rate or press more slowly",
                press.end - touch.row
            ));
        }
        let exponent = exponent(&self.rows[touch.row..press.end], touch.depth_m, peak_n);
        if let Some(exponent) = exponent.filter(|exponent| *exponent < LEAST_EXPONENT) {
            return Err(format!(
                "the force grows only like depth to the power of {exponent:.2}, where tissue gives 1 to 3: the columns of depth and force seem to be swapped; check their names and units"
            ));
        }
        let noise_n = self.noise_n.max(noise(&self.force_n[..touch.row]));
        if let Some((row, level_n)) = saturation(&self.depth_m, &self.force_n, press.end, noise_n) {
            return Err(format!(
                "the force stays at exactly {} N from {:.2} s on: the sensor is saturated, or the machine holds the force; press less deep, and hold the depth",
                (level_n * 1e6).round() / 1e6,
                self.rows[row][0]
            ));
        }
        Ok(())
    }

    /// Points that are fitted, their segments, and their noise [N]: means of rows without the noise
    /// of the depth's sensor. Rows long before contact say nothing more.
    pub fn points(mut self, touch: &Touch, segments: &Segments, span_m: f64) -> (Vec<[f64; 3]>, Segments, f64) {
        driven(&mut self.depth_m, segments, span_m);
        self.rows.iter_mut().zip(&self.depth_m).for_each(|(row, depth_m)| row[1] = *depth_m);
        let Segments { press, hold, retreat } = segments.clone();
        let from = touch.row.saturating_sub(press.end - touch.row);
        let step = ((press.end - from) / MOST_POINTS).max(1);
        let parts =
            [thinned(from..press.end, step, usize::MAX), thinned(hold, step, MOST_LATER), thinned(retreat, step, MOST_LATER)];
        let (press, hold) = (parts[0].len(), parts[0].len() + parts[1].len());
        let points: Vec<[f64; 3]> =
            parts.concat().into_iter().map(|rows| [0, 1, 2].map(|k| mean(&column(&self.rows[rows.clone()], k)))).collect();
        let segments = Segments { press: 0..press, hold: press..hold, retreat: hold..points.len() };
        (points, segments, self.noise_n / (step as f64).sqrt())
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
