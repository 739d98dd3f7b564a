//! Pairs the triangles at the edges of a surface, and parts it where it merely touches itself.

use nalgebra::Vector3;

type V3 = Vector3<f64>;

/// The triangle beyond an edge.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beyond {
    pub triangle: u32,
    /// Index of the edge there; edge `k` goes from corner `k` to the next.
    edge: u8,
    /// Whether it must be reversed to face as the triangle on this side does.
    pub turned: bool,
}

/// An edge as seen from one of its triangles.
#[derive(Clone, Copy)]
pub(super) struct Side {
    /// Vertices of the edge in rising order, the same from both sides.
    pub key: [u32; 2],
    pub triangle: u32,
    edge: u8,
    /// Whether the triangle has the vertices in this order.
    rises: bool,
}

/// The sides of all edges; those of one edge follow each other.
pub(super) fn sides(triangles: &[[u32; 3]]) -> Vec<Side> {
    let of = |(triangle, corners): (u32, &[u32; 3])| {
        let corners = *corners;
        (0..3_u8).map(move |edge| {
            let (i, j) = (corners[usize::from(edge)], corners[(usize::from(edge) + 1) % 3]);
            Side { key: [i.min(j), i.max(j)], triangle, edge, rises: i < j }
        })
    };
    let mut sides: Vec<Side> = (0..).zip(triangles).flat_map(of).collect();
    sides.sort_unstable_by_key(|side| (side.key, side.triangle));
    sides
}

/// Volumes that several pairs of triangles that meet in an edge enclose between the two of each
/// pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Wedge {
    Body,
    Void,
}

/// Edges that are not in pairs of triangles.
#[derive(Debug)]
pub(super) struct Unpaired {
    /// Edges of one triangle.
    pub open: Vec<[u32; 2]>,
    /// Edges of three triangles, or another odd number.
    pub crowded: Vec<[u32; 2]>,
}

/// The triangle beyond each edge of every triangle. Where several pairs of triangles meet in an
/// edge, each pair bounds one `wedge`, if the triangles face outward there.
pub(super) fn neighbours(vertices: &[[f64; 3]], triangles: &[[u32; 3]], wedge: Wedge) -> Result<Vec<[Beyond; 3]>, Unpaired> {
    let none = Beyond { triangle: u32::MAX, edge: 0, turned: false };
    let mut around = vec![[none; 3]; triangles.len()];
    let mut join = |a: Side, b: Side| {
        let turned = a.rises == b.rises;
        around[a.triangle as usize][usize::from(a.edge)] = Beyond { triangle: b.triangle, edge: b.edge, turned };
        around[b.triangle as usize][usize::from(b.edge)] = Beyond { triangle: a.triangle, edge: a.edge, turned };
    };
    let (mut open, mut crowded) = (Vec::new(), Vec::new());
    let sides = sides(triangles);
    for edge in sides.chunk_by(|a, b| a.key == b.key) {
        match edge {
            [a, b] => join(*a, *b),
            _ if edge.len() % 2 == 0 => wedges(vertices, triangles, edge, wedge).into_iter().for_each(|[a, b]| join(a, b)),
            [side] => open.push(side.key),
            [side, ..] => crowded.push(side.key),
            [] => {}
        }
    }
    if open.is_empty() && crowded.is_empty() { Ok(around) } else { Err(Unpaired { open, crowded }) }
}

/// Angle below which two triangles at an edge lie on each other [rad].
const SAME_ANGLE: f64 = 1e-9;

/// Pairs of sides of one edge, each around a wedge.
fn wedges(vertices: &[[f64; 3]], triangles: &[[u32; 3]], edge: &[Side], wedge: Wedge) -> Vec<[Side; 2]> {
    let Some(first) = edge.first() else { return Vec::new() };
    let place = |vertex: u32| V3::from(vertices[vertex as usize]);
    let from = place(first.key[0]);
    let along = place(first.key[1]) - from;
    let third = |side: &Side| {
        let corner = triangles[side.triangle as usize][(usize::from(side.edge) + 2) % 3];
        let to = place(corner) - from;
        to - along * (to.dot(&along) / along.norm_squared())
    };
    let axis_1 = third(first);
    let axis_2 = along.cross(&axis_1) / along.norm();
    let mut turned: Vec<(f64, Side)> = edge
        .iter()
        .map(|side| {
            let to = third(side);
            (to.dot(&axis_2).atan2(to.dot(&axis_1)), *side)
        })
        .collect();
    turned.sort_by(|a, b| a.0.total_cmp(&b.0));
    // walls of two parts that lie on each other: the one part ends where the next begins, and their
    // order is that of the rounding
    for n in 1..turned.len() {
        let ends = |side: &Side| side.rises == (wedge == Wedge::Body);
        if turned[n].0 - turned[n - 1].0 < SAME_ANGLE && ends(&turned[n].1) && !ends(&turned[n - 1].1) {
            turned.swap(n - 1, n);
        }
    }
    // a triangle that has the edge in rising order faces the way in which the angle grows: the
    // body before it begins at one that has the edge in falling order
    let start = turned.iter().position(|(_, side)| side.rises == (wedge == Wedge::Void)).unwrap_or(0);
    turned.rotate_left(start);
    turned.chunks_exact(2).map(|pair| [pair[0].1, pair[1].1]).collect()
}

/// Gives each group of triangles that are connected around a vertex a vertex of its own, so that
/// parts that meet in a corner or an edge are not connected there.
pub(super) fn part(vertices: &mut Vec<[f64; 3]>, triangles: &mut [[u32; 3]], around: &[[Beyond; 3]]) {
    let mut parent: Vec<u32> = (0..3 * triangles.len() as u32).collect();
    for (triangle, (corners, beyond)) in triangles.iter().zip(around).enumerate() {
        for (k, beyond) in beyond.iter().enumerate() {
            let other = triangles[beyond.triangle as usize];
            let there = [usize::from(beyond.edge), (usize::from(beyond.edge) + 1) % 3];
            for corner in [k, (k + 1) % 3] {
                let Some(same) = there.iter().find(|m| other[**m] == corners[corner]) else { continue };
                let (a, b) = (first(&mut parent, (3 * triangle + corner) as u32), 3 * beyond.triangle + *same as u32);
                let b = first(&mut parent, b);
                parent[a.max(b) as usize] = a.min(b);
            }
        }
    }
    let mut of_group = vec![u32::MAX; parent.len()];
    let mut is_taken = vec![false; vertices.len()];
    for (triangle, corners) in triangles.iter_mut().enumerate() {
        for (k, vertex) in corners.iter_mut().enumerate() {
            let group = first(&mut parent, (3 * triangle + k) as u32) as usize;
            if of_group[group] == u32::MAX {
                let place = vertices[*vertex as usize];
                let taken = std::mem::replace(&mut is_taken[*vertex as usize], true);
                of_group[group] = if taken {
                    vertices.push(place);
                    vertices.len() as u32 - 1
                } else {
                    *vertex
                };
            }
            *vertex = of_group[group];
        }
    }
}

/// The corner that stands for all that are connected to one.
fn first(parent: &mut [u32], mut corner: u32) -> u32 {
    while parent[corner as usize] != corner {
        parent[corner as usize] = parent[parent[corner as usize] as usize];
        corner = parent[corner as usize];
    }
    corner
}
