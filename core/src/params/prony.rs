//! Relaxation of the tissue as a user sets it, and as the tick reads it.
//!
//! Fung's quasi-linear viscoelasticity: every elastic force f becomes `int G(t - s) df(s)` with the
//! reduced relaxation function `G(t) = 1 - sum g (1 - exp(-t / tau))`. G is 1 at first, so Young's
//! modulus is the *instantaneous* one and the stable step does not change; after a long hold
//! `1 - sum g` of every force is left.

use crate::fault::BuildError;

/// Largest number of terms of a relaxation function.
pub const MOST_TERMS: usize = 3;
/// Largest sum of the shares (1): some elastic force must remain.
const MOST_SHARE: f32 = 0.99;
/// Longest time constant, in ticks. The part that fades in one substep must stay well above the
/// rounding error of the part that has faded already. At this limit, with one substep per tick, the
/// force at the end of a hold may be off by 1.2 % of the term's share, and with n substeps by n
/// times that.
const MOST_TICKS: f32 = 2e5;

/// One term of the relaxation function (Prony series).
///
/// ```
/// use palpate::{Params, PronyTerm};
///
/// // of the force at first contact, 57 % fades in a hold of half a minute
/// let fast = PronyTerm { share: 0.3, time_s: 0.3 };
/// let slow = PronyTerm { share: 0.27, time_s: 4.7 };
/// let tissue = Params { relaxation: [fast, slow, PronyTerm::NONE], ..Params::default() };
/// assert_eq!(tissue.check(), Ok(()));
/// assert!((tissue.long_term_modulus_pa() / tissue.youngs_modulus_pa - 0.43).abs() < 1e-6);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PronyTerm {
    /// Share of the instantaneous force that fades with this term (1). Zero leaves the term out.
    pub share: f32,
    /// Time constant of the fading [s], at least one tick.
    pub time_s: f32,
}

impl PronyTerm {
    /// A term that is left out.
    pub const NONE: Self = Self { share: 0.0, time_s: 0.0 };
}

/// Sum of the shares (1).
pub(super) fn faded_share(terms: &[PronyTerm; MOST_TERMS]) -> f32 {
    terms.iter().map(|term| term.share).sum()
}

/// Checks shares and times of the terms that act.
pub(super) fn check(terms: &[PronyTerm; MOST_TERMS], tick_s: f32) -> Result<(), BuildError> {
    const SHARE: [&str; MOST_TERMS] = ["relaxation[0].share", "relaxation[1].share", "relaxation[2].share"];
    const TIME: [&str; MOST_TERMS] = ["relaxation[0].time_s", "relaxation[1].time_s", "relaxation[2].time_s"];
    for ((term, share), time) in terms.iter().zip(SHARE).zip(TIME) {
        BuildError::within(share, term.share, 0.0, MOST_SHARE)?;
        if term.share > 0.0 {
            BuildError::within(time, term.time_s, tick_s, MOST_TICKS * tick_s)?;
        }
    }
    BuildError::within("relaxation shares in all", faded_share(terms), 0.0, MOST_SHARE)
}

/// Discrete form of a relaxation function in steps of one substep, exact for forces that are linear
/// within each.
///
/// Per term, the faded part is kept as s, with its sign reversed: `h = s + rises f`,
/// `s -= fades h`, and the force that acts is `stays f + sum h`. This is the recursion
/// `h <- a h + g b (f - f_prev)`, `a = exp(-dt / tau)`, `b = (1 - a) tau / dt`, with
/// `s = a h - g b f` stored in place of h and `f_prev`: 12 bytes instead of 24 with one term, and
/// no value decays into denormal numbers in a long hold.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Prony {
    /// Number of terms that act; zero without relaxation.
    pub terms: usize,
    /// Share of a force that never fades, `1 - sum g`.
    pub stays: f32,
    /// Response of the force to a change within the substep, `1 - sum g (1 - b)`: just below one.
    pub at_once: f32,
    /// `g b` of every term.
    pub rises: [f32; MOST_TERMS],
    /// `1 - a` of every term.
    pub fades: [f32; MOST_TERMS],
}

impl Prony {
    /// Derives the step's constants.
    pub(super) fn of(terms: &[PronyTerm; MOST_TERMS], substep_s: f32) -> Self {
        let mut prony = Self { terms: 0, stays: 1.0, at_once: 1.0, rises: [0.0; MOST_TERMS], fades: [0.0; MOST_TERMS] };
        for term in terms.iter().filter(|term| term.share > 0.0) {
            let steps = substep_s / term.time_s;
            let fades = faded_after(steps);
            if let (Some(rise), Some(fade)) = (prony.rises.get_mut(prony.terms), prony.fades.get_mut(prony.terms)) {
                (*rise, *fade) = (term.share * fades / steps, fades);
                prony.stays -= term.share;
                prony.terms += 1;
            }
        }
        prony.at_once = prony.stays + prony.rises.iter().sum::<f32>();
        prony
    }
}

/// `1 - exp(-x)` for x from 0 to 1 by its series: accurate to rounding, also where x is small, with
/// the same bits on every target. It takes a thirtieth of the code of `libm::expm1f`.
fn faded_after(x: f32) -> f32 {
    let nested = (2..=11_u8).rev().fold(1.0, |sum, n| 1.0 - sum * x / f32::from(n));
    x * nested
}

#[cfg(test)]
#[allow(clippy::disallowed_types, reason = "the oracle is in double precision")]
mod tests {
    use super::*;

    #[test]
    fn the_series_is_the_exponential() {
        for n in 1..=1000_u16 {
            for x in [f32::from(n) * 1e-3, f32::from(n) * 1e-8] {
                let exact = -libm::expm1(f64::from(-x));
                assert!((f64::from(faded_after(x)) / exact - 1.0).abs() < 3e-7, "{x}");
            }
        }
    }

    #[test]
    fn the_step_is_the_recursion_of_the_literature() {
        let (share, time_s, dt) = (0.4, 0.02, 1e-3);
        let prony = Prony::of(&[PronyTerm { share, time_s }, PronyTerm::NONE, PronyTerm::NONE], dt);
        assert_eq!(prony.terms, 1);
        let a = libm::exp(-f64::from(dt / time_s));
        let b = (1.0 - a) * f64::from(time_s / dt);
        let (mut h, mut previous, mut s) = (0.0, 0.0, 0.0_f32);
        for n in 0..200_u16 {
            // a ramp, a hold, a fall to zero
            let f = f64::from(n.min(50)) * if n < 120 { 1.0 } else { 0.0 };
            h = a * h + f64::from(share) * b * (f - previous);
            previous = f;
            let expected = (1.0 - f64::from(share)) * f + h;
            let kept = s + prony.rises[0] * f as f32;
            s -= prony.fades[0] * kept;
            let found = f64::from(prony.stays * f as f32 + kept);
            assert!((found - expected).abs() < 1e-4, "tick {n}: {found} for {expected}");
        }
    }
}
