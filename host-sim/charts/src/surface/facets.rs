//! Divides the surface into small pieces of uniform colour, sorted from far to near.

use super::view::{V3, View};
use crate::style::FINE;

/// A triangle of the mesh that faces the eye.
pub struct Face {
    /// The whole face in its mean colour.
    pub whole: Facet,
    /// Pieces of the face; empty where one colour is enough.
    pub parts: Vec<Facet>,
}

/// A piece of a face that is small enough for a uniform colour.
pub struct Facet {
    /// Corners [canvas units].
    pub corners: [(f64, f64); 3],
    /// Magnitude of the tissue's displacement, averaged over the facet [m].
    pub moved_m: f64,
    /// Brightness from 0 (dark) to 1.
    pub light: f64,
    /// Coordinate of the middle of the facet along the direction to the eye [m]; larger is nearer.
    pub near: f64,
}

/// A surface that is to be divided into facets.
#[derive(Clone, Copy)]
pub struct Skin<'a> {
    /// Node positions [m].
    pub places_m: &'a [[f64; 3]],
    /// Nodes of each triangle, counter-clockwise seen from outside.
    pub triangles: &'a [[u32; 3]],
    /// Magnitude of the displacement of each node [m].
    pub moved_m: &'a [f64],
    /// Displacement at the upper end of the colour scale [m].
    pub scale_m: f64,
    /// Unit vector toward the lamp.
    pub lamp: V3,
    /// Largest allowed side of a part [px]; infinite if only colour and light limit its size.
    pub largest_px: f64,
}

impl Facet {
    /// Corners moved by `margin` away from the middle of the facet [canvas units].
    pub fn grown(&self, margin: f64) -> [(f64, f64); 3] {
        let x = self.corners.iter().map(|p| p.0).sum::<f64>() / 3.0;
        let y = self.corners.iter().map(|p| p.1).sum::<f64>() / 3.0;
        self.corners.map(|p| {
            let (dx, dy) = (p.0 - x, p.1 - y);
            let by = 1.0 + margin / dx.hypot(dy).max(1.0);
            (x + dx * by, y + dy * by)
        })
    }
}

/// Cosine of 40 degrees: two adjacent faces whose normals differ by more meet in a sharp edge, and
/// the normals are not smoothed across it.
const CREASE: f64 = 0.766;

/// Number of facets over which colour or light passes through its whole range.
const SHADES: f64 = 24.0;

/// Smallest side of a facet [px]; smaller ones are not divided further.
const SMALLEST_PX: f64 = 6.0;

/// Direction to a lamp low at the left, which gives even a shallow dent a bright and a dark side.
pub fn low_lamp(view: &View) -> V3 {
    lamp(view, [-0.75, 0.42, 0.4])
}

/// Direction to a lamp behind the viewer's left shoulder, which lights everything that is visible.
pub fn high_lamp(view: &View) -> V3 {
    lamp(view, [-0.45, 0.4, 0.8])
}

/// Unit vector with components to the right, upward and toward the eye.
fn lamp(view: &View, [right, up, near]: [f64; 3]) -> V3 {
    (view.eye * near + view.up * up + view.right * right).try_normalize(0.0).unwrap_or(view.eye)
}

/// The faces that are turned toward the eye, sorted from far to near.
pub fn faces(skin: &Skin, view: &View) -> Vec<Face> {
    let normals = corner_normals(skin);
    let mut all = Vec::new();
    for (triangle, normals) in skin.triangles.iter().zip(normals) {
        let corner = |k: usize| {
            let node = triangle[k] as usize;
            Some(Corner {
                at: V3::from(*skin.places_m.get(node)?),
                moved_m: *skin.moved_m.get(node)?,
                light: normals[k].dot(&skin.lamp).max(0.0),
            })
        };
        let (Some(a), Some(b), Some(c)) = (corner(0), corner(1), corner(2)) else {
            continue;
        };
        if (b.at - a.at).cross(&(c.at - a.at)).dot(&view.eye) > 0.0 {
            all.push(Face { whole: facet([a, b, c], view), parts: split([a, b, c], skin, view) });
        }
    }
    all.sort_by(|a, b| a.whole.near.total_cmp(&b.whole.near));
    all
}

#[derive(Clone, Copy)]
struct Corner {
    at: V3,
    moved_m: f64,
    light: f64,
}

fn split(corners: [Corner; 3], skin: &Skin, view: &View) -> Vec<Facet> {
    let range = |of: fn(&Corner) -> f64| {
        let (low, high) =
            corners.iter().map(of).fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        high - low
    };
    let colour = range(|c| c.moved_m) / skin.scale_m;
    let [a, b, c] = corners.map(|c| c.at);
    let side = (b - a).norm().max((c - b).norm()).max((a - c).norm());
    let room = view.scale * side / (SMALLEST_PX * f64::from(FINE));
    let least = view.scale * side / (skin.largest_px * f64::from(FINE));
    let parts = (SHADES * colour.max(range(|c| c.light))).min(room).max(least).ceil().clamp(1.0, 64.0) as u32;

    let mix = |i: u32, j: u32| {
        let (u, v) = (f64::from(i) / f64::from(parts), f64::from(j) / f64::from(parts));
        let lerp = |a: f64, b: f64, c: f64| a + u * (b - a) + v * (c - a);
        let [a, b, c] = &corners;
        Corner {
            at: a.at + (b.at - a.at) * u + (c.at - a.at) * v,
            moved_m: lerp(a.moved_m, b.moved_m, c.moved_m),
            light: lerp(a.light, b.light, c.light),
        }
    };
    if parts == 1 {
        return Vec::new();
    }
    let mut facets = Vec::new();
    for i in 0..parts {
        for j in 0..parts - i {
            facets.push(facet([mix(i, j), mix(i + 1, j), mix(i, j + 1)], view));
            if i + j + 1 < parts {
                facets.push(facet([mix(i + 1, j), mix(i + 1, j + 1), mix(i, j + 1)], view));
            }
        }
    }
    facets
}

fn facet(corners: [Corner; 3], view: &View) -> Facet {
    let mean = |of: fn(&Corner) -> f64| corners.iter().map(of).sum::<f64>() / 3.0;
    let near = corners.iter().map(|c| c.at.dot(&view.eye)).sum::<f64>() / 3.0;
    Facet { corners: corners.map(|c| view.at(c.at)), moved_m: mean(|c| c.moved_m), light: mean(|c| c.light), near }
}

/// Unit normals at the three corners of every triangle, smoothed over bends but not across sharp
/// edges.
fn corner_normals(surface: &Skin) -> Vec<[V3; 3]> {
    let place = |node: u32| surface.places_m.get(node as usize).copied().map_or_else(V3::zeros, V3::from);
    let faces: Vec<V3> = (surface.triangles.iter()).map(|t| t.map(place)).map(|[a, b, c]| (b - a).cross(&(c - a))).collect();
    let mut around = vec![Vec::new(); surface.places_m.len()];
    for (face, triangle) in faces.iter().zip(surface.triangles) {
        for node in triangle {
            if let Some(around) = around.get_mut(*node as usize) {
                around.push(*face);
            }
        }
    }
    let normal = |own: V3, node: u32| {
        let around = around.get(node as usize).into_iter().flatten();
        let bent = around.filter(|face| own.dot(face) >= CREASE * own.norm() * face.norm());
        bent.sum::<V3>().try_normalize(0.0).unwrap_or_default()
    };
    (faces.iter().zip(surface.triangles)).map(|(own, triangle)| triangle.map(|node| normal(*own, node))).collect()
}
