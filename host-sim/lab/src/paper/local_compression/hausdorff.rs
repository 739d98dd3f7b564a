//! Hausdorff distance between two sets of points: paper 004, eqs (4)-(6). The formulas are missing
//! from the text and are taken to be the usual ones.

use palpate::Vector3;

/// `h(A, B) = max over a of min over b of |a - b|` (5), (6); 0 for an empty A, infinite for an
/// empty B.
pub fn directed(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    let mut furthest = 0.0_f64;
    for from in a {
        let mut nearest = f64::INFINITY;
        for to in b {
            nearest = nearest.min((from - to).norm_squared());
            // closer than the present maximum, so this point cannot be the furthest
            if nearest <= furthest {
                break;
            }
        }
        furthest = furthest.max(nearest);
    }
    furthest.sqrt()
}

/// `H(A, B) = max(h(A, B), h(B, A))` (4), in the unit of the points.
pub fn hausdorff(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    directed(a, b).max(directed(b, a))
}
