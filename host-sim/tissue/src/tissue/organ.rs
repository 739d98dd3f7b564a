//! Mesh of an organ or a closed surface for a scene, graded so that it is finest at the site.

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::rc::Rc;

use nalgebra::Vector3;

use super::organ_source::{OrganSource, Site};
use super::{boundary, nearest_on_triangle};
use crate::mesh::TetMesh;
use crate::mesh::quality::element_size;
use crate::organ::{Fine, OrganError, Stance, Turned};
use crate::scene::{ORGAN_NODES, Scene, SceneError};

/// Number of nodes of an organ if the scene gives none, and its elements under the probe are then
/// fine enough.
pub const DEFAULT_ORGAN_NODES: usize = 600;
/// Distance from the site within which elements are smallest, in probe radii (1).
const FINE_RADII: f64 = 1.25;
const GROWTH: f64 = 1.0;
/// Least number of lattice cubes through the organ under the site (1). Nodes lie half a cube apart,
/// so that each cube gives at least two elements.
pub const THROUGH: f64 = 2.0;
/// Smallest and largest spacing that is tried, in probe radii (1).
const SPACING_RADII: [f64; 2] = [0.12, 3.0];
/// Number of bisections of the spacing.
const HALVINGS: u32 = 12;
/// Largest accepted deviation from the wanted number of nodes (1).
const WORST_SHARE: f64 = 0.15;
/// Ratio of the expected to the wanted number of nodes above which no mesh is made to count them
/// (1): far above the error of the expectation.
const TOO_MANY: f64 = 4.0;
/// Number of steps of the implicit function in all meshes that are tried for a scene: a few
/// seconds. A body that fills its box takes a tenth of them.
const MOST_STEPS: usize = 30_000_000;
/// Number of such steps that take as long as a point of the lattice, and as a node of the mesh.
const STEPS_PER_POINT: usize = 1;
const STEPS_PER_NODE: usize = 200;
/// Largest element under the probe, and largest distance of the site from the mesh, with which a
/// mesh is good enough, in probe radii (1).
const GOOD_RADII: [f64; 2] = [1.0, 0.1];
/// Largest such element as a share of the thickness there (1): two elements through a thin place,
/// where a plate as thick as the probe's radius is else 15 % too soft.
const GOOD_THICKNESS: f64 = 0.6;
/// Number of elements across a thin body (1).
const ACROSS: f64 = 3.0;
/// Growth of the number of nodes from one attempt to the next where the scene gives none (1).
const MORE: usize = 2;

/// A mesh with what matters at its site.
struct Attempt {
    mesh: TetMesh,
    /// Size of the element nearest to the site [m].
    element_m: f64,
    /// Distance of the site from the mesh's surface: what the lattice cut off there [m].
    cut_m: f64,
}

impl Attempt {
    fn of(mesh: TetMesh, site: &Site) -> Self {
        let at = Vector3::from(site.at_m);
        let triangles = boundary(&mesh);
        let off_m = |place: Vector3<f64>| (place - at).norm();
        let nearest = triangles.iter().min_by(|a, b| off_m(middle(a)).total_cmp(&off_m(middle(b))));
        let element_m = nearest.map_or(f64::INFINITY, size_m);
        let cut_m = triangles.iter().map(|t| off_m(nearest_on_triangle(*t, at))).fold(f64::INFINITY, f64::min);
        Self { mesh, element_m, cut_m }
    }

    fn is_good(&self, radius_m: f64, thickness_m: f64) -> bool {
        let good_m = (GOOD_RADII[0] * radius_m).min(GOOD_THICKNESS * thickness_m);
        self.element_m <= good_m && self.cut_m <= GOOD_RADII[1] * radius_m
    }

    fn nodes(&self) -> usize {
        self.mesh.nodes_m.len()
    }
}

fn middle(corners: &[Vector3<f64>; 3]) -> Vector3<f64> {
    corners.iter().sum::<Vector3<f64>>() / 3.0
}

/// Size of an element with this face [m].
fn size_m([a, b, c]: &[Vector3<f64>; 3]) -> f64 {
    element_size(0.5 * (b - a).cross(&(c - a)).norm())
}

/// Size of the surface element that is nearest to a place [m].
pub(crate) fn element_at_m(mesh: &TetMesh, at_m: [f64; 3]) -> f64 {
    let site = Site { at_m, axis: [0.0; 3], off_m: 0.0 };
    let at = Vector3::from(site.at_m);
    let off_m = |corners: &[Vector3<f64>; 3]| (middle(corners) - at).norm();
    boundary(mesh).iter().min_by(|a, b| off_m(a).total_cmp(&off_m(b))).map_or(0.0, size_m)
}

/// Meshes a shape with about the number of nodes that the scene asks for or, if it gives none, with
/// as many as the site needs.
pub(super) fn graded(scene: &Scene, shape: &OrganSource, site: &Site) -> Result<TetMesh, SceneError> {
    if shape.is_bare(site) {
        let why = "is where a hollow, or another side, touches the surface: there is no tissue to press, take another place";
        return scene.bad("probe.site", why);
    }
    let thickness_m = shape.thickness_m(site);
    let search = Search { scene, shape, site, thickness_m, steps: Cell::new(0), tried: RefCell::new(BTreeMap::new()) };
    let radius_m = scene.probe.radius_m;
    if let Some(wanted) = scene.tissue.nodes {
        let found = search.best(wanted)?.filter(|found| is_near(found, wanted));
        return match found {
            // a mesh that no probe can press is refused with the number that works
            Some(found) if found.element_m <= radius_m && found.cut_m <= radius_m => Ok(found.mesh.clone()),
            found => search.refuse(wanted, found.as_deref()),
        };
    }
    let mut best: Option<Rc<Attempt>> = None;
    let (mut wanted, most) = (DEFAULT_ORGAN_NODES, *ORGAN_NODES.end());
    loop {
        if let Some(found) = search.best(wanted)?.filter(|found| ORGAN_NODES.contains(&found.nodes())) {
            // a thin shape or a narrow hollow may need more nodes from the start
            wanted = wanted.max(found.nodes());
            let better = best.as_ref().is_none_or(|best| found.element_m.max(found.cut_m) < best.element_m.max(best.cut_m));
            let is_good = found.is_good(radius_m, thickness_m);
            if better {
                best = Some(found);
            }
            if is_good {
                break;
            }
        }
        if wanted >= most {
            break;
        }
        wanted = (wanted * MORE).min(most);
    }
    match best {
        Some(best) if best.element_m <= radius_m && best.cut_m <= radius_m => Ok(best.mesh.clone()),
        best => search.refuse(DEFAULT_ORGAN_NODES, best.as_deref()),
    }
}

fn is_near(found: &Attempt, wanted: usize) -> bool {
    found.nodes().abs_diff(wanted) as f64 <= WORST_SHARE * wanted as f64
}

struct Search<'a> {
    scene: &'a Scene,
    shape: &'a OrganSource,
    site: &'a Site,
    /// Thickness of the shape under the site [m].
    thickness_m: f64,
    /// Number of steps spent so far.
    steps: Cell<usize>,
    /// Results by the bits of the spacing and the stance: searches for other numbers of nodes pass
    /// through the same spacings.
    tried: RefCell<BTreeMap<(u64, bool), Tried>>,
}

/// Result of one spacing.
#[derive(Clone)]
enum Tried {
    Mesh(Rc<Attempt>),
    TooCoarse,
    TooFine,
}

impl Search<'_> {
    /// The mesh whose number of nodes is nearest to the wanted one. The lattice lies in the surface
    /// with whole faces; on a point, where it would cut off the tip, it stands on an edge.
    fn best(&self, wanted: usize) -> Result<Option<Rc<Attempt>>, SceneError> {
        let flat = self.nearest(wanted, Stance::Face)?;
        let radius_m = self.scene.probe.radius_m;
        if flat.as_ref().is_some_and(|flat| flat.cut_m <= GOOD_RADII[1] * radius_m) {
            return Ok(flat);
        }
        let upright = self.nearest(wanted, Stance::Edge)?;
        let of = |attempt: &Attempt| (!is_near(attempt, wanted), attempt.element_m.max(attempt.cut_m));
        let all = [flat, upright].into_iter().flatten();
        Ok(all.min_by(|a, b| of(a).0.cmp(&of(b).0).then(of(a).1.total_cmp(&of(b).1))))
    }

    fn turned(&self, spacing_m: f64) -> Turned {
        let radius_m = FINE_RADII * self.scene.probe.radius_m;
        let fine = Fine { at_m: self.site.at_m, radius_m, spacing_m, growth: GROWTH };
        let coarsest_m = (self.thickness_m / THROUGH).max(spacing_m);
        Turned { fine, axis: self.site.axis, coarsest_m }
    }

    fn nearest(&self, wanted: usize, stance: Stance) -> Result<Option<Rc<Attempt>>, SceneError> {
        let [mut low, mut high] = SPACING_RADII.map(|radii| (radii * self.scene.probe.radius_m).ln());
        let mut best: Option<Rc<Attempt>> = None;
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            match self.tried(middle.exp(), stance, TOO_MANY * wanted as f64)? {
                Tried::Mesh(found) => {
                    let nodes = found.nodes();
                    if nodes > wanted {
                        low = middle;
                    } else {
                        high = middle;
                    }
                    if best.as_ref().is_none_or(|b| nodes.abs_diff(wanted) < b.nodes().abs_diff(wanted)) {
                        best = Some(found);
                    }
                }
                Tried::TooCoarse => high = middle,
                Tried::TooFine => low = middle,
            }
        }
        Ok(best)
    }

    /// The mesh of a spacing; too fine if it would have more than `most` nodes, or if looking for
    /// it would take too long.
    fn tried(&self, spacing_m: f64, stance: Stance, most: f64) -> Result<Tried, SceneError> {
        let key = (spacing_m.to_bits(), stance == Stance::Edge);
        if let Some(tried) = self.tried.borrow().get(&key) {
            return Ok(tried.clone());
        }
        if self.steps.get() > MOST_STEPS {
            return Ok(Tried::TooFine);
        }
        let turned = self.turned(spacing_m);
        let expected = self.shape.expected(&turned, stance, &self.steps);
        if expected.nodes > most {
            return Ok(Tried::TooFine);
        }
        let of_lattice = expected.points.saturating_mul(STEPS_PER_POINT);
        let steps = self.steps.get().saturating_add(of_lattice).saturating_add(STEPS_PER_NODE * expected.nodes as usize);
        if steps > MOST_STEPS {
            return Ok(Tried::TooFine);
        }
        self.steps.set(steps);
        let tried = match self.shape.mesh_with(&turned, stance, &self.steps) {
            Ok(mesh) => Tried::Mesh(Rc::new(Attempt::of(mesh, self.site))),
            Err(OrganError::Empty { .. } | OrganError::TooCoarse { .. } | OrganError::Inverted { .. }) => Tried::TooCoarse,
            Err(OrganError::TooFine { .. }) => Tried::TooFine,
            Err(other) => {
                let key = if matches!(self.shape, OrganSource::Organ(_)) { "tissue.organ:" } else { "tissue.mesh:" };
                return self.scene.bad(key, &other.to_string());
            }
        };
        self.tried.borrow_mut().insert(key, tried.clone());
        Ok(tried)
    }

    /// Refuses a number of nodes with one that works, which is tried, or says that there is none.
    fn refuse<T>(&self, wanted: usize, found: Option<&Attempt>) -> Result<T, SceneError> {
        let radius_m = self.scene.probe.radius_m;
        let is_fine = |attempt: &Attempt| attempt.element_m <= radius_m && attempt.cut_m <= radius_m;
        let mut works = None;
        let mut nodes = wanted;
        // without a number in the scene, all were tried
        while self.scene.tissue.nodes.is_some() && works.is_none() && nodes <= *ORGAN_NODES.end() {
            let attempt = self.best(nodes)?.filter(|attempt| ORGAN_NODES.contains(&attempt.nodes()) && is_fine(attempt));
            if let Some(nodes) = attempt.map(|attempt| attempt.nodes()) {
                works = self.best(nodes)?.filter(|again| is_near(again, nodes) && is_fine(again)).map(|_| nodes);
            }
            nodes *= MORE;
        }
        let why = match (found, works) {
            (None, Some(_)) => format!("no mesh of about so many nodes holds the shape of {}", self.shape.name()),
            (None, None) => self.too_thin(),
            (Some(found), _) if found.cut_m > radius_m => {
                format!("a mesh of so many nodes cuts {:.1} mm off the place that is pressed", found.cut_m * 1e3)
            }
            (Some(found), _) => {
                let [element_mm, radius_mm] = [found.element_m, radius_m].map(|m| m * 1e3);
                format!("its elements under the probe would be {element_mm:.1} mm, larger than the radius of {radius_mm:.1} mm")
            }
        };
        let advice = match (found, works) {
            (_, Some(nodes)) => format!(": give nodes = {nodes}"),
            (None, None) => String::new(),
            (Some(_), None) => format!(
                "; at most {} nodes fit: palpate fit --scene {} cuts out a piece with fine elements of its own",
                ORGAN_NODES.end(),
                self.scene.file
            ),
        };
        let key = if self.scene.tissue.nodes.is_some() { "tissue.nodes" } else { "tissue.mesh:" };
        let given = self.scene.tissue.nodes.map_or(String::new(), |nodes| format!("= {nodes}: "));
        self.scene.bad(key, &format!("{given}{why}{advice}"))
    }

    /// Says how thick the shape is, and how many nodes that would take; where these would fit, that
    /// no mesh held the shape.
    fn too_thin(&self) -> String {
        let (name, thickness_m) = (self.shape.name(), self.shape.exact_thickness_m(self.site));
        let expected = self.shape.expected(&self.turned(thickness_m / ACROSS), Stance::Face, &self.steps).nodes;
        if let Some((pairs, near)) = self.shape.crossings() {
            return format!(
                "{pairs} pair(s) of its triangles cross, the first near {near} in file units, and no mesh that was tried holds such a shape: unite its parts (Blender: Boolean, Union) or remesh by voxels"
            );
        }
        let most = ORGAN_NODES.end();
        let advice = "press a thicker place, or a smaller piece of the body around the site";
        if expected <= *most as f64 {
            return format!("no mesh that was tried holds the shape of {name} at this site: {advice}");
        }
        let nodes = if expected.is_finite() { format!("about {expected:.0} nodes") } else { "millions of nodes".to_owned() };
        let [thickness_mm, element_mm] = [thickness_m, thickness_m / ACROSS].map(|m| m * 1e3);
        format!(
            "{name} is {thickness_mm:.1} mm thick at this site, and elements of {element_mm:.2} mm would take {nodes}, at most {most} fit: {advice}"
        )
    }
}
