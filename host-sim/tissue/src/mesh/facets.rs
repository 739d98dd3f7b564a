//! Fits the facets of a mesh to the curved surface that they replace.
//!
//! A mesh whose surface nodes lie on a shape has chords for facets: on a dome they lie below it, so
//! that the mesh lacks volume and is touched too late. Here the surface nodes move until the mean
//! square distance of the facets from the shape is smallest, so that they lie as much above it as
//! below. Flat facets stay where they are.

use nalgebra::{Matrix3, Vector3};

use super::{TetMesh, six_volume, surface};

type V3 = Vector3<f64>;

/// Points of a triangle at which its distance is measured, all with the same weight: exact to
/// degree 2, the degree of a chord's distance from its arc.
const POINTS: [[f64; 3]; 3] =
    [[2.0 / 3.0, 1.0 / 6.0, 1.0 / 6.0], [1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0], [1.0 / 6.0, 1.0 / 6.0, 2.0 / 3.0]];
/// Number of rounds; on a sphere the first is exact up to the square of the chord's distance.
const ROUNDS: usize = 4;
/// Weight against motion along the surface, as a share of a node's weight (1).
const TANGENTIAL: f64 = 0.05;
/// Smallest share of its volume that a tet may keep (1).
const LEAST_VOLUME: f64 = 0.3;

/// Moves the surface nodes of a mesh. `distance` gives the signed distance of a point from the
/// shape, negative inside [m], and the outward unit normal of the shape there.
pub fn fit_facets(mesh: &mut TetMesh, distance: impl Fn([f64; 3]) -> (f64, [f64; 3])) {
    let triangles = surface::surface(&mesh.tets);
    let before: Vec<f64> = mesh.tets.iter().map(|tet| six_volume(mesh, *tet)).collect();
    let mut around: Vec<Vec<u32>> = vec![Vec::new(); mesh.nodes_m.len()];
    (0_u32..).zip(&mesh.tets).for_each(|(t, tet)| tet.iter().for_each(|n| around[*n as usize].push(t)));
    for _ in 0..ROUNDS {
        for (n, step) in steps(mesh, &triangles, &distance) {
            let kept = mesh.nodes_m[n];
            mesh.nodes_m[n] = (V3::from(kept) + step).into();
            let shrinks = |t: &u32| {
                let t = *t as usize;
                six_volume(mesh, mesh.tets[t]) < LEAST_VOLUME * before[t]
            };
            if around[n].iter().any(shrinks) {
                mesh.nodes_m[n] = kept;
            }
        }
    }
}

/// Steps of the surface nodes toward the least mean square distance, in the order of the nodes.
/// The least-squares matrix is lumped to its nodes: then a constant distance is closed at once, and
/// no step is too long.
fn steps(mesh: &TetMesh, triangles: &[[u32; 3]], distance: impl Fn([f64; 3]) -> (f64, [f64; 3])) -> Vec<(usize, V3)> {
    let mut sums: Vec<(Matrix3<f64>, V3, f64)> = vec![(Matrix3::zeros(), V3::zeros(), 0.0); mesh.nodes_m.len()];
    for triangle in triangles {
        let corners = triangle.map(|n| V3::from(mesh.nodes_m[n as usize]));
        let area_m2 = (corners[1] - corners[0]).cross(&(corners[2] - corners[0])).norm();
        for at in POINTS {
            let (distance_m, normal) = distance((corners[0] * at[0] + corners[1] * at[1] + corners[2] * at[2]).into());
            let normal = V3::from(normal);
            for (n, share) in triangle.iter().zip(at) {
                let weight = share * area_m2;
                let (matrix, slope, all) = &mut sums[*n as usize];
                *matrix += normal * (normal.transpose() * weight);
                *slope += normal * (weight * distance_m);
                *all += weight;
            }
        }
    }
    let step = |(n, (matrix, slope, all)): (usize, (Matrix3<f64>, V3, f64))| {
        let damped = matrix + Matrix3::identity() * (TANGENTIAL * all);
        Some((n, -damped.cholesky().filter(|_| all > 0.0)?.solve(&slope)))
    };
    sums.into_iter().enumerate().filter_map(step).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::organ::even_mesh;

    fn meshed(shape: &dyn Fn([f64; 3]) -> f64, spacing_m: f64) -> TetMesh {
        even_mesh("shape", shape, [[-0.032; 3], [0.032; 3]], spacing_m).unwrap()
    }

    #[test]
    fn a_ball_of_few_facets_keeps_its_volume() {
        let ball = |x: [f64; 3]| V3::from(x).norm() - 0.03;
        let mut mesh = meshed(&ball, 0.011);
        let share = |mesh: &TetMesh| mesh.volume_m3() / (4.0 / 3.0 * std::f64::consts::PI * 0.03_f64.powi(3));
        assert!(share(&mesh) < 0.97, "{}", share(&mesh));
        fit_facets(&mut mesh, |x| (ball(x), V3::from(x).normalize().into()));
        assert!((share(&mesh) - 1.0).abs() < 0.004, "{}", share(&mesh));
        assert!(mesh.tets.iter().all(|tet| six_volume(&mesh, *tet) > 0.0));
    }

    #[test]
    fn a_cube_gains_at_its_cut_edges_while_its_faces_stay_flat() {
        let half_m = 0.0297;
        let cube = |x: [f64; 3]| {
            let q = V3::from(x).abs() - V3::repeat(half_m);
            q.map(|c| c.max(0.0)).norm() + q.max().min(0.0)
        };
        let normal = |x: [f64; 3]| {
            let q = V3::from(x).abs();
            let mut normal = V3::zeros();
            normal[q.imax()] = x[q.imax()].signum();
            normal.into()
        };
        let mut mesh = meshed(&cube, 0.007);
        let share = |mesh: &TetMesh| mesh.volume_m3() / (2.0 * half_m).powi(3);
        let cut = 1.0 - share(&mesh);
        fit_facets(&mut mesh, |x| (cube(x), normal(x)));
        let left = 1.0 - share(&mesh);
        assert!(cut > 0.01 && left.abs() < 0.5 * cut, "{cut} {left}");
        // away from the edges nothing has moved
        let inner = |x: &&[f64; 3]| x.iter().filter(|c| c.abs() < 0.5 * half_m).count() == 2 && cube(**x).abs() < 1e-3;
        let moved_m = mesh.nodes_m.iter().filter(inner).map(|x| cube(*x).abs()).fold(0.0, f64::max);
        assert!(moved_m < 2e-5, "{moved_m}");
    }
}
