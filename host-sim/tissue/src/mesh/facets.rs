//! Fits the facets of a mesh to the curved surface that they replace.
//!
//! A mesh whose surface nodes lie on a shape has chords for facets: on a dome they lie below it, so
//! that the mesh lacks volume and is touched too late. Here the surface nodes move until the mean
//! square distance of the facets from the shape is smallest, so that they lie as much above it as
//! below. A facet moves a node only if the shape bends little between the two: one that cuts off a
//! sharp edge or a point of the shape moves none, and flat faces stay where they are. The node at
//! the site is held, since a press begins there.

use nalgebra::{Matrix3, Vector3};

use super::{TetMesh, six_volume, surface};

type V3 = Vector3<f64>;

/// Points of a triangle at which its distance is measured, all with the same weight: exact to
/// degree 2, the degree of a chord's distance from its arc.
const POINTS: [[f64; 3]; 3] =
    [[2.0 / 3.0, 1.0 / 6.0, 1.0 / 6.0], [1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0], [1.0 / 6.0, 1.0 / 6.0, 2.0 / 3.0]];
/// Smallest cosine of the angle between the shape's normals at a node and anywhere on a facet that
/// moves it (1). On a sphere, facets whose sides are half its radius reach it.
const SMOOTH_COSINE: f64 = 0.87;
/// Distance from the site up to which a node is that of the site [m].
const AT_SITE_M: f64 = 1e-9;
/// Number of rounds; on a sphere the first is exact up to the square of the chord's distance.
const ROUNDS: usize = 4;
/// Weight against motion along the surface, as a share of a node's weight (1).
const TANGENTIAL: f64 = 0.05;
/// Smallest share of its volume that a tet may keep (1).
const LEAST_VOLUME: f64 = 0.3;

/// Moves the surface nodes of a mesh that is pressed at `site_m`. `distance` gives the signed
/// distance of a point from the shape, negative inside [m], and the outward unit normal of the
/// shape there.
pub fn fit_facets(mesh: &mut TetMesh, site_m: [f64; 3], distance: impl Fn([f64; 3]) -> (f64, [f64; 3])) {
    let triangles = surface::surface(&mesh.tets);
    let moving = moving(mesh, &triangles, site_m, &distance);
    let before: Vec<f64> = mesh.tets.iter().map(|tet| six_volume(mesh, *tet)).collect();
    let mut around: Vec<Vec<u32>> = vec![Vec::new(); mesh.nodes_m.len()];
    (0_u32..).zip(&mesh.tets).for_each(|(t, tet)| tet.iter().for_each(|n| around[*n as usize].push(t)));
    for _ in 0..ROUNDS {
        for (n, step) in steps(mesh, &moving, &distance) {
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

/// The triangles, each with the nodes that it moves.
fn moving(
    mesh: &TetMesh,
    triangles: &[[u32; 3]],
    site_m: [f64; 3],
    distance: impl Fn([f64; 3]) -> (f64, [f64; 3]),
) -> Vec<([u32; 3], [bool; 3])> {
    let normal = |at_m: V3| V3::from(distance(at_m.into()).1);
    let moved = |triangle: &[u32; 3]| {
        let corners = triangle.map(|n| V3::from(mesh.nodes_m[n as usize]));
        let (at_corners, inside) = (corners.map(normal), points(mesh, triangle).map(|(_, at_m)| normal(at_m)));
        let moves = |n: usize| {
            let is_smooth = at_corners.iter().chain(&inside).all(|other| other.dot(&at_corners[n]) > SMOOTH_COSINE);
            is_smooth && (corners[n] - V3::from(site_m)).norm() > AT_SITE_M
        };
        (*triangle, [0, 1, 2].map(moves))
    };
    triangles.iter().map(moved).collect()
}

/// Points of a triangle, with the shares of its corners in them, and their places [m].
fn points(mesh: &TetMesh, triangle: &[u32; 3]) -> [([f64; 3], V3); 3] {
    let [a, b, c] = triangle.map(|n| V3::from(mesh.nodes_m[n as usize]));
    POINTS.map(|at| (at, a * at[0] + b * at[1] + c * at[2]))
}

/// Steps of the surface nodes toward the least mean square distance, in the order of the nodes.
/// The least-squares matrix is lumped to its nodes: then a constant distance is closed at once, and
/// no step is too long.
fn steps(
    mesh: &TetMesh,
    triangles: &[([u32; 3], [bool; 3])],
    distance: impl Fn([f64; 3]) -> (f64, [f64; 3]),
) -> Vec<(usize, V3)> {
    let mut sums: Vec<(Matrix3<f64>, V3, f64)> = vec![(Matrix3::zeros(), V3::zeros(), 0.0); mesh.nodes_m.len()];
    for (triangle, moves) in triangles {
        let corners = triangle.map(|n| V3::from(mesh.nodes_m[n as usize]));
        let area_m2 = (corners[1] - corners[0]).cross(&(corners[2] - corners[0])).norm();
        for (shares, at_m) in points(mesh, triangle) {
            let (distance_m, normal) = distance(at_m.into());
            let normal = V3::from(normal);
            for ((n, share), _) in triangle.iter().zip(shares).zip(moves).filter(|(_, moves)| **moves) {
                let weight = share * area_m2;
                let (matrix, slope, all) = &mut sums[*n as usize];
                *matrix += normal * (normal.transpose() * weight);
                *slope += normal * (weight * distance_m);
                *all += weight;
            }
        }
    }
    // a node that no triangle moves has no step
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
    fn a_ball_of_few_facets_keeps_its_volume_and_its_site() {
        let ball = |x: [f64; 3]| V3::from(x).norm() - 0.03;
        let mut mesh = meshed(&ball, 0.011);
        let share = |mesh: &TetMesh| mesh.volume_m3() / (4.0 / 3.0 * std::f64::consts::PI * 0.03_f64.powi(3));
        assert!(share(&mesh) < 0.97, "{}", share(&mesh));
        let n = surface::surface(&mesh.tets)[0][0] as usize;
        let site_m = mesh.nodes_m[n];
        fit_facets(&mut mesh, site_m, |x| (ball(x), V3::from(x).normalize().into()));
        assert!((share(&mesh) - 1.0).abs() < 0.004, "{}", share(&mesh));
        assert!(mesh.tets.iter().all(|tet| six_volume(&mesh, *tet) > 0.0));
        assert_eq!(mesh.nodes_m[n].map(f64::to_bits), site_m.map(f64::to_bits));
    }

    #[test]
    fn a_cube_stays_to_the_last_bit_although_its_edges_are_cut() {
        let half_m = 0.0297;
        let cube = |x: [f64; 3]| {
            let q = V3::from(x).abs() - V3::repeat(half_m);
            q.map(|c| c.max(0.0)).norm() + q.max().min(0.0)
        };
        let near = |x: [f64; 3]| {
            let q = V3::from(x).abs();
            let mut normal = V3::zeros();
            normal[q.imax()] = x[q.imax()].signum();
            // as a surface of triangles has it
            (if cube(x).abs() < 1e-9 { 0.0 } else { cube(x) }, normal.into())
        };
        let mut mesh = meshed(&cube, 0.007);
        let cut = 1.0 - mesh.volume_m3() / (2.0 * half_m).powi(3);
        assert!(cut > 0.01, "{cut}");
        let before = mesh.nodes_m.clone();
        fit_facets(&mut mesh, [0.0; 3], near);
        let bits = |nodes_m: &[[f64; 3]]| nodes_m.iter().map(|x| x.map(f64::to_bits)).collect::<Vec<_>>();
        assert!(bits(&mesh.nodes_m) == bits(&before));
    }
}
