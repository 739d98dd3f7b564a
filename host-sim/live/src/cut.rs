//! The cut-away: tissue and probe are cut through the tip, and the half nearer to the eye is not
//! drawn. The face of the cut shows the mesh, the dent, the surface at rest and the nodule.

use eframe::egui::{Color32, FontId, Mesh, Painter, Pos2, Rect, Shape as Drawn, Stroke, vec2};
use palpate::Vector3;
use palpate_loop::live::Nodule;

use crate::camera::Lens;
use crate::drawn_body::DrawnBody;
use crate::message::Frame;
use crate::shown::{Shown, scale, screen};

type V = Vector3<f32>;
/// A position [m] and its colour, 0 .. 1.
pub(crate) type Corner = (V, [f32; 3]);

/// Brightness of the cut, a little less than that of the surface.
const LIT: f32 = 0.86;
/// Colour of the probe's metal where it is cut.
const METAL: [f32; 3] = [0.40, 0.44, 0.50];

/// A plane; everything in front of it is left out.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cut {
    at_m: V,
    /// Normal towards the eye, perpendicular to the probe's axis.
    normal: V,
}

impl Cut {
    /// Creates the cut that contains a point and an axis, facing the eye.
    pub fn through(at_m: V, axis: &V, lens: &Lens) -> Self {
        let to_eye = lens.eye_m() - at_m;
        let across = to_eye - axis * to_eye.dot(axis);
        Self { at_m, normal: across.try_normalize(1e-6).unwrap_or_else(|| -lens.along(axis)[1]) }
    }

    /// Distance in front of the plane [m].
    pub fn ahead_m(&self, x: &V) -> f32 {
        (x - self.at_m).dot(&self.normal)
    }

    /// The part of a convex polygon behind the plane; empty if the polygon is in front.
    pub fn kept(&self, corners: &[Corner]) -> Vec<Corner> {
        let mut kept = Vec::with_capacity(corners.len() + 1);
        for (k, (x, colour)) in corners.iter().enumerate() {
            let (next, its) = corners[(k + 1) % corners.len()];
            let (here_m, there_m) = (self.ahead_m(x), self.ahead_m(&next));
            if here_m <= 0.0 {
                kept.push((*x, *colour));
            }
            if (here_m <= 0.0) != (there_m <= 0.0) {
                let share = here_m / (here_m - there_m);
                kept.push((x + (next - x) * share, [0, 1, 2].map(|c| colour[c] + (its[c] - colour[c]) * share)));
            }
        }
        kept
    }

    /// Ends of the line along which the plane cuts a triangle [m].
    fn line(&self, corners: [V; 3]) -> Option<[V; 2]> {
        let crossed = [[0, 1], [1, 2], [2, 0]].into_iter().filter_map(|[a, b]| self.crossing(&corners[a], &corners[b]));
        match crossed.collect::<Vec<_>>().as_slice() {
            [(a, _), (b, _)] => Some([*a, *b]),
            _ => None,
        }
    }

    /// Point at which an edge crosses the plane [m], and its distance along the edge as a share of
    /// the edge.
    fn crossing(&self, a: &V, b: &V) -> Option<(V, f32)> {
        let (from_m, to_m) = (self.ahead_m(a), self.ahead_m(b));
        let share = from_m / (from_m - to_m);
        ((from_m <= 0.0) != (to_m <= 0.0)).then(|| (a + (b - a) * share, share))
    }

    /// Polygon in which the plane cuts a tet, with corners in order: their positions [m] and
    /// colours. Empty if the plane does not cut the tet.
    fn slice(&self, corners: [(V, f32); 4]) -> Vec<(V, f32)> {
        let (behind, ahead): (Vec<_>, Vec<_>) = corners.into_iter().partition(|(x, _)| self.ahead_m(x) <= 0.0);
        let pairs: &[[usize; 2]] = match (behind.len(), ahead.len()) {
            (1, 3) => &[[0, 0], [0, 1], [0, 2]],
            (3, 1) => &[[0, 0], [1, 0], [2, 0]],
            // around the quadrilateral, not along its diagonals
            (2, 2) => &[[0, 0], [0, 1], [1, 1], [1, 0]],
            _ => &[],
        };
        let at = |[b, a]: &[usize; 2]| {
            let ((x, from), (y, to)) = (behind[*b], ahead[*a]);
            self.crossing(&x, &y).map(|(place, share)| (place, from + (to - from) * share))
        };
        pairs.iter().filter_map(at).collect()
    }
}

/// Draws the face of the cut; `shares` are the colours of the nodes.
#[expect(clippy::too_many_arguments, reason = "as much as a picture shows")]
pub(crate) fn face(
    painter: &Painter,
    lens: &Lens,
    cut: &Cut,
    shape: &DrawnBody,
    frame: &Frame,
    shown: &Shown,
    shares: &[f32],
    nodules: &[Nodule],
) {
    let nodes_m: Vec<V> = frame.nodes_m.iter().map(|x| V::from(*x)).collect();
    let ink = if shown.dark { Color32::from_gray(235) } else { Color32::from_gray(25) };
    let thin = Stroke::new(0.6, Color32::from_rgba_unmultiplied(20, 24, 30, 100));
    let (mut filled, mut edges) = (Mesh::default(), Vec::new());
    for tet in &shape.body.tets {
        let slice = cut.slice(tet.map(|n| (nodes_m[usize::from(n)], shares[usize::from(n)])));
        let corners: Vec<(Pos2, Color32)> =
            slice.iter().filter_map(|(x, share)| Some((lens.project(x)?.0, screen(scale(*share).map(|c| c * LIT))))).collect();
        if corners.len() < 3 {
            continue;
        }
        fan(&mut filled, &corners);
        let ring = |k: usize| corners[k % corners.len()].0;
        edges.extend((0..corners.len()).map(|k| Drawn::line_segment([ring(k), ring(k + 1)], thin)));
    }
    painter.add(Drawn::mesh(filled));
    painter.extend(edges);
    // the surface at rest, then the present one, which covers it where it did not move
    let rest_m: Vec<V> = shape.body.rest_m.iter().map(|x| V::from(*x)).collect();
    let lines = |nodes_m: &[V], stroke: Stroke| {
        let triangles = shape.body.skin.iter().filter_map(|t| cut.line(t.map(|n| nodes_m[usize::from(n)])));
        for [a, b] in triangles {
            if let (Some((a, _)), Some((b, _))) = (lens.project(&a), lens.project(&b)) {
                painter.line_segment([a, b], stroke);
            }
        }
    };
    lines(&rest_m, Stroke::new(1.5, Color32::WHITE));
    lines(&nodes_m, Stroke::new(2.4, ink));
    nodules.iter().for_each(|nodule| ball(painter, lens, cut, nodule, &nodes_m, &rest_m));
}

/// Draws a nodule as a ball that moves with the tissue inside it.
fn ball(painter: &Painter, lens: &Lens, cut: &Cut, nodule: &Nodule, nodes_m: &[V], rest_m: &[V]) {
    let ([x, y], z) = (nodule.place_m, -nodule.depth_m);
    let (rest_of_it_m, radius_m) = (V::new(x as f32, y as f32, z as f32), nodule.radius_m as f32);
    let moved = |near_m: f32| {
        let inside = rest_m.iter().zip(nodes_m).filter(|(rest, _)| (**rest - rest_of_it_m).norm() <= near_m);
        inside.fold((V::zeros(), 0.0), |(sum, count), (rest, now)| (sum + (now - rest), count + 1.0))
    };
    // a ball smaller than the elements around it contains no node: the radius is then enlarged
    let all = [1.0, 2.0, 4.0].map(|times| moved(times * radius_m));
    let displacement_m = all.into_iter().find(|(_, count)| *count > 0.0).map_or(V::zeros(), |(sum, count)| sum / count);
    let centre_m = rest_of_it_m + displacement_m;
    let ahead_m = cut.ahead_m(&centre_m);
    let wide_m = (radius_m.powi(2) - ahead_m.powi(2)).max(0.0).sqrt();
    if wide_m == 0.0 {
        return;
    }
    let middle_m = centre_m - cut.normal * ahead_m;
    let up = if cut.normal.z.abs() < 0.9 { V::z() } else { V::x() };
    let aside = up.cross(&cut.normal).normalize();
    let up = cut.normal.cross(&aside);
    let ring = (0..=48_u8).filter_map(|k| {
        let turn = f32::from(k) * std::f32::consts::TAU / 48.0;
        lens.project(&(middle_m + (aside * turn.cos() + up * turn.sin()) * wide_m)).map(|p| p.0)
    });
    let red = Color32::from_rgb(170, 25, 25);
    painter.add(Drawn::line(ring.collect(), Stroke::new(2.0, red)));
    if let Some((pixel, _)) = lens.project(&(middle_m + aside * wide_m)) {
        // the name has a background, since the mesh would cross its letters
        let name = painter.layout_no_wrap("nodule".into(), FontId::proportional(13.0), red);
        let place = Rect::from_min_size(pixel + vec2(5.0, -0.5 * name.size().y), name.size());
        painter.rect_filled(place.expand(2.0), 3.0, Color32::from_white_alpha(200));
        painter.galley(place.min, name, red);
    }
}

/// Draws the cut face of a convex part of the probe, given the triangles of its surface.
pub(crate) fn metal(painter: &Painter, lens: &Lens, cut: &Cut, triangles: &[[V; 3]]) {
    let mut round: Vec<V> = triangles.iter().filter_map(|corners| cut.line(*corners)).flatten().collect();
    if round.len() < 3 {
        return;
    }
    let middle_m = round.iter().sum::<V>() / round.len() as f32;
    let Some(u) = (round[0] - middle_m).try_normalize(1e-9) else { return };
    let w = cut.normal.cross(&u);
    let turn = |x: &V| (x - middle_m).dot(&w).atan2((x - middle_m).dot(&u));
    round.sort_by(|a, b| turn(a).total_cmp(&turn(b)));
    let corners: Vec<_> = round.iter().filter_map(|x| Some((lens.project(x)?.0, screen(METAL)))).collect();
    let mut filled = Mesh::default();
    fan(&mut filled, &corners);
    painter.add(Drawn::mesh(filled));
}

/// Adds a convex polygon as triangles.
fn fan(mesh: &mut Mesh, corners: &[(Pos2, Color32)]) {
    let first = mesh.vertices.len() as u32;
    corners.iter().for_each(|(pixel, colour)| mesh.colored_vertex(*pixel, *colour));
    for k in 2..corners.len() as u32 {
        mesh.add_triangle(first, first + k - 1, first + k);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CUT: Cut = Cut { at_m: V::new(0.25, 0.0, 0.0), normal: V::new(1.0, 0.0, 0.0) };
    const CORNERS: [V; 4] = [V::new(0.0, 0.0, 0.0), V::new(1.0, 0.0, 0.0), V::new(0.0, 1.0, 0.0), V::new(1.0, 0.0, 1.0)];

    fn area(polygon: &[V]) -> f32 {
        let spokes = polygon.windows(2).skip(1).map(|pair| (pair[0] - polygon[0]).cross(&(pair[1] - polygon[0])));
        0.5 * spokes.sum::<V>().norm()
    }

    #[test]
    fn a_tet_is_cut_in_a_polygon_of_its_own_area() {
        // two corners are on each side of the plane
        let slice = CUT.slice(CORNERS.map(|x| (x, x.x)));
        assert_eq!(slice.len(), 4);
        assert!(slice.iter().all(|(x, share)| (x.x - 0.25).abs() < 1e-6 && (share - 0.25).abs() < 1e-6), "{slice:?}");
        // 0.75 wide along y and 0.25 along z: a rectangle, not a bow tie
        let area = area(&slice.iter().map(|(x, _)| *x).collect::<Vec<_>>());
        assert!((area - 0.75 * 0.25).abs() < 1e-6, "{area}");
        assert!(Cut { at_m: V::new(2.0, 0.0, 0.0), ..CUT }.slice(CORNERS.map(|x| (x, 0.0))).is_empty());
    }

    #[test]
    fn what_lies_in_front_is_not_kept() {
        let triangle = [CORNERS[0], CORNERS[1], CORNERS[2]].map(|x| (x, [x.x; 3]));
        let kept = CUT.kept(&triangle);
        assert!(kept.iter().all(|(x, colour)| x.x <= 0.2501 && (colour[0] - x.x).abs() < 1e-6), "{kept:?}");
        assert!((area(&kept.iter().map(|(x, _)| *x).collect::<Vec<_>>()) - (0.5 - 0.5 * 0.75 * 0.75)).abs() < 1e-6);
        let line = CUT.line([CORNERS[0], CORNERS[1], CORNERS[2]]).unwrap();
        assert!(((line[0] - line[1]).norm() - 0.75).abs() < 1e-6);
    }
}
