//! The converged answer of the standard press.

use palpate::Vector3;

use crate::methods::BLOCK_M;
use palpate_tissue::answer::Answer;

/// Forces and shapes to compare with; everything scales with E.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference(Answer);

impl Reference {
    /// The shipped one.
    #[must_use]
    pub fn block() -> Self {
        let answer = Answer::block();
        debug_assert_eq!(answer.tissue.block_m, Some(BLOCK_M));
        Self(answer)
    }

    /// Force over E at a depth [m^2], where it is known.
    #[must_use]
    pub fn force_over_e_m2(&self, depth_m: f64) -> Option<f64> {
        self.0.hold([0.0; 3], depth_m).map(|h| h.force_over_e_m2)
    }

    /// Displacement of the point of the top that rested at (x, y), at a depth [m], where it is
    /// known.
    #[must_use]
    pub fn displacement_m(&self, depth_m: f64, at_m: [f64; 2]) -> Option<Vector3<f64>> {
        let surface = self.0.hold([0.0; 3], depth_m)?.surface.as_ref()?;
        surface.at_m(at_m).map(Vector3::from)
    }
}
