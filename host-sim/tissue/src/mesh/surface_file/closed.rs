//! Makes one closed surface that faces outward from loose triangles.

use super::RawSurface;
use crate::mesh::distance::ClosedSurface;
use crate::mesh::error::Defect;

/// Distance, as a share of the largest extent, below which corners are merged (1): a few rounding
/// errors in STL's single precision.
const WELD: f64 = 1e-6;
/// Largest number of closed surfaces of an organ with cavities.
const MOST_PIECES: usize = 64;

/// A closed surface in file units.
pub(super) struct Closed {
    pub vertices: Vec<[f64; 3]>,
    /// Counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    pub turned_triangles: usize,
    pub left_out: usize,
    pub hollows: usize,
    /// Enclosed volume, in cubes of the file unit.
    pub volume: f64,
}

/// An edge as seen from one of its triangles.
struct Side {
    /// Vertices of the edge in rising order, the same from both sides.
    key: [u32; 2],
    triangle: usize,
    /// Whether the triangle has the vertices in this order.
    rises: bool,
}

/// Merges corners at the same place and turns all triangles outward.
///
/// # Errors
/// There are no triangles, an edge does not belong to two of them, the triangles cannot be oriented
/// consistently, or there are several bodies.
pub(super) fn close(raw: &RawSurface) -> Result<Closed, Defect> {
    let exact = weld(&raw.vertices, &raw.triangles, 0.0);
    let is_open = |triangles: &[[u32; 3]]| sides(triangles).chunk_by(|a, b| a.key == b.key).any(|edge| edge.len() == 1);
    let (vertices, mut triangles) = if is_open(&exact.1) { weld(&exact.0, &exact.1, tolerance(&exact.0)) } else { exact };
    if triangles.is_empty() {
        return Err(Defect::NoTriangles);
    }
    let left_out = raw.triangles.len() - triangles.len();
    let around = neighbours(&vertices, &triangles)?;
    let (piece, mut turned) = orient(&vertices, &triangles, &around)?;
    turn(&mut triangles, &turned);
    let pieces = piece.iter().max().map_or(0, |last| last + 1);
    let (hollows, volume) = outward(&vertices, &mut triangles, &mut turned, &piece, pieces)?;
    let turned_triangles = turned.iter().filter(|turned| **turned).count();
    Ok(Closed { vertices, triangles, turned_triangles, left_out, hollows, volume })
}

/// A place as text for messages, in file units.
pub(super) fn place(at: [f64; 3]) -> String {
    let [x, y, z] = at.map(|c| format!("{c:.4}").trim_end_matches('0').trim_end_matches('.').to_owned());
    format!("({x}, {y}, {z})")
}

fn tolerance(vertices: &[[f64; 3]]) -> f64 {
    let extent = |k: usize| {
        let along = vertices.iter().map(|at| at[k]);
        along.clone().fold(f64::NEG_INFINITY, f64::max) - along.fold(f64::INFINITY, f64::min)
    };
    WELD * extent(0).max(extent(1)).max(extent(2))
}

/// Merges vertices at the same place; returns those in use, and the triangles that still have three
/// corners. With a `tolerance` above zero, a vertex within it of an earlier one is merged with
/// that.
fn weld(vertices: &[[f64; 3]], triangles: &[[u32; 3]], tolerance: f64) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    // Adding zero makes -0 and 0 equal.
    let cell = |at: &[f64; 3]| at.map(|x| if tolerance > 0.0 { (x / tolerance).floor() } else { x + 0.0 });
    let compare = |a: &[f64; 3], b: &[f64; 3]| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])).then(a[2].total_cmp(&b[2]));
    let mut cells: Vec<([f64; 3], u32)> = vertices.iter().map(&cell).zip(0..).collect();
    cells.sort_unstable_by(|a, b| compare(&a.0, &b.0).then(a.1.cmp(&b.1)));
    let in_cell = |wanted: [f64; 3]| {
        let from = cells.partition_point(|(cell, _)| compare(cell, &wanted).is_lt());
        cells[from..].iter().take_while(move |(cell, _)| compare(cell, &wanted).is_eq()).map(|(_, vertex)| *vertex)
    };
    let near = |a: u32, b: u32| {
        let (a, b) = (vertices[a as usize], vertices[b as usize]);
        (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>() <= tolerance * tolerance
    };
    let steps = if tolerance > 0.0 { vec![-1.0, 0.0, 1.0] } else { vec![0.0] };
    let first_of = |vertex: u32| {
        let own = cell(&vertices[vertex as usize]);
        let mut first = vertex;
        for x in &steps {
            for y in &steps {
                for z in &steps {
                    let there = in_cell([own[0] + x, own[1] + y, own[2] + z]);
                    // the vertices of a cell are in rising order
                    first = there.take_while(|other| *other < first).find(|other| near(*other, vertex)).unwrap_or(first);
                }
            }
        }
        first
    };
    let mut stands_for: Vec<u32> = Vec::with_capacity(vertices.len());
    for vertex in 0..vertices.len() as u32 {
        let first = first_of(vertex);
        // Earlier vertices already have their place.
        stands_for.push(stands_for.get(first as usize).copied().unwrap_or(vertex));
    }
    let mut kept = Vec::new();
    let mut new_index = vec![u32::MAX; vertices.len()];
    let mut out = Vec::new();
    for triangle in triangles {
        let [a, b, c] = triangle.map(|vertex| stands_for[vertex as usize]);
        if a == b || b == c || c == a {
            continue;
        }
        out.push([a, b, c].map(|vertex| {
            let index = &mut new_index[vertex as usize];
            if *index == u32::MAX {
                *index = kept.len() as u32;
                kept.push(vertices[vertex as usize]);
            }
            *index
        }));
    }
    (kept, out)
}

/// The sides of all edges; those of one edge follow each other.
fn sides(triangles: &[[u32; 3]]) -> Vec<Side> {
    let of = |(triangle, [a, b, c]): (usize, &[u32; 3])| {
        [[*a, *b], [*b, *c], [*c, *a]].map(|[i, j]| Side { key: [i.min(j), i.max(j)], triangle, rises: i < j })
    };
    let mut sides: Vec<Side> = triangles.iter().enumerate().flat_map(of).collect();
    sides.sort_unstable_by_key(|side| (side.key, side.triangle));
    sides
}

/// Neighbours of every triangle, and whether each must be reversed to face as the triangle does.
fn neighbours(vertices: &[[f64; 3]], triangles: &[[u32; 3]]) -> Result<Vec<Vec<(usize, bool)>>, Defect> {
    let mut around = vec![Vec::with_capacity(3); triangles.len()];
    let (mut open, mut crowded) = (Vec::new(), Vec::new());
    for edge in sides(triangles).chunk_by(|a, b| a.key == b.key) {
        match edge {
            [a, b] => {
                around[a.triangle].push((b.triangle, a.rises == b.rises));
                around[b.triangle].push((a.triangle, a.rises == b.rises));
            }
            [side] => open.push(side.key),
            [side, ..] => crowded.push(side.key),
            [] => {}
        }
    }
    let middle = |[i, j]: [u32; 2]| {
        let (a, b) = (vertices[i as usize], vertices[j as usize]);
        place([0, 1, 2].map(|k| 0.5 * (a[k] + b[k])))
    };
    match (open.first(), crowded.first()) {
        (Some(edge), _) => Err(Defect::Open { edges: open.len(), near: middle(*edge) }),
        (None, Some(edge)) => Err(Defect::CrowdedEdge { edges: crowded.len(), near: middle(*edge) }),
        (None, None) => Ok(around),
    }
}

/// Piece that every triangle belongs to, and whether the triangle must be reversed to face as the
/// first one of its piece.
fn orient(
    vertices: &[[f64; 3]],
    triangles: &[[u32; 3]],
    around: &[Vec<(usize, bool)>],
) -> Result<(Vec<usize>, Vec<bool>), Defect> {
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
            for (other, alike) in &around[triangle] {
                let wanted = turned ^ alike;
                match state[*other] {
                    None => {
                        state[*other] = Some((pieces, wanted));
                        next.push(*other);
                    }
                    Some((_, found)) if found != wanted => {
                        return Err(Defect::OneSided { near: place(vertices[triangles[*other][0] as usize]) });
                    }
                    Some(_) => {}
                }
            }
        }
        pieces += 1;
    }
    Ok(state.into_iter().flatten().unzip())
}

fn turn(triangles: &mut [[u32; 3]], turned: &[bool]) {
    for (triangle, _) in triangles.iter_mut().zip(turned).filter(|(_, turned)| **turned) {
        triangle.swap(1, 2);
    }
}

/// Turns the outer piece outward, and each piece inside it toward the cavity that it bounds.
/// Returns the number of cavities and the volume of the body.
fn outward(
    vertices: &[[f64; 3]],
    triangles: &mut [[u32; 3]],
    turned: &mut [bool],
    piece: &[usize],
    pieces: usize,
) -> Result<(usize, f64), Defect> {
    let several = |near: u32| Defect::Bodies { pieces, near: place(vertices[near as usize]) };
    let Some(&[somewhere, ..]) = triangles.last() else { return Err(Defect::NoTriangles) };
    if pieces > MOST_PIECES {
        return Err(several(somewhere));
    }
    let mut volumes = vec![0.0; pieces];
    let origin = vertices[0];
    for (triangle, piece) in triangles.iter().zip(piece) {
        let [a, b, c] = triangle.map(|n| [0, 1, 2].map(|k| vertices[n as usize][k] - origin[k]));
        let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
        volumes[*piece] += (cross[0] * c[0] + cross[1] * c[1] + cross[2] * c[2]) / 6.0;
    }
    let largest = (0..pieces).max_by(|a, b| volumes[*a].abs().total_cmp(&volumes[*b].abs())).unwrap_or(0);
    let inward = |piece: usize, volumes: &[f64]| (volumes[piece] < 0.0) == (piece == largest);
    let flip: Vec<bool> = (0..pieces).map(|piece| inward(piece, &volumes)).collect();
    for ((triangle, turned), piece) in triangles.iter_mut().zip(turned).zip(piece) {
        if flip[*piece] {
            triangle.swap(1, 2);
            *turned = !*turned;
        }
    }
    let of = |wanted: usize| -> Vec<[u32; 3]> {
        triangles.iter().zip(piece).filter(|(_, piece)| **piece == wanted).map(|(triangle, _)| *triangle).collect()
    };
    if pieces > 1 {
        let surfaces: Vec<_> = (0..pieces).map(|n| ClosedSurface::of_triangles(vertices, &of(n))).collect();
        for inner in (0..pieces).filter(|n| *n != largest) {
            let Some(&[first, ..]) = of(inner).first() else { continue };
            let is_in = |outer: usize| {
                let distance = surfaces[outer].as_ref().map_or(0.0, |s| s.foot(vertices[first as usize]).distance_m);
                if outer == largest { distance < 0.0 } else { distance > 0.0 }
            };
            // An inner piece bounds a cavity only if it lies in the outer piece and in no other
            // inner one.
            let is_hollow = is_in(largest) && !(0..pieces).any(|n| n != largest && n != inner && !is_in(n));
            if !is_hollow {
                return Err(several(first));
            }
        }
    }
    let hollow: f64 = (0..pieces).filter(|n| *n != largest).map(|n| volumes[n].abs()).sum();
    Ok((pieces - 1, volumes[largest].abs() - hollow))
}
