//! Where a force is possible, from geometry at rest alone: a plane, or the solid that a patch's
//! tets fill.
//!
//! The check of contact relies neither on the patch nor on the loop: it uses this geometry, in
//! double precision, with the *sensed* tip.

use std::fmt::Debug;
use std::sync::Arc;

use nalgebra::Matrix3;
use palpate::{Model, Probe, ProbeShape, Vector3};

use super::box_tree::{BoxTree, around};
use palpate_tissue::mesh::surface;

/// Depth below the touchable surface, beside the tissue, to which a ball may still touch its edge
/// [m].
const BELOW_M: f64 = 1e-3;
/// Rounding at the face between two tets [m].
const FACE_M: f64 = 1e-9;
/// Triangles whose distances differ by less are equally near: those that meet at an edge [m].
const EQUALLY_NEAR_M: f64 = 1e-7;
/// Number of samples on the rim of a flat probe, and along the segment of a capsule.
const RIM: usize = 16;
const SEGMENT: usize = 17;

/// Geometry at rest of the touched surface.
pub trait RestShape: Debug + Send + Sync {
    /// Distance of a tip from the region where a force is possible [m]; zero inside it.
    fn outside_m(&self, tip_m: &Vector3<f64>) -> f64;

    /// Whether a tip is inside the tissue.
    fn inside(&self, tip_m: &Vector3<f64>) -> bool;

    /// Depth of a tip below the surface at rest [m]; zero where no force is possible.
    fn depth_m(&self, tip_m: &Vector3<f64>) -> f64;

    /// [`Self::outside_m`] and [`Self::inside`] of one tip, at the cost of the more expensive one.
    fn place(&self, tip_m: &Vector3<f64>) -> (f64, bool) {
        (self.outside_m(tip_m), self.inside(tip_m))
    }

    /// Outward normals of the touchable surface that the probe's end can press at once: those
    /// within its radius, and always the nearest.
    fn normals(&self, tip_m: &Vector3<f64>) -> Vec<Vector3<f64>>;
}

/// Everything below a plane is tissue.
#[derive(Clone, Copy, Debug)]
pub struct HalfSpace {
    /// A point on the plane [m].
    pub at_m: Vector3<f64>,
    /// Unit normal of the plane, which points out of the tissue.
    pub normal: Vector3<f64>,
}

impl RestShape for HalfSpace {
    fn outside_m(&self, tip_m: &Vector3<f64>) -> f64 {
        (tip_m - self.at_m).dot(&self.normal).max(0.0)
    }

    fn inside(&self, tip_m: &Vector3<f64>) -> bool {
        (tip_m - self.at_m).dot(&self.normal) < 0.0
    }

    fn depth_m(&self, tip_m: &Vector3<f64>) -> f64 {
        (self.at_m - tip_m).dot(&self.normal).max(0.0)
    }

    fn normals(&self, _: &Vector3<f64>) -> Vec<Vector3<f64>> {
        vec![self.normal]
    }
}

/// A shape seen from another frame: the point `x` of the caller's frame is `turn * x + shift_m` in
/// the shape's own.
#[derive(Clone, Debug)]
pub struct Placed {
    /// The shape in its own frame.
    pub shape: Arc<dyn RestShape>,
    /// Rotation from the caller's frame to the shape's own.
    pub turn: Matrix3<f64>,
    /// Origin of the caller's frame in the shape's frame [m].
    pub shift_m: Vector3<f64>,
}

impl RestShape for Placed {
    fn outside_m(&self, tip_m: &Vector3<f64>) -> f64 {
        self.shape.outside_m(&(self.turn * tip_m + self.shift_m))
    }

    fn inside(&self, tip_m: &Vector3<f64>) -> bool {
        self.shape.inside(&(self.turn * tip_m + self.shift_m))
    }

    fn depth_m(&self, tip_m: &Vector3<f64>) -> f64 {
        self.shape.depth_m(&(self.turn * tip_m + self.shift_m))
    }

    fn place(&self, tip_m: &Vector3<f64>) -> (f64, bool) {
        self.shape.place(&(self.turn * tip_m + self.shift_m))
    }

    fn normals(&self, tip_m: &Vector3<f64>) -> Vec<Vector3<f64>> {
        let mut normals = self.shape.normals(&(self.turn * tip_m + self.shift_m));
        normals.iter_mut().for_each(|n| *n = self.turn.transpose() * *n);
        normals
    }
}

/// The union of a patch's tets, its closed boundary, and the part of it that can be touched.
#[derive(Clone, Debug)]
pub struct RestSolid {
    nodes_m: Vec<Vector3<f64>>,
    /// Corners of each tet.
    tets: Vec<[u32; 4]>,
    tets_tree: BoxTree,
    boundary: Vec<[u32; 3]>,
    boundary_tree: BoxTree,
    skin: Vec<[u32; 3]>,
    skin_tree: BoxTree,
    probe: Probe,
    /// For an ellipsoid: the tissue in a frame in which the probe is a ball of its radius.
    stretched: Option<Stretched>,
}

/// Geometry in which an ellipsoid is a ball.
#[derive(Clone, Debug)]
struct Stretched {
    into: Matrix3<f64>,
    nodes_m: Vec<Vector3<f64>>,
    boundary_tree: BoxTree,
    /// Largest factor by which a distance grows (1).
    most: f64,
}

impl RestSolid {
    /// The rest geometry of a model, for this probe.
    #[must_use]
    pub fn of(model: &Model, probe: &Probe) -> Self {
        let nodes_m: Vec<Vector3<f64>> = model.nodes.iter().map(|n| Vector3::from(n.rest_m).cast()).collect();
        let tets: Vec<[u32; 4]> = model.tets.iter().map(|t| t.node.map(u32::from)).collect();
        // a surface that faces away from the handle by more than 30 degrees cannot be pressed by a
        // probe with a handle
        let axis = probe.axis.cast::<f64>();
        let faces_handle = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|n| nodes_m[n as usize]);
            (b - a).cross(&(c - a)).normalize().dot(&axis) >= -0.5
        };
        let skin: Vec<[u32; 3]> = model
            .triangles
            .iter()
            .map(|t| t.node.map(u32::from))
            .filter(|t| !matches!(probe.shape, ProbeShape::Hemisphere | ProbeShape::Flat) || faces_handle(t))
            .collect();
        let boundary = surface::surface(&tets);
        fn tree<const N: usize>(nodes_m: &[Vector3<f64>], items: &[[u32; N]]) -> BoxTree {
            let corners = |item: &[u32; N]| around(item.map(|n| <[f64; 3]>::from(nodes_m[n as usize])).iter());
            BoxTree::over(&items.iter().map(corners).collect::<Vec<_>>())
        }
        let stretched = stretch(probe).map(|(into, most)| {
            let nodes_m: Vec<_> = nodes_m.iter().map(|x| into * x).collect();
            Stretched { into, boundary_tree: tree(&nodes_m, &boundary), nodes_m, most }
        });
        Self {
            stretched,
            tets_tree: tree(&nodes_m, &tets),
            boundary_tree: tree(&nodes_m, &boundary),
            skin_tree: tree(&nodes_m, &skin),
            nodes_m,
            tets,
            boundary,
            skin,
            probe: *probe,
        }
    }

    /// Whether a point is inside the tissue at rest.
    #[must_use]
    pub fn contains(&self, p: &Vector3<f64>) -> bool {
        self.tets_tree.any(&(*p).into(), FACE_M, |n| {
            let [a, b, c, d] = self.tets[n].map(|v| self.nodes_m[v as usize]);
            // each face with its outward normal; the fourth corner is on the inner side
            [[a, c, b], [a, b, d], [a, d, c], [b, c, d]].iter().all(|[u, v, w]| {
                let normal = (v - u).cross(&(w - u));
                (p - u).dot(&normal) <= FACE_M * normal.norm()
            })
        })
    }

    /// Distance of a point from the tissue at rest [m]; zero inside.
    #[must_use]
    pub fn distance_m(&self, p: &Vector3<f64>) -> f64 {
        if self.contains(p) {
            return 0.0;
        }
        let square = |n: usize| (self.on(&self.boundary[n], p) - p).norm_squared();
        self.boundary_tree.nearest(&(*p).into(), square).map_or(f64::INFINITY, |(_, square)| square.sqrt())
    }

    /// Lower and upper corner of the tissue [m] along three axes, relative to a point.
    #[must_use]
    pub fn extent_m(&self, from_m: &Vector3<f64>, axes: &[Vector3<f64>; 3]) -> [[f64; 3]; 2] {
        let local = self.nodes_m.iter().map(|x| axes.map(|axis| (x - from_m).dot(&axis))).collect::<Vec<_>>();
        around(local.iter())
    }

    /// The touchable point nearest to a point, and the outward normal there.
    fn skin_near(&self, p: &Vector3<f64>) -> Option<(Vector3<f64>, Vector3<f64>)> {
        let square = |n: usize| (self.on(&self.skin[n], p) - p).norm_squared();
        let (nearest, _) = self.skin_tree.nearest(&(*p).into(), square)?;
        let [a, b, c] = self.skin[nearest].map(|v| self.nodes_m[v as usize]);
        Some((self.on(&self.skin[nearest], p), (b - a).cross(&(c - a)).normalize()))
    }

    /// The point of a triangle that is nearest to `p`.
    fn on(&self, triangle: &[u32; 3], p: &Vector3<f64>) -> Vector3<f64> {
        let [a, b, c] = triangle.map(|v| self.nodes_m[v as usize]);
        nearest_on_triangle(p, &a, &b, &c)
    }

    /// Centre of the probe's end, whatever its shape [m].
    fn end_m(&self, tip_m: &Vector3<f64>) -> Vector3<f64> {
        let arm_m = if self.probe.shape == ProbeShape::Flat { 0.0 } else { f64::from(self.probe.radius_m) };
        tip_m + self.probe.axis.cast::<f64>() * arm_m
    }

    /// Depth of the deepest point of a tip that is no ball below the tip, against this unit vector
    /// [m].
    fn below_tip_m(&self, up: &Vector3<f64>) -> f64 {
        let (radius_m, axis) = (f64::from(self.probe.radius_m), self.probe.axis.cast::<f64>());
        let above_m = radius_m * axis.dot(up);
        match self.probe.shape {
            ProbeShape::Hemisphere | ProbeShape::Sphere => 0.0,
            ProbeShape::Flat => radius_m * axis.cross(up).norm(),
            ProbeShape::Capsule { length_m, along } => {
                radius_m - above_m + 0.5 * f64::from(length_m) * along.cast::<f64>().dot(up).abs()
            }
            ProbeShape::Ellipsoid { semi_axes_m, along } => {
                let [a_m, b_m] = semi_axes_m.map(f64::from);
                let along = along.cast::<f64>();
                Vector3::new(a_m * along.dot(up), b_m * axis.cross(&along).dot(up), above_m).norm() - above_m
            }
        }
    }

    /// Whether a tip is on the outer side of (or at most [`BELOW_M`] below) a touchable triangle
    /// that the probe's end overlaps, or else the nearest triangle. Triangles that meet at an edge
    /// are equally near to a ball outside it: it is enough to be above one of them.
    fn above_skin(&self, tip_m: &Vector3<f64>) -> bool {
        let end_m = self.end_m(tip_m);
        let Some((foot_m, _)) = self.skin_near(&end_m) else { return false };
        let near_m = f64::from(self.probe.reach_m()).max((foot_m - end_m).norm() + EQUALLY_NEAR_M);
        self.skin_tree.any(&end_m.into(), near_m, |n| {
            let [a, b, c] = self.skin[n].map(|v| self.nodes_m[v as usize]);
            let normal = (b - a).cross(&(c - a)).normalize();
            (nearest_on_triangle(&end_m, &a, &b, &c) - end_m).norm() <= near_m && (tip_m - a).dot(&normal) >= -BELOW_M
        })
    }

    /// Free space between the probe's end and the tissue [m].
    fn gap_m(&self, tip_m: &Vector3<f64>) -> f64 {
        let (radius_m, axis) = (f64::from(self.probe.radius_m), self.probe.axis.cast::<f64>());
        let end_m = self.end_m(tip_m);
        match self.probe.shape {
            ProbeShape::Hemisphere | ProbeShape::Sphere => return (self.distance_m(&end_m) - radius_m).max(0.0),
            ProbeShape::Capsule { length_m, along } => return self.capsule_gap_m(&end_m, f64::from(length_m), &along.cast()),
            ProbeShape::Ellipsoid { .. } => return self.ellipsoid_gap_m(&end_m),
            ProbeShape::Flat => {}
        }
        let along = if axis.x.abs() < 0.7 { Vector3::x() } else { Vector3::y() };
        let across = axis.cross(&along).normalize();
        let along = across.cross(&axis);
        let rim = (0..RIM).flat_map(|n| {
            let (sin, cos) = (std::f64::consts::TAU * n as f64 / RIM as f64).sin_cos();
            [0.5, 1.0].map(|share| tip_m + (along * cos + across * sin) * (radius_m * share))
        });
        rim.chain([*tip_m]).map(|p| self.distance_m(&p)).fold(f64::INFINITY, f64::min)
    }
}

impl RestSolid {
    /// Gap between a capsule around `end_m` and the tissue. A contact between two samples of the
    /// segment is nearer than either, by Pythagoras.
    fn capsule_gap_m(&self, end_m: &Vector3<f64>, length_m: f64, along: &Vector3<f64>) -> f64 {
        let spacing_m = length_m / (SEGMENT - 1) as f64;
        let samples = (0..SEGMENT).map(|n| self.distance_m(&(end_m + along * (n as f64 * spacing_m - 0.5 * length_m))));
        let nearest_m = samples.fold(f64::INFINITY, f64::min);
        let between_m = (nearest_m * nearest_m - 0.25 * spacing_m * spacing_m).max(0.0).sqrt();
        (between_m - f64::from(self.probe.radius_m)).max(0.0)
    }

    /// Gap between an ellipsoid around `end_m` and the tissue [m], rounded down: zero if they
    /// overlap, otherwise at most the true gap.
    fn ellipsoid_gap_m(&self, end_m: &Vector3<f64>) -> f64 {
        let Some(stretched) = self.stretched.as_ref().filter(|_| !self.contains(end_m)) else { return 0.0 };
        let end = stretched.into * end_m;
        let square = |n: usize| {
            let [a, b, c] = self.boundary[n].map(|v| stretched.nodes_m[v as usize]);
            (nearest_on_triangle(&end, &a, &b, &c) - end).norm_squared()
        };
        let nearest_m = stretched.boundary_tree.nearest(&end.into(), square).map_or(f64::INFINITY, |(_, square)| square.sqrt());
        (nearest_m - f64::from(self.probe.radius_m)).max(0.0) / stretched.most
    }
}

/// The map that turns an ellipsoid into a ball, and the largest factor by which it lengthens a
/// distance (1).
fn stretch(probe: &Probe) -> Option<(Matrix3<f64>, f64)> {
    let ProbeShape::Ellipsoid { semi_axes_m, along } = probe.shape else { return None };
    let (axis, along) = (probe.axis.cast::<f64>(), along.cast::<f64>());
    let [p, q] = semi_axes_m.map(|semi_m| f64::from(probe.radius_m / semi_m));
    let across = axis.cross(&along);
    let into = along * along.transpose() * p + across * across.transpose() * q + axis * axis.transpose();
    Some((into, p.max(q).max(1.0)))
}

impl RestShape for RestSolid {
    /// Inside: zero. Above the touchable surface, or at most `BELOW_M` below it: the gap between
    /// probe and tissue. Elsewhere, beside or below the tissue: the distance of the tip.
    fn outside_m(&self, tip_m: &Vector3<f64>) -> f64 {
        self.place(tip_m).0
    }

    fn inside(&self, tip_m: &Vector3<f64>) -> bool {
        self.contains(tip_m)
    }

    /// Distance of the tip from the touchable surface, wherever the gap to the tissue is zero; of a
    /// tip that is no ball, the depth of its deepest point below that surface if it is larger.
    fn depth_m(&self, tip_m: &Vector3<f64>) -> f64 {
        match self.skin_near(tip_m) {
            Some((foot_m, normal)) if self.outside_m(tip_m) == 0.0 => {
                let arm_m = foot_m - tip_m;
                arm_m.norm().max(arm_m.dot(&normal) + self.below_tip_m(&normal))
            }
            _ => 0.0,
        }
    }

    fn place(&self, tip_m: &Vector3<f64>) -> (f64, bool) {
        if self.contains(tip_m) {
            return (0.0, true);
        }
        (if self.above_skin(tip_m) { self.gap_m(tip_m) } else { self.distance_m(tip_m) }, false)
    }

    fn normals(&self, tip_m: &Vector3<f64>) -> Vec<Vector3<f64>> {
        let end_m = self.end_m(tip_m);
        let Some((foot_m, _)) = self.skin_near(&end_m) else { return Vec::new() };
        let near_m = f64::from(self.probe.reach_m()).max((foot_m - end_m).norm() + EQUALLY_NEAR_M);
        let mut normals = Vec::new();
        self.skin_tree.any(&end_m.into(), near_m, |n| {
            let [a, b, c] = self.skin[n].map(|v| self.nodes_m[v as usize]);
            if (nearest_on_triangle(&end_m, &a, &b, &c) - end_m).norm() <= near_m {
                normals.push((b - a).cross(&(c - a)).normalize());
            }
            false
        });
        normals
    }
}

/// The point of a triangle that is nearest to `p`, by Voronoi regions (Ericson, Real-Time Collision
/// Detection, 5.1.5).
fn nearest_on_triangle(p: &Vector3<f64>, a: &Vector3<f64>, b: &Vector3<f64>, c: &Vector3<f64>) -> Vector3<f64> {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(&ap), ac.dot(&ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return *a;
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(&bp), ac.dot(&bp));
    if d3 >= 0.0 && d4 <= d3 {
        return *b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + ab * (d1 / (d1 - d3));
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(&cp), ac.dot(&cp));
    if d6 >= 0.0 && d5 <= d6 {
        return *c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + ac * (d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
    }
    let all = va + vb + vc;
    a + ab * (vb / all) + ac * (vc / all)
}
