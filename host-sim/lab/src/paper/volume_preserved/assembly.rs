//! The scene at one resolution: the meshes of the organs, and the sets of nodes that are fixed,
//! held and joined.
//!
//! Sets are found geometrically among the corner nodes; a mid-edge node belongs to a set if both
//! ends of its edge do. Springs and finite elements on one mesh therefore have exactly the same
//! scene. That is important because the position of a hinge or a grip matters more than the
//! elements, and on two different meshes it would differ by half an element.

use std::collections::BTreeSet;

use nalgebra::Vector3;

use super::scene::{FixedScene, HangingScene};
use crate::error::Error;
use crate::hanging::locate::Locator;
use crate::hanging::organs::{Organ, join};
use palpate_fit::reference::nearest::{Nearest, nearest};
use palpate_fit::reference::quadratic::QuadraticMesh;
use palpate_fit::reference::shape::{TET_EDGES, TRIANGLE_EDGES};
use palpate_tissue::mesh::TetMesh;
use palpate_tissue::mesh::import::import;
use palpate_tissue::organ::{Organ as Shape, Spec};
use palpate_tissue::scene::SceneError;

/// Smallest cosine between the normal of a surface and its required direction (1), for 60 degrees.
const FACING: f64 = 0.5;
/// Largest distance by which a landmark may be outside the faceted surface, as a share of the
/// organ's largest side (1).
const OUTSIDE: f64 = 0.03;

/// The meshed organs, with the sets of nodes and triangles of the scene.
pub struct Assembly<'a> {
    /// Scene from which the assembly was built.
    pub scene: &'a HangingScene,
    /// Mesh of each organ.
    pub meshes: Vec<TetMesh>,
    /// All meshes combined into one mesh of quadratic tets. The nodes of each organ are those of
    /// its mesh, followed by the mid-edge nodes.
    pub quadratic: QuadraticMesh,
    /// Index ranges of each organ in `quadratic`.
    pub organs: Vec<Organ>,
    /// Nodes of `quadratic` that do not move.
    pub fixed: Vec<u32>,
    /// Nodes of `quadratic` that move with the stick.
    pub held: Vec<u32>,
    /// Triangles of `quadratic` that are joined to another organ.
    pub joined: Vec<usize>,
    /// Triangles of `quadratic` to which these may be joined.
    pub onto: Vec<usize>,
    /// Named points of the first organ at rest [m].
    pub landmarks: Vec<(String, Vector3<f64>)>,
    /// Points of the first organ's upper surface at rest [m].
    pub surface: Vec<Vector3<f64>>,
}

impl<'a> Assembly<'a> {
    /// Meshes the organs with about `tets` tets each and finds the sets; `points` is the number of
    /// points sampled on the upper surface.
    pub fn build(scene: &'a HangingScene, tets: &[usize], points: usize) -> Result<Self, Error> {
        let meshes = scene.organ.iter().zip(tets).map(|(organ, tets)| match (&organ.mesh, organ.length_unit) {
            (Some(path), Some(unit)) => Ok(import(path, unit.metres)?.mesh),
            _ => {
                let refuse = |why: &dyn std::fmt::Display| SceneError::value(&scene.file, "organ.shape", &format!("{why}"));
                let shape = Shape::named(&organ.shape).map_err(|why| refuse(&why))?;
                Ok::<_, Error>(shape.mesh(&Spec::Tets(*tets)).map_err(|why| refuse(&why))?)
            }
        });
        let meshes = meshes.collect::<Result<Vec<_>, _>>()?;
        let mut assembly = Self::of(scene, meshes);
        assembly.find_supports()?;
        assembly.find_joint()?;
        assembly.find_landmarks()?;
        assembly.sample_surface(points)?;
        Ok(assembly)
    }

    fn of(scene: &'a HangingScene, meshes: Vec<TetMesh>) -> Self {
        let (quadratic, organs) = join(&meshes.iter().map(QuadraticMesh::new).collect::<Vec<_>>());
        Self {
            scene,
            meshes,
            quadratic,
            organs,
            fixed: Vec::new(),
            held: Vec::new(),
            joined: Vec::new(),
            onto: Vec::new(),
            landmarks: Vec::new(),
            surface: Vec::new(),
        }
    }

    /// Returns the scene with every tet cut into eight; shape, supports, joints and points do not
    /// change.
    pub fn subdivided(&self) -> Self {
        let mut meshes = Vec::new();
        for organ in &self.organs {
            let start = organ.nodes.start as u32;
            let tets: Vec<[u32; 4]> =
                self.quadratic.tets[organ.tets.clone()].iter().flat_map(eighths).map(|t| t.map(|n| n - start)).collect();
            let nodes_m = self.quadratic.nodes_m[organ.nodes.clone()].iter().map(|x| (*x).into()).collect();
            meshes.push(TetMesh { nodes_m, regions: vec![0; tets.len()], tets });
        }
        let mut finer = Self::of(self.scene, meshes);
        // the nodes of each organ in the coarse quadratic mesh are its corners in the finer mesh
        let corner = |n: u32| {
            let (old, new) = self.organs.iter().zip(&finer.organs).find(|(old, _)| old.nodes.contains(&(n as usize)))?;
            Some(n - old.nodes.start as u32 + new.nodes.start as u32)
        };
        let moved = |nodes: &[u32]| nodes.iter().filter_map(|n| corner(*n)).collect::<Vec<u32>>();
        let (mut fixed, mut held) = (moved(&self.fixed), moved(&self.held));
        let parts = |triangles: &[usize]| -> BTreeSet<[u32; 3]> {
            let quarters = triangles.iter().flat_map(|t| quarters(&self.quadratic.triangles[*t]));
            quarters.map(|t| sorted(t.map(|n| corner(n).unwrap_or(n)))).collect()
        };
        let (joined, onto) = (parts(&self.joined), parts(&self.onto));
        let find = |wanted: &BTreeSet<[u32; 3]>| {
            let is = |t: &usize| wanted.contains(&sorted([0, 1, 2].map(|k| finer.quadratic.triangles[*t][k])));
            (0..finer.quadratic.triangles.len()).filter(is).collect::<Vec<_>>()
        };
        let (joined, onto) = (find(&joined), find(&onto));
        finer.add_middles(&mut fixed);
        finer.add_middles(&mut held);
        fixed.retain(|n| held.binary_search(n).is_err());
        (finer.fixed, finer.held, finer.joined, finer.onto) = (fixed, held, joined, onto);
        (finer.landmarks, finer.surface) = (self.landmarks.clone(), self.surface.clone());
        finer
    }

    /// Adds the mid-edge nodes of edges whose ends are both in a set of corners, and sorts the set.
    fn add_middles(&self, set: &mut Vec<u32>) {
        let corners: BTreeSet<u32> = set.iter().copied().collect();
        let mut all = corners.clone();
        for tet in &self.quadratic.tets {
            for (edge, [i, j]) in TET_EDGES.into_iter().enumerate() {
                if corners.contains(&tet[i]) && corners.contains(&tet[j]) {
                    all.insert(tet[4 + edge]);
                }
            }
        }
        *set = all.into_iter().collect();
    }

    fn organ(&self, name: &str) -> &Organ {
        let at = self.scene.organ.iter().position(|o| o.shape == name).unwrap_or(0);
        &self.organs[at]
    }

    /// Triangles of an organ's surface whose normal is within 60 degrees of the direction `facing`.
    fn facing(&self, organ: &Organ, facing: [f64; 3]) -> impl Iterator<Item = usize> {
        let facing = Vector3::from(facing).normalize();
        organ.triangles.clone().filter(move |t| {
            let [a, b, c] = [0, 1, 2].map(|k| self.quadratic.nodes_m[self.quadratic.triangles[*t][k] as usize]);
            let normal = (b - a).cross(&(c - a));
            normal.dot(&facing) >= FACING * normal.norm()
        })
    }

    fn find_supports(&mut self) -> Result<(), SceneError> {
        let scene = self.scene;
        for (n, FixedScene { organ, box_m, facing }) in scene.fixed.iter().enumerate() {
            let triangles: Vec<usize> = self.facing(self.organ(organ), *facing).collect();
            let nodes = triangles.into_iter().flat_map(|t| self.quadratic.triangles[t]).filter(|n| self.is_corner(*n));
            let inside: Vec<u32> = nodes.filter(|n| within(box_m, &self.quadratic.nodes_m[*n as usize])).collect();
            if inside.is_empty() {
                let why = format!("holds no surface of {organ}: widen it, or turn facing");
                return Err(SceneError::value(&scene.file, &format!("fixed[{n}].box_m"), &why));
            }
            self.fixed.extend(inside);
        }
        let stick = &scene.attachment;
        let [from, to] = [stick.from_m, stick.to_m].map(Vector3::from);
        let near = |n: &u32| {
            let (along, arm) = (to - from, self.quadratic.nodes_m[*n as usize] - from);
            let share = (arm.dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
            (arm - along * share).norm() <= stick.radius_m
        };
        let corners = self.organ(&stick.organ).nodes.clone().map(|n| n as u32).filter(|n| self.is_corner(*n));
        let mut held: Vec<u32> = corners.filter(near).collect();
        if held.is_empty() {
            let why =
                format!("= {} m reaches no mesh node of {}: move the stick or make it thicker", stick.radius_m, stick.organ);
            return Err(SceneError::value(&scene.file, "attachment.radius_m", &why));
        }
        let mut fixed = std::mem::take(&mut self.fixed);
        fixed.retain(|n| !held.contains(n));
        self.add_middles(&mut held);
        self.add_middles(&mut fixed);
        fixed.retain(|n| held.binary_search(n).is_err());
        (self.fixed, self.held) = (fixed, held);
        Ok(())
    }

    fn find_joint(&mut self) -> Result<(), SceneError> {
        let scene = self.scene;
        let joint = &scene.joint;
        let refuse = |why: String| Err(SceneError::value(&scene.file, "joint.reach_m", &why));
        let onto: Vec<usize> = self.organ(&joint.onto).triangles.clone().collect();
        let own: Vec<usize> = self.facing(self.organ(&joint.organ), joint.facing).collect();
        let middle = |t: &usize| {
            self.quadratic.triangles[*t][..3].iter().map(|n| self.quadratic.nodes_m[*n as usize] / 3.0).sum::<Vector3<f64>>()
        };
        let boxed: Vec<usize> = own.into_iter().filter(|t| within(&joint.box_m, &middle(t))).collect();
        let gap = |t: &usize| {
            nearest(&self.quadratic, onto.iter().copied(), &middle(t), f64::MAX).map_or(f64::INFINITY, |n| n.distance_m)
        };
        let gaps: Vec<f64> = boxed.iter().map(gap).collect();
        let least = gaps.iter().copied().fold(f64::INFINITY, f64::min);
        if least > joint.reach_m {
            let nearest = if least.is_finite() {
                format!("are {:.2} mm apart", 1e3 * least)
            } else {
                "face each other nowhere in joint.box_m".into()
            };
            return refuse(format!(
                "= {} m: {} and {} do not touch, they {nearest}: move one of them, or reach further",
                joint.reach_m, joint.organ, joint.onto
            ));
        }
        self.joined = boxed.into_iter().zip(gaps).filter(|(_, gap)| *gap <= joint.reach_m).map(|(t, _)| t).collect();
        self.onto = onto;
        if self.joints().is_empty() {
            return refuse(format!(
                "= {} m: no node of {} finds a partner on {}: reach further, or use a finer mesh",
                joint.reach_m, joint.organ, joint.onto
            ));
        }
        Ok(())
    }

    /// Corner nodes of the joined surface that have a partner: the node, its share of the joined
    /// area [m^2], and the nearest point of the other surface.
    pub fn joints(&self) -> Vec<(u32, f64, Nearest)> {
        let mut areas = std::collections::BTreeMap::new();
        for t in &self.joined {
            let nodes = &self.quadratic.triangles[*t][..3];
            let [a, b, c] = [0, 1, 2].map(|k| self.quadratic.nodes_m[nodes[k] as usize]);
            let third = (b - a).cross(&(c - a)).norm() / 6.0;
            nodes.iter().for_each(|n| *areas.entry(*n).or_insert(0.0) += third);
        }
        let partner = |(n, area): (u32, f64)| {
            // a corner of a joined triangle may be a little further from the other surface than its
            // centre
            let reach_m = 2.0 * self.scene.joint.reach_m;
            let found = nearest(&self.quadratic, self.onto.iter().copied(), &self.quadratic.nodes_m[n as usize], reach_m)?;
            Some((n, area, found))
        };
        areas.into_iter().filter_map(partner).collect()
    }

    fn find_landmarks(&mut self) -> Result<(), SceneError> {
        let first = &self.organs[0];
        let size_m = largest_side(self.meshes[0].nodes_m.iter());
        let locator = Locator::new(&self.quadratic, first, OUTSIDE * size_m);
        for (n, landmark) in self.scene.landmark.iter().enumerate() {
            let name = &landmark.name;
            let at = match (landmark.above_m, landmark.inside_m) {
                (Some([x, y]), _) => self.top(x, y),
                (_, at) => at.map(Vector3::from),
            };
            let Some(at) = at.filter(|at| locator.weights(at).is_some()) else {
                let why = format!("\"{name}\" lies outside {}: move it", self.scene.organ[0].shape);
                return Err(SceneError::value(&self.scene.file, &format!("landmark[{n}]"), &why));
            };
            self.landmarks.push((name.clone(), at));
        }
        Ok(())
    }

    /// Highest point of the first organ's surface at x, y [m]; `None` if there is none.
    fn top(&self, x: f64, y: f64) -> Option<Vector3<f64>> {
        let mut highest: Option<Vector3<f64>> = None;
        for t in self.organs[0].triangles.clone() {
            let [a, b, c] = [0, 1, 2].map(|k| self.quadratic.nodes_m[self.quadratic.triangles[t][k] as usize]);
            let twice = |p: &Vector3<f64>, q: &Vector3<f64>| (p.x - x) * (q.y - y) - (p.y - y) * (q.x - x);
            let parts = [twice(&b, &c), twice(&c, &a), twice(&a, &b)];
            let whole: f64 = parts.iter().sum();
            if whole > 0.0 && parts.iter().all(|p| *p >= 0.0) {
                let at = (a * parts[0] + b * parts[1] + c * parts[2]) / whole;
                if highest.is_none_or(|h| at.z > h.z) {
                    highest = Some(at);
                }
            }
        }
        highest
    }

    fn sample_surface(&mut self, points: usize) -> Result<(), SceneError> {
        // two dimensions of the low-discrepancy sequence of Roberts (2018)
        const STEPS: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_3];
        let area = self.scene.surface;
        for n in 0..20 * points {
            if self.surface.len() == points {
                return Ok(());
            }
            let at = [0, 1].map(|k| area.low_m[k] + (0.5 + n as f64 * STEPS[k]).fract() * (area.high_m[k] - area.low_m[k]));
            self.surface.extend(self.top(at[0], at[1]));
        }
        Err(SceneError::value(
            &self.scene.file,
            "surface",
            &format!("has hardly any surface of {} in it: move it", self.scene.organ[0].shape),
        ))
    }

    /// Whether a node of `quadratic` is a corner node, that is, a node of `meshes`.
    pub fn is_corner(&self, node: u32) -> bool {
        let node = node as usize;
        self.organs
            .iter()
            .zip(&self.meshes)
            .any(|(organ, mesh)| (organ.nodes.start..organ.nodes.start + mesh.nodes_m.len()).contains(&node))
    }
}

fn within(box_m: &[[f64; 3]; 2], at: &Vector3<f64>) -> bool {
    (0..3).all(|k| (box_m[0][k]..=box_m[1][k]).contains(&at[k]))
}

fn largest_side<'a>(nodes: impl Iterator<Item = &'a [f64; 3]>) -> f64 {
    let (low, high) = nodes.fold(([f64::MAX; 3], [f64::MIN; 3]), |(low, high), x| {
        ([0, 1, 2].map(|k| low[k].min(x[k])), [0, 1, 2].map(|k| high[k].max(x[k])))
    });
    (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max)
}

/// The eight tets into which a 10-node tet is cut; the inner octahedron is split along the line
/// between the first and the last mid-edge node.
fn eighths(tet: &[u32; 10]) -> Vec<[u32; 4]> {
    let middle = |i: usize, j: usize| {
        let edge = TET_EDGES.iter().position(|e| *e == [i, j] || *e == [j, i]).unwrap_or(0);
        tet[4 + edge]
    };
    let corner = |k: usize| [0, 1, 2, 3].map(|j| if j == k { tet[k] } else { middle(k.min(j), k.max(j)) });
    let (m01, m02, m03, m12, m13, m23) = (middle(0, 1), middle(0, 2), middle(0, 3), middle(1, 2), middle(1, 3), middle(2, 3));
    let mut parts: Vec<[u32; 4]> = (0..4).map(corner).collect();
    parts.extend([[m01, m02, m03, m23], [m01, m02, m23, m12], [m01, m12, m23, m13], [m01, m13, m23, m03]]);
    parts
}

fn quarters(triangle: &[u32; 6]) -> [[u32; 3]; 4] {
    let middle = |i: usize, j: usize| {
        let side = TRIANGLE_EDGES.iter().position(|e| *e == [i, j] || *e == [j, i]).unwrap_or(0);
        triangle[3 + side]
    };
    let (a, b, c) = (middle(0, 1), middle(1, 2), middle(0, 2));
    [[triangle[0], a, c], [a, triangle[1], b], [c, b, triangle[2]], [a, b, c]]
}

fn sorted(mut nodes: [u32; 3]) -> [u32; 3] {
    nodes.sort_unstable();
    nodes
}
