//! Shape of one tet.

use super::vector::{Vec3, add_scaled, cross, dot, sub};

/// Three times inradius over circumradius: 1 for a regular tet, 0 for a flat one, negative for an
/// inverted one.
#[must_use]
pub fn radius_ratio([a, b, c, d]: [Vec3; 4]) -> f64 {
    let (u, v, w) = (sub(b, a), sub(c, a), sub(d, a));
    let (uv, vw, wu) = (cross(u, v), cross(v, w), cross(w, u));
    let six_volume = dot(uv, w);
    let opposite_a = add_scaled(add_scaled(uv, 1.0, vw), 1.0, wu);
    let twice_area = norm(uv) + norm(vw) + norm(wu) + norm(opposite_a);
    // The circumcentre seen from `a` is this vector over `2 six_volume`.
    let centre = add_scaled(add_scaled([0.0; 3], dot(u, u), vw), dot(v, v), wu);
    let centre = add_scaled(centre, dot(w, w), uv);
    let product = twice_area * norm(centre);
    if product > 0.0 {
        // r = six_volume / twice_area and R = |centre| / (2 six_volume).
        6.0 * six_volume * six_volume.abs() / product
    } else {
        0.0
    }
}

fn norm(a: Vec3) -> f64 {
    dot(a, a).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regular_is_one_and_mirrored_is_minus_one() {
        let [a, b, c, d] = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
        assert!((radius_ratio([a, b, d, c]).abs() - 1.0).abs() < 1e-14);
        assert!((radius_ratio([a, b, c, d]) + radius_ratio([a, b, d, c])).abs() < 1e-14);
    }

    #[test]
    fn unit_corner_has_the_textbook_value() {
        // r = 1 / (3 + sqrt 3), R = sqrt 3 / 2.
        let q = radius_ratio([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        let s = 3.0_f64.sqrt();
        assert!((q - 6.0 / (s * (3.0 + s))).abs() < 1e-14);
    }

    #[test]
    fn flat_and_collapsed_are_zero() {
        let flat = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
        assert_eq!(radius_ratio(flat), 0.0);
        assert_eq!(radius_ratio([[1.0; 3]; 4]), 0.0);
    }
}
