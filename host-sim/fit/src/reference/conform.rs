//! Makes facets of a mesh lie on the surfaces of balls, so that every tet is either inside or
//! outside a ball.
//!
//! As in isosurface stuffing (Labelle and Shewchuk 2007), nodes near the surface are moved onto it,
//! and edges that still cross it are cut there. If a tet has another stiffness in only a part of
//! it, the ball is too stiff by an error of first order in the edge length; with facets on the
//! surface the error is of second order.

use std::collections::{BTreeSet, HashMap};
use std::f64::consts::PI;

use nalgebra::Vector3;
use palpate_tissue::mesh::TetMesh;
use palpate_tissue::mesh::surface::surface;
use palpate_tissue::scene::Inclusion;

type V3 = Vector3<f64>;

/// Distance between a crossing and an end of its edge, as a share of the edge, below which the end
/// is moved onto the surface.
const NEAR: f64 = 0.35;
/// Smallest share of its volume that a tet may have after a node was moved.
const LEAST_VOLUME: f64 = 0.2;
/// Distance from the surface, as a share of the radius, up to which a node counts as on it.
const ON: f64 = 1e-9;
/// Maximum number of passes over the edges; a tet is cut at most three times.
const PASSES: usize = 20;

/// Returns the mesh with facets on the surfaces of the balls, and the stiffness of each tet as a
/// multiple of the tissue's; where balls overlap, the last one applies. The facets are chords of a
/// slightly larger ball, chosen so that their polyhedron has the volume of the ball. The surface of
/// the mesh itself is not changed: where a ball protrudes through it, tets remain uncut.
#[must_use]
pub fn conform(mesh: &TetMesh, balls: &[Inclusion]) -> (TetMesh, Vec<f64>) {
    let mut mesh = mesh.clone();
    let own: BTreeSet<u32> = surface(&mesh.tets).into_iter().flatten().collect();
    let mut levels = Vec::new();
    for ball in balls {
        let mut level = Level { centre: ball.center_m.into(), radius_m: ball.radius_m };
        move_nodes(&mut mesh, &level, &own);
        cut_edges(&mut mesh, &level, &own);
        level.grow(&mut mesh, &own);
        levels.push((level, ball.stiffness_ratio));
    }
    let ratio = |tet: &[u32; 4]| levels.iter().rev().find(|(level, _)| level.holds(&mesh, tet)).map_or(1.0, |(_, ratio)| *ratio);
    let ratios = mesh.tets.iter().map(ratio).collect();
    (mesh, ratios)
}

struct Level {
    centre: V3,
    radius_m: f64,
}

impl Level {
    /// Distance of a point from the surface of the ball [m]; positive outside.
    fn of(&self, at: [f64; 3]) -> f64 {
        (V3::from(at) - self.centre).norm() - self.radius_m
    }

    /// Whether a tet whose corners are all on one side or on the surface is in the ball. A tet with
    /// all corners on the surface counts as inside.
    fn holds(&self, mesh: &TetMesh, tet: &[u32; 4]) -> bool {
        tet.iter().map(|n| self.of(mesh.nodes_m[*n as usize])).sum::<f64>() < ON * self.radius_m
    }

    /// Moves the facets outward until they enclose the volume of the ball.
    fn grow(&mut self, mesh: &mut TetMesh, own: &BTreeSet<u32>) {
        // a ball that the surface of the mesh cuts off has less than its full volume
        if own.iter().any(|n| self.of(mesh.nodes_m[*n as usize]) < 0.0) {
            return;
        }
        let within: f64 = mesh.tets.iter().filter(|t| self.holds(mesh, t)).map(|t| volume(mesh, t)).sum();
        if within <= 0.0 {
            return;
        }
        let growth = (4.0 / 3.0 * PI * self.radius_m.powi(3) / within).cbrt();
        for node in &mut mesh.nodes_m {
            if self.of(*node).abs() < ON * self.radius_m {
                *node = (self.centre + (V3::from(*node) - self.centre) * growth).into();
            }
        }
        self.radius_m *= growth;
    }

    /// Whether the surface is between two points at these distances from it.
    fn parts(&self, a: f64, b: f64) -> bool {
        let on = ON * self.radius_m;
        a.min(b) < -on && a.max(b) > on
    }

    /// Position of the crossing along an edge, as a share from its first end (1).
    fn crossing(&self, from: V3, to: V3) -> f64 {
        let (way, off) = (to - from, from - self.centre);
        let (a, b, c) = (way.norm_squared(), way.dot(&off), off.norm_squared() - self.radius_m * self.radius_m);
        let root = (b * b - a * c).max(0.0).sqrt();
        // from inside the later crossing applies, from outside the earlier one
        if c < 0.0 { (-b + root) / a } else { (-b - root) / a }
    }
}

fn edges(mesh: &TetMesh) -> BTreeSet<[u32; 2]> {
    const PAIRS: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];
    let of = |t: &[u32; 4]| PAIRS.map(|[i, j]| [t[i].min(t[j]), t[i].max(t[j])]);
    mesh.tets.iter().flat_map(of).collect()
}

fn volume(mesh: &TetMesh, tet: &[u32; 4]) -> f64 {
    let [a, b, c, d] = tet.map(|n| V3::from(mesh.nodes_m[n as usize]));
    (b - a).cross(&(c - a)).dot(&(d - a)) / 6.0
}

/// Moves nodes near the surface of the ball onto it, if all tets around them remain valid.
fn move_nodes(mesh: &mut TetMesh, level: &Level, own: &BTreeSet<u32>) {
    let mut near = BTreeSet::new();
    for [i, j] in edges(mesh) {
        let [a, b] = [i, j].map(|n| mesh.nodes_m[n as usize]);
        if level.parts(level.of(a), level.of(b)) {
            let share = level.crossing(a.into(), b.into());
            near.extend((share < NEAR).then_some(i));
            near.extend((share > 1.0 - NEAR).then_some(j));
        }
    }
    let mut around: HashMap<u32, Vec<[u32; 4]>> = HashMap::new();
    mesh.tets.iter().for_each(|t| t.iter().for_each(|n| around.entry(*n).or_default().push(*t)));
    for node in near.into_iter().filter(|n| !own.contains(n)) {
        let tets = around.get(&node).map_or(&[][..], Vec::as_slice);
        let before: Vec<f64> = tets.iter().map(|t| volume(mesh, t)).collect();
        let kept = mesh.nodes_m[node as usize];
        let out = V3::from(kept) - level.centre;
        mesh.nodes_m[node as usize] = (level.centre + out * (level.radius_m / out.norm())).into();
        if tets.iter().zip(before).any(|(t, v)| volume(mesh, t) < LEAST_VOLUME * v) {
            mesh.nodes_m[node as usize] = kept;
        }
    }
}

/// Cuts the edges that cross the surface of the ball, in all tets around them.
fn cut_edges(mesh: &mut TetMesh, level: &Level, own: &BTreeSet<u32>) {
    for _ in 0..PASSES {
        let passes = |[i, j]: &[u32; 2]| {
            let of = |n: &u32| level.of(mesh.nodes_m[*n as usize]);
            level.parts(of(i), of(j)) && !(own.contains(i) && own.contains(j))
        };
        let through: Vec<[u32; 2]> = edges(mesh).into_iter().filter(passes).collect();
        if through.is_empty() {
            return;
        }
        let has = |t: &[u32; 4], [i, j]: [u32; 2]| t.contains(&i) && t.contains(&j);
        let mut at_node: HashMap<u32, Vec<usize>> = HashMap::new();
        let before = mesh.tets.clone();
        before.iter().enumerate().for_each(|(k, t)| t.iter().for_each(|n| at_node.entry(*n).or_default().push(k)));
        // at most one edge per tet and pass
        let mut taken = vec![false; mesh.tets.len()];
        for edge in through {
            let around: Vec<usize> = at_node[&edge[0]].iter().copied().filter(|t| has(&before[*t], edge)).collect();
            if around.iter().any(|t| taken[*t]) {
                continue;
            }
            let [i, j] = edge;
            let [a, b] = edge.map(|n| V3::from(mesh.nodes_m[n as usize]));
            let node = mesh.nodes_m.len() as u32;
            mesh.nodes_m.push((a + (b - a) * level.crossing(a, b)).into());
            for t in around {
                taken[t] = true;
                let with = |from: u32| mesh.tets[t].map(|n| if n == from { node } else { n });
                let halves = [with(i), with(j)];
                mesh.tets[t] = halves[0];
                mesh.tets.push(halves[1]);
                mesh.regions.push(mesh.regions[t]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::refine::refine;
    use palpate_tissue::mesh::{BlockSpec, block};

    fn fine_block(fine_m: f64, around: [f64; 3]) -> TetMesh {
        let coarse = block(&BlockSpec { size_m: [0.04; 3], nodes: 60, fine_at_m: [0.0; 2], fine_radius_m: 0.01 }).unwrap();
        let away = move |x: [f64; 3]| (V3::from(x) - V3::from(around)).norm();
        refine(&coarse, |x| fine_m + 0.9 * (away(x) - 0.004).max(0.0), 6000)
    }

    /// Volume of all tets with the ratio `of`, divided by 4/3 pi r^3.
    fn share(mesh: &TetMesh, ratios: &[f64], of: f64, radius_m: f64) -> f64 {
        let own = mesh.tets.iter().zip(ratios).filter(|(_, ratio)| **ratio == of);
        own.map(|(t, _)| volume(mesh, t)).sum::<f64>() / (4.0 / 3.0 * PI * radius_m.powi(3))
    }

    #[test]
    fn the_ball_has_its_volume_and_the_block_its_own_in_closed_upright_tets() {
        for (centre, edge_m) in [([0.0, 0.0, -0.01], 0.0032), ([0.0031, -0.0017, -0.0123], 0.0044)] {
            let ball = Inclusion { center_m: centre, radius_m: 0.004, stiffness_ratio: 10.0, stiffening_b: None };
            let before = fine_block(edge_m, centre);
            let (mesh, ratios) = conform(&before, &[ball]);
            assert!(mesh.tets.iter().all(|t| volume(&mesh, t) > 0.0));
            let all: f64 = mesh.tets.iter().map(|t| volume(&mesh, t)).sum();
            assert!((all / 0.04_f64.powi(3) - 1.0).abs() < 1e-12, "{all}");
            let own = share(&mesh, &ratios, 10.0, 0.004);
            assert!((own - 1.0).abs() < 1e-9, "{own}");
            // the mesh is closed: it has as many outer facets as before
            assert_eq!(surface(&mesh.tets).len(), surface(&before.tets).len());
            // the facets are on one sphere, slightly larger than the ball
            let facets = mesh.tets.iter().zip(&ratios).filter(|(_, ratio)| **ratio == 10.0).map(|(t, _)| *t).collect::<Vec<_>>();
            let radii =
                surface(&facets).into_iter().flatten().map(|n| (V3::from(mesh.nodes_m[n as usize]) - V3::from(centre)).norm());
            let (low, high) = radii.fold((f64::MAX, 0.0_f64), |(l, h), r| (l.min(r), h.max(r)));
            assert!(low > 0.004 && high < 0.0045 && high - low < 1e-8, "{low} {high}");
        }
    }

    #[test]
    fn of_overlapping_balls_the_last_counts_and_one_through_the_surface_leaves_the_block_whole() {
        let ball = |z: f64, ratio: f64| Inclusion {
            center_m: [0.0, 0.0, z],
            radius_m: 0.004,
            stiffness_ratio: ratio,
            stiffening_b: None,
        };
        let before = fine_block(0.0032, [0.0, 0.0, -0.01]);
        let (mesh, ratios) = conform(&before, &[ball(-0.010, 10.0), ball(-0.013, 3.0), ball(0.001, 5.0)]);
        let all: f64 = mesh.tets.iter().map(|t| volume(&mesh, t)).sum();
        assert!((all / 0.04_f64.powi(3) - 1.0).abs() < 1e-12 && mesh.tets.iter().all(|t| volume(&mesh, t) > 0.0));
        let second = share(&mesh, &ratios, 3.0, 0.004);
        assert!((second - 1.0).abs() < 0.02, "{second}");
        // the overlap of the balls belongs to the second one
        let lens = 1.0 - PI / 12.0 * (16.0 + 3.0) * (8.0_f64 - 3.0).powi(2) / (4.0 / 3.0 * PI * 64.0);
        let first = share(&mesh, &ratios, 10.0, 0.004);
        assert!((first - lens).abs() < 0.03, "{first} {lens}");
        assert!(share(&mesh, &ratios, 5.0, 0.004) > 0.1);
    }
}
