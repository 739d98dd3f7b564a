//! Checks whether a surface passes through itself.

use nalgebra::Vector3;
use robust::{Coord3D, orient3d};

use super::distance::{ClosedSurface, Facet};

type V3 = Vector3<f64>;

/// Number of pairs of triangles that cross, and a corner near the first of them [m]; `None` if no
/// triangles cross. Triangles that merely touch, or lie in one plane, do not cross.
pub(super) fn crossings(surface: &ClosedSurface) -> Option<(usize, [f64; 3])> {
    let mut found = None;
    for (index, facet) in surface.facets.iter().enumerate() {
        let [a, b, c] = facet.corners;
        let (low, high) = (a.inf(&b).inf(&c), a.sup(&b).sup(&c));
        let mut open = vec![0];
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
                if cross(facet, &surface.facets[other]) {
                    found.get_or_insert((0, facet.corners[0].into())).0 += 1;
                }
            }
        }
    }
    found
}

fn cross(a: &Facet, b: &Facet) -> bool {
    pierces(a, b) || pierces(b, a)
}

/// Whether an edge of `a` that shares no corner with `b` passes through `b`.
fn pierces(a: &Facet, b: &Facet) -> bool {
    let shared = |corner: &V3| b.corners.contains(corner);
    (0..3).any(|k| {
        let (from, to) = (a.corners[k], a.corners[(k + 1) % 3]);
        if shared(&from) || shared(&to) {
            return false;
        }
        let [p, q, r] = b.corners;
        let (above, below) = (side(&p, &q, &r, &from), side(&p, &q, &r, &to));
        if above * below >= 0.0 {
            return false;
        }
        let turns = [side(&from, &to, &p, &q), side(&from, &to, &q, &r), side(&from, &to, &r, &p)];
        turns.iter().all(|turn| *turn >= 0.0) || turns.iter().all(|turn| *turn <= 0.0)
    })
}

/// Side of the plane of `a`, `b`, `c` on which `d` lies: -1, 0 or 1, exactly.
fn side(a: &V3, b: &V3, c: &V3, d: &V3) -> f64 {
    let point = |at: &V3| Coord3D { x: at.x, y: at.y, z: at.z };
    let volume = orient3d(point(a), point(b), point(c), point(d));
    if volume == 0.0 { 0.0 } else { volume.signum() }
}
