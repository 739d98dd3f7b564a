//! Elastic force of a test over depth and stiffening exponent: finite elements at a few exponents,
//! interpolated as a factor on the law of small depth, such as Hertz's.
//!
//! The factor is 1 where the depth vanishes, and smooth in the square root of the depth, as it
//! depends on the contact radius over the thickness. Its logarithm is a polynomial without a
//! constant, fitted to the solved depths: first contact, where elements are too coarse, is exact.

use nalgebra::{SMatrix, SVector};
use rayon::prelude::{IntoParallelIterator, ParallelIterator};

use super::axial::Cylinder;

/// Number of solved depths, and number of terms of the polynomial.
const DEPTHS: usize = 14;
const TERMS: usize = 6;
/// Square root of the first solved depth over that of the deepest.
const FIRST: f64 = 0.22;
/// Size of the elements, divided by the largest contact radius.
const FINENESS: f64 = 0.14;
/// Exponents at which forces are solved, evenly spaced in ln(1 + b).
pub const EXPONENTS: [f64; 5] = [0.0, 1.0, 3.0, 7.0, 15.0];

/// A ball over the centre of a slab with a fixed bottom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setup {
    /// Radius of the ball [m].
    pub ball_m: f64,
    /// Sides of the slab, the thickness last [m].
    pub block_m: [f64; 3],
    /// Poisson's ratio (1).
    pub poisson_ratio: f64,
}

impl Setup {
    /// The cylinder of the slab's area.
    fn cylinder(&self, stiffening_b: f64, fineness: f64) -> Cylinder {
        let [x, y, height_m] = self.block_m;
        let radius_m = (x * y / std::f64::consts::PI).sqrt();
        let &Self { ball_m, poisson_ratio, .. } = self;
        Cylinder { ball_m, radius_m, height_m, poisson_ratio, stiffening_b, fineness }
    }
}

/// Force over Young's modulus as a function of depth and exponent.
#[derive(Clone, Debug)]
pub struct Elastic {
    deepest_m: f64,
    /// Force over E at small depth [m^2] is this times depth to the power.
    scale: f64,
    power: f64,
    exponents: Vec<f64>,
    polynomials: Vec<[f64; TERMS]>,
}

/// Curve at one exponent.
#[derive(Clone, Copy, Debug)]
pub struct Curve {
    deepest_m: f64,
    scale: f64,
    power: f64,
    polynomial: [f64; TERMS],
}

/// Depths at which forces are solved [m].
#[must_use]
pub fn depths_m(deepest_m: f64) -> [f64; DEPTHS] {
    std::array::from_fn(|n| deepest_m * (FIRST + (1.0 - FIRST) * n as f64 / (DEPTHS - 1) as f64).powi(2))
}

impl Elastic {
    /// Solves a ball on a slab to a depth [m]; `None` if some press finds no equilibrium.
    #[must_use]
    pub fn solve(setup: &Setup, deepest_m: f64) -> Option<Self> {
        Self::solve_at(setup, deepest_m, &EXPONENTS)
    }

    /// Solves at these exponents.
    #[must_use]
    pub fn solve_at(setup: &Setup, deepest_m: f64, exponents: &[f64]) -> Option<Self> {
        Self::solve_with(setup, deepest_m, exponents, FINENESS)
    }

    /// Solves with elements of another size, divided by the largest contact radius.
    #[must_use]
    pub fn solve_with(setup: &Setup, deepest_m: f64, exponents: &[f64], fineness: f64) -> Option<Self> {
        let depths_m = depths_m(deepest_m);
        let solve = |b: &f64| (*b, setup.cylinder(*b, fineness).forces_m2(&depths_m));
        let solved: Vec<(f64, Vec<f64>)> = exponents.to_vec().into_par_iter().map(|b| solve(&b)).collect();
        let nu = setup.poisson_ratio;
        Self::of(deepest_m, 4.0 / 3.0 / (1.0 - nu * nu) * setup.ball_m.sqrt(), 1.5, &solved)
    }

    /// Takes forces over E at [`depths_m`] for ascending exponents; the force at small depth is
    /// `scale` times depth to `power`. An exponent without all of its forces ends the list.
    #[must_use]
    pub fn of(deepest_m: f64, scale: f64, power: f64, solved: &[(f64, Vec<f64>)]) -> Option<Self> {
        let depths_m = depths_m(deepest_m);
        let place = |depth_m: f64| (depth_m / deepest_m).sqrt();
        // an error of the elements is like one over the number of them in contact
        let rows = SMatrix::<f64, DEPTHS, TERMS>::from_fn(|n, k| place(depths_m[n]).powi(k as i32 + 2)).qr();
        let of = |forces: &[f64]| -> Option<[f64; TERMS]> {
            let right =
                SVector::<f64, DEPTHS>::from_fn(|n, _| (forces[n] / (scale * depths_m[n].powf(power))).ln() * place(depths_m[n]));
            rows.r().solve_upper_triangular(&(rows.q().transpose() * right)).map(Into::into)
        };
        let whole = solved.iter().take_while(|(_, forces)| forces.len() == DEPTHS && forces.iter().all(|f| *f > 0.0));
        let polynomials: Vec<[f64; TERMS]> = whole.map(|(_, forces)| of(forces)).collect::<Option<_>>()?;
        let exponents = solved.iter().map(|(b, _)| *b).take(polynomials.len()).collect();
        (!polynomials.is_empty()).then_some(Self { deepest_m, scale, power, exponents, polynomials })
    }

    /// Largest exponent.
    #[must_use]
    pub fn most_b(&self) -> f64 {
        self.exponents.last().copied().unwrap_or(0.0)
    }

    /// Curve at an exponent.
    #[must_use]
    pub fn at(&self, b: f64) -> Curve {
        let x = |b: f64| b.ln_1p();
        let mut polynomial = [0.0; TERMS];
        for (n, of) in self.polynomials.iter().enumerate() {
            let others = (0..self.exponents.len()).filter(|m| *m != n).map(|m| self.exponents[m]);
            let weight: f64 = others.map(|other| (x(b) - x(other)) / (x(self.exponents[n]) - x(other))).product();
            polynomial.iter_mut().zip(of).for_each(|(p, of)| *p += weight * of);
        }
        Curve { deepest_m: self.deepest_m, scale: self.scale, power: self.power, polynomial }
    }
}

impl Curve {
    /// Force over E [m^2] at a depth [m]; zero above the surface.
    #[must_use]
    pub fn force_m2(&self, depth_m: f64) -> f64 {
        if depth_m <= 0.0 {
            return 0.0;
        }
        let s = (depth_m / self.deepest_m).sqrt();
        let ln = s * self.polynomial.iter().rev().fold(0.0, |sum, p| sum * s + p);
        self.scale * depth_m.powf(self.power) * ln.exp()
    }
}

#[cfg(test)]
mod tests {
    use super::super::fit::{Fitted, Problem, Settings};
    use super::super::model::{Tissue, any_n};
    use super::super::record::Record;
    use super::*;

    fn fitted(elastic: &Elastic, record: Record, settings: Settings) -> Fitted {
        let rows = vec![record.time_s.len()];
        Problem::new(elastic, &[record], rows, settings).solve().unwrap()
    }

    /// The record has the force at the end of the loading and at five times of the hold only.
    #[test]
    fn a_hold_with_known_motion_gives_its_terms_again() {
        let deepest_m = 4e-3;
        let hertz_m2 = depths_m(deepest_m).map(|d| 0.1 * d.powf(1.5)).to_vec();
        let elastic = Elastic::of(deepest_m, 0.1, 1.5, &[(0.0, hertz_m2)]).unwrap();
        let made = Tissue { youngs_modulus_pa: 20e3, stiffening_b: 0.0, terms: vec![(0.3, 0.35), (0.25, 5.0)] };
        let time_s: Vec<f64> = (0..=675).map(|n| 0.02 * f64::from(n)).collect();
        let depth_m: Vec<f64> = time_s.iter().map(|t| deepest_m * (t / 4.0).min(1.0)).collect();
        let mut force_n = any_n(&made, &elastic.at(0.0), &time_s, &depth_m);
        let known = [200, 225, 250, 300, 450, 675];
        (0..force_n.len()).filter(|n| !known.contains(n)).for_each(|n| force_n[n] = f64::NAN);
        let record = Record::of_points(time_s, depth_m, force_n, [0.0; 2]);
        let settings = Settings { terms: 2..3, stiffens: false, contact: false, times_s: Some([0.1, 30.0]) };
        let found = fitted(&elastic, record, settings).tissue();
        assert!((found.youngs_modulus_pa / 20e3 - 1.0).abs() < 0.05, "{found:?}");
        for ((share, time_s), (made_share, made_s)) in found.terms.iter().zip(&made.terms) {
            assert!((share / made_share - 1.0).abs() < 0.1 && (time_s / made_s - 1.0).abs() < 0.15, "{found:?}");
        }
    }

    /// Lin et al. 2009: force under a ball of radius 4 mm, divided by E [m^2].
    fn lin_m2(b: f64, depth_m: f64) -> f64 {
        let a_m = (4e-3 * depth_m).sqrt();
        let l = 1.0 - 0.2 * a_m / 4e-3;
        80.0 / 27.0 * a_m * a_m * (l.powi(-2) - l) * (b * (l * l + 2.0 / l - 3.0)).exp()
    }

    #[test]
    fn a_press_by_a_table_gives_exponent_and_contact_again() {
        let deepest_m = 5e-3;
        let table = [0.0, 3.0, 8.0, 16.0, 30.0].map(|b| (b, depths_m(deepest_m).map(|d| lin_m2(b, d)).to_vec()));
        let elastic = Elastic::of(deepest_m, 16.0 / 9.0 * 4e-3_f64.sqrt(), 1.5, &table).unwrap();
        let depth_m: Vec<f64> = (1..=5).map(|n| 6e-4 * f64::from(n)).collect();
        let force_n = depth_m.iter().map(|d| 3.5e3 * lin_m2(18.0, d + 0.75e-3)).collect();
        let record = Record::of_points((0..5).map(f64::from).collect(), depth_m, force_n, [-1.5e-3, 0.0]);
        let found = fitted(&elastic, record, Settings { terms: 0..1, ..Settings::default() });
        let tissue = found.tissue();
        assert!((tissue.stiffening_b - 18.0).abs() < 0.6 && (found.contact_m(0) + 0.75e-3).abs() < 6e-5, "{found:?}");
        assert!((tissue.youngs_modulus_pa / 3.5e3 - 1.0).abs() < 0.1, "{found:?}");
    }
}
