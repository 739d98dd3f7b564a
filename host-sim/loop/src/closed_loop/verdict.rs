//! Decides whether a hand would feel anything besides the tissue: the limit-cycle detector, whose
//! thresholds are fixed, buzz, energy, and the force that the controller adds.
//!
//! A hold *fails* if in its last half second the handle moves by more than two counts peak to peak
//! (5 um at least), or the force above 20 Hz is stronger than 20 mN RMS, or that motion grows over
//! three successive windows of 100 ms. Tissue that relaxes sinks under a steady push, so the motion
//! on it is counted from the straight line that fits it best. 20 mN is two thirds of the only
//! detection threshold found for such devices (30 mN, Dosher and Hannaford, bare finger, slow
//! exploration).

use palpate::Vector3;

use super::butterworth::Butterworth;

/// Ticks of the hold that are evaluated.
pub const JUDGED: usize = 500;
const WINDOW: usize = 100;
/// Force above 20 Hz that counts as felt [N].
pub const FELT_N: f64 = 0.020;
/// Limit of the swing for an encoder with counts of less than half of this [m].
const LEAST_SWING_M: f64 = 5e-6;

/// Measurements over the last half second of a hold.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Hold {
    /// Peak-to-peak motion of the handle, the largest over the axes [m].
    pub swing_m: f64,
    /// RMS of the force vector above 20 Hz [N].
    pub shake_n: f64,
    /// Whether the swing grew over three windows in a row.
    pub grows: bool,
    /// Largest swing allowed [m].
    pub most_swing_m: f64,
}

impl Hold {
    /// Evaluates the end of a run: positions of the handle [m] and forces on it [N], one per tick,
    /// the encoder's count [m], and whether the surface creeps.
    #[must_use]
    pub fn judge(at_m: &[Vector3<f64>], force_n: &[Vector3<f64>], count_m: f64, creeps: bool) -> Self {
        let last = at_m.len().saturating_sub(JUDGED);
        let tail = if creeps { from_line(&at_m[last..]) } else { at_m[last..].to_vec() };
        let most_swing_m = (2.0 * count_m).max(LEAST_SWING_M);
        let windows: Vec<f64> = tail.chunks_exact(WINDOW).map(swing_m).collect();
        let grew = |w: &[f64]| w[1] > 1.01 * w[0] && w[2] > 1.01 * w[1] && w[2] > 0.5 * most_swing_m;
        Self {
            swing_m: swing_m(&tail),
            shake_n: rms_above(force_n, 20.0, last),
            grows: windows.windows(3).any(grew),
            most_swing_m,
        }
    }

    /// Whether the run ends in a limit cycle, which fails it.
    #[must_use]
    pub fn limit_cycle(&self) -> bool {
        // written so that NaN fails
        !(self.swing_m <= self.most_swing_m && self.shake_n <= FELT_N) || self.grows
    }
}

fn swing_m(at_m: &[Vector3<f64>]) -> f64 {
    let Some(first) = at_m.first() else { return 0.0 };
    let (low, high) = at_m.iter().fold((*first, *first), |(l, h), x| (l.inf(x), h.sup(x)));
    (high - low).max()
}

/// Positions relative to the straight line over time that fits them best [m].
fn from_line(at_m: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let middle = 0.5 * (at_m.len() as f64 - 1.0);
    let timed = || at_m.iter().enumerate().map(|(n, x)| (n as f64 - middle, x));
    let squares: f64 = timed().map(|(t, _)| t * t).sum();
    let slope_m = timed().map(|(t, x)| x * t).sum::<Vector3<f64>>() / squares;
    timed().map(|(t, x)| x - slope_m * t).collect()
}

/// RMS of a force above a frequency [N], from the tick `from` on, after a fourth-order Butterworth
/// high-pass that starts with the first sample.
#[must_use]
pub fn rms_above(force_n: &[Vector3<f64>], hz: f64, from: usize) -> f64 {
    let Some(first) = force_n.first() else { return 0.0 };
    if from >= force_n.len() {
        return 0.0;
    }
    // a step at the start would ring: the filter begins settled at the first value
    let mut filter = Butterworth::high(hz);
    let passed = force_n.iter().map(|force_n| filter.next(force_n - first).norm_squared());
    (passed.skip(from).sum::<f64>() / (force_n.len() - from) as f64).sqrt()
}

/// Largest rotation of a force from tick to tick [degrees], while it is stronger than `least_n`.
#[must_use]
pub fn largest_turn_deg(force_n: &[Vector3<f64>], least_n: f64) -> f64 {
    let turn = |w: &[Vector3<f64>]| if w[0].norm().min(w[1].norm()) > least_n { w[0].angle(&w[1]).to_degrees() } else { 0.0 };
    force_n.windows(2).map(turn).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn still() -> Vec<Vector3<f64>> {
        vec![Vector3::zeros(); 2000]
    }

    fn waves(amplitude: f64, hz: f64, growth_per_s: f64) -> Vec<Vector3<f64>> {
        let at = |n: u32| f64::from(n) * 1e-3;
        let wave = |t: f64| amplitude * (growth_per_s * t).exp() * (std::f64::consts::TAU * hz * t).sin();
        (0..2000).map(|n| Vector3::new(0.0, 0.0, wave(at(n)))).collect()
    }

    #[test]
    fn a_still_hand_passes_and_each_of_the_three_signs_fails() {
        let count_m = 55e-6;
        assert!(!Hold::judge(&still(), &still(), count_m, false).limit_cycle());
        // 100 um peak to peak is allowed, 120 is not
        assert!(!Hold::judge(&waves(50e-6, 10.0, 0.0), &still(), count_m, false).limit_cycle());
        assert!(Hold::judge(&waves(60e-6, 10.0, 0.0), &still(), count_m, false).limit_cycle());
        // 20 mN RMS is 28.3 mN of amplitude
        assert!(!Hold::judge(&still(), &waves(27e-3, 100.0, 0.0), count_m, false).limit_cycle());
        assert!(Hold::judge(&still(), &waves(29.5e-3, 100.0, 0.0), count_m, false).limit_cycle());
        let growing = Hold::judge(&waves(5e-6, 30.0, 1.0), &still(), count_m, false);
        assert!(growing.grows && growing.swing_m < 110e-6, "{growing:?}");
        let nan = vec![Vector3::repeat(f64::NAN); 2000];
        assert!(Hold::judge(&nan, &nan, count_m, false).limit_cycle());
    }

    /// 0.4 mm in half a second is faster than `beef` sinks.
    #[test]
    fn a_handle_that_sinks_into_creeping_tissue_passes_and_one_that_cycles_meanwhile_does_not() {
        let hold = |amplitude: f64, hz: f64, creeps: bool| {
            let mut at_m = waves(amplitude, hz, 0.0);
            at_m.iter_mut().enumerate().for_each(|(n, x)| x.z -= 0.8e-6 * n as f64);
            Hold::judge(&at_m, &still(), 55e-6, creeps)
        };
        assert!(!hold(0.0, 10.0, true).limit_cycle() && hold(0.0, 10.0, true).swing_m < 1e-9);
        assert!(hold(0.0, 10.0, false).limit_cycle(), "a wall does not creep");
        for hz in [3.0, 10.0, 55.0] {
            let Hold { swing_m, .. } = hold(60e-6, hz, true);
            assert!(hold(60e-6, hz, true).limit_cycle() && (swing_m / 120e-6 - 1.0).abs() < 0.25, "{hz} Hz: {swing_m}");
        }
    }

    #[test]
    fn a_position_that_is_no_number_fails() {
        for creeps in [false, true] {
            assert!(Hold::judge(&vec![Vector3::repeat(f64::NAN); 2000], &still(), 55e-6, creeps).limit_cycle());
        }
    }

    #[test]
    fn a_turn_is_an_angle() {
        let force = [Vector3::z(), Vector3::new(0.0, 0.1, 0.995), Vector3::x() * 1e-4];
        assert!((largest_turn_deg(&force, 1e-3) - 5.74).abs() < 0.01);
    }
}
