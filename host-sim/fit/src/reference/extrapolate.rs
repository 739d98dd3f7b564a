//! Estimates the limit of a quantity under mesh refinement.

/// Estimate of the limit of a quantity under mesh refinement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Value at vanishing element size, from `value + c h^3` through the two finest levels
    /// (Richardson), with h^3 ~ 1/nodes. Quadratic elements reach third order if the edge of the
    /// contact limits the smoothness.
    pub limit: f64,
    /// The larger of two differences: between the finest level and the limit, and between the
    /// finest level and the previous one.
    pub error: f64,
}

/// Extrapolates the pairs (nodes, value) of all levels, coarse to fine; `None` if there are fewer
/// than two.
#[must_use]
pub fn extrapolate(levels: &[(usize, f64)]) -> Option<Estimate> {
    let [.., (coarse, before), (fine, finest)] = levels else { return None };
    let (coarse, fine) = (*coarse as f64, *fine as f64);
    let limit = if fine > coarse { (fine * finest - coarse * before) / (fine - coarse) } else { *finest };
    Some(Estimate { limit, error: (finest - limit).abs().max((finest - before).abs()) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_third_order_error_is_extrapolated_away() {
        let value = |n: usize| 3.0 + 40.0 / n as f64;
        let levels = [100, 300, 900].map(|n| (n, value(n)));
        let estimate = extrapolate(&levels).unwrap();
        assert!((estimate.limit - 3.0).abs() < 1e-12);
        assert!((estimate.error - (value(300) - value(900)).max(value(900) - 3.0)).abs() < 1e-12);
        assert_eq!(extrapolate(&levels[..1]), None);
    }
}
