//! Finds the edges and the outline of a wire surface.

use std::collections::BTreeMap;

use super::Layer;
use crate::style::FINE;
use crate::surface::view::{V3, View};

/// A piece of an edge of a wire surface.
pub struct Wire {
    /// Ends [canvas units].
    pub ends: [(f64, f64); 2],
    /// Coordinate of the middle of the piece along the direction to the eye [m]; larger is nearer.
    pub near: f64,
}

/// Edges, each with its node numbers in ascending order, and the numbers of adjacent triangles that
/// face the eye and that face away from it.
fn edges(layer: &Layer, view: &View) -> BTreeMap<[u32; 2], [u32; 2]> {
    let mut edges = BTreeMap::new();
    for triangle in layer.triangles {
        let [Some(a), Some(b), Some(c)] = triangle.map(|n| place(layer, n)) else { continue };
        let (ab, ac) = (b - a, c - a);
        let normal = ab.cross(&ac);
        // a triangle without area has no direction
        if normal.norm() <= 1e-9 * ab.norm_squared().max(ac.norm_squared()) {
            continue;
        }
        let away = usize::from(normal.dot(&view.eye) <= 0.0);
        for k in 0..3 {
            let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
            let sides: &mut [u32; 2] = edges.entry([a.min(b), a.max(b)]).or_default();
            sides[away] += 1;
        }
    }
    edges
}

fn place(layer: &Layer, node: u32) -> Option<V3> {
    layer.nodes_m.get(node as usize).copied().map(V3::from)
}

fn ends(layer: &Layer, edge: [u32; 2]) -> Option<[V3; 2]> {
    let [a, b] = edge.map(|n| place(layer, n));
    Some([a?, b?])
}

/// Edges of the triangles that face the eye, divided into pieces no longer than `piece_px`.
///
/// The pieces are moved away from the eye by half their length, so that where two surfaces coincide
/// only the skin is visible and not a moiré pattern of both.
pub fn wires(layer: &Layer, view: &View, piece_px: f64) -> Vec<Wire> {
    let mut all = Vec::new();
    let behind = 0.5 * piece_px * f64::from(FINE) / view.scale;
    for (edge, _) in edges(layer, view).into_iter().filter(|(_, [toward, _])| *toward > 0) {
        let Some([a, b]) = ends(layer, edge) else { continue };
        let (from, to) = (view.at(a), view.at(b));
        let length_px = (to.0 - from.0).hypot(to.1 - from.1) / f64::from(FINE);
        let count = (length_px / piece_px).ceil().clamp(1.0, 200.0);
        let near = |p: V3| p.dot(&view.eye);
        let mix = |a: f64, b: f64, k: f64| a + (b - a) * k / count;
        for k in 0..count as u32 {
            let (k, next) = (f64::from(k), f64::from(k) + 1.0);
            let at = |k| (mix(from.0, to.0, k), mix(from.1, to.1, k));
            all.push(Wire { ends: [at(k), at(next)], near: mix(near(a), near(b), k + 0.5) - behind });
        }
    }
    all
}

/// Edges between a triangle that faces the eye and one that faces away, and open borders [canvas
/// units].
pub fn outline(layer: &Layer, view: &View) -> Vec<[(f64, f64); 2]> {
    let turned = |[toward, away]: &[u32; 2]| *toward > 0 && *away > 0 || toward + away == 1;
    (edges(layer, view).into_iter().filter(|(_, sides)| turned(sides)))
        .filter_map(|(edge, _)| Some(ends(layer, edge)?.map(|p| view.at(p))))
        .collect()
}
