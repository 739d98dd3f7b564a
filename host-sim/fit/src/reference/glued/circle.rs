//! Cuts a mesh along the edge of a glued disc.
//!
//! If a surface edge crosses the circle close to one of its ends, that end is moved along the edge
//! onto the circle; any other such edge is cut at the crossing, in all tets around it. Afterwards
//! no surface edge has one end inside and one outside, and every tet that was valid remains valid.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use super::Disc;
use palpate_tissue::mesh::{TetMesh, surface};

/// Distance from the circle, as a share of the radius, up to which a node counts as on it.
pub(super) const ON_EDGE: f64 = 1e-9;
/// Distance of a crossing from an end, as a share of the edge, below which the end is moved.
const NEAR_END: f64 = 0.3;
/// Smallest share of its volume that a tet may have after a corner was moved.
const LEAST_VOLUME: f64 = 0.2;

/// Cuts the mesh so that no surface edge crosses the edge of the disc. Nodes keep their numbers and
/// new ones follow them; tets keep their regions.
pub(super) fn cut(mesh: &TetMesh, disc: &Disc) -> TetMesh {
    let mut mesh = mesh.clone();
    snap(&mut mesh, disc);
    // the halves of a cut edge end on the circle, so one pass finds every crossing once
    for ([i, j], share) in crossings(&mesh, disc) {
        let middle = mesh.nodes_m.len() as u32;
        mesh.nodes_m.push(between(&mesh, [i, j], share).into());
        for t in 0..mesh.tets.len() {
            if mesh.tets[t].contains(&i) && mesh.tets[t].contains(&j) {
                let with = |from: u32| mesh.tets[t].map(|n| if n == from { middle } else { n });
                let halves = [with(i), with(j)];
                mesh.tets[t] = halves[0];
                mesh.tets.push(halves[1]);
                mesh.regions.push(mesh.regions[t]);
            }
        }
    }
    mesh
}

/// Moves nodes near the circle onto it, each along the edge on which its displacement is shortest,
/// unless a tet around it would lose too much volume.
fn snap(mesh: &mut TetMesh, disc: &Disc) {
    let mut moves: BTreeMap<u32, (f64, Vector3<f64>)> = BTreeMap::new();
    for ([i, j], share) in crossings(mesh, disc) {
        let (node, near) = if share < 0.5 { (i, share) } else { (j, 1.0 - share) };
        if near < NEAR_END {
            let at = between(mesh, [i, j], share);
            let displacement_m = (at - between(mesh, [node; 2], 0.0)).norm();
            let best = moves.entry(node).or_insert((displacement_m, at));
            if displacement_m < best.0 {
                *best = (displacement_m, at);
            }
        }
    }
    let mut around: BTreeMap<u32, Vec<usize>> = moves.keys().map(|n| (*n, Vec::new())).collect();
    for (t, tet) in mesh.tets.iter().enumerate() {
        for n in tet {
            if let Some(tets) = around.get_mut(n) {
                tets.push(t);
            }
        }
    }
    for (node, (_, at)) in moves {
        let tets = &around[&node];
        let volumes = |mesh: &TetMesh| tets.iter().map(|t| six_volume(mesh, *t)).collect::<Vec<_>>();
        let (kept, before) = (mesh.nodes_m[node as usize], volumes(mesh));
        mesh.nodes_m[node as usize] = at.into();
        if volumes(mesh).iter().zip(before).any(|(now, before)| *now < LEAST_VOLUME * before) {
            mesh.nodes_m[node as usize] = kept;
        }
    }
}

/// Surface edges with one end inside and one outside, each with the position of the circle along it
/// (0 to 1).
fn crossings(mesh: &TetMesh, disc: &Disc) -> Vec<([u32; 2], f64)> {
    let sides = surface::surface(&mesh.tets).into_iter().flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]]);
    let mut edges: Vec<[u32; 2]> = sides.map(|[a, b]| [a.min(b), a.max(b)]).collect();
    edges.sort_unstable();
    edges.dedup();
    edges.into_iter().filter_map(|edge| crossing(mesh, disc, edge).map(|share| (edge, share))).collect()
}

fn crossing(mesh: &TetMesh, disc: &Disc, [i, j]: [u32; 2]) -> Option<f64> {
    let [a, b] = [i, j].map(|n| Vector3::from(mesh.nodes_m[n as usize]));
    let (from, to) = (disc.outside_m(&a), disc.outside_m(&b));
    let least = ON_EDGE * disc.radius_m;
    if from * to >= 0.0 || from.abs() <= least || to.abs() <= least {
        return None;
    }
    // |a + s (b - a) - centre| = radius has two roots; the one between the ends is used
    let (arm, way) = (a - disc.place_m, b - a);
    let (square, half) = (way.norm_squared(), arm.dot(&way));
    let root = (half * half - square * (arm.norm_squared() - disc.radius_m * disc.radius_m)).max(0.0).sqrt();
    Some((if from < 0.0 { root - half } else { -root - half }) / square)
}

fn between(mesh: &TetMesh, [i, j]: [u32; 2], share: f64) -> Vector3<f64> {
    let [a, b] = [i, j].map(|n| Vector3::from(mesh.nodes_m[n as usize]));
    a + (b - a) * share
}

fn six_volume(mesh: &TetMesh, tet: usize) -> f64 {
    let [a, b, c, d] = mesh.tets[tet].map(|n| Vector3::from(mesh.nodes_m[n as usize]));
    (b - a).cross(&(c - a)).dot(&(d - a))
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate_tissue::mesh::{BlockSpec, block};

    #[test]
    fn a_cut_block_is_whole_and_its_glued_triangles_fill_the_circle() {
        let coarse =
            block(&BlockSpec { size_m: [0.04, 0.04, 0.02], nodes: 300, fine_at_m: [0.0; 2], fine_radius_m: 0.01 }).unwrap();
        let disc = Disc { place_m: Vector3::new(0.003, 0.001, 0.0), axis: Vector3::z(), radius_m: 0.008 };
        let mesh = cut(&coarse, &disc);
        assert!(mesh.nodes_m.len() > coarse.nodes_m.len() && mesh.regions.len() == mesh.tets.len());
        let volumes: Vec<f64> = (0..mesh.tets.len()).map(|t| six_volume(&mesh, t)).collect();
        assert!(volumes.iter().all(|v| *v > 0.0));
        assert!((volumes.iter().sum::<f64>() / (6.0 * 0.04 * 0.04 * 0.02) - 1.0).abs() < 1e-12);
        assert!(crossings(&mesh, &disc).is_empty());
        let (mut glued_m2, mut whole_m2, mut corners_on_edge) = (0.0, 0.0, 0);
        for t in surface::surface(&mesh.tets) {
            let corners = t.map(|n| Vector3::from(mesh.nodes_m[n as usize]));
            let area_m2 = 0.5 * (corners[1] - corners[0]).cross(&(corners[2] - corners[0])).norm();
            whole_m2 += area_m2;
            if disc.covers(&corners) {
                glued_m2 += area_m2;
                corners_on_edge += corners.iter().filter(|x| disc.outside_m(x).abs() < ON_EDGE * disc.radius_m).count();
            }
        }
        assert!((whole_m2 / (2.0 * 0.04 * 0.04 + 4.0 * 0.04 * 0.02) - 1.0).abs() < 1e-9);
        // an inscribed polygon is smaller than the circle by at most a share of (2 pi / sides)^2 /
        // 6
        let circle_m2 = std::f64::consts::PI * disc.radius_m * disc.radius_m;
        assert!(corners_on_edge > 12 && (0.94..1.0).contains(&(glued_m2 / circle_m2)), "{}", glued_m2 / circle_m2);
    }
}
