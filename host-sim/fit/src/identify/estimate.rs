//! Quantities that are identified, and how well they are known.

/// Relative half width of an interval up to which modulus and exponent are told (1), and the half
/// width of a share.
const TOLD_MODULUS: f64 = 0.05;
const TOLD_EXPONENT: f64 = 0.2;
/// Half width of an exponent's interval that is narrow at any value (1): gelatin has none.
const TOLD_EXPONENT_LEAST: f64 = 0.05;
const TOLD_SHARE: f64 = 0.05;

/// A quantity that is identified.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Instantaneous modulus [Pa].
    Modulus,
    /// Modulus after complete relaxation [Pa].
    Relaxed,
    /// Stiffening exponent (1).
    Exponent,
    /// Share of a Prony term (1).
    Share(usize),
    /// Time of a Prony term [s].
    Time(usize),
    /// Depth of first contact of a test [m].
    Contact(usize),
}

impl Quantity {
    /// Place of the quantity, or of what it depends on most, among the unknowns.
    pub(super) fn place(self, terms: usize) -> usize {
        match self {
            Self::Modulus | Self::Relaxed => 0,
            Self::Exponent => 1,
            Self::Share(k) => 2 + 2 * k,
            Self::Time(k) => 3 + 2 * k,
            Self::Contact(k) => 2 + 2 * terms + k,
        }
    }

    /// The quantity itself, where the fit moves it by its logarithm.
    pub(super) fn outer(self, x: f64) -> f64 {
        match self {
            Self::Modulus | Self::Relaxed | Self::Time(_) => x.exp(),
            Self::Exponent => x.exp_m1(),
            Self::Share(_) | Self::Contact(_) => x,
        }
    }
}

/// A value with its 90 % interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The quantity.
    pub of: Quantity,
    /// Most likely value.
    pub value: f64,
    /// 90 % interval by the profile likelihood, wider by what still finer elements would change.
    pub interval: [f64; 2],
    /// Whether an end of the interval is where the fit stops looking, and not the data's.
    pub open: bool,
}

impl Estimate {
    /// With so much more on either side of the interval; no constant of a tissue is negative.
    pub(super) fn wider(self, by: f64) -> Self {
        let [low, high] = self.interval;
        Self { interval: [(low - by).max(0.0).min(low), high + by], ..self }
    }

    /// Half the width of the interval over the value (1).
    #[must_use]
    pub fn relative(&self) -> f64 {
        0.5 * (self.interval[1] - self.interval[0]) / self.value
    }

    /// Whether the interval is narrow enough for the value to be relied on.
    #[must_use]
    pub fn told(&self) -> bool {
        let half = 0.5 * (self.interval[1] - self.interval[0]);
        !self.open
            && match self.of {
                Quantity::Modulus | Quantity::Relaxed => self.relative() <= TOLD_MODULUS,
                Quantity::Exponent => half <= (TOLD_EXPONENT * self.value).max(TOLD_EXPONENT_LEAST),
                Quantity::Share(_) => half <= TOLD_SHARE,
                Quantity::Time(_) => self.relative() <= 0.5,
                Quantity::Contact(_) => true,
            }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wider_interval_stays_positive_and_may_no_longer_be_told() {
        let narrow = Estimate { of: Quantity::Exponent, value: 0.3, interval: [0.27, 0.33], open: false };
        assert!(narrow.told());
        let wider = narrow.wider(0.4);
        assert!(wider.interval == [0.0, 0.73] && !wider.told(), "{wider:?}");
    }
}
