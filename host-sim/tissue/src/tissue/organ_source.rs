//! A closed shape that can be remeshed (a surface file, the surface of a mesh file, or an organ of
//! [`crate::organ`]), with its site and its fixed parts.

use std::cell::Cell;

use nalgebra::Vector3;

use super::{UNDERSIDE_COSINE, faces_away, nearest_on_surface, underside};
use crate::error::Error;
use crate::mesh::import::{MeshFile, open_turned};
use crate::mesh::{ClosedSurface, ImportReport, SurfaceReport, TetMesh, surface};
use crate::organ::{Expected, Organ, OrganError, Stance, Turned};
use crate::scene::{Scene, SceneError};

type V3 = Vector3<f64>;

/// Number of samples along the path on which the thickness is measured.
const STEPS: u32 = 400;
/// Number of steps for the implicit function of a built-in organ.
const ORGAN_STEPS: usize = 20;
/// Largest thickness at which a shape has no tissue under a site, as a share of its size (1): the
/// first sample of the thickness.
const BARE_SHARE: f64 = 1.5 / (50.0 * STEPS as f64);

/// Distance from a faceted surface below which a point is on it, with the normal of its facet [m].
const ON_M: f64 = 1e-9;

/// A closed shape, by its source.
pub enum OrganSource {
    /// Surface of a mesh file, with flat facets, and the mesh with the report of its import.
    File(ClosedSurface, TetMesh, ImportReport),
    /// Surface file, with flat facets, and the report of its import.
    Surface(ClosedSurface, SurfaceReport),
    /// A built-in organ.
    Organ(Organ),
}

/// Site at which a shape is pressed.
#[derive(Clone, Copy, Debug)]
pub struct Site {
    /// Surface point [m].
    pub at_m: [f64; 3],
    /// Outward unit normal there.
    pub axis: [f64; 3],
    /// Distance from there to the site that the scene gives [m].
    pub off_m: f64,
}

impl OrganSource {
    /// The shape of a scene; `None` for a block or a packed patch.
    pub fn of(scene: &Scene) -> Result<Option<Self>, Error> {
        let tissue = &scene.tissue;
        if let Some(name) = &tissue.organ {
            let organ =
                Organ::named(name).map_err(|cause| SceneError::value(&scene.file, "tissue.organ:", &cause.to_string()))?;
            return Ok(Some(Self::Organ(organ)));
        }
        let (Some(path), Some(unit)) = (&tissue.mesh, tissue.length_unit) else { return Ok(None) };
        match open_turned(path, unit.metres, tissue.up)? {
            MeshFile::Surface(imported) => Ok(Some(Self::Surface(imported.surface, imported.report))),
            MeshFile::Tets(_) if tissue.nodes.is_some() => Ok(scene.refuse_nodes()?),
            // an import has tets, so it has a surface
            MeshFile::Tets(imported) => {
                Ok(ClosedSurface::of(&imported.mesh).map(|surface| Self::File(surface, imported.mesh, imported.report)))
            }
        }
    }

    /// Name of the shape in messages.
    pub fn name(&self) -> &str {
        match self {
            Self::File(..) => "the mesh's surface",
            Self::Surface(..) => "the surface",
            Self::Organ(organ) => organ.name(),
        }
    }

    /// The built-in organ, if it is one.
    pub fn organ(&self) -> Option<&Organ> {
        match self {
            Self::Organ(organ) => Some(organ),
            Self::File(..) | Self::Surface(..) => None,
        }
    }

    /// Number of pairs of triangles that cross, and a place near the first in file units.
    pub(super) fn crossings(&self) -> Option<&(usize, String)> {
        match self {
            Self::Surface(_, report) => report.crossings.as_ref(),
            Self::File(..) | Self::Organ(_) => None,
        }
    }

    /// Surface point nearest to the scene's site, and the outward normal there; for a faceted
    /// surface, the mean normal within a probe radius.
    pub fn site(&self, scene: &Scene) -> Result<Site, SceneError> {
        let Some(wanted) = scene.probe.site else { return scene.bad("probe.site", "is missing: give x, y, z in metres") };
        let (at_m, axis) = match self {
            // not that of the mesh, which takes seconds to find in millions of tets
            Self::File(surface, ..) => {
                let skin: Vec<_> = surface.in_order_m().into_iter().map(|(corners, _)| corners).collect();
                nearest_on_surface(&skin, wanted, scene.probe.radius_m)
            }
            Self::Surface(surface, _) => {
                nearest_on_surface(&surface.triangles_m().collect::<Vec<_>>(), wanted, scene.probe.radius_m)
            }
            Self::Organ(organ) => {
                let at_m = organ.nearest_m(wanted);
                (at_m, organ.normal(at_m))
            }
        };
        Ok(Site { at_m, axis, off_m: (V3::from(wanted) - V3::from(at_m)).norm() })
    }

    /// The site, which must be within a probe radius of the surface.
    ///
    /// # Errors
    /// The site is further away; the message gives the nearest surface point.
    pub fn near_site(&self, scene: &Scene) -> Result<Site, SceneError> {
        let site = self.site(scene)?;
        // written so that a distance that is not a number is refused
        if site.off_m <= scene.probe.radius_m {
            return Ok(site);
        }
        let [x, y, z] = site.at_m;
        let why = format!(
            "is {:.1} mm from the surface, further than the probe's radius: take its nearest point, site = [{x:.5}, {y:.5}, {z:.5}]",
            site.off_m * 1e3
        );
        scene.bad("probe.site", &why)
    }

    /// Implicit function of the shape [m]: negative inside, zero on the surface.
    pub fn value_m(&self, at_m: [f64; 3]) -> f64 {
        self.value_counted(at_m).0
    }

    /// The implicit function, and the number of steps that it took.
    fn value_counted(&self, at_m: [f64; 3]) -> (f64, usize) {
        match self {
            Self::File(surface, ..) | Self::Surface(surface, _) => {
                let foot = surface.foot(at_m);
                (foot.distance_m, foot.looked_at)
            }
            Self::Organ(organ) => (organ.implicit_m(at_m), ORGAN_STEPS),
        }
    }

    /// A mesh of the shape; all regions are 0.
    pub fn mesh(&self, turned: &Turned) -> Result<TetMesh, OrganError> {
        self.mesh_with(turned, Stance::Face, &Cell::new(0))
    }

    /// A mesh of the shape on a lattice of this stance. Every hollow of the shape is one of the
    /// mesh, apart from the skin and the others: a lattice that is too coarse for a wall would open
    /// the hollow behind it, or leave no tissue there. Adds the number of steps of the implicit
    /// function to `steps`.
    pub(super) fn mesh_with(&self, turned: &Turned, stance: Stance, steps: &Cell<usize>) -> Result<TetMesh, OrganError> {
        let implicit = (&self.counting(steps) as &dyn Fn([f64; 3]) -> f64, self.is_distance());
        let mesh = turned.mesh_with(self.name(), implicit, self.bounds_m(), stance)?;
        let hollows = match self {
            Self::File(surface, ..) | Self::Surface(surface, _) => surface.hollows(),
            Self::Organ(_) => return Ok(mesh),
        };
        if surface::hollows(&mesh) == Some(hollows) {
            return Ok(mesh);
        }
        let (organ, spacing_m, defect) = (self.name().to_owned(), turned.fine.spacing_m, "opens, loses or touches a hollow");
        Err(OrganError::TooCoarse { organ, spacing_m, defect })
    }

    /// Cost of such a mesh; the steps to find it are added to `steps`.
    pub(super) fn expected(&self, turned: &Turned, stance: Stance, steps: &Cell<usize>) -> Expected {
        turned.expected((&self.counting(steps), self.is_distance()), self.bounds_m(), stance)
    }

    /// Signed distance of a point near the surface [m], negative inside, and the outward unit
    /// normal there. For an organ the distance is of first order.
    pub fn distance_m(&self, at_m: [f64; 3]) -> (f64, [f64; 3]) {
        match self {
            Self::File(surface, ..) | Self::Surface(surface, _) => {
                let foot = surface.foot(at_m);
                let out = (V3::from(at_m) - V3::from(foot.at_m)) * foot.distance_m.signum();
                // on the surface itself, the normal of the facet
                let on_surface = || (0.0, surface.wall(at_m).1);
                out.try_normalize(ON_M).map_or_else(on_surface, |normal| (foot.distance_m, normal.into()))
            }
            Self::Organ(organ) => organ.near_m(at_m),
        }
    }

    /// Point of the surface nearest to a place [m].
    pub fn nearest_m(&self, at_m: [f64; 3]) -> [f64; 3] {
        match self {
            Self::File(surface, ..) | Self::Surface(surface, _) => surface.foot(at_m).at_m,
            Self::Organ(organ) => organ.nearest_m(at_m),
        }
    }

    fn is_distance(&self) -> bool {
        !matches!(self, Self::Organ(_))
    }

    fn counting<'a>(&'a self, steps: &'a Cell<usize>) -> impl Fn([f64; 3]) -> f64 + 'a {
        move |at_m| {
            let (value_m, own) = self.value_counted(at_m);
            steps.set(steps.get().saturating_add(own));
            value_m
        }
    }

    fn bounds_m(&self) -> [[f64; 3]; 2] {
        match self {
            Self::File(surface, ..) | Self::Surface(surface, _) => surface.bounds_m(),
            Self::Organ(organ) => organ.bounds_m(),
        }
    }

    /// Whether there is no tissue under a site, because the wall of a hollow, or another side,
    /// meets the surface there.
    pub(super) fn is_bare(&self, site: &Site) -> bool {
        self.exact_thickness_m(site) <= BARE_SHARE * self.longest_m()
    }

    /// Thickness of the shape along the inward normal at a site [m].
    pub fn thickness_m(&self, site: &Site) -> f64 {
        self.thickness_in(site, STEPS)
    }

    /// Thickness within a share of a millimetre, for messages.
    pub(super) fn exact_thickness_m(&self, site: &Site) -> f64 {
        self.thickness_in(site, 50 * STEPS)
    }

    fn thickness_in(&self, site: &Site, steps: u32) -> f64 {
        let longest_m = self.longest_m();
        let depth_m = |n: u32| longest_m * f64::from(n) / f64::from(steps);
        let inside = |n: &u32| self.value_m((V3::from(site.at_m) - V3::from(site.axis) * depth_m(*n)).into()) < 0.0;
        depth_m((1..=steps).take_while(inside).last().unwrap_or(1))
    }

    fn longest_m(&self) -> f64 {
        let [low, high] = self.bounds_m().map(V3::from);
        (high - low).norm()
    }

    /// Nodes of a mesh of the shape that are fixed when it is pressed along `axis`, ascending:
    /// those on the underside and those inside a bone.
    pub fn anchors(&self, mesh: &TetMesh, axis: [f64; 3]) -> Vec<u32> {
        match self {
            // a shape without an underside is refused, even if trimming gave the mesh downward
            // faces
            Self::File(surface, ..) | Self::Surface(surface, _)
                if !surface.in_order_m().into_iter().any(|(corners, is_inner)| !is_inner && faces_away(corners, axis)) =>
            {
                Vec::new()
            }
            // a wall may be thinner than the elements, which then face anywhere: the surface
            // decides
            Self::File(surface, ..) => {
                let mut nodes = underside(mesh, axis);
                nodes.retain(|n| !surface.wall(mesh.nodes_m[*n as usize]).0);
                nodes
            }
            Self::Surface(surface, _) => {
                let away = |t: &[u32; 3]| {
                    let middle = [0, 1, 2].map(|k| t.iter().map(|n| mesh.nodes_m[*n as usize][k]).sum::<f64>() / 3.0);
                    let (is_inner, normal) = surface.wall(middle);
                    !is_inner && V3::from(normal).dot(&V3::from(axis)) < UNDERSIDE_COSINE
                };
                let mut nodes: Vec<u32> = surface::surface(&mesh.tets).into_iter().filter(away).flatten().collect();
                nodes.sort_unstable();
                nodes.dedup();
                nodes.retain(|n| !surface.wall(mesh.nodes_m[*n as usize]).0);
                nodes
            }
            Self::Organ(organ) => held(mesh, axis, Some(organ)),
        }
    }
}

/// Nodes of a mesh that are fixed when it is pressed along `axis`, ascending: those on the
/// underside and those inside a bone of the organ.
pub fn held(mesh: &TetMesh, axis: [f64; 3], organ: Option<&Organ>) -> Vec<u32> {
    let mut anchors = underside(mesh, axis);
    if let Some(organ) = organ {
        let in_bone = (0_u32..).zip(&mesh.nodes_m).filter(|(_, x)| organ.bone_m(**x).is_some_and(|d| d <= 0.0));
        anchors.extend(in_bone.map(|(n, _)| n));
        anchors.sort_unstable();
        anchors.dedup();
    }
    anchors
}
