//! Divides a polygon into triangles that stay inside it, also if it is not convex (Meisters 1975,
//! "Polygons have ears").

use robust::{Coord, orient2d};

/// Triangles of a polygon, by its corners in order; as many as it has corners, less two. One with
/// fewer than three corners has none. A corner on the line between its neighbours stays a corner,
/// because the polygon on the other side may have it too.
pub(super) fn triangles(vertices: &[[f64; 3]], corners: &[u32]) -> Vec<[u32; 3]> {
    if corners.len() <= 3 {
        return corners.try_into().map_or_else(|_| Vec::new(), |triangle| vec![triangle]);
    }
    let flat = flattened(vertices, corners);
    let turn = |a: usize, b: usize, c: usize| orient2d(flat[a], flat[b], flat[c]);
    let n = corners.len();
    let is_convex = (0..n).all(|k| turn(k, (k + 1) % n, (k + 2) % n) > 0.0) && (1..n - 1).all(|k| turn(0, k, k + 1) > 0.0);
    if is_convex {
        return (1..n - 1).map(|k| [corners[0], corners[k], corners[k + 1]]).collect();
    }
    // only a corner that turns the other way can lie in an ear before all others
    let hollow: Vec<bool> = (0..n).map(|k| turn((k + n - 1) % n, k, (k + 1) % n) <= 0.0).collect();
    let mut left: Vec<usize> = (0..n).collect();
    let mut out = Vec::with_capacity(n - 2);
    let mut from = 0;
    while left.len() > 3 {
        let count = left.len();
        let around = |k: usize| [left[(k + count - 1) % count], left[k % count], left[(k + 1) % count]];
        let is_ear = |k: &usize| {
            let [a, b, c] = around(*k);
            let (low, high) = (flat[a].y.min(flat[b].y).min(flat[c].y), flat[a].y.max(flat[b].y).max(flat[c].y));
            let covers = |p: usize| {
                hollow[p]
                    && (low..=high).contains(&flat[p].y)
                    // corners at the same place are where a polygon touches itself
                    && ![a, b, c].iter().any(|corner| flat[*corner] == flat[p])
                    && turn(a, b, p) >= 0.0
                    && turn(b, c, p) >= 0.0
                    && turn(c, a, p) >= 0.0
            };
            turn(a, b, c) > 0.0 && !left.iter().any(|p| covers(*p))
        };
        // a polygon that passes through itself may have no ear; the check of the surface says so
        let Some(ear) = (from..from + count).find(is_ear).map(|ear| ear % count) else { break };
        out.push(around(ear).map(|k| corners[k]));
        left.remove(ear);
        from = ear % left.len();
    }
    out.extend(left.windows(2).skip(1).map(|pair| [corners[left[0]], corners[pair[0]], corners[pair[1]]]));
    out
}

/// The corners in the plane of two axes in which the polygon is largest, counter-clockwise.
fn flattened(vertices: &[[f64; 3]], corners: &[u32]) -> Vec<Coord<f64>> {
    let at = |k: usize| vertices[corners[k % corners.len()] as usize];
    // twice the area of the projections along x, y, z (Newell)
    let origin = at(0);
    let mut area = [0.0; 3];
    for k in 0..corners.len() {
        let (a, b) = ([0, 1, 2].map(|i| at(k)[i] - origin[i]), [0, 1, 2].map(|i| at(k + 1)[i] - origin[i]));
        for (axis, sum) in area.iter_mut().enumerate() {
            let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
            *sum += a[i] * b[j] - a[j] * b[i];
        }
    }
    let axis = (0..3).max_by(|a, b| area[*a].abs().total_cmp(&area[*b].abs())).unwrap_or(2);
    let (mut i, mut j) = ((axis + 1) % 3, (axis + 2) % 3);
    if area[axis] < 0.0 {
        std::mem::swap(&mut i, &mut j);
    }
    (0..corners.len()).map(|k| Coord { x: at(k)[i], y: at(k)[j] }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_polygon_of_many_corners_and_one_that_passes_through_itself_are_divided_at_once() {
        let n = 20_000_u32;
        let at = |k: u32, turns: f64| {
            let angle = turns * std::f64::consts::TAU * f64::from(k) / f64::from(n);
            let radius = 1.0 + 0.1 * f64::from(k % 2);
            [radius * angle.cos(), radius * angle.sin(), 0.0]
        };
        let corners: Vec<u32> = (0..n).collect();
        for turns in [1.0, 7.0] {
            let vertices: Vec<[f64; 3]> = corners.iter().map(|k| at(*k, turns)).collect();
            assert_eq!(triangles(&vertices, &corners).len(), 19_998);
        }
    }

    #[test]
    fn a_polygon_keeps_its_area_wherever_it_begins() {
        let l = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
        let u = [[0.0, 0.0], [3.0, 0.0], [3.0, 2.0], [2.0, 2.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
        let split_side = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
        for (polygon, area) in [(&l[..], 3.0), (&u[..], 5.0), (&split_side[..], 4.0)] {
            for start in 0..polygon.len() {
                for turn in [1.0, -1.0] {
                    let vertices: Vec<[f64; 3]> = polygon.iter().map(|[x, y]| [turn * x, 0.3 * x + 2.0 * y, *y]).collect();
                    let corners: Vec<u32> = (0..polygon.len()).map(|k| ((k + start) % polygon.len()) as u32).collect();
                    let found = triangles(&vertices, &corners);
                    assert_eq!(found.len(), polygon.len() - 2);
                    let area_of = |t: &[u32; 3]| {
                        let [a, b, c] = t.map(|n| vertices[n as usize]);
                        0.5 * turn * ((b[0] - a[0]) * (c[2] - a[2]) - (b[2] - a[2]) * (c[0] - a[0]))
                    };
                    assert!(found.iter().all(|t| area_of(t) > 0.0), "{found:?}");
                    assert!((found.iter().map(area_of).sum::<f64>() - area).abs() < 1e-12);
                }
            }
        }
    }
}
