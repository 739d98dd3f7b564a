//! The point of a surface that is nearest to a given one, at rest, where all triangles are flat.

use nalgebra::Vector3;

use super::quadratic::QuadraticMesh;
use super::shape::TRIANGLE_EDGES;

/// A point of a surface triangle.
#[derive(Clone, Copy, Debug)]
pub struct Nearest {
    /// Index into the mesh's triangles.
    pub triangle: usize,
    /// Area coordinates.
    pub at: [f64; 3],
    /// Distance to it [m].
    pub distance_m: f64,
}

/// Nearest of some triangles' points within `reach_m`; `None` if there is none.
#[must_use]
pub fn nearest(
    mesh: &QuadraticMesh,
    triangles: impl IntoIterator<Item = usize>,
    point_m: &Vector3<f64>,
    reach_m: f64,
) -> Option<Nearest> {
    let mut best: Option<Nearest> = None;
    for triangle in triangles {
        let nodes = &mesh.triangles[triangle];
        let corners = [0, 1, 2].map(|k| mesh.nodes_m[nodes[k] as usize]);
        let within_m = best.map_or(reach_m, |b| b.distance_m);
        let outside = |k: usize| {
            let [a, b, c] = corners.map(|x| x[k]);
            point_m[k] < a.min(b).min(c) - within_m || point_m[k] > a.max(b).max(c) + within_m
        };
        if (0..3).any(outside) {
            continue;
        }
        let at = on_triangle(&corners, point_m);
        let distance_m = (corners[0] * at[0] + corners[1] * at[1] + corners[2] * at[2] - point_m).norm();
        if distance_m < within_m || (best.is_none() && distance_m <= reach_m) {
            best = Some(Nearest { triangle, at, distance_m });
        }
    }
    best
}

/// Area coordinates of a triangle's point that is nearest to `point`: the foot of the perpendicular if it lies within, else on a side.
fn on_triangle(corners: &[Vector3<f64>; 3], point: &Vector3<f64>) -> [f64; 3] {
    let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
    let opposite = |k: usize| {
        let [i, j] = TRIANGLE_EDGES[(k + 1) % 3];
        normal.dot(&(corners[j] - corners[i]).cross(&(point - corners[i]))) / normal.norm_squared()
    };
    let foot = [0, 1, 2].map(opposite);
    if foot.iter().all(|part| *part >= 0.0) {
        return foot;
    }
    let sides = TRIANGLE_EDGES.map(|[i, j]| {
        let along = corners[j] - corners[i];
        let share = ((point - corners[i]).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
        let mut at = [0.0; 3];
        (at[i], at[j]) = (1.0 - share, share);
        ((corners[i] + along * share - point).norm_squared(), at)
    });
    sides.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).map_or(foot, |side| side.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_point_of_a_fine_grid_on_the_triangle_is_nearer() {
        let corners = [[0.0, 0.0, 0.1], [1.0, 0.2, 0.0], [0.3, 0.9, -0.2]].map(Vector3::from);
        let place = |at: &[f64; 3]| (0..3).map(|k| corners[k] * at[k]).sum::<Vector3<f64>>();
        const STEPS: i32 = 60;
        for seed in 0..40 {
            let wave = |k: f64| 1.6 * (f64::from(seed) * k).sin();
            let point = Vector3::new(wave(1.3), wave(2.1), wave(0.7));
            let at = on_triangle(&corners, &point);
            assert!(at.iter().all(|part| *part >= 0.0) && (at.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{at:?}");
            let found = (place(&at) - point).norm();
            let grid = (0..=STEPS)
                .flat_map(|i| (0..=STEPS - i).map(move |j| [i, j, STEPS - i - j].map(|n| f64::from(n) / f64::from(STEPS))));
            let least = grid.map(|at| (place(&at) - point).norm()).fold(f64::INFINITY, f64::min);
            assert!(found <= least + 1e-12 && found > least - 0.02, "{found} but {least} on the grid");
        }
    }
}
