//! First contact of a test, and the force before it.

use nalgebra::{Matrix3, Vector3};

/// Powers of the depth that are tried: Hertz's, and those of thin or stiffening tissue.
const POWERS: [f64; 4] = [1.5, 2.0, 2.75, 4.0];
/// Number of depths of the first row below the surface that are tried, the least one over the way
/// of the rows (1), and the ratio of two (1).
const BELOW: (i32, f64, f64) = (40, 0.01, 1.15);
/// Standard errors from which the rows before contact show a drift (1).
const SEEN: f64 = 2.5;
/// Twice the number of rows among which contact is looked for by depth, by time and by number.
const MOST_TRIED: usize = 200;
/// Number of rows before contact from which the zero of the force and its drift are known.
pub const FEWEST_BEFORE: usize = 8;
/// Way of the tip before contact, as a share of the depth (1), without which it may have been at
/// rest on the tissue.
pub const LEAST_APPROACH: f64 = 0.05;
/// Largest change of the force by drift until the peak, as a share of the peak (1).
pub const MOST_DRIFT: f64 = 0.05;
/// Smallest drift that is believed, in standard errors of it (1). With three, one in a hundred
/// tests of a quiet sensor was refused, since contact is found from the same noise.
pub const UNSURE: f64 = 4.5;

/// First contact.
pub struct Touch {
    /// First row in contact.
    pub row: usize,
    /// Depth of the surface [m], at most that of the row.
    pub depth_m: f64,
    /// Force before contact [N]; zero without rows before it.
    pub zero_n: f64,
    /// Change of the force in air that explains the rows best [N/s].
    drift_n_per_s: f64,
    /// Logarithm of the likelihood that this drift gains, times two, for independent noise.
    gain: f64,
}

impl Touch {
    /// Finds the surface above which the force is level, and below which a power of the depth is
    /// added to it. The tip may start below the surface; its force has no level then.
    pub fn find(rows: &[[f64; 3]]) -> Self {
        let places = places(rows);
        let rows: Vec<[f64; 3]> = places.iter().map(|n| rows[*n]).collect();
        let [(first_s, first_m), (_, last_m)] = [rows[0], rows[rows.len() - 1]].map(|[t, d, _]| (t, d));
        let within = (0..rows.len().saturating_sub(4)).map(|row| (row, rows[row][1]));
        let below = (0..BELOW.0).map(|n| (0, first_m - BELOW.1 * BELOW.2.powi(n) * (last_m - first_m).max(0.0)));
        let tried: Vec<((usize, f64), f64)> = within.chain(below).flat_map(|at| POWERS.map(|power| (at, power))).collect();
        let squares: f64 = rows.iter().map(|row| row[2].powi(2)).sum();
        let count = rows.len() as f64;
        // level, drift and power; the first two only where rows before contact show them
        let best = |drifts: bool| {
            let mut best = (f64::MAX, 0, first_m, Vector3::zeros());
            for ((row, surface_m), power) in tried.iter().copied() {
                let used = [row >= FEWEST_BEFORE, drifts && row >= FEWEST_BEFORE, true].map(|used| f64::from(u8::from(used)));
                let span_m = (last_m - surface_m).max(f64::MIN_POSITIVE);
                let basis = |[t, d, _]: &[f64; 3]| {
                    Vector3::new(used[0], used[1] * (t - first_s), ((d - surface_m).max(0.0) / span_m).powf(power))
                };
                let mut normal = Matrix3::from_diagonal(&Vector3::from(used.map(|used| 1.0 - used)));
                let mut right = Vector3::zeros();
                for at in &rows {
                    normal += basis(at) * basis(at).transpose();
                    right += basis(at) * at[2];
                }
                let Some(found) = normal.lu().solve(&right) else { continue };
                let off: f64 = rows.iter().map(|at| (found.dot(&basis(at)) - at[2]).powi(2)).sum();
                let criterion = count * (off + 1e-9 * squares).ln() + used.iter().sum::<f64>() * count.ln();
                if criterion < best.0 && found.z > 0.0 {
                    best = (criterion, places[row], surface_m, found);
                }
            }
            best
        };
        let [(level, row, depth_m, found), (drifting, .., line)] = [best(false), best(true)];
        Self { row, depth_m, zero_n: found.x, drift_n_per_s: line.y, gain: level - drifting + count.ln() }
    }

    /// Whether the tip is known to be in air before contact: a level force alone is also that of a
    /// tip at rest on the tissue.
    pub fn in_air(&self, depth_m: &[f64], deepest_m: f64) -> bool {
        let lowest_m = depth_m[..self.row].iter().copied().fold(f64::MAX, f64::min);
        self.row >= FEWEST_BEFORE && self.depth_m - lowest_m > LEAST_APPROACH * (deepest_m - self.depth_m)
    }

    /// A drift of the sensor [N/s] that changes the force until the peak [s] by a share of it [N],
    /// that the rows before contact show, and without which neither a later nor an earlier contact
    /// explains the others. `noise_n` is that of a row, and `lasting` the factor by which it lasts.
    pub fn drift(&self, rows: &[[f64; 3]], until_s: f64, peak_n: f64, noise_n: f64, lasting: f64) -> Option<f64> {
        let rows = &rows[..self.row];
        let [mean_s, mean_n] = [0, 2].map(|k| rows.iter().map(|row| row[k]).sum::<f64>() / self.row as f64);
        let spread: f64 = rows.iter().map(|row| (row[0] - mean_s).powi(2)).sum();
        let slope = rows.iter().map(|row| (row[0] - mean_s) * (row[2] - mean_n)).sum::<f64>() / spread;
        let changes = (self.drift_n_per_s * until_s).abs() > MOST_DRIFT * peak_n;
        let seen = slope * self.drift_n_per_s.signum() > SEEN * noise_n * lasting / spread.sqrt();
        (changes && seen && self.gain > (UNSURE * lasting).powi(2)).then_some(self.drift_n_per_s)
    }
}

/// Rows among which contact is looked for: those in which the tip is deeper than before by a part
/// of the way, and some at even times and numbers, as a long rest says no more than a short one.
fn places(rows: &[[f64; 3]]) -> Vec<usize> {
    let [first, last] = [rows[0], rows[rows.len() - 1]];
    let [step_s, step_m] = [0, 1].map(|k| (last[k] - first[k]) / (0.5 * MOST_TRIED as f64));
    let every = rows.len().div_ceil(MOST_TRIED / 2);
    let (mut places, mut deepest_m) = (vec![0], first[1]);
    for (n, [t, d, _]) in rows.iter().enumerate().skip(1) {
        let kept_s = rows[places[places.len() - 1]][0];
        let deeper = *d > deepest_m && *d >= deepest_m + step_m;
        if deeper || *t >= kept_s + step_s || n % every == 0 {
            places.push(n);
            deepest_m = deepest_m.max(*d);
        }
    }
    places
}
