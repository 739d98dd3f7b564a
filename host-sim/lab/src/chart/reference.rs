//! The converged finite-element answer of the standard press.

use palpate::Vector3;

use crate::methods::BLOCK_M;
use palpate_tissue::answer::Answer;

/// Reference forces and surface shapes; the forces are proportional to E, the shapes do not depend
/// on it.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference(Answer);

impl Reference {
    /// The shipped reference of the standard block.
    pub fn block() -> Self {
        let answer = Answer::block();
        debug_assert_eq!(answer.tissue.block_m, Some(BLOCK_M));
        Self(answer)
    }

    /// Force over E at a depth [m^2]; `None` if the reference has no hold there.
    pub fn force_over_e_m2(&self, depth_m: f64) -> Option<f64> {
        self.0.hold([0.0; 3], depth_m).map(|h| h.force_over_e_m2)
    }

    /// Displacement [m] of the point of the top surface that was at (x, y) at rest, when the tip is
    /// at `depth_m`; `None` where the reference does not have it.
    pub fn displacement_m(&self, depth_m: f64, at_m: [f64; 2]) -> Option<Vector3<f64>> {
        let surface = self.0.hold([0.0; 3], depth_m)?.surface.as_ref()?;
        surface.at_m(at_m).map(Vector3::from)
    }
}
