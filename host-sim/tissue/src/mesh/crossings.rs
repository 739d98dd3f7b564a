//! Checks whether a surface passes through itself.

use nalgebra::Vector3;
use robust::{Coord3D, orient3d};

use super::distance::{ClosedSurface, Facet};

type V3 = Vector3<f64>;

/// Triangles of a surface that cross.
pub(super) struct Crossings {
    /// Number of pairs.
    pub pairs: usize,
    /// A corner near the first pair.
    pub near: [f64; 3],
    /// Share of the surface in triangles that cross others (1).
    pub share: f64,
}

/// Pairs of triangles that cross; `None` if there are none. Triangles that merely touch, or lie in
/// one plane, do not cross. The surface gives the boxes, `vertices` the corners of the same
/// triangles as they are in their file.
pub(super) fn crossings(surface: &ClosedSurface, vertices: &[[f64; 3]], triangles: &[[u32; 3]]) -> Option<Crossings> {
    let exact = |facet: &Facet| triangles[facet.triangle as usize].map(|n| V3::from(vertices[n as usize]));
    let mut found: Option<Crossings> = None;
    let mut crosses = vec![false; surface.facets.len()];
    let mut open = Vec::new();
    for (index, facet) in surface.facets.iter().enumerate() {
        let [a, b, c] = facet.corners;
        let (low, high) = (a.inf(&b).inf(&c), a.sup(&b).sup(&c));
        open.push(0);
        while let Some(at) = open.pop() {
            let bounds = &surface.boxes[at];
            if (0..3).any(|k| bounds.low[k] > high[k] || bounds.high[k] < low[k]) || bounds.facets.end <= index {
                continue;
            }
            if bounds.second != 0 {
                open.extend([at + 1, bounds.second]);
                continue;
            }
            for other in bounds.facets.clone().filter(|other| *other > index) {
                let beside = &surface.facets[other].corners;
                let is_apart = (0..3).any(|k| {
                    let along = beside.map(|corner| corner[k]);
                    along.iter().all(|x| *x > high[k]) || along.iter().all(|x| *x < low[k])
                });
                if is_apart {
                    continue;
                }
                let (own, beyond) = (exact(facet), exact(&surface.facets[other]));
                if pierces(&own, &beyond) || pierces(&beyond, &own) {
                    (crosses[index], crosses[other]) = (true, true);
                    found.get_or_insert(Crossings { pairs: 0, near: own[0].into(), share: 0.0 }).pairs += 1;
                }
            }
        }
    }
    let mut found = found?;
    let area = |facet: &Facet| (facet.corners[1] - facet.corners[0]).cross(&(facet.corners[2] - facet.corners[0])).norm();
    let of_crossing: f64 = surface.facets.iter().zip(crosses).filter(|(_, crosses)| *crosses).map(|(facet, _)| area(facet)).sum();
    found.share = of_crossing / surface.facets.iter().map(area).sum::<f64>();
    Some(found)
}

/// Whether an edge of `a` that shares no corner with `b` passes through `b`, or through
/// an edge of it: in a symmetric shape, crossings may be at edges alone.
fn pierces(a: &[V3; 3], b: &[V3; 3]) -> bool {
    (0..3).any(|k| {
        let (from, to) = (a[k], a[(k + 1) % 3]);
        if b.contains(&from) || b.contains(&to) {
            return false;
        }
        let [p, q, r] = b;
        let (above, below) = (side(p, q, r, &from), side(p, q, r, &to));
        if above * below >= 0.0 {
            return false;
        }
        let turns = [side(&from, &to, p, q), side(&from, &to, q, r), side(&from, &to, r, p)];
        turns.iter().all(|turn| *turn >= 0.0) || turns.iter().all(|turn| *turn <= 0.0)
    })
}

/// Side of the plane of `a`, `b`, `c` on which `d` lies: -1, 0 or 1, exactly.
fn side(a: &V3, b: &V3, c: &V3, d: &V3) -> f64 {
    let point = |at: &V3| Coord3D { x: at.x, y: at.y, z: at.z };
    let volume = orient3d(point(a), point(b), point(c), point(d));
    if volume == 0.0 { 0.0 } else { volume.signum() }
}
