//! Spreads the nodes until the Delaunay edges have the wanted length: the truss of DistMesh
//! (Persson and Strang 2004), with every face node held on its face.

use super::delaunay::delaunay;
use super::grading::Grading;
use super::seed::Cloud;
use super::seed::Side;
use super::vector::{Vec3, add_scaled, distance, sub};

const ROUNDS: usize = 60;
/// Factor by which bars are longer than wanted, so that they push everywhere (1).
const OVERLENGTH: f64 = 1.15;
/// Share of the computed displacement that is applied per round.
const STEP: f64 = 0.15;
/// Weight of a bar on the surface, where triangles matter most (1).
const SURFACE_WEIGHT: f64 = 2.0;
/// Least distance of a node from any face that it does not lie on, in elements.
const MARGIN: f64 = 0.3;
/// Least distance between the shell and a node that is not on it, in elements: about the height of
/// a regular tet, so that the next layer rests on the shell. At 0.5, half of the coarse patches
/// have Delaunay tets that cross the shell; at 0.8, none of 48 had any.
const OFF_SHELL: f64 = 0.8;

/// Relaxes the cloud; returns the tets of the last positions, or `None` if two nodes coincide.
pub(super) fn relax(cloud: &mut Cloud, grading: &Grading) -> Option<Vec<[u32; 4]>> {
    for _ in 0..ROUNDS {
        let bars = edges(&delaunay(&cloud.at)?);
        let push = truss_push(cloud, grading, &bars);
        for (i, push) in push.into_iter().enumerate() {
            let size = grading.size_at(cloud.at[i]);
            for k in (0..3).filter(|k| !cloud.pinned[i][*k]) {
                let (low, high) = (grading.low[k], grading.high[k]);
                let margin = (MARGIN * size).min(0.25 * (high - low));
                cloud.at[i][k] = (cloud.at[i][k] + push[k]).clamp(low + margin, high - margin);
            }
            cloud.at[i] = grading.hold(cloud.side[i], cloud.at[i], OFF_SHELL * size);
        }
    }
    delaunay(&cloud.at)
}

/// The edges of some tets, each once, in ascending order.
pub(super) fn edges(tets: &[[u32; 4]]) -> Vec<[u32; 2]> {
    const PAIRS: [(usize, usize); 6] = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)];
    let pair = |t: &[u32; 4]| PAIRS.map(|(i, j)| [t[i].min(t[j]), t[i].max(t[j])]);
    let mut edges: Vec<_> = tets.iter().flat_map(pair).collect();
    edges.sort_unstable();
    edges.dedup();
    edges
}

fn truss_push(cloud: &Cloud, grading: &Grading, bars: &[[u32; 2]]) -> Vec<Vec3> {
    let ends = |bar: &[u32; 2]| bar.map(|n| cloud.at[n as usize]);
    let measure = |bar: &[u32; 2]| {
        let [a, b] = ends(bar);
        let middle = add_scaled(a, 0.5, sub(b, a));
        (distance(a, b), grading.size_at(middle))
    };
    let measured: Vec<_> = bars.iter().map(measure).collect();
    let (length, size) = measured.iter().fold((0.0, 0.0), |s, m| (s.0 + m.0, s.1 + m.1));
    let scale = OVERLENGTH * length / size;
    let mut push = vec![[0.0; 3]; cloud.at.len()];
    for (bar, (length, size)) in bars.iter().zip(measured) {
        let missing = scale * size - length;
        if missing > 0.0 {
            let [i, j] = bar.map(|n| n as usize);
            let on_shell = cloud.side[i] == Side::Shell && cloud.side[j] == Side::Shell;
            let on_surface = on_shell || (0..3).any(|k| cloud.share_face(i, j, k));
            let weight = if on_surface { SURFACE_WEIGHT } else { 1.0 };
            let along = sub(cloud.at[j], cloud.at[i]);
            let walk = STEP * weight * missing / length;
            push[i] = add_scaled(push[i], -walk, along);
            push[j] = add_scaled(push[j], walk, along);
        }
    }
    push
}
