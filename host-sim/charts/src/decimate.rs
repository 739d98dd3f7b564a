//! Thins a long trace for drawing and keeps every peak.

use super::Sample;

/// Number of runs of samples that are drawn, about two per pixel column.
const RUNS: usize = 2000;

/// Keeps at most six samples of each of `RUNS` runs: the first, the last, and the extremes of depth
/// and force. A trace of at most six times `RUNS` samples is returned unchanged.
pub fn decimate(trace: &[Sample]) -> Vec<Sample> {
    if trace.len() <= 6 * RUNS {
        return trace.to_vec();
    }
    let run = trace.len().div_ceil(RUNS);
    let mut kept = Vec::with_capacity(6 * RUNS);
    for run in trace.chunks(run) {
        let last = run.len() - 1;
        let mut at = [
            0,
            last,
            extreme(run, |s| s.depth_m),
            extreme(run, |s| -s.depth_m),
            extreme(run, |s| s.force_n),
            extreme(run, |s| -s.force_n),
        ];
        at.sort_unstable();
        let mut next = 0;
        for i in at.into_iter().filter(|&i| std::mem::replace(&mut next, i + 1) <= i) {
            kept.extend(run.get(i));
        }
    }
    kept
}

fn extreme(run: &[Sample], of: impl Fn(&Sample) -> f64) -> usize {
    let mut best = 0;
    let mut most = f64::NEG_INFINITY;
    for (i, sample) in run.iter().enumerate() {
        if of(sample) > most {
            (best, most) = (i, of(sample));
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extremes_and_order_survive() {
        let mut trace: Vec<_> =
            (0..1_000_000).map(|i| Sample { t_s: f64::from(i) * 1e-3, depth_m: 0.002, force_n: 0.05 }).collect();
        trace[123_456].force_n = 9.0;
        trace[777_777].depth_m = -0.5;
        let thin = decimate(&trace);
        assert!(thin.len() <= 6 * RUNS);
        assert!(thin.contains(&trace[123_456]));
        assert!(thin.contains(&trace[777_777]));
        assert_eq!(thin.first(), trace.first());
        assert_eq!(thin.last(), trace.last());
        assert!(thin.is_sorted_by(|a, b| a.t_s < b.t_s));
    }
}
