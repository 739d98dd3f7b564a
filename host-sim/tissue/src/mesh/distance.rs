//! Signed distance to a closed surface of triangles, such as that of a tet mesh.
//!
//! The nearest triangle is found in a hierarchy of boxes. The sign is that of the angle-weighted
//! normal at the nearest point, which is a corner or lies on a side or a face (Baerentzen and
//! Aanaes 2005, "Signed distance computation using the angle weighted pseudonormal", IEEE TVCG
//! 11:243). It is correct in front of any edge of a closed surface, where the normal of a single
//! triangle may give the wrong sign.

use nalgebra::Vector3;

use super::triangle::nearest_on_triangle;
use super::{TetMesh, surface};

type V3 = Vector3<f64>;

/// Largest number of triangles in a box that is not divided further.
const LEAF: usize = 4;

/// A closed surface of flat triangles.
#[derive(Clone, Debug)]
pub struct ClosedSurface {
    pub(super) facets: Vec<Facet>,
    pub(super) boxes: Vec<Bounds>,
    hollows: usize,
}

#[derive(Clone, Debug)]
pub(super) struct Facet {
    /// Index in the list of triangles that the surface was made of.
    pub triangle: u32,
    pub corners: [V3; 3],
    /// Whether the triangle is part of the wall of a cavity.
    is_inner: bool,
    /// Outward unit normal of the face.
    normal: V3,
    /// For side `k`, from corner `k` to the next: the sum of the normals of its two faces.
    at_sides: [V3; 3],
    /// For each corner, the sum of the normals of the faces around it, weighted by their angles.
    at_corners: [V3; 3],
}

/// A box of the hierarchy with its range of facets. Its first half is the next box in the list,
/// `second` is the index of its other half, or 0 for a box that is not divided.
#[derive(Clone, Debug)]
pub(super) struct Bounds {
    pub low: V3,
    pub high: V3,
    pub facets: std::ops::Range<usize>,
    pub second: usize,
}

/// Point of a surface that is nearest to a given point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foot {
    /// Position of the nearest point [m].
    pub at_m: [f64; 3],
    /// Distance to the surface [m], negative inside.
    pub distance_m: f64,
    /// Number of boxes and triangles that were looked at, to which the time is proportional.
    pub looked_at: usize,
}

/// The facet that is nearest to a point.
struct Nearest {
    /// Square of the distance to it [m^2].
    squared: f64,
    /// Index of the facet.
    facet: usize,
    /// Place on it, by the weights of its corners.
    at: [f64; 3],
    looked_at: usize,
}

impl ClosedSurface {
    /// The surface of a mesh whose tets are positively oriented; `None` if there are no tets.
    #[must_use]
    pub fn of(mesh: &TetMesh) -> Option<Self> {
        Self::of_triangles(&mesh.nodes_m, &surface::surface(&mesh.tets))
    }

    /// The surface of triangles that are counter-clockwise seen from outside, and each of whose
    /// edges is in two of them; `None` if there are no triangles. A triangle without area has no
    /// normal of its own.
    #[must_use]
    pub fn of_triangles(nodes_m: &[[f64; 3]], triangles: &[[u32; 3]]) -> Option<Self> {
        let place = |n: u32| V3::from(nodes_m[n as usize]);
        let normals: Vec<V3> = triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(place);
                (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_default()
            })
            .collect();
        let mut at_corners = vec![V3::zeros(); nodes_m.len()];
        let mut sides = Vec::with_capacity(3 * triangles.len());
        for (index, (t, normal)) in (0..).zip(triangles.iter().zip(&normals)) {
            for k in 0..3 {
                let [n, next, last] = [0, 1, 2].map(|step| t[(k + step) % 3]);
                let angle = (place(next) - place(n)).angle(&(place(last) - place(n)));
                at_corners[n as usize] += normal * angle;
                sides.push(([n.min(next), n.max(next)], 3 * index + k as u32));
            }
        }
        sides.sort_unstable();
        let mut at_sides = vec![V3::zeros(); sides.len()];
        for edge in sides.chunk_by(|a, b| a.0 == b.0) {
            let sum = edge.iter().fold(V3::zeros(), |sum, (_, side)| sum + normals[*side as usize / 3]);
            edge.iter().for_each(|(_, side)| at_sides[*side as usize] = sum);
        }
        let walls = surface::walls(nodes_m, triangles);
        let facets = (0..).zip(triangles.iter().zip(&normals)).map(|(triangle, (t, normal))| Facet {
            triangle,
            corners: t.map(place),
            is_inner: walls.is_inner[triangle as usize],
            normal: *normal,
            at_sides: [0, 1, 2].map(|k| at_sides[3 * triangle as usize + k]),
            at_corners: t.map(|n| at_corners[n as usize]),
        });
        let mut own = Self { facets: facets.collect(), boxes: Vec::new(), hollows: walls.hollows };
        let all = 0..own.facets.len();
        if all.is_empty() {
            return None;
        }
        let mut order: Vec<u32> = (0..own.facets.len() as u32).collect();
        own.divide(all, &mut order);
        own.facets = order.iter().map(|n| own.facets[*n as usize].clone()).collect();
        Some(own)
    }

    /// Lowest and highest corner [m] of the box around the surface.
    #[must_use]
    pub fn bounds_m(&self) -> [[f64; 3]; 2] {
        [self.boxes[0].low.into(), self.boxes[0].high.into()]
    }

    /// Corners of the triangles, counter-clockwise seen from outside [m].
    pub fn triangles_m(&self) -> impl Iterator<Item = [V3; 3]> {
        self.facets.iter().map(|facet| facet.corners)
    }

    /// The triangles in the order of the list that the surface was made of, and whether each is
    /// part of the wall of a cavity.
    #[must_use]
    pub fn in_order_m(&self) -> Vec<([V3; 3], bool)> {
        let mut facets: Vec<&Facet> = self.facets.iter().collect();
        facets.sort_unstable_by_key(|facet| facet.triangle);
        facets.into_iter().map(|facet| (facet.corners, facet.is_inner)).collect()
    }

    /// Number of cavities.
    #[must_use]
    pub fn hollows(&self) -> usize {
        self.hollows
    }

    /// Whether the part of the surface nearest to a place is the wall of a cavity, and its outward
    /// unit normal.
    #[must_use]
    pub fn wall(&self, at_m: [f64; 3]) -> (bool, [f64; 3]) {
        let facet = &self.facets[self.nearest(&V3::from(at_m)).facet];
        (facet.is_inner, facet.normal.into())
    }

    /// Nearest point of the surface, and signed distance to it.
    #[must_use]
    pub fn foot(&self, at_m: [f64; 3]) -> Foot {
        let point = V3::from(at_m);
        let Nearest { squared, facet, at, looked_at } = self.nearest(&point);
        let foot = self.facets[facet].place(at);
        let outside = (point - foot).dot(&self.facets[facet].normal_at(at)) >= 0.0;
        Foot { at_m: foot.into(), distance_m: if outside { squared.sqrt() } else { -squared.sqrt() }, looked_at }
    }

    fn nearest(&self, point: &V3) -> Nearest {
        let mut best = Nearest { squared: f64::INFINITY, facet: 0, at: [1.0, 0.0, 0.0], looked_at: 0 };
        let mut open = vec![(0, 0.0)];
        while let Some((index, least)) = open.pop() {
            let own = &self.boxes[index];
            if least >= best.squared {
                continue;
            }
            best.looked_at += 1;
            if own.second != 0 {
                let halves = [index + 1, own.second].map(|half| (half, self.boxes[half].squared_to(point)));
                let [near, far] = if halves[0].1 <= halves[1].1 { halves } else { [halves[1], halves[0]] };
                open.extend([far, near]);
                continue;
            }
            for n in own.facets.clone() {
                let facet = &self.facets[n];
                let at = nearest_on_triangle(&facet.corners, point);
                let squared = (facet.place(at) - point).norm_squared();
                best.looked_at += 1;
                if squared < best.squared {
                    best = Nearest { squared, facet: n, at, ..best };
                }
            }
        }
        best
    }

    /// Divides a range of the `order` of facets, which is sorted for that; the facets, which are
    /// larger than their numbers, stay where they are.
    fn divide(&mut self, facets: std::ops::Range<usize>, order: &mut [u32]) {
        let corners = order[facets.clone()].iter().flat_map(|n| self.facets[*n as usize].corners);
        let (low, high) = corners.fold((V3::repeat(f64::INFINITY), V3::repeat(f64::NEG_INFINITY)), |(low, high), x| {
            (low.zip_map(&x, |a, b| if b < a { b } else { a }), high.zip_map(&x, |a, b| if b > a { b } else { a }))
        });
        let own = self.boxes.len();
        self.boxes.push(Bounds { low, high, facets: facets.clone(), second: 0 });
        if facets.len() <= LEAF {
            return;
        }
        let axis = (high - low).imax();
        let mut along: Vec<(f64, u32)> =
            order[facets.clone()].iter().map(|n| (self.facets[*n as usize].middle(axis), *n)).collect();
        along.sort_by(|a, b| a.0.total_cmp(&b.0));
        order[facets.clone()].iter_mut().zip(along).for_each(|(n, (_, sorted))| *n = sorted);
        let middle = facets.start.midpoint(facets.end);
        self.divide(facets.start..middle, order);
        self.boxes[own].second = self.boxes.len();
        self.divide(middle..facets.end, order);
    }
}

impl Bounds {
    /// Square of the distance to the box [m^2].
    fn squared_to(&self, point: &V3) -> f64 {
        (0..3).map(|k| (self.low[k] - point[k]).max(point[k] - self.high[k]).max(0.0).powi(2)).sum()
    }
}

impl Facet {
    fn place(&self, at: [f64; 3]) -> V3 {
        self.corners[0] * at[0] + self.corners[1] * at[1] + self.corners[2] * at[2]
    }

    /// Three times the coordinate of the facet's centroid along an axis.
    fn middle(&self, axis: usize) -> f64 {
        self.corners.iter().map(|x| x[axis]).sum()
    }

    fn normal_at(&self, at: [f64; 3]) -> V3 {
        let zero = [0, 1, 2].map(|k| at[k] == 0.0);
        match zero {
            [false, true, true] => self.at_corners[0],
            [true, false, true] => self.at_corners[1],
            [true, true, false] => self.at_corners[2],
            [false, false, true] => self.at_sides[0],
            [true, false, false] => self.at_sides[1],
            [false, true, false] => self.at_sides[2],
            _ => self.normal,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{BlockSpec, block};

    /// Distance to a box by coordinates (Quilez), independent of triangles.
    fn to_box(x: V3, half: V3, middle: V3) -> f64 {
        let q = (x - middle).abs() - half;
        q.map(|c| c.max(0.0)).norm() + q.max().min(0.0)
    }

    #[test]
    fn the_distance_to_a_block_is_that_of_its_formula_inside_and_out() {
        let mesh =
            block(&BlockSpec { size_m: [0.08, 0.06, 0.04], nodes: 120, fine_at_m: [0.0; 2], fine_radius_m: 0.01 }).unwrap();
        let surface = ClosedSurface::of(&mesh).unwrap();
        let (half, middle) = (V3::new(0.04, 0.03, 0.02), V3::new(0.0, 0.0, -0.02));
        let (mut inside, mut outside) = (0, 0);
        for seed in 0..4000 {
            let wave = |k: f64| (f64::from(seed) * k).sin();
            let x = V3::new(0.05 * wave(1.3), 0.04 * wave(2.1), -0.02 + 0.025 * wave(0.7));
            let expected = to_box(x, half, middle);
            let found = surface.foot(x.into());
            assert!((found.distance_m - expected).abs() < 1e-12, "{x:?}: {found:?}, not {expected}");
            assert!(to_box(V3::from(found.at_m), half, middle).abs() < 1e-12);
            if expected < 0.0 { inside += 1 } else { outside += 1 }
        }
        assert!(inside > 500 && outside > 500, "{inside} {outside}");
    }

    #[test]
    fn the_triangles_keep_their_order() {
        let mesh =
            block(&BlockSpec { size_m: [0.08, 0.06, 0.04], nodes: 120, fine_at_m: [0.0; 2], fine_radius_m: 0.01 }).unwrap();
        let wanted: Vec<_> = surface::surface(&mesh.tets).iter().map(|t| t.map(|n| V3::from(mesh.nodes_m[n as usize]))).collect();
        let surface = ClosedSurface::of(&mesh).unwrap();
        assert!(surface.in_order_m().into_iter().eq(wanted.iter().map(|corners| (*corners, false))));
        assert!(!surface.triangles_m().eq(wanted), "boxes reorder the triangles");
    }

    #[test]
    fn in_front_of_a_sharp_reentrant_edge_the_sign_is_right() {
        // two tets share a face; at the notch between them the normal of a single triangle is wrong
        let nodes_m = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.2, 0.2, 1.0], [2.0, 2.0, 1.5]];
        let mut tets = vec![[0, 1, 2, 3], [1, 2, 3, 4]];
        for tet in &mut tets {
            let [a, b, c, d] = tet.map(|n: u32| V3::from(nodes_m[n as usize]));
            if (b - a).cross(&(c - a)).dot(&(d - a)) < 0.0 {
                tet.swap(2, 3);
            }
        }
        let mesh = TetMesh { nodes_m: nodes_m.clone(), regions: vec![0; 2], tets };
        let surface = ClosedSurface::of(&mesh).unwrap();
        for seed in 0..3000 {
            let wave = |k: f64| (f64::from(seed) * k).sin();
            let x = V3::new(1.0 + 1.3 * wave(1.3), 1.0 + 1.3 * wave(2.1), 0.7 + wave(0.7));
            let inside = mesh.tets.iter().any(|tet| {
                let c = tet.map(|n| V3::from(nodes_m[n as usize]));
                let volume = |c: [V3; 4]| (c[1] - c[0]).cross(&(c[2] - c[0])).dot(&(c[3] - c[0]));
                (0..4).all(|k| {
                    let mut part = c;
                    part[k] = x;
                    volume(part) > 0.0
                })
            });
            assert_eq!(surface.foot(x.into()).distance_m < 0.0, inside, "{x:?}");
        }
    }
}
