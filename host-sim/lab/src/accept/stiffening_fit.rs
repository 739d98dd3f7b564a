//! Fits the modulus, the stiffening exponent and the depth of first contact to the forces of a
//! press.
//!
//! The force divided by E is computed at a few exponents and depths and interpolated between them:
//! for a given exponent and offset the best modulus follows directly, so only those two are
//! searched.

/// Fitted modulus, exponent and offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StiffeningFit {
    /// Young's modulus at rest [Pa].
    pub youngs_modulus_pa: f64,
    /// Stiffening exponent b (1).
    pub stiffening_b: f64,
    /// Depth added to each recorded depth [m].
    pub offset_m: f64,
    /// Root mean square of the residual, divided by the largest fitted force (1).
    pub rms: f64,
}

/// Force divided by Young's modulus as a function of depth, at several exponents.
#[derive(Clone, Debug)]
pub struct Curves {
    /// Spacing of the depths, which is also the first depth [m].
    step_m: f64,
    /// Exponents in ascending order (1).
    b: Vec<f64>,
    /// `ln (F / (E d^1.5))` at every depth, for each exponent; nearly a straight line over depth.
    ln: Vec<Vec<f64>>,
}

/// Weights of Lagrange interpolation at `x`, with nodes at `at`.
fn lagrange(at: &[f64], x: f64) -> impl Iterator<Item = f64> {
    at.iter().map(move |a| at.iter().filter(|c| *c != a).map(|c| (x - c) / (a - c)).product())
}

/// Index of the first of those `taken` neighbours in the ascending list `all` that best surround
/// `x`.
fn around(all: &[f64], taken: usize, x: f64) -> usize {
    let above = all.partition_point(|a| *a < x);
    above.saturating_sub(taken.div_ceil(2)).min(all.len() - taken)
}

impl Curves {
    /// Takes the forces divided by E [m^2] at the depths `step_m`, 2 `step_m` and so on, for each
    /// exponent. `None` if there are fewer than three exponents or four depths, or a force is not
    /// positive.
    #[must_use]
    pub fn new(step_m: f64, curves: &[(f64, Vec<f64>)]) -> Option<Self> {
        let scaled = |(n, force): (usize, &f64)| (force / ((n + 1) as f64 * step_m).powf(1.5)).ln();
        let ln: Vec<Vec<f64>> = curves.iter().map(|(_, force)| force.iter().enumerate().map(scaled).collect()).collect();
        let depths = ln.first()?.len();
        let good = curves.len() >= 3 && depths >= 4 && ln.iter().all(|ln| ln.len() == depths);
        let finite = ln.iter().flatten().all(|ln| ln.is_finite());
        (good && finite).then(|| Self { step_m, b: curves.iter().map(|(b, _)| *b).collect(), ln })
    }

    /// Force divided by E [m^2]; zero above the surface, `None` beyond the deepest computed depth.
    #[must_use]
    pub fn force_m2(&self, b: f64, depth_m: f64) -> Option<f64> {
        let place: Vec<f64> = (1..=self.ln.first()?.len()).map(|n| n as f64).collect();
        let x = depth_m / self.step_m;
        if x > *place.last()? + 1e-9 {
            return None;
        }
        if depth_m <= 0.0 {
            return Some(0.0);
        }
        // at smaller depths than the first the power law of first contact is used
        let x = x.max(1.0);
        let (i, j) = (around(&self.b, 3, b), around(&place, 4, x));
        let (b_at, place_at) = (self.b.get(i..i + 3)?, place.get(j..j + 4)?);
        let ln: f64 = lagrange(b_at, b)
            .zip(&self.ln[i..])
            .map(|(of_b, ln)| of_b * lagrange(place_at, x).zip(&ln[j..]).map(|(w, ln)| w * ln).sum::<f64>())
            .sum();
        Some(ln.exp() * depth_m.powf(1.5))
    }
}

/// Values tried for exponent and offset: smallest, largest, and number of steps between them.
#[derive(Clone, Copy, Debug)]
pub struct Tried {
    /// Range of the exponent (1) and number of steps.
    pub b: (f64, f64, usize),
    /// Range of the offset [m] and number of steps.
    pub offset_m: (f64, f64, usize),
}

fn steps((low, high, count): (f64, f64, usize)) -> impl Iterator<Item = f64> {
    (0..=count).map(move |n| low + (high - low) * n as f64 / count.max(1) as f64)
}

/// Fits modulus, exponent and offset to forces [N] at depths [m]. Offsets are left out if they make
/// the force at recorded depth zero larger than `most_at_contact_n` [N], or if the curves do not
/// reach that deep.
#[must_use]
pub fn fit(curves: &Curves, tried: Tried, depth_m: &[f64], force_n: &[f64], most_at_contact_n: f64) -> Option<StiffeningFit> {
    let largest = force_n.iter().copied().fold(0.0, f64::max);
    let mut best: Option<StiffeningFit> = None;
    for stiffening_b in steps(tried.b) {
        for offset_m in steps(tried.offset_m) {
            let shape = depth_m.iter().map(|d| curves.force_m2(stiffening_b, d + offset_m)).collect::<Option<Vec<f64>>>();
            let Some((shape, first)) = shape.zip(curves.force_m2(stiffening_b, offset_m)) else { continue };
            let (ss, sf): (f64, f64) = shape.iter().zip(force_n).fold((0.0, 0.0), |(ss, sf), (s, f)| (ss + s * s, sf + s * f));
            let youngs_modulus_pa = sf / ss;
            let square: f64 = shape.iter().zip(force_n).map(|(s, f)| (s * youngs_modulus_pa - f).powi(2)).sum();
            let rms = (square / force_n.len() as f64).sqrt() / largest;
            if youngs_modulus_pa * first <= most_at_contact_n && best.is_none_or(|best| rms < best.rms) {
                best = Some(StiffeningFit { youngs_modulus_pa, stiffening_b, offset_m, rms });
            }
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lin et al. 2009: force under a ball of radius 4 mm, divided by E [m^2].
    fn lin(b: f64, depth_m: f64) -> f64 {
        let a_m = (4e-3 * depth_m).sqrt();
        let l = 1.0 - 0.2 * a_m / 4e-3;
        80.0 / 27.0 * a_m * a_m * (l.powi(-2) - l) * (b * (l * l + 2.0 / l - 3.0)).exp()
    }

    const TRIED: Tried = Tried { b: (0.0, 24.0, 48), offset_m: (0.0, 1.5e-3, 30) };

    fn curves() -> Curves {
        let curve = |b: f64| (b, (1..=20).map(|n| lin(b, 2.5e-4 * f64::from(n))).collect());
        Curves::new(2.5e-4, &[0.0, 8.0, 16.0, 24.0].map(curve)).unwrap()
    }

    #[test]
    fn a_press_that_was_made_is_found_again() {
        let depth_m: Vec<f64> = (1..=5).map(|n| 6e-4 * f64::from(n)).collect();
        let force_n: Vec<f64> = depth_m.iter().map(|d| 3.5e3 * lin(18.0, d + 0.75e-3)).collect();
        let found = fit(&curves(), TRIED, &depth_m, &force_n, 0.035).unwrap();
        assert!(found.rms < 1e-3, "{found:?}");
        assert!((found.stiffening_b - 18.0).abs() < 0.6 && (found.offset_m - 0.75e-3).abs() < 6e-5, "{found:?}");
        assert!((found.youngs_modulus_pa / 3.5e3 - 1.0).abs() < 0.1, "{found:?}");
    }

    #[test]
    fn the_force_at_contact_bounds_the_offset() {
        let depth_m: Vec<f64> = (1..=5).map(|n| 6e-4 * f64::from(n)).collect();
        let force_n: Vec<f64> = depth_m.iter().map(|d| 3.5e3 * lin(18.0, d + 0.75e-3)).collect();
        let free = fit(&curves(), TRIED, &depth_m, &force_n, 1.0).unwrap();
        let bound = fit(&curves(), TRIED, &depth_m, &force_n, 0.005).unwrap();
        assert!(bound.offset_m < 0.7 * free.offset_m, "{bound:?} {free:?}");
        assert!(curves().force_m2(10.0, 5.01e-3).is_none(), "not computed so deep");
    }
}
