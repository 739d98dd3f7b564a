//! Makes one closed surface that faces outward from loose triangles.

use super::RawSurface;
use super::copies::{Unique, unique};
use super::nested::{Body, outward, place};
use super::weld::{extent, in_use, weld};
use crate::mesh::error::Defect;
use crate::mesh::pairs::{Beyond, Unpaired, Wedge, neighbours, part, sides};

/// Distances, as shares of the largest extent, within which corners are merged until the surface is
/// closed (1): nothing, a few rounding errors in single precision, then texts of fewer digits.
const WELDS: [f64; 4] = [0.0, 1e-6, 1e-5, 1e-4];
/// A closed surface in file units.
pub(super) struct Closed {
    pub vertices: Vec<[f64; 3]>,
    /// Counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    pub turned_triangles: usize,
    pub left_out: usize,
    pub copies: usize,
    pub hollows: usize,
    pub labels: usize,
    pub label_triangles: usize,
    /// Enclosed volume, in cubes of the file unit.
    pub volume: f64,
}

/// Merges corners at the same place and turns all triangles outward.
///
/// # Errors
/// There are no triangles, an edge does not belong to two of them, the triangles cannot be oriented
/// consistently, or there are several bodies.
pub(super) fn close(raw: &RawSurface) -> Result<Closed, Defect> {
    let all = raw.triangles.len();
    let (mut vertices, unique, left_out) = welded(raw);
    let mut triangles = unique.without_sheets();
    let copies = all - left_out - triangles.len();
    if triangles.is_empty() {
        return Err(Defect::NoTriangles);
    }
    if copies > 0 {
        (vertices, triangles) = in_use(&vertices, &triangles);
    }
    let around = neighbours(&vertices, &triangles, Wedge::Body).map_err(|unpaired| defect(&vertices, &unpaired))?;
    part(&mut vertices, &mut triangles, &around);
    let (piece, mut turned) = orient(&vertices, &triangles, &around)?;
    turn(&mut triangles, &turned);
    let pieces = piece.iter().max().map_or(0, |last| last + 1);
    let Body { hollows, labels, volume } = outward(&vertices, &mut triangles, &mut turned, &piece, pieces)?;
    let is_own = |n: usize| !labels.contains(&piece[n]);
    let label_triangles = (0..piece.len()).filter(|n| !is_own(*n)).count();
    let turned_triangles = (0..piece.len()).filter(|n| turned[*n] && is_own(*n)).count();
    if label_triangles > 0 {
        let own: Vec<[u32; 3]> = (0..piece.len()).filter(|n| is_own(*n)).map(|n| triangles[n]).collect();
        (vertices, triangles) = in_use(&vertices, &own);
    }
    Ok(Closed { vertices, triangles, turned_triangles, left_out, copies, hollows, labels: labels.len(), label_triangles, volume })
}

/// Merges corners as far as it takes to close the surface; returns also the number of triangles
/// that lost their area by that. If nothing closes it, only rounding errors are merged.
fn welded(raw: &RawSurface) -> (Vec<[f64; 3]>, Unique, usize) {
    let extent = extent(&raw.vertices);
    let merged = |share: f64, vertices: &[[f64; 3]], triangles: &[[u32; 3]]| {
        let (vertices, triangles) = weld(vertices, triangles, share * extent);
        let left_out = raw.triangles.len() - triangles.len();
        (vertices, unique(&triangles), left_out)
    };
    let exact = merged(WELDS[0], &raw.vertices, &raw.triangles);
    if !exact.1.is_open() {
        return exact;
    }
    let (vertices, triangles) = weld(&raw.vertices, &raw.triangles, 0.0);
    let mut wider = WELDS[1..].iter().map(|share| merged(*share, &vertices, &triangles));
    let least = wider.next();
    match least {
        Some(least) if least.1.is_open() => wider.find(|(_, unique, _)| !unique.is_open()).unwrap_or(least),
        Some(least) => least,
        None => exact,
    }
}

fn defect(vertices: &[[f64; 3]], unpaired: &Unpaired) -> Defect {
    let middle = |[i, j]: [u32; 2]| {
        let (a, b) = (vertices[i as usize], vertices[j as usize]);
        place([0, 1, 2].map(|k| 0.5 * (a[k] + b[k])))
    };
    let Unpaired { open, crowded } = unpaired;
    match (open.first(), crowded.first()) {
        (Some(edge), _) => Defect::Open { edges: open.len(), near: middle(*edge) },
        (None, Some(edge)) => Defect::CrowdedEdge { edges: crowded.len(), near: middle(*edge) },
        (None, None) => Defect::NoTriangles,
    }
}

/// Piece that every triangle belongs to, and whether the triangle must be reversed to face as the
/// first one of its piece.
fn orient(vertices: &[[f64; 3]], triangles: &[[u32; 3]], around: &[[Beyond; 3]]) -> Result<(Vec<usize>, Vec<bool>), Defect> {
    let mut state: Vec<Option<(usize, bool)>> = vec![None; triangles.len()];
    let mut pieces = 0;
    for first in 0..triangles.len() {
        if state[first].is_some() {
            continue;
        }
        state[first] = Some((pieces, false));
        let mut next = vec![first];
        while let Some(triangle) = next.pop() {
            let turned = state[triangle].is_some_and(|(_, turned)| turned);
            for beyond in &around[triangle] {
                let (other, wanted) = (beyond.triangle as usize, turned ^ beyond.turned);
                match state[other] {
                    None => {
                        state[other] = Some((pieces, wanted));
                        next.push(other);
                    }
                    Some((_, found)) if found != wanted => {
                        return Err(one_sided(vertices, triangles, triangles[other][0]));
                    }
                    Some(_) => {}
                }
            }
        }
        pieces += 1;
    }
    Ok(state.into_iter().flatten().unzip())
}

/// A surface that cannot be oriented: walls of several parts that meet in an edge may be paired
/// wrongly, any other has one side only.
fn one_sided(vertices: &[[f64; 3]], triangles: &[[u32; 3]], near: u32) -> Defect {
    let sides = sides(triangles);
    let mut edges = sides.chunk_by(|a, b| a.key == b.key);
    match edges.find(|edge| edge.len() > 2) {
        Some(edge) => Defect::WallsMeet { near: place(vertices[edge[0].key[0] as usize]) },
        None => Defect::OneSided { near: place(vertices[near as usize]) },
    }
}

fn turn(triangles: &mut [[u32; 3]], turned: &[bool]) {
    for (triangle, _) in triangles.iter_mut().zip(turned).filter(|(_, turned)| **turned) {
        triangle.swap(1, 2);
    }
}
