//! Intervals by the profile likelihood: one quantity is held while all others are fitted.

use super::{CHI_90, Estimate, Fitted, Problem, Quantity};

/// Weight of a held quantity, relative to a standard deviation of it.
const HOLDING: f64 = 1e3;

impl Problem<'_> {
    /// The 90 % interval of a quantity; those of moduli and exponent contain what about equally
    /// likely numbers of terms give.
    #[must_use]
    pub fn estimate(&self, fit: &Fitted, of: Quantity) -> Estimate {
        let own = self.estimate_alone(fit, of);
        if matches!(of, Quantity::Share(_) | Quantity::Time(_)) {
            return own;
        }
        let join = |[a, b]: [f64; 2], [c, d]: [f64; 2]| [a.min(c), b.max(d)];
        let others = fit.rivals.iter().map(|rival| self.estimate_alone(rival, of));
        others.fold(own, |own, other| Estimate {
            interval: join(own.interval, other.interval),
            open: own.open || other.open,
            ..own
        })
    }

    fn estimate_alone(&self, fit: &Fitted, of: Quantity) -> Estimate {
        let at = self.inner(&fit.p, fit.terms, of);
        let limits = self.limits(fit.terms);
        let own = of.place(fit.terms);
        let range = match of {
            Quantity::Relaxed => [f64::MIN, f64::MAX],
            _ => [limits[own].limit_low, limits[own].limit_up],
        };
        let spread = fit.chi / (self.points() as f64 - fit.p.len() as f64).max(1.0);
        let wanted = CHI_90 * fit.inflation * spread;
        let sd = fit.sd[own].max(1e-4 * (range[1] - range[0]).min(1.0)).min(1.0);
        let side = |sign: f64| {
            let (mut step, mut start) = (1.6 * sd * (fit.inflation * spread).sqrt(), fit.p.clone());
            let mut ends = (0.0, f64::MAX);
            for _ in 0..10 {
                let to = (at + sign * step).clamp(range[0], range[1]);
                let held = (of, to, HOLDING / sd);
                let Some(found) = self.least(&start, fit.terms, Some(held)) else { break };
                let rise = found.chi - fit.chi;
                if rise < wanted {
                    start.clone_from(&found.p);
                    ends.0 = (to - at).abs();
                    if to == range[0] || to == range[1] {
                        return to;
                    }
                } else {
                    ends.1 = (to - at).abs();
                }
                if (rise / wanted - 1.0).abs() < 0.05 {
                    return to;
                }
                let aim = step * (wanted / rise.max(0.05 * wanted)).sqrt();
                step = if ends.1 < f64::MAX { aim.clamp(0.9 * ends.0 + 0.1 * ends.1, 0.1 * ends.0 + 0.9 * ends.1) } else { aim };
            }
            // the outer end of what is left
            at + sign * if ends.1 < f64::MAX { ends.1 } else { step }
        };
        let ends = [side(-1.0), side(1.0)];
        // neither exponent nor share can be below zero
        let floor = matches!(of, Quantity::Exponent | Quantity::Share(_));
        let open = range[0] < range[1] && (ends[0] == range[0] && !floor || ends[1] == range[1]);
        Estimate { of, value: of.outer(at), interval: ends.map(|end| of.outer(end)), open }
    }
}
