//! Cuts tets and surface with the plane of the picture, and clips the result to the visible part.

use crate::surface::facets::Skin;
use crate::surface::view::{V3, View};

/// A point of the tissue with its displacement.
#[derive(Clone, Copy, Debug)]
pub struct Corner {
    /// Deformed position [m].
    pub at: V3,
    /// Magnitude of the displacement at this point [m].
    pub moved_m: f64,
}

/// A piece of the surface behind the cut, clipped to the visible part.
pub struct Piece {
    /// Corners in order around the piece.
    pub corners: Vec<Corner>,
    /// Brightness from 0 (dark) to 1.
    pub light: f64,
    near: f64,
}

/// The plane of the cut and the part of it that is visible in the picture.
pub struct Window {
    /// Point of the surface at rest that the probe presses [m].
    pub site_m: V3,
    /// Unit vector to the right in the picture.
    pub right: V3,
    /// Unit vector out of the tissue along the press, up in the picture.
    pub up: V3,
    /// Unit normal of the cut, toward the eye.
    pub front: V3,
    /// Half of the visible width [m].
    pub half_width_m: f64,
    /// Visible depth below the site [m].
    pub depth_m: f64,
    /// Visible distance behind the cut [m].
    pub behind_m: f64,
}

/// The part of a polygon in which `outside` [m], a signed distance, is not positive.
fn clipped(polygon: &[Corner], outside: impl Fn(V3) -> f64) -> Vec<Corner> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (k, a) in polygon.iter().enumerate() {
        let b = &polygon[(k + 1) % polygon.len()];
        let (da, db) = (outside(a.at), outside(b.at));
        if da <= 0.0 {
            kept.push(*a);
        }
        if (da <= 0.0) != (db <= 0.0) {
            kept.push(between(a, b, da / (da - db)));
        }
    }
    kept
}

fn between(a: &Corner, b: &Corner, share: f64) -> Corner {
    Corner { at: a.at + (b.at - a.at) * share, moved_m: a.moved_m + (b.moved_m - a.moved_m) * share }
}

impl Window {
    /// The part of a polygon within the visible width and depth.
    fn shown(&self, polygon: &[Corner]) -> Vec<Corner> {
        let x = |p: V3| (p - self.site_m).dot(&self.right);
        let below = |p: V3| (self.site_m - p).dot(&self.up);
        let right = clipped(polygon, |p| x(p) - self.half_width_m);
        let left = clipped(&right, |p| -x(p) - self.half_width_m);
        clipped(&left, |p| below(p) - self.depth_m)
    }

    /// Signed distance of a point from the cut [m]; positive in front of it.
    fn before_m(&self, p: V3) -> f64 {
        (p - self.site_m).dot(&self.front)
    }

    /// Polygon in which a tet intersects the cut; empty if it does not.
    pub fn through(&self, tet: &[u32; 4], places_m: &[[f64; 3]], moved_m: &[f64]) -> Vec<Corner> {
        let corners = tet.map(|n| Corner { at: V3::from(places_m[n as usize]), moved_m: moved_m[n as usize] });
        let (before, behind): (Vec<Corner>, Vec<Corner>) = corners.iter().partition(|c| self.before_m(c.at) > 0.0);
        let meet = |a: &Corner, b: &Corner| {
            let (da, db) = (self.before_m(a.at), self.before_m(b.at));
            between(a, b, da / (da - db))
        };
        let polygon = match (&before[..], &behind[..]) {
            ([a], [b, c, d]) | ([b, c, d], [a]) => vec![meet(a, b), meet(a, c), meet(a, d)],
            // in this order, consecutive corners of the quadrilateral share a node of the tet
            ([a, b], [c, d]) => vec![meet(a, c), meet(a, d), meet(b, d), meet(b, c)],
            _ => return Vec::new(),
        };
        self.shown(&polygon)
    }

    /// Segments in which triangles whose nodes are all `chosen` intersect the cut.
    pub fn outline(&self, triangles: &[[u32; 3]], places_m: &[[f64; 3]], chosen: impl Fn(usize) -> bool) -> Vec<[V3; 2]> {
        let mut segments = Vec::new();
        for triangle in triangles.iter().filter(|t| t.iter().all(|n| chosen(*n as usize))) {
            let corners = triangle.map(|n| V3::from(places_m[n as usize]));
            let mut ends = Vec::with_capacity(2);
            for k in 0..3 {
                let (a, b) = (corners[k], corners[(k + 1) % 3]);
                let (da, db) = (self.before_m(a), self.before_m(b));
                if (da > 0.0) != (db > 0.0) {
                    ends.push(Corner { at: a + (b - a) * (da / (da - db)), moved_m: 0.0 });
                }
            }
            // clipping treats the segment as a polygon of two corners and may return one end twice
            let shown = self.shown(&ends);
            let Some(a) = shown.first().map(|c| c.at) else { continue };
            let from_a = |c: &Corner| (c.at - a).norm();
            if let Some(b) = shown.iter().max_by(|b, c| from_a(b).total_cmp(&from_a(c))).map(|c| c.at) {
                segments.push([a, b]);
            }
        }
        segments
    }

    /// The pieces of the surface behind the cut that face the eye, farthest first.
    pub fn behind(&self, skin: &Skin, view: &View) -> Vec<Piece> {
        let mut pieces = Vec::new();
        for triangle in skin.triangles {
            let corners = triangle.map(|n| Corner { at: V3::from(skin.places_m[n as usize]), moved_m: skin.moved_m[n as usize] });
            let [a, b, c] = corners.map(|c| c.at);
            let normal = (b - a).cross(&(c - a));
            if normal.dot(&view.eye) <= 0.0 {
                continue;
            }
            let behind = clipped(&self.shown(&corners), |p| self.before_m(p));
            let behind = clipped(&behind, |p| -self.before_m(p) - self.behind_m);
            if behind.len() >= 3 {
                let light = normal.try_normalize(0.0).map_or(0.0, |n| n.dot(&skin.lamp)).max(0.0);
                let near = behind.iter().map(|c| c.at.dot(&view.eye)).sum::<f64>() / behind.len() as f64;
                pieces.push(Piece { corners: behind, light, near });
            }
        }
        pieces.sort_by(|a, b| a.near.total_cmp(&b.near));
        pieces
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TET: [[f64; 3]; 4] = [[-1.0, 0.0, -1.0], [1.0, -1.0, -1.0], [1.0, 1.0, -1.0], [1.0, 0.0, 1.0]];

    fn window(site_m: V3) -> Window {
        Window { site_m, right: V3::y(), up: V3::z(), front: V3::x(), half_width_m: 10.0, depth_m: 10.0, behind_m: 10.0 }
    }

    fn area(corners: &[Corner]) -> f64 {
        let first = corners[0].at;
        let pairs = corners.windows(2).map(|pair| (pair[0].at - first).cross(&(pair[1].at - first)));
        0.5 * pairs.sum::<V3>().norm()
    }

    /// At half its height the cross-section of a tet has a quarter of the area of its base, and the
    /// displacement in the cut is interpolated.
    #[test]
    fn a_tet_is_cut_to_the_area_of_its_height() {
        let cut = window(V3::zeros()).through(&[0, 1, 2, 3], &TET, &[0.0, 2.0, 2.0, 2.0]);
        assert_eq!(cut.len(), 3);
        assert!((area(&cut) - 0.25 * 2.0).abs() < 1e-12, "{}", area(&cut));
        assert!(cut.iter().all(|c| (c.moved_m - 1.0).abs() < 1e-12));
        // this cut has two nodes on each side
        let turned = Window { front: V3::z(), up: V3::x(), ..window(V3::new(0.0, 0.0, 0.0)) };
        assert_eq!(turned.through(&[0, 1, 2, 3], &TET, &[0.0; 4]).len(), 3);
        let sideways = Window { front: V3::y(), right: V3::x(), ..window(V3::new(0.0, 0.1, 0.0)) };
        assert!(sideways.through(&[0, 1, 2, 3], &TET, &[0.0; 4]).len() >= 3);
        assert!(window(V3::x() * 3.0).through(&[0, 1, 2, 3], &TET, &[0.0; 4]).is_empty());
    }

    #[test]
    fn the_window_cuts_what_is_beside_and_below_it() {
        let narrow = Window { half_width_m: 0.25, depth_m: 0.5, ..window(V3::zeros()) };
        let cut = narrow.through(&[0, 1, 2, 3], &TET, &[0.0; 4]);
        assert!(cut.iter().all(|c| c.at.y.abs() <= 0.25 + 1e-12 && c.at.z >= -0.5 - 1e-12), "{cut:?}");
        assert!(cut.len() >= 3);
    }

    #[test]
    fn only_the_back_of_the_surface_is_left() {
        let (window, sides) = (window(V3::zeros()), [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]);
        let frame = super::super::Frame { low: (0, 0), high: (100, 100) };
        let view = View::from_eye(V3::new(0.9, 0.0, 0.4).normalize(), V3::z(), &TET.into_iter().map(V3::from), frame);
        let skin = Skin {
            places_m: &TET,
            triangles: &sides,
            moved_m: &[0.0; 4],
            scale_m: 1.0,
            lamp: V3::z(),
            largest_px: f64::INFINITY,
        };
        for piece in window.behind(&skin, &view) {
            assert!(piece.corners.iter().all(|c| c.at.x <= 1e-12));
        }
        assert_eq!(window.outline(&sides, &TET, |_| true).len(), 3);
        assert!(window.outline(&sides, &TET, |n| n > 0).is_empty());
    }

    #[test]
    fn a_line_that_leaves_the_window_ends_at_its_edge() {
        let flat = [[-1.0, -3.0, 0.0], [1.0, -3.0, 0.0], [1.0, 3.0, 0.0], [-1.0, 3.0, 0.0]];
        let narrow = Window { half_width_m: 2.0, ..window(V3::zeros()) };
        let segments = narrow.outline(&[[0, 1, 2], [0, 2, 3]], &flat, |_| true);
        let length: f64 = segments.iter().map(|[a, b]| (b - a).norm()).sum();
        assert!((length - 4.0).abs() < 1e-12, "{segments:?}");
    }
}
