//! Elastic force of a test over depth and stiffening exponent: finite elements at a few exponents,
//! interpolated as a factor on the law of small depth, such as Hertz's. Once the exponent is about
//! known, finer elements at that exponent take off the errors of elements and interpolation.
//!
//! The factor is 1 where the depth vanishes, and smooth in the square root of the depth, as it
//! depends on the contact radius over the thickness. Its logarithm is a polynomial without a
//! constant, fitted to the solved depths, so that first contact is exact.

use nalgebra::{SMatrix, SVector};
use rayon::prelude::{IntoParallelIterator, ParallelExtend, ParallelIterator};

use super::axial::Cylinder;

/// Number of solved depths, and number of terms of the polynomial. With six terms the force was up
/// to 0.2 % off between the depths, in slabs that stiffen strongly and are pressed to half of their
/// thickness.
const DEPTHS: usize = 14;
const TERMS: usize = 9;
/// Square root of the first solved depth over that of the deepest.
const FIRST: f64 = 0.15;
/// Sizes of the elements, divided by the contact radius: those of all exponents, and those of the
/// one that is found. The former are within 0.3 %, the latter within 0.06 % of the force.
pub const FINENESS: f64 = 0.25;
const FINER: f64 = 0.125;
/// Change that still finer elements would bring, over that of these (1), if errors fall with the
/// square of the size.
pub const STILL_FINER: f64 = FINER * FINER / (FINENESS * FINENESS - FINER * FINER);
/// Exponents at which forces are solved: Chebyshev points in ln(1 + b). Between five even ones the
/// force was up to 7 % off where a press is half as deep as the slab, between nine 2 %.
pub const EXPONENTS: [f64; 9] = [0.0, 0.111_294, 0.500_857, 1.353_215, 3.0, 5.799_209, 9.660_577, 13.397_626, 15.0];

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

    /// Hertz's force over Young's modulus and depth to 1.5 [m^0.5].
    fn hertz(&self) -> f64 {
        4.0 / 3.0 / (1.0 - self.poisson_ratio.powi(2)) * self.ball_m.sqrt()
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
    /// Correction of the polynomials by finer elements.
    finer: [f64; TERMS],
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
    /// Solves a ball on a slab to a depth [m], or as deep as presses without stiffening find their
    /// equilibrium; `None` if that is nowhere.
    #[must_use]
    pub fn solve(setup: &Setup, deepest_m: f64) -> Option<Self> {
        let at = |b: f64, deepest_m: f64| (b, setup.cylinder(b, FINENESS).forces_m2(&depths_m(deepest_m)));
        let [first, others @ ..] = EXPONENTS;
        let mut reached_m = deepest_m;
        let plain = loop {
            let plain = at(first, reached_m);
            if plain.1.len() == DEPTHS {
                break plain;
            }
            // finer elements and other exponents need some room
            reached_m = depths_m(reached_m)[plain.1.len().checked_sub(2)?];
        };
        let mut solved = vec![plain];
        solved.par_extend(others.into_par_iter().map(|b| at(b, reached_m)));
        Self::of(reached_m, setup.hertz(), 1.5, &solved)
    }

    /// The curves with the force of finer elements at an exponent; `None` if those find no
    /// equilibrium.
    #[must_use]
    pub fn finer_at(mut self, setup: &Setup, b: f64) -> Option<Self> {
        let found = Self::solve_with(setup, self.deepest_m, &[b], FINER)?;
        let [fine, own] = [&found, &self].map(|of| of.at(b).polynomial);
        self.finer.iter_mut().zip(fine.iter().zip(own)).for_each(|(add, (fine, own))| *add += fine - own);
        Some(self)
    }

    /// Solves at some exponents with elements of another size, divided by the contact radius (1).
    #[must_use]
    pub fn solve_with(setup: &Setup, deepest_m: f64, exponents: &[f64], fineness: f64) -> Option<Self> {
        let depths_m = depths_m(deepest_m);
        let solve = |b: &f64| (*b, setup.cylinder(*b, fineness).forces_m2(&depths_m));
        let solved: Vec<(f64, Vec<f64>)> = exponents.to_vec().into_par_iter().map(|b| solve(&b)).collect();
        Self::of(deepest_m, setup.hertz(), 1.5, &solved)
    }

    /// Takes forces over E at [`depths_m`] for ascending exponents; the force at small depth is
    /// `scale` times depth to `power`. One exponent without all of its forces is left out, but not
    /// the first one; the second one without them ends the list.
    #[must_use]
    pub fn of(deepest_m: f64, scale: f64, power: f64, solved: &[(f64, Vec<f64>)]) -> Option<Self> {
        let depths_m = depths_m(deepest_m);
        let place = |depth_m: f64| (depth_m / deepest_m).sqrt();
        let rows = SMatrix::<f64, DEPTHS, TERMS>::from_fn(|n, k| place(depths_m[n]).powi(k as i32 + 1)).qr();
        let of = |forces: &[f64]| -> Option<[f64; TERMS]> {
            let right = SVector::<f64, DEPTHS>::from_fn(|n, _| (forces[n] / (scale * depths_m[n].powf(power))).ln());
            rows.r().solve_upper_triangular(&(rows.q().transpose() * right)).map(Into::into)
        };
        let is_whole = |forces: &[f64]| forces.len() == DEPTHS && forces.iter().all(|f| *f > 0.0);
        let mut missing = 0;
        let near = solved.iter().enumerate().take_while(|(n, (_, forces))| {
            missing += if is_whole(forces) { 0 } else { 1 + usize::from(*n == 0) };
            missing < 2
        });
        let whole = near.map(|(_, of)| of).filter(|(_, forces)| is_whole(forces));
        let curves: Vec<(f64, [f64; TERMS])> = whole.map(|(b, forces)| Some((*b, of(forces)?))).collect::<Option<_>>()?;
        let (exponents, polynomials): (Vec<f64>, Vec<[f64; TERMS]>) = curves.into_iter().unzip();
        (!polynomials.is_empty()).then_some(Self { deepest_m, scale, power, exponents, polynomials, finer: [0.0; TERMS] })
    }

    /// Deepest press that was solved [m].
    #[must_use]
    pub fn deepest_m(&self) -> f64 {
        self.deepest_m
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
        let mut polynomial = self.finer;
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
