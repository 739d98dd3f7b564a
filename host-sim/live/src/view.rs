//! The picture of the tissue: shaded triangles, drawn from far to near, and over them probe,
//! springs, rim and force.

use eframe::egui::{Color32, Mesh, Painter, Pos2, Rect, Shape as Drawn, Stroke, pos2, vec2};
use palpate::Vector3;
use palpate_loop::live::Nodule;

use crate::camera::Lens;
use crate::cut::{self, Corner, Cut};
use crate::drawn_body::DrawnBody;
use crate::message::{Frame, Tip};
use crate::shown::{Colour, LEAST_J, Shown, scale, screen};

type V = Vector3<f32>;

/// Length of the force arrow [probe radii per newton].
const RADII_PER_N: f32 = 6.0;

/// A triangle that is ready to be drawn.
struct Facet {
    corners: [(Pos2, Color32); 3],
    far_m: f32,
}

/// The cut-away, if it is shown.
pub(crate) fn cut(lens: &Lens, shape: &DrawnBody, frame: &Frame, shown: &Shown) -> Option<Cut> {
    shown.cut.then(|| Cut::through(frame.tip_m.into(), &shape.body.axis.into(), lens))
}

/// Draws the picture with the `nodules` that may be visible; returns the number of triangles.
pub fn draw(painter: &Painter, lens: &Lens, shape: &DrawnBody, frame: &Frame, shown: &Shown, nodules: &[Nodule]) -> usize {
    if frame.nodes_m.len() != shape.body.rest_m.len() || frame.nodes_m.is_empty() {
        return 0;
    }
    let cut = cut(lens, shape, frame, shown);
    let shares: Vec<f32> = match shown.colour {
        Colour::Displacement => shape.moved_m(&frame.nodes_m).iter().map(|m| m / shown.most_m).collect(),
        Colour::J => shape.j(&frame.nodes_m).iter().map(|j| (1.0 - j) / (1.0 - LEAST_J)).collect(),
        Colour::Pressure => shape.pressure_pa(frame).iter().map(|pa| pa / shown.most_pa).collect(),
    };
    let mut facets = Vec::with_capacity(shape.boundary.len() + 200);
    tissue(&mut facets, lens, shape, frame, &shares, cut.as_ref());
    let parts = probe(&mut facets, lens, shape, frame, cut.as_ref());
    facets.sort_unstable_by(|a, b| b.far_m.total_cmp(&a.far_m));
    let mut mesh = Mesh::default();
    mesh.reserve_triangles(facets.len());
    mesh.reserve_vertices(3 * facets.len());
    for facet in &facets {
        let at = mesh.vertices.len() as u32;
        facet.corners.iter().for_each(|(pixel, colour)| mesh.colored_vertex(*pixel, *colour));
        mesh.add_triangle(at, at + 1, at + 2);
    }
    painter.add(Drawn::mesh(mesh));
    if let Some(cut) = &cut {
        // everything that is kept is behind the cut, so nothing hides its face
        parts.iter().for_each(|part| cut::metal(painter, lens, cut, part));
        cut::face(painter, lens, cut, shape, frame, shown, &shares, nodules);
    }
    let kept = |x: &V| cut.is_none_or(|cut| cut.ahead_m(x) <= 0.0);
    if shown.springs {
        springs(painter, lens, shape, frame, shown, &kept);
    }
    if shown.rim {
        rim(painter, lens, shape, frame, &kept);
    }
    if shown.colour == Colour::Pressure {
        ellipse(painter, lens, frame);
    }
    force(painter, lens, shape, frame, shown);
    facets.len()
}

fn tissue(facets: &mut Vec<Facet>, lens: &Lens, shape: &DrawnBody, frame: &Frame, shares: &[f32], cut: Option<&Cut>) {
    let nodes_m: Vec<V> = frame.nodes_m.iter().map(|x| V::from(*x)).collect();
    let normals = shape.normals(&nodes_m);
    let light = lens.light();
    for (&corners, own) in shape.boundary.iter().zip(&normals) {
        let [a, b, c] = corners.map(|n| nodes_m[n]);
        let middle = (a + b + c) / 3.0;
        if own.dot(&(lens.eye_m() - middle)) <= 0.0 {
            continue;
        }
        let own = own.normalize();
        let vertex = |n: usize| {
            let normal = shape.normal(n, &own, &normals);
            let lit = 0.48 + 0.52 * normal.dot(&light).max(0.0);
            (nodes_m[n], scale(shares[n]).map(|k| k * lit))
        };
        push(facets, lens, corners.map(vertex), cut);
    }
}

/// Adds the part of a triangle that the cut leaves.
fn push(facets: &mut Vec<Facet>, lens: &Lens, corners: [Corner; 3], cut: Option<&Cut>) {
    let mut add = |corners: [Corner; 3]| {
        let drawn = corners.map(|(x, colour)| lens.project(&x).map(|(pixel, far_m)| ((pixel, screen(colour)), far_m)));
        if let [Some(a), Some(b), Some(c)] = drawn {
            facets.push(Facet { corners: [a.0, b.0, c.0], far_m: (a.1 + b.1 + c.1) / 3.0 });
        }
    };
    match cut {
        None => add(corners),
        Some(cut) => {
            let kept = cut.kept(&corners);
            kept.windows(2).skip(1).for_each(|pair| add([kept[0], pair[0], pair[1]]));
        }
    }
}

/// Adds the tip and its handle; returns all triangles of each, also those that are not visible.
fn probe(facets: &mut Vec<Facet>, lens: &Lens, shape: &DrawnBody, frame: &Frame, cut: Option<&Cut>) -> [Vec<[V; 3]>; 2] {
    const ROUND: usize = 32;
    let (axis, radius_m, tip_m) = (V::from(shape.body.axis), shape.body.radius_m, V::from(frame.tip_m));
    let aside = if axis.x.abs() < 0.9 { V::x() } else { V::y() };
    let u = axis.cross(&aside).normalize();
    let w = axis.cross(&u);
    let arcs = |last: u8| (0..=last).map(|k| f32::from(k) * std::f32::consts::FRAC_PI_2 / 5.0).map(|a| (1.0 - a.cos(), a.sin()));
    // rings as (height above the tip, radius), from the tip upwards
    let body: Vec<(f32, f32)> = match shape.body.tip {
        Tip::Flat => vec![(0.0, 0.0), (0.0, 1.0), (1.7, 1.0)],
        Tip::Ball => arcs(5).chain([(1.7, 1.0)]).collect(),
        Tip::Capsule { .. } | Tip::Ellipsoid { .. } => arcs(10).collect(),
    };
    let handle: Vec<(f32, f32)> = match shape.body.tip {
        Tip::Flat | Tip::Ball => vec![(1.7, 1.0), (2.1, 0.4), (3.0, 0.4), (3.0, 0.0)],
        Tip::Capsule { .. } | Tip::Ellipsoid { .. } => vec![(1.8, 0.4), (3.0, 0.4), (3.0, 0.0)],
    };
    let light = lens.light();
    let round = |k: usize| {
        let turn = (k % ROUND) as f32 * std::f32::consts::TAU / ROUND as f32;
        (turn.cos(), turn.sin())
    };
    let on_handle = |(height, wide): (f32, f32), k: usize| {
        let (cos, sin) = round(k);
        tip_m + axis * (height * radius_m) + (u * cos + w * sin) * (wide * radius_m)
    };
    let on_body = |ring: (f32, f32), k: usize| {
        let (cos, sin) = round(k);
        match shape.body.tip {
            Tip::Flat | Tip::Ball => on_handle(ring, k),
            Tip::Capsule { half_m } => {
                let half_m = V::from(half_m);
                let ball_m = on_handle(ring, k);
                ball_m + half_m * 1.0_f32.copysign((u * cos + w * sin).dot(&half_m))
            }
            Tip::Ellipsoid { semi_axes_m: [a, b] } => {
                tip_m + axis * (ring.0 * radius_m) + (V::from(a) * cos + V::from(b) * sin) * ring.1
            }
        }
    };
    type Place<'a> = &'a dyn Fn((f32, f32), usize) -> V;
    let parts: [(&[(f32, f32)], Place<'_>); 2] = [(&body, &on_body), (&handle, &on_handle)];
    let mut around = [Vec::new(), Vec::new()];
    let strips = parts.into_iter().enumerate();
    for (part, pair, at) in strips.flat_map(|(part, (rings, at))| rings.windows(2).map(move |pair| (part, pair, at))) {
        for k in 0..ROUND {
            let [a, b, c, d] = [at(pair[0], k), at(pair[0], k + 1), at(pair[1], k + 1), at(pair[1], k)];
            for corners in [[a, c, b], [a, d, c]] {
                let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
                let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
                let Some(mut normal) = normal.try_normalize(1e-12) else { continue };
                around[part].push(corners);
                let mut out = middle - (tip_m + axis * (axis.dot(&(middle - tip_m))).max(radius_m));
                if let Tip::Capsule { half_m } = shape.body.tip {
                    let half_m = V::from(half_m);
                    let share = out.dot(&half_m) / half_m.norm_squared().max(f32::MIN_POSITIVE);
                    out -= half_m * share.clamp(-1.0, 1.0);
                }
                if normal.dot(&out) < 0.0 {
                    normal = -normal;
                }
                if normal.dot(&(lens.eye_m() - middle)) <= 0.0 {
                    continue;
                }
                let lit = 0.35 + 0.65 * normal.dot(&light).max(0.0);
                let colour = [0.62, 0.66, 0.72].map(|k| k * lit);
                push(facets, lens, corners.map(|x| (x, colour)), cut);
            }
        }
    }
    around
}

/// Returns whether a position [m] is on the side of the cut that is drawn.
type Kept<'a> = &'a dyn Fn(&V) -> bool;

fn springs(painter: &Painter, lens: &Lens, shape: &DrawnBody, frame: &Frame, shown: &Shown, kept: Kept<'_>) {
    let ink = if shown.dark {
        Color32::from_rgba_unmultiplied(235, 240, 245, 70)
    } else {
        Color32::from_rgba_unmultiplied(20, 24, 30, 70)
    };
    let places = |n: u16| frame.nodes_m.get(usize::from(n)).map(|x| V::from(*x));
    let at = |n: u16| places(n).filter(kept).and_then(|x| lens.project(&x));
    for [i, j] in &shape.body.springs {
        if let (Some((a, _)), Some((b, _))) = (at(*i), at(*j)) {
            painter.line_segment([a, b], Stroke::new(0.6, ink));
        }
    }
}

fn rim(painter: &Painter, lens: &Lens, shape: &DrawnBody, frame: &Frame, kept: Kept<'_>) {
    let dots = |nodes: &[u16], colour: Color32| {
        for n in nodes {
            let place = frame.nodes_m.get(usize::from(*n)).map(|x| V::from(*x)).filter(kept);
            if let Some((pixel, _)) = place.and_then(|x| lens.project(&x)) {
                painter.circle_filled(pixel, 2.6, colour);
            }
        }
    };
    dots(&shape.body.anchors, Color32::from_rgb(40, 44, 52));
    dots(&shape.body.rim, Color32::from_rgb(200, 75, 30));
}

/// Draws the ellipse of the contact, over everything that hides it.
fn ellipse(painter: &Painter, lens: &Lens, frame: &Frame) {
    let Some(map) = frame.map.as_ref().filter(|map| map.area_m2 > 0.0) else { return };
    let [a, b] = map.half_axes_m.map(V::from);
    let ring = (0..=48_u8).filter_map(|k| {
        let turn = f32::from(k) * std::f32::consts::TAU / 48.0;
        lens.project(&(V::from(map.centre_m) + a * turn.cos() + b * turn.sin())).map(|p| p.0)
    });
    painter.add(Drawn::line(ring.collect(), Stroke::new(2.0, Color32::from_rgb(190, 30, 20))));
}

/// Share of the line from `a` to `b` that is inside the picture, so that the arrow of a strong
/// force keeps its head and its number.
fn share_inside(rect: Rect, a: Pos2, b: Pos2) -> f32 {
    let along = |from: f32, to: f32, low: f32, high: f32| {
        let end = if to > high { high } else { low };
        if (low..=high).contains(&to) { 1.0 } else { ((end - from) / (to - from)).max(0.0) }
    };
    along(a.x, b.x, rect.left(), rect.right()).min(along(a.y, b.y, rect.top(), rect.bottom())).min(1.0)
}

fn force(painter: &Painter, lens: &Lens, shape: &DrawnBody, frame: &Frame, shown: &Shown) {
    let force_n = V::from(frame.force_n);
    let length_n = force_n.norm();
    if length_n < 1e-3 {
        return;
    }
    let radius_m = shape.body.radius_m;
    // the arrow begins beside the handle, which would hide it
    let from_m = V::from(frame.contact_m);
    let displacement_m = force_n / length_n * (radius_m * (1.2 + RADII_PER_N * length_n).min(12.0));
    let (Some((a, _)), Some((b, _))) = (lens.project(&from_m), lens.project(&(from_m + displacement_m))) else { return };
    let b = a + (b - a) * share_inside(painter.clip_rect().shrink2(vec2(70.0, 20.0)), a, b);
    let red = if shown.dark { Color32::from_rgb(255, 110, 90) } else { Color32::from_rgb(190, 30, 20) };
    let along = (b - a).normalized();
    let across = along.rot90();
    painter.line_segment([a, b - along * 8.0], Stroke::new(4.0, red));
    let head = vec![b, b - along * 14.0 + across * 7.0, b - along * 14.0 - across * 7.0];
    painter.add(Drawn::convex_polygon(head, red, Stroke::NONE));
    painter.text(
        pos2(b.x + 8.0, b.y),
        eframe::egui::Align2::LEFT_CENTER,
        format!("{length_n:.3} N"),
        eframe::egui::FontId::proportional(15.0),
        red,
    );
}
