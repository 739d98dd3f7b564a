//! Margin of a method to failure: one quantity is increased until a press or a tap no longer
//! passes.

use serde::{Deserialize, Serialize};

use super::built_method::BuiltMethod;
use super::load_case::{PRESS, Stimulus, TAP};
use super::verdict::Verdict;
use crate::error::Error;

/// Relative accuracy to which the largest value that passes is found (1).
const RESOLUTION: f64 = 0.05;

/// Quantity that is increased.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Axis {
    /// Length of the tick divided by 1 ms (1), with unchanged masses and foundation; tested with
    /// the press and the tap.
    Tick,
    /// Depth of the slow press [m].
    Depth,
    /// Speed of the tap to a depth of 8 mm [m/s]. The core limits the speed of the tip to 1 m/s.
    Speed,
    /// Young's modulus [Pa], with unchanged substeps; tested with the press and the tap.
    Stiffness,
}

impl Axis {
    /// All quantities in the order of tables.
    pub const ALL: [Self; 4] = [Self::Tick, Self::Depth, Self::Speed, Self::Stiffness];

    /// Name in files, with the unit.
    pub fn name(self) -> &'static str {
        match self {
            Self::Tick => "tick_over_1ms",
            Self::Depth => "depth_m",
            Self::Speed => "tap_m_per_s",
            Self::Stiffness => "youngs_modulus_pa",
        }
    }

    /// Range of the search. The core rejects ticks longer than 2 ms.
    pub fn range(self) -> [f64; 2] {
        match self {
            Self::Tick => [0.35, 2.0],
            Self::Depth => [1e-3, 36e-3],
            Self::Speed => [0.02, 3.0],
            Self::Stiffness => [1e3, 1e6],
        }
    }

    /// Standard value, with which a method of this Young's modulus [Pa] must pass.
    pub fn standard(self, youngs_modulus_pa: f64) -> f64 {
        match self {
            Self::Tick => 1.0,
            Self::Depth => PRESS.depth_m,
            Self::Speed => TAP.in_m_per_s,
            Self::Stiffness => youngs_modulus_pa,
        }
    }

    /// Formats a value in the unit of tables (ms, mm, m/s or kPa); `or_more` says that no larger
    /// value was tried.
    pub fn said(self, value: f64, or_more: bool) -> String {
        let number = match self {
            Self::Tick | Self::Speed => format!("{value:.2}"),
            Self::Depth => format!("{:.1}", value * 1e3),
            Self::Stiffness => format!("{:.0}", value * 1e-3),
        };
        if or_more { format!("≥ {number}") } else { number }
    }

    fn verdict(self, method: &BuiltMethod, value: f64) -> Result<Verdict, Error> {
        match self {
            Self::Tick => both(&method.with_tick((value * 1e-3) as f32)),
            Self::Depth => Ok(method.stand(&Stimulus { depth_m: value, ..PRESS })?.verdict),
            Self::Speed => Ok(method.stand(&Stimulus { in_m_per_s: value, out_m_per_s: value, ..TAP })?.verdict),
            Self::Stiffness => both(&method.with_modulus(value)),
        }
    }
}

/// Verdict on the press, or on the tap if the press passes.
fn both(method: &BuiltMethod) -> Result<Verdict, Error> {
    let press = method.stand(&PRESS)?.verdict;
    if press != Verdict::Pass {
        return Ok(press);
    }
    Ok(method.stand(&TAP)?.verdict)
}

/// Limit up to which a method passes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Margin {
    /// Largest value that passes; `None` if neither the standard value nor the smallest value
    /// passes.
    pub passes: Option<f64>,
    /// Verdict just beyond that value; `None` if the largest value tried passes.
    pub beyond: Option<Verdict>,
}

/// Finds the largest value between the ends that passes, by bisection of its logarithm: above the
/// standard value if that passes, otherwise below it. A method that fails at a value is assumed to
/// fail at all larger values.
pub fn largest(
    [low, high]: [f64; 2],
    standard: f64,
    mut verdict: impl FnMut(f64) -> Result<Verdict, Error>,
) -> Result<Margin, Error> {
    let at_standard = verdict(standard)?;
    let (mut good, mut bad, mut beyond) = if at_standard == Verdict::Pass {
        match verdict(high)? {
            Verdict::Pass => return Ok(Margin { passes: Some(high), beyond: None }),
            wrong => (standard, high, wrong),
        }
    } else {
        match verdict(low)? {
            Verdict::Pass => (low, standard, at_standard),
            _ => return Ok(Margin { passes: None, beyond: Some(at_standard) }),
        }
    };
    while bad / good > 1.0 + RESOLUTION {
        let middle = (good * bad).sqrt();
        match verdict(middle)? {
            Verdict::Pass => good = middle,
            wrong => (bad, beyond) = (middle, wrong),
        }
    }
    Ok(Margin { passes: Some(good), beyond: Some(beyond) })
}

/// Margin of a method along an axis.
pub fn margin(method: &BuiltMethod, axis: Axis) -> Result<Margin, Error> {
    let standard = axis.standard(method.block.params.youngs_modulus_pa.into());
    largest(axis.range(), standard, |value| axis.verdict(method, value))
}
