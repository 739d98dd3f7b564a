//! Modulus, stiffening exponent and the place of first contact from a curve of force over depth.

/// A fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExponentialFit {
    /// Young's modulus at rest [Pa].
    pub youngs_modulus_pa: f64,
    /// Stiffening exponent b (1).
    pub stiffening_b: f64,
    /// Depth at which the contact was declared [m]: how much deeper than recorded each depth is.
    pub offset_m: f64,
    /// Root mean square of what is left, over the largest force fitted (1).
    pub rms: f64,
}

/// Force over Young's modulus [m^2] over depths a fixed step apart, from zero on.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Distance of the depths [m].
    pub step_m: f64,
    /// Force over Young's modulus at each [m^2].
    pub force_m2: Vec<f64>,
}

impl Curve {
    /// Between the depths `F / d^1.5` is quadratic: the power law of first contact is exact.
    #[must_use]
    pub fn at(&self, depth_m: f64) -> Option<f64> {
        let scaled = |n: usize| self.force_m2.get(n).map(|f| f / (n as f64 * self.step_m).powf(1.5));
        let place = depth_m / self.step_m;
        let middle = (place.round() as usize).clamp(2, self.force_m2.len().checked_sub(2)?);
        if place > self.force_m2.len() as f64 - 1.0 + 1e-9 {
            return None;
        }
        let (a, b, c) = (scaled(middle - 1)?, scaled(middle)?, scaled(middle + 1)?);
        let t = place - middle as f64;
        Some((b + 0.5 * t * (c - a) + 0.5 * t * t * (a - 2.0 * b + c)) * depth_m.powf(1.5))
    }
}

/// Offsets tried [m]: none, up to where a ball of 4 mm already pushes with more than the force at
/// which contact was declared.
const OFFSETS_M: [f64; 2] = [0.0, 1.5e-3];
const OFFSETS: usize = 301;

/// Best modulus and offset for a curve; `None` where no offset lies on it.
#[must_use]
pub fn fit_curve(curve: &Curve, stiffening_b: f64, depth_m: &[f64], force_n: &[f64]) -> Option<ExponentialFit> {
    let largest = force_n.iter().copied().fold(0.0, f64::max);
    let tried = (0..OFFSETS).filter_map(|n| {
        let offset_m = OFFSETS_M[0] + (OFFSETS_M[1] - OFFSETS_M[0]) * n as f64 / (OFFSETS - 1) as f64;
        let shape = depth_m.iter().map(|d| curve.at(d + offset_m)).collect::<Option<Vec<f64>>>()?;
        let (ff, fs): (f64, f64) = shape.iter().zip(force_n).fold((0.0, 0.0), |(ff, fs), (s, f)| (ff + s * s, fs + s * f));
        let youngs_modulus_pa = fs / ff;
        let square: f64 = shape.iter().zip(force_n).map(|(s, f)| (s * youngs_modulus_pa - f).powi(2)).sum();
        Some(ExponentialFit { youngs_modulus_pa, stiffening_b, offset_m, rms: (square / force_n.len() as f64).sqrt() / largest })
    });
    tried.min_by(|a, b| a.rms.total_cmp(&b.rms))
}

/// Exponents tried in a round, and the rounds: each narrows the range to two of its steps.
const TRIED: usize = 5;
const ROUNDS: usize = 4;

/// Fits all three; `curve` gives the force of an exponent.
///
/// # Errors
/// Those of `curve`.
pub fn fit<E>(
    most_b: f64,
    depth_m: &[f64],
    force_n: &[f64],
    mut curve: impl FnMut(f64) -> Result<Curve, E>,
) -> Result<Option<ExponentialFit>, E> {
    let mut range = [0.0, most_b];
    let mut best: Option<ExponentialFit> = None;
    for _ in 0..ROUNDS {
        let step = (range[1] - range[0]) / (TRIED - 1) as f64;
        for n in 0..TRIED {
            let b = range[0] + step * n as f64;
            let found = fit_curve(&curve(b)?, b, depth_m, force_n);
            best = best.into_iter().chain(found).min_by(|a, b| a.rms.total_cmp(&b.rms));
        }
        let Some(middle) = best.map(|best| best.stiffening_b) else { return Ok(None) };
        range = [(middle - step).max(0.0), (middle + step).min(most_b)];
    }
    Ok(best)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lin et al. 2009: force of a ball of this radius over `80 E / 27` [m^2].
    fn lin(radius_m: f64, b: f64, depth_m: f64) -> f64 {
        let a_m = (radius_m * depth_m).sqrt();
        let l = 1.0 - 0.2 * a_m / radius_m;
        a_m * a_m * (l.powi(-2) - l) * (b * (l * l + 2.0 / l - 3.0)).exp()
    }

    #[test]
    fn a_curve_that_was_made_is_found_again() {
        let curve = |b: f64| {
            let force_m2 = (0..=25).map(|n| lin(4e-3, b, 2e-4 * f64::from(n))).collect();
            Ok::<_, ()>(Curve { step_m: 2e-4, force_m2 })
        };
        let depth_m: Vec<f64> = (0..10).map(|n| 3.3e-4 * f64::from(n) + 0.06e-3).collect();
        let force_n: Vec<f64> = depth_m.iter().map(|d| 3e3 * lin(4e-3, 18.0, d + 0.7e-3)).collect();
        let found = fit(40.0, &depth_m, &force_n, curve).unwrap().unwrap();
        assert!(found.rms < 2e-3, "{found:?}");
        assert!((found.stiffening_b - 18.0).abs() < 1.0 && (found.offset_m - 0.7e-3).abs() < 1e-4, "{found:?}");
    }
}
