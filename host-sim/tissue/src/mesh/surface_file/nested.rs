//! Tells the closed pieces of a surface apart: the outer one, hollows in it, and labels.

use crate::mesh::distance::ClosedSurface;
use crate::mesh::error::Defect;

/// Largest number of closed surfaces of an organ with cavities.
const MOST_PIECES: usize = 64;
/// Number of corners of a piece at which its place in another is tested: it may touch that at some.
const PROBES: usize = 32;

/// A body with the pieces of its surface.
pub(super) struct Body {
    pub hollows: usize,
    /// Pieces inside that face outward as the outer one does, by number.
    pub labels: Vec<usize>,
    /// Volume without the hollows, in cubes of the file unit.
    pub volume: f64,
}

/// Turns the outer piece outward, and each piece inside it toward the cavity that it bounds. In a
/// file, a hollow faces the other way than the outer piece; one that faces as that does bounds a
/// part of the body.
pub(super) fn outward(
    vertices: &[[f64; 3]],
    triangles: &mut [[u32; 3]],
    turned: &mut [bool],
    piece: &[usize],
    pieces: usize,
) -> Result<Body, Defect> {
    let several = |near: u32| Defect::Bodies { pieces, near: place(vertices[near as usize]) };
    let Some(&[somewhere, ..]) = triangles.last() else { return Err(Defect::NoTriangles) };
    if pieces > MOST_PIECES {
        return Err(several(somewhere));
    }
    let mut volumes = vec![0.0; pieces];
    // the number of triangles that face as they do in the file, less those that were turned
    let mut as_in_file = vec![0_i64; pieces];
    let origin = vertices[0];
    for ((triangle, turned), piece) in triangles.iter().zip(&*turned).zip(piece) {
        let [a, b, c] = triangle.map(|n| [0, 1, 2].map(|k| vertices[n as usize][k] - origin[k]));
        let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
        volumes[*piece] += (cross[0] * c[0] + cross[1] * c[1] + cross[2] * c[2]) / 6.0;
        as_in_file[*piece] += if *turned { -1 } else { 1 };
    }
    let largest = (0..pieces).max_by(|a, b| volumes[*a].abs().total_cmp(&volumes[*b].abs())).unwrap_or(0);
    let faces_out: Vec<bool> = volumes.iter().zip(&as_in_file).map(|(volume, n)| (*volume > 0.0) == (*n >= 0)).collect();
    let flip: Vec<bool> = (0..pieces).map(|piece| (volumes[piece] < 0.0) == (piece == largest)).collect();
    for ((triangle, turned), piece) in triangles.iter_mut().zip(turned).zip(piece) {
        if flip[*piece] {
            triangle.swap(1, 2);
            *turned = !*turned;
        }
    }
    let (mut labels, mut hollows) = (Vec::new(), Vec::new());
    for inner in (0..pieces).filter(|n| *n != largest) {
        if faces_out[inner] == faces_out[largest] { labels.push(inner) } else { hollows.push(inner) }
    }
    if pieces > 1 {
        let of: Vec<Vec<[u32; 3]>> = (0..pieces)
            .map(|wanted| triangles.iter().zip(piece).filter(|(_, piece)| **piece == wanted).map(|(t, _)| *t).collect())
            .collect();
        let surfaces: Vec<_> = of.iter().map(|triangles| ClosedSurface::of_triangles(vertices, triangles)).collect();
        // distance from the outer piece or a hollow, at the corner where it is largest
        let distance = |inner: usize, from: usize| {
            let step = of[inner].len().div_ceil(PROBES);
            let corners = of[inner].iter().step_by(step).map(|[a, ..]| vertices[*a as usize]);
            let distances = corners.map(|at| surfaces[from].as_ref().map_or(0.0, |surface| surface.foot(at).distance_m));
            distances.max_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or(0.0)
        };
        for inner in (0..pieces).filter(|n| *n != largest) {
            // a hollow faces inward, so that the distance is positive in it
            let is_in_hollow = hollows.iter().any(|hollow| *hollow != inner && distance(inner, *hollow) > 0.0);
            if let (true, Some(&[first, ..])) = (distance(inner, largest) >= 0.0 || is_in_hollow, of[inner].first()) {
                return Err(several(first));
            }
        }
    }
    let hollow: f64 = hollows.iter().map(|n| volumes[*n].abs()).sum();
    Ok(Body { hollows: hollows.len(), labels, volume: volumes[largest].abs() - hollow })
}

/// A place as text for messages, in file units.
pub(super) fn place(at: [f64; 3]) -> String {
    let [x, y, z] = at.map(|c| format!("{c:.4}").trim_end_matches('0').trim_end_matches('.').to_owned());
    format!("({x}, {y}, {z})")
}
