//! Bends the surface of a mesh onto the shape that it was made from.
//!
//! With flat facets a press of half a millimetre into a dome starts below its surface. Here the
//! corners and the middles of the edges on the surface are moved onto the shape, so that its
//! distance from the mesh falls with the third power of the edge length instead of the second.

use std::collections::BTreeSet;

use nalgebra::Vector3;
use palpate_tissue::mesh::{TetMesh, surface};

use super::quadratic::QuadraticMesh;
use super::shape::{TET_EDGES, TetRule, tet_at};

type V3 = Vector3<f64>;

/// Smallest share of the volume that an element may keep at any point that is looked at (1). Where
/// a sharp edge of the shape would need more, the element stays straight.
const LEAST_VOLUME: f64 = 0.3;

/// A quadratic mesh whose surface nodes lie on the shape; `nearest_m` gives the point of the shape
/// that is nearest to a place [m].
pub fn curved(mesh: &TetMesh, nearest_m: impl Fn([f64; 3]) -> [f64; 3]) -> QuadraticMesh {
    let mut corners = QuadraticMesh::new(mesh);
    let own: BTreeSet<u32> = surface::surface(&mesh.tets).into_iter().flatten().collect();
    bend(&mut corners, &own, &nearest_m);
    let moved = TetMesh {
        nodes_m: corners.nodes_m[..mesh.nodes_m.len()].iter().map(|x| (*x).into()).collect(),
        tets: mesh.tets.clone(),
        regions: mesh.regions.clone(),
    };
    let mut bent = QuadraticMesh::new(&moved);
    let middles: BTreeSet<u32> = bent.triangles.iter().flat_map(|t| t[3..].iter().copied()).collect();
    bend(&mut bent, &middles, &nearest_m);
    bent
}

/// Moves nodes onto the shape, one by one, as long as all elements around them keep their volume.
/// A corner takes half of its motion to the middles of its edges, which stay straight.
fn bend(mesh: &mut QuadraticMesh, nodes: &BTreeSet<u32>, nearest_m: impl Fn([f64; 3]) -> [f64; 3]) {
    let mut around: Vec<Vec<usize>> = vec![Vec::new(); mesh.nodes_m.len()];
    mesh.tets.iter().enumerate().for_each(|(t, tet)| tet.iter().for_each(|n| around[*n as usize].push(t)));
    let straight: Vec<f64> = (0..mesh.tets.len()).map(|t| least_volume_m3(mesh, t)).collect();
    for n in nodes {
        let tets = &around[*n as usize];
        let before = mesh.nodes_m[*n as usize];
        let step = V3::from(nearest_m(before.into())) - before;
        let mut with: BTreeSet<u32> = BTreeSet::new();
        for t in tets {
            let tet = &mesh.tets[*t];
            let Some(corner) = tet[..4].iter().position(|m| m == n) else { continue };
            let edges = TET_EDGES.iter().enumerate().filter(|(_, edge)| edge.contains(&corner));
            with.extend(edges.map(|(e, _)| tet[4 + e]));
        }
        let shift = |mesh: &mut QuadraticMesh, step: V3| {
            mesh.nodes_m[*n as usize] += step;
            with.iter().for_each(|m| mesh.nodes_m[*m as usize] += step * 0.5);
        };
        shift(mesh, step);
        if tets.iter().any(|t| least_volume_m3(mesh, *t) < LEAST_VOLUME * straight[*t]) {
            shift(mesh, -step);
        }
    }
}

/// Smallest volume that an element would have if it were everywhere deformed as at one of its
/// corners or quadrature points [m^3].
fn least_volume_m3(mesh: &QuadraticMesh, tet: usize) -> f64 {
    let nodes = mesh.tets[tet].map(|n| mesh.nodes_m[n as usize]);
    let corner = |k: usize| std::array::from_fn(|l| f64::from(u8::from(k == l)));
    let inner = TetRule::Four.points().into_iter().map(|(at, _)| at);
    (0..4).map(corner).chain(inner).map(|at| tet_at(at, &nodes).1).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate_tissue::organ::even_mesh;

    #[test]
    fn a_bent_ball_has_its_volume_and_a_straight_one_lacks_some() {
        const RADIUS_M: f64 = 0.03;
        let ball = |x: [f64; 3]| V3::from(x).norm() - RADIUS_M;
        let mesh = even_mesh("ball", &ball, [[-0.032; 3], [0.032; 3]], 0.009).unwrap();
        let volume_m3 = |mesh: &QuadraticMesh| -> f64 {
            let of = |tet: &[u32; 10]| {
                let nodes = tet.map(|n| mesh.nodes_m[n as usize]);
                TetRule::Four.points().into_iter().map(|(at, share)| share * tet_at(at, &nodes).1).sum::<f64>()
            };
            mesh.tets.iter().map(of).sum()
        };
        let whole_m3 = 4.0 / 3.0 * std::f64::consts::PI * RADIUS_M.powi(3);
        let straight = volume_m3(&QuadraticMesh::new(&mesh)) / whole_m3 - 1.0;
        let bent = volume_m3(&curved(&mesh, |x| (V3::from(x).normalize() * RADIUS_M).into())) / whole_m3 - 1.0;
        assert!(straight < -0.01 && bent.abs() < 0.03 * straight.abs(), "{straight} {bent}");
    }
}
