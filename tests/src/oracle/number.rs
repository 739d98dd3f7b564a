//! Numbers that carry their derivative, so that a force is the derivative of an energy and needs no
//! formula of its own.

use std::ops::{Add, Div, Mul, Sub};

/// Scalar type with which an energy is computed.
pub trait Number: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> {
    /// A constant, with zero derivative.
    fn of(value: f64) -> Self;
    /// Value without the derivative.
    fn value(self) -> f64;
    /// Square root.
    fn root(self) -> Self;
    /// Natural logarithm.
    fn log(self) -> Self;
}

impl Number for f64 {
    fn of(value: f64) -> Self {
        value
    }
    fn value(self) -> f64 {
        self
    }
    fn root(self) -> Self {
        self.sqrt()
    }
    fn log(self) -> Self {
        self.ln()
    }
}

/// A number with its derivatives with respect to the three coordinates of one point (forward-mode
/// differentiation).
#[derive(Clone, Copy, Debug)]
pub struct Dual {
    /// Value of the number.
    pub value: f64,
    /// Derivatives with respect to x, y and z.
    pub slope: [f64; 3],
}

impl Dual {
    /// Coordinates of the point itself, with unit derivatives.
    pub fn coordinates(x: [f64; 3]) -> [Self; 3] {
        std::array::from_fn(|k| Self { value: x[k], slope: std::array::from_fn(|m| f64::from(u8::from(k == m))) })
    }

    fn chain(value: f64, a: Self, by_a: f64, b: Self, by_b: f64) -> Self {
        Self { value, slope: std::array::from_fn(|k| by_a * a.slope[k] + by_b * b.slope[k]) }
    }
}

impl Number for Dual {
    fn of(value: f64) -> Self {
        Self { value, slope: [0.0; 3] }
    }
    fn value(self) -> f64 {
        self.value
    }
    fn root(self) -> Self {
        let root = self.value.sqrt();
        Self::chain(root, self, 0.5 / root, self, 0.0)
    }
    fn log(self) -> Self {
        Self::chain(self.value.ln(), self, 1.0 / self.value, self, 0.0)
    }
}

impl Add for Dual {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self::chain(self.value + other.value, self, 1.0, other, 1.0)
    }
}

impl Sub for Dual {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self::chain(self.value - other.value, self, 1.0, other, -1.0)
    }
}

impl Mul for Dual {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self::chain(self.value * other.value, self, other.value, other, self.value)
    }
}

impl Div for Dual {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let ratio = self.value / other.value;
        Self::chain(ratio, self, 1.0 / other.value, other, -ratio / other.value)
    }
}
