//! The converged answer of the standard press.

use palpate::Vector3;

use crate::reference_values::STANDARD_PRESS;

/// Force over E at 1 mm [m^2]: quadratic elements, 7080 corner nodes on a quarter.
const AT_1_MM: (f64, f64) = (0.001, 4.9341e-6);

/// Forces and shapes to compare with; everything scales with E.
#[derive(Clone, Copy, Debug, Default)]
pub struct Reference;

impl Reference {
    /// The shipped one.
    #[must_use]
    pub fn block() -> Self {
        Self
    }

    /// Force over E at a depth [m^2], where it is known.
    #[must_use]
    pub fn force_over_e_m2(&self, depth_m: f64) -> Option<f64> {
        std::iter::once(&AT_1_MM)
            .chain(&STANDARD_PRESS)
            .find(|(depth, _)| (depth - depth_m).abs() < 1e-7)
            .map(|(_, force)| *force)
    }

    /// Displacement of the point of the top that rested at (x, y), at a depth [m], where it is known.
    #[must_use]
    pub fn displacement_m(&self, _depth_m: f64, _at_m: [f64; 2]) -> Option<Vector3<f64>> {
        None
    }
}
