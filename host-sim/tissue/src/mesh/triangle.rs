//! Nearest point of a triangle, and the point at which a ray enters it.

use nalgebra::Vector3;

/// Sides of a triangle, each as a pair of its corners.
const SIDES: [[usize; 2]; 3] = [[0, 1], [1, 2], [2, 0]];

/// Area coordinates of the point of a triangle that is nearest to `point`: the foot of the
/// perpendicular if that lies within the triangle, else a point on a side. For a point on a side or
/// at a corner, the coordinates that vanish there are exactly 0.
#[must_use]
pub fn nearest_on_triangle(corners: &[Vector3<f64>; 3], point: &Vector3<f64>) -> [f64; 3] {
    let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
    let opposite = |k: usize| {
        let [i, j] = SIDES[(k + 1) % 3];
        normal.dot(&(corners[j] - corners[i]).cross(&(point - corners[i]))) / normal.norm_squared()
    };
    let foot = [0, 1, 2].map(opposite);
    if foot.iter().all(|part| *part >= 0.0) {
        return foot;
    }
    let sides = SIDES.map(|[i, j]| {
        let along = corners[j] - corners[i];
        let share = ((point - corners[i]).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
        let mut at = [0.0; 3];
        (at[i], at[j]) = (1.0 - share, share);
        ((corners[i] + along * share - point).norm_squared(), at)
    });
    sides.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).map_or(foot, |side| side.1)
}

/// Tolerance outside an edge within which a ray still hits, as a share of the triangle (1): a ray
/// through an edge must not, by rounding, miss both triangles of that edge.
const EDGE: f64 = 1e-9;

/// Distance along a ray at which it enters a triangle from outside [m] (Moeller and Trumbore 1997);
/// `None` if it misses.
#[must_use]
pub fn entry_m([a, b, c]: [Vector3<f64>; 3], from: &Vector3<f64>, direction: &Vector3<f64>) -> Option<f64> {
    let (u, v, w) = (b - a, c - a, from - a);
    let across = direction.cross(&v);
    let determinant = u.dot(&across);
    let (s, t) = (w.dot(&across) / determinant, direction.dot(&w.cross(&u)) / determinant);
    let way = v.dot(&w.cross(&u)) / determinant;
    (determinant > 0.0 && s >= -EDGE && t >= -EDGE && s + t <= 1.0 + EDGE && way >= 0.0).then_some(way)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ray_through_an_edge_hits_one_of_its_triangles() {
        let mut missed = 0;
        for seed in 1..2000 {
            let wave = |k: f64| (f64::from(seed) * k).sin();
            let [a, b] = [wave(1.1), wave(2.3)].map(|y| Vector3::new(wave(0.3), y, 0.2 * wave(3.7)));
            let (left, right) = (Vector3::new(-2.0, 0.1, 0.0), Vector3::new(2.0, -0.2, 0.0));
            let share = 0.5 + 0.49 * wave(5.1);
            let direction = Vector3::new(0.3, -0.2, -1.0).normalize();
            let from = a + (b - a) * share - direction;
            let hit = |corners| entry_m(corners, &from, &direction);
            let sides = [[left, a, b], [left, b, a], [b, right, a], [a, right, b]];
            let ways: Vec<f64> = sides.into_iter().filter_map(hit).collect();
            missed += usize::from(ways.is_empty());
            assert!(ways.iter().all(|way| (way - 1.0).abs() < 1e-6), "{ways:?}");
        }
        assert_eq!(missed, 0);
    }

    #[test]
    fn no_point_of_a_fine_grid_on_the_triangle_is_nearer() {
        let corners = [[0.0, 0.0, 0.1], [1.0, 0.2, 0.0], [0.3, 0.9, -0.2]].map(Vector3::from);
        let place = |at: &[f64; 3]| (0..3).map(|k| corners[k] * at[k]).sum::<Vector3<f64>>();
        const STEPS: i32 = 60;
        for seed in 0..40 {
            let wave = |k: f64| 1.6 * (f64::from(seed) * k).sin();
            let point = Vector3::new(wave(1.3), wave(2.1), wave(0.7));
            let at = nearest_on_triangle(&corners, &point);
            assert!(at.iter().all(|part| *part >= 0.0) && (at.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{at:?}");
            let found = (place(&at) - point).norm();
            let grid = (0..=STEPS)
                .flat_map(|i| (0..=STEPS - i).map(move |j| [i, j, STEPS - i - j].map(|n| f64::from(n) / f64::from(STEPS))));
            let least = grid.map(|at| (place(&at) - point).norm()).fold(f64::INFINITY, f64::min);
            assert!(found <= least + 1e-12 && found > least - 0.02, "{found} but {least} on the grid");
        }
    }
}
