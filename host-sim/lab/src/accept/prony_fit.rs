//! Fits two Prony terms to a hold, taking the preceding loading into account.
//!
//! During a loading that lasts seconds the fast part relaxes already: shares read directly off a
//! hold refer to the force at the end of the loading, not to the instantaneous elastic force. The
//! fit therefore relaxes the force of an elastic loading in one dimension; it does not use the
//! relaxation code of the core.

/// Number of time constants tried for each term in a round, and number of rounds, each of which
/// halves the range.
const TRIED: usize = 31;
const ROUNDS: usize = 10;
/// Shortest and longest time constant [s] that a hold of 0.5 to 9.5 s can determine.
const TIMES_S: [f64; 2] = [0.1, 30.0];

/// Two fitted Prony terms.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct PronyFit {
    /// Share (1) and time [s] of each term.
    pub terms: [(f64, f64); 2],
    /// Root mean square of the residual force ratio (1).
    pub rms: f64,
}

/// Fits the ratios `left` of the force during a hold to the force at the end of the loading, at the
/// times `time_s` after that end. `loading` holds the elastic force from zero to its largest value,
/// in steps of `dt_s`.
#[must_use]
pub fn fit(loading: &[f64], dt_s: f64, time_s: &[f64], left: &[f64]) -> Option<PronyFit> {
    let mut range = [TIMES_S.map(f64::ln); 2];
    let mut best: Option<PronyFit> = None;
    for _ in 0..ROUNDS {
        let tried = range.map(|[low, high]| {
            let step = (high - low) / (TRIED - 1) as f64;
            (0..TRIED)
                .map(|n| {
                    let tau_s = (low + step * n as f64).exp();
                    (tau_s, Lag::of(loading, dt_s, tau_s, time_s))
                })
                .collect::<Vec<_>>()
        });
        for fast in &tried[0] {
            for slow in tried[1].iter().filter(|slow| slow.0 > 1.5 * fast.0) {
                if let Some(found) = shares(fast, slow, left)
                    && best.is_none_or(|best| found.rms < best.rms)
                {
                    best = Some(found);
                }
            }
        }
        let around = best?.terms.map(|(_, tau_s)| tau_s.ln());
        for ([low, high], middle) in range.iter_mut().zip(around) {
            let half = 0.25 * (*high - *low);
            (*low, *high) = (middle - half, middle + half);
        }
    }
    best
}

/// Low-pass filtered elastic force, divided by its largest value, at the end of the loading and at
/// the times of the hold.
struct Lag {
    at_peak: f64,
    after: Vec<f64>,
}

impl Lag {
    fn of(loading: &[f64], dt_s: f64, tau_s: f64, time_s: &[f64]) -> Self {
        let peak = loading.last().copied().unwrap_or(f64::NAN);
        let kept = (-dt_s / tau_s).exp();
        let rise = (1.0 - kept) * tau_s / dt_s;
        // share carried by a Maxwell element with this time constant; the lag is the remainder
        let borne = loading.windows(2).fold(0.0, |borne, pair| kept * borne + rise * (pair[1] - pair[0]) / peak);
        let after = time_s.iter().map(|t_s| 1.0 - borne * (-t_s / tau_s).exp()).collect();
        Self { at_peak: 1.0 - borne, after }
    }
}

/// The best shares for two given time constants: the remaining force is a quotient whose numerator
/// and denominator are linear in the shares.
fn shares(fast: &(f64, Lag), slow: &(f64, Lag), left: &[f64]) -> Option<PronyFit> {
    let (mut aa, mut ab, mut bb, mut ay, mut by) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (n, left) in left.iter().enumerate() {
        let [a, b] = [&fast.1, &slow.1].map(|lag| lag.after[n] - left * lag.at_peak);
        let y = 1.0 - left;
        (aa, ab, bb, ay, by) = (aa + a * a, ab + a * b, bb + b * b, ay + a * y, by + b * y);
    }
    let det = aa * bb - ab * ab;
    let (g, h) = ((ay * bb - by * ab) / det, (by * aa - ay * ab) / det);
    // the negated form also rejects NaN
    if !(g > 0.0 && h > 0.0 && g + h < 0.95) {
        return None;
    }
    let peak = 1.0 - g * fast.1.at_peak - h * slow.1.at_peak;
    let off = |(n, left): (usize, &f64)| (1.0 - g * fast.1.after[n] - h * slow.1.after[n]) / peak - left;
    let square: f64 = left.iter().enumerate().map(off).map(|off| off * off).sum();
    Some(PronyFit { terms: [(g, fast.0), (h, slow.0)], rms: (square / left.len() as f64).sqrt() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hold_that_was_made_with_two_terms_is_found_again() {
        let (made, time_s) = ([(0.3, 0.35), (0.25, 5.0)], [0.5, 1.0, 2.0, 5.0, 9.5]);
        let loading: Vec<f64> = (0..=400).map(|n| (f64::from(n) / 400.0).powf(1.5)).collect();
        let lags = made.map(|(_, tau_s)| Lag::of(&loading, 0.01, tau_s, &time_s));
        let force = |of: &dyn Fn(&Lag) -> f64| 1.0 - made.iter().zip(&lags).map(|((g, _), lag)| g * of(lag)).sum::<f64>();
        let left: Vec<f64> = (0..5).map(|n| force(&|lag| lag.after[n]) / force(&|lag| lag.at_peak)).collect();
        let found = fit(&loading, 0.01, &time_s, &left).unwrap();
        assert!(found.rms < 2e-4, "{found:?}");
        for ((g, tau_s), (made_g, made_s)) in found.terms.into_iter().zip(made) {
            assert!((g / made_g - 1.0).abs() < 0.15 && (tau_s / made_s - 1.0).abs() < 0.25, "{found:?}");
        }
    }
}
