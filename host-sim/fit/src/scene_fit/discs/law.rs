//! Stiffness of a glued disc as a function of its radius and place: a polynomial fitted to some
//! solved discs.

use nalgebra::{SMatrix, SVector};

/// Number of terms of ln(K / a): 1, a, a^2, x^2, y^2. By symmetry, a block with the site in its
/// middle has no odd terms.
const TERMS: usize = 5;
/// Number of directions of a disc.
const DIRECTIONS: usize = 3;

/// Stiffness K over E along each direction, of a disc with the radius a at the place (x, y), all
/// divided by the radius of the probe. On a half-space K / a is constant; depth and sides of the
/// block change it smoothly, by a fifth.
pub struct Law([SVector<f64, TERMS>; DIRECTIONS]);

impl Law {
    /// Least-squares fit to discs (x, y, a) and their stiffness along each direction; `None` if a
    /// stiffness is not positive or the discs do not determine all terms.
    pub fn through(discs: &[[f64; 3]], stiffness: &[[f64; DIRECTIONS]]) -> Option<Self> {
        let mut normal = SMatrix::<f64, TERMS, TERMS>::zeros();
        let mut right = [SVector::<f64, TERMS>::zeros(); DIRECTIONS];
        for (disc, stiffness) in discs.iter().zip(stiffness) {
            let row = terms(disc);
            normal += row * row.transpose();
            for (right, stiffness) in right.iter_mut().zip(stiffness) {
                let value = (stiffness / disc[2]).ln();
                if !value.is_finite() {
                    return None;
                }
                *right += row * value;
            }
        }
        let factor = normal.cholesky()?;
        Some(Self(right.map(|right| factor.solve(&right))))
    }

    /// Stiffness along each direction, over E and the radius of the probe.
    pub fn stiffness(&self, disc: [f64; 3]) -> [f64; DIRECTIONS] {
        let row = terms(&disc);
        self.0.map(|law| disc[2] * law.dot(&row).exp())
    }
}

fn terms(&[x, y, a]: &[f64; 3]) -> SVector<f64, TERMS> {
    [1.0, a, a * a, x * x, y * y].into()
}

#[cfg(test)]
mod tests {
    use super::Law;

    const DISCS: [[f64; 3]; 6] =
        [[0.0, 0.0, 1.0], [0.0, 0.0, 0.6], [1.0, 0.0, 0.8], [0.0, -1.0, 0.9], [0.7, 0.7, 0.7], [-0.5, 0.9, 1.1]];

    fn stiffness([x, y, a]: [f64; 3]) -> [f64; 3] {
        [3.0, 2.0, 2.5].map(|k: f64| k * a * (0.2 * a + 0.01 * k * x * x - 0.02 * y * y).exp())
    }

    #[test]
    fn goes_through_what_has_its_form() {
        let law = Law::through(&DISCS, &DISCS.map(stiffness)).expect("five terms, six discs");
        for disc in [[0.3, -0.8, 0.75], [-1.0, 0.1, 1.05]] {
            let (found, wanted) = (law.stiffness(disc), stiffness(disc));
            assert!(found.iter().zip(wanted).all(|(f, w)| (f / w - 1.0).abs() < 1e-9), "{found:?}, wanted {wanted:?}");
        }
    }

    #[test]
    fn refuses_discs_that_leave_a_term_open_and_stiffness_below_zero() {
        let same_radius = DISCS.map(|[x, y, _]| [x, y, 1.0]);
        assert!(Law::through(&same_radius, &same_radius.map(stiffness)).is_none());
        let mut negative = DISCS.map(stiffness);
        negative[2][1] = -1.0;
        assert!(Law::through(&DISCS, &negative).is_none());
    }
}
