//! A mesh with facets on the surfaces of balls, so that every tet is inside or outside a ball.
//!
//! As in isosurface stuffing (Labelle and Shewchuk 2007), nodes near the surface are moved onto it,
//! and edges that still pass through it are cut there. A tet with another stiffness in a part of it
//! makes the ball act too stiff, by an error of first order in its edge; with facets on the surface
//! the error is of second order.

use std::collections::{BTreeSet, HashMap};
use std::f64::consts::PI;

use nalgebra::Vector3;
use palpate_tissue::mesh::TetMesh;
use palpate_tissue::mesh::surface::surface;
use palpate_tissue::scene::Inclusion;

type V3 = Vector3<f64>;

/// Distance from the surface, as a share of the edge, within which its end is moved onto it.
const NEAR: f64 = 0.35;
/// Least share of its volume that a tet keeps when a node is moved.
const LEAST_VOLUME: f64 = 0.2;
/// Distance from the surface, as a share of the radius, that counts as zero.
const ON: f64 = 1e-9;
/// Largest number of passes over the edges: a tet is cut at most three times.
const PASSES: usize = 20;

/// Returns the mesh with facets on the balls' surfaces, and the stiffness of each tet as a multiple
/// of the tissue's; where balls overlap the last one counts. The facets are chords of a slightly
/// larger ball, chosen so that their polyhedron has the ball's volume. The mesh's own surface is
/// kept: where a ball protrudes through it, tets stay uncut.
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
    /// Distance outside the ball [m].
    fn of(&self, at: [f64; 3]) -> f64 {
        (V3::from(at) - self.centre).norm() - self.radius_m
    }

    /// Whether a tet, whose corners lie on one side or on the surface, is in the ball. A tet with
    /// all corners on the surface is.
    fn holds(&self, mesh: &TetMesh, tet: &[u32; 4]) -> bool {
        tet.iter().map(|n| self.of(mesh.nodes_m[*n as usize])).sum::<f64>() < ON * self.radius_m
    }

    /// Moves the facets outwards until they enclose the ball's volume.
    fn grow(&mut self, mesh: &mut TetMesh, own: &BTreeSet<u32>) {
        // a ball that ends at the mesh's surface has less than its volume there
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

    /// Whether the surface lies between two distances from it.
    fn parts(&self, a: f64, b: f64) -> bool {
        let on = ON * self.radius_m;
        a.min(b) < -on && a.max(b) > on
    }

    /// Position of the crossing on an edge, from its first end (1).
    fn crossing(&self, from: V3, to: V3) -> f64 {
        let (way, off) = (to - from, from - self.centre);
        let (a, b, c) = (way.norm_squared(), way.dot(&off), off.norm_squared() - self.radius_m * self.radius_m);
        let root = (b * b - a * c).max(0.0).sqrt();
        // from inside, the later crossing counts, from outside, the earlier one
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

/// Moves nodes near the ball's surface onto it if all tets around them stay valid.
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

/// Cuts the edges that pass through the ball's surface, in all tets around them.
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
        // one edge per tet and pass
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

    /// Sum of volumes over 4/3 pi r^3, of the tets of this ratio.
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
            // closed: as many outer facets as before
            assert_eq!(surface(&mesh.tets).len(), surface(&before.tets).len());
            // facets lie on one sphere, a little larger than the ball
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
        // the overlap of the balls counts as part of the second
        let lens = 1.0 - PI / 12.0 * (16.0 + 3.0) * (8.0_f64 - 3.0).powi(2) / (4.0 / 3.0 * PI * 64.0);
        let first = share(&mesh, &ratios, 10.0, 0.004);
        assert!((first - lens).abs() < 0.03, "{first} {lens}");
        assert!(share(&mesh, &ratios, 5.0, 0.004) > 0.1);
    }
}
