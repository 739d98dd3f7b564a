//! The body as it is drawn: its boundary, displacement and compression of its nodes, and its
//! intersections with rays.

use palpate::Vector3;
use palpate_tissue::mesh::surface;

use crate::message::{Body, Frame};

type V = Vector3<f32>;

/// Geometry computed once from a body.
#[derive(Clone, Debug, Default)]
pub struct DrawnBody {
    /// The body that is drawn.
    pub body: Body,
    /// Whole boundary of the body, counter-clockwise seen from outside.
    pub boundary: Vec<[usize; 3]>,
    /// Indices of the boundary triangles at each node.
    around: Vec<Vec<usize>>,
    six_volumes_m3: Vec<f32>,
}

impl DrawnBody {
    /// Prepares a body for drawing.
    #[must_use]
    pub fn of(body: Body) -> Self {
        let tets: Vec<[u32; 4]> = body.tets.iter().map(|t| t.map(u32::from)).collect();
        let boundary: Vec<[usize; 3]> = surface::surface(&tets).iter().map(|t| t.map(|n| n as usize)).collect();
        let mut around = vec![Vec::new(); body.rest_m.len()];
        for (face, corners) in boundary.iter().enumerate() {
            corners.iter().for_each(|n| around[*n].push(face));
        }
        let six_volumes_m3 = body.tets.iter().map(|t| six_volume_m3(t, &body.rest_m)).collect();
        Self { body, boundary, around, six_volumes_m3 }
    }

    /// Middle [m] and longest side [m] of the body.
    #[must_use]
    pub fn extent_m(&self) -> (V, f32) {
        let all = || self.body.rest_m.iter().map(|x| V::from(*x));
        let Some(first) = all().next() else { return (V::zeros(), 0.1) };
        let (low, high) = all().fold((first, first), |(l, h), x| (l.inf(&x), h.sup(&x)));
        ((low + high) * 0.5, (high - low).max())
    }

    /// Area normals of the boundary [m^2]; their length is twice the area.
    #[must_use]
    pub fn normals(&self, nodes_m: &[V]) -> Vec<V> {
        self.boundary.iter().map(|&[a, b, c]| (nodes_m[b] - nodes_m[a]).cross(&(nodes_m[c] - nodes_m[a]))).collect()
    }

    /// Normal at a node of a triangle with normal `own`: smooth where the surface is, but not
    /// across a sharp edge.
    #[must_use]
    pub fn normal(&self, node: usize, own: &V, normals: &[V]) -> V {
        let near = self.around[node].iter().map(|f| normals[*f]).filter(|n| n.dot(own) > 0.7 * n.norm());
        near.sum::<V>().try_normalize(0.0).unwrap_or(*own)
    }

    /// Volume of each node's tets over their volume at rest (1).
    #[must_use]
    pub fn j(&self, nodes_m: &[[f32; 3]]) -> Vec<f32> {
        let (mut now, mut rest) = (vec![0.0; nodes_m.len()], vec![0.0; nodes_m.len()]);
        for (tet, rest_m3) in self.body.tets.iter().zip(&self.six_volumes_m3) {
            let now_m3 = six_volume_m3(tet, nodes_m);
            for n in tet.map(usize::from) {
                if let (Some(a), Some(b)) = (now.get_mut(n), rest.get_mut(n)) {
                    (*a, *b) = (*a + now_m3, *b + rest_m3);
                }
            }
        }
        now.iter().zip(rest).map(|(a, b)| if b == 0.0 { 1.0 } else { a / b }).collect()
    }

    /// Mean pressure on the skin around each node [Pa]; zero without a contact map.
    #[must_use]
    pub fn pressure_pa(&self, frame: &Frame) -> Vec<f32> {
        let mut sums = vec![(0.0, 0.0); self.body.rest_m.len()];
        let pressures = frame.map.iter().flat_map(|map| &map.pressure_pa);
        for (corners, pressure_pa) in self.body.skin.iter().zip(pressures) {
            for n in corners.map(usize::from) {
                if let Some((sum, count)) = sums.get_mut(n) {
                    (*sum, *count) = (*sum + pressure_pa, *count + 1.0);
                }
            }
        }
        sums.into_iter().map(|(sum, count)| if count > 0.0 { sum / count } else { 0.0 }).collect()
    }

    /// Distance of each node from its position at rest [m].
    #[must_use]
    pub fn moved_m(&self, nodes_m: &[[f32; 3]]) -> Vec<f32> {
        nodes_m.iter().zip(&self.body.rest_m).map(|(x, rest)| (V::from(*x) - V::from(*rest)).norm()).collect()
    }

    /// Point at which a ray first meets the skin at rest, on the side of the probe [m].
    #[must_use]
    pub fn meets(&self, from_m: &V, ray: &V) -> Option<V> {
        let axis = V::from(self.body.axis);
        let at = |n: u16| self.body.rest_m.get(usize::from(n)).map(|x| V::from(*x));
        let mut nearest: Option<f32> = None;
        for triangle in &self.body.skin {
            let [Some(a), Some(b), Some(c)] = triangle.map(at) else { continue };
            let normal = (b - a).cross(&(c - a));
            if normal.dot(&axis) < 0.3 * normal.norm() {
                continue;
            }
            if let Some(displacement_m) = along(from_m, ray, [a, b, c])
                && nearest.is_none_or(|n| displacement_m < n)
            {
                nearest = Some(displacement_m);
            }
        }
        nearest.map(|displacement_m| from_m + ray * displacement_m)
    }
}

fn six_volume_m3(tet: &[u16; 4], nodes_m: &[[f32; 3]]) -> f32 {
    let at = |n: u16| nodes_m.get(usize::from(n)).map_or_else(V::zeros, |x| V::from(*x));
    let [a, b, c, d] = tet.map(at);
    (b - a).cross(&(c - a)).dot(&(d - a))
}

/// Distance along a ray to a triangle, after Moeller and Trumbore.
fn along(from: &V, ray: &V, [a, b, c]: [V; 3]) -> Option<f32> {
    let (e1, e2) = (b - a, c - a);
    let p = ray.cross(&e2);
    let det = e1.dot(&p);
    if det.abs() < 1e-12 {
        return None;
    }
    let t = from - a;
    let u = t.dot(&p) / det;
    let q = t.cross(&e1);
    let v = ray.dot(&q) / det;
    let way = e2.dot(&q) / det;
    (u >= -1e-4 && v >= -1e-4 && u + v <= 1.0001 && way > 0.0).then_some(way)
}
