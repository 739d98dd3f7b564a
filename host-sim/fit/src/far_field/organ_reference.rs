//! Computes the response of the whole organ to a press by quadratic finite elements
//! ([`crate::reference`]) on the mesh of [`super::whole`], refined under the probe.
//!
//! The surface nodes of the elements lie on the shape of the scene, and their edges follow it: the
//! facets of the patch, which is cut out of the same mesh, do so only on average. At the site the
//! force is extrapolated from two meshes. At other places only the coarser mesh is solved, and its
//! force is multiplied by the ratio of the extrapolated to the coarse force at the site, since the
//! effect of the mesh is much the same at both places.

use std::sync::atomic::{AtomicUsize, Ordering};

use nalgebra::Vector3;
use rayon::prelude::{IntoParallelRefIterator, ParallelIterator};

use crate::far_field::shape_surface::ShapeSurface;
use crate::far_field::whole::shape_of;
use crate::reference::body::{Body, Stiffness};
use crate::reference::curved::curved;
use crate::reference::newton::Press;
use crate::reference::probe::RigidProbe;
use crate::reference::quadratic::QuadraticMesh;
use crate::reference::refine::refine;
use crate::reference::shape::{TET_EDGES, TetRule};
use crate::solved::Solved;
use palpate_tissue::error::Error;
use palpate_tissue::organ::tangents;
use palpate_tissue::scene::Scene;
use palpate_tissue::tissue::organ_source::{OrganSource, held};
use palpate_tissue::tissue::{Layout, Placed};

type V3 = Vector3<f64>;

/// Refinement of a mesh under the probe: longest edge, divided by the radius of the smallest
/// contact, and growth of the longest edge with the distance beyond that radius (1).
#[derive(Clone, Copy, Debug, PartialEq)]
struct Level {
    edge: f64,
    growth: f64,
}

const COARSE: Level = Level { edge: 1.4, growth: 0.9 };
const FINE: Level = Level { edge: 1.0, growth: 0.65 };
/// Upper limit of the radius of the smallest contact [probe radii].
const LARGEST_RADII: f64 = 0.35;
/// Maximum number of corner nodes of a mesh.
const MOST_NODES: usize = 6000;

/// Forces of presses at several places to several depths.
#[derive(Clone, Debug, PartialEq)]
pub struct OrganReference {
    /// Forces in the requested order, shape \[places\].
    pub places: Vec<PlaceForces>,
    /// Depths in ascending order [m], shape \[depths\].
    pub depths_m: Vec<f64>,
    /// Estimated error of the force at the site at each depth (1): the relative change between the
    /// two meshes.
    pub error: Vec<f64>,
    /// Number of nodes of the finest quadratic mesh.
    pub nodes: usize,
    /// Surface of the shape around the site.
    pub surface: ShapeSurface,
}

/// Forces at one place.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaceForces {
    /// Offset from the site along the two tangents of [`tangents`] [m].
    pub offset_m: [f64; 2],
    /// Place on the surface, at which the depth of the tip is zero [m].
    pub place_m: [f64; 3],
    /// Force along the site's axis, over the scene's Young's modulus [m^2], shape \[depths\].
    pub force_over_e_m2: Vec<f64>,
}

/// Result of the presses at one place to all depths, on one mesh.
struct Pressed {
    nodes: usize,
    force_over_e_m2: Vec<f64>,
}

/// Presses the organ of [`super::whole`] with the scene's probe along the axis of its site, without
/// friction, at each of `offsets_m` from the site and to each of `depths_m`, except for presses
/// that are in `solved`. It calls `progress` with the number of finished presses and their total
/// number.
///
/// # Errors
/// Fails if `depths_m` is empty or does not rise from above zero, if an offset misses the surface,
/// if there is no equilibrium at some depth, or if there is not enough memory.
pub fn organ_reference(
    scene: &Scene,
    placed: &Placed,
    offsets_m: &[[f64; 2]],
    depths_m: &[f64],
    solved: Option<&Solved>,
    progress: impl Fn(usize, usize) + Sync,
) -> Result<OrganReference, Error> {
    let bench = Bench::of(scene, placed, depths_m)?;
    let places = offsets_m.iter().map(|offset| bench.place(*offset)).collect::<Result<Vec<V3>, Error>>()?;
    let site = V3::from(placed.tissue.site_m);
    // a place at the site needs no press of its own
    let off_site: Vec<V3> = places.iter().copied().filter(|place| *place != site).collect();
    let tasks: Vec<(V3, Level)> =
        [(site, FINE), (site, COARSE)].into_iter().chain(off_site.into_iter().map(|place| (place, COARSE))).collect();
    let done = AtomicUsize::new(0);
    let press = |task: &(V3, Level)| -> Result<Pressed, Error> {
        let solve = || bench.press(task.0, task.1).map(|pressed| pressed.numbers().collect::<Vec<f64>>());
        let numbers = match solved {
            Some(solved) => solved.answer(&bench.problem(task), 1 + depths_m.len(), solve)?,
            None => solve()?,
        };
        progress(done.fetch_add(1, Ordering::Relaxed) + 1, tasks.len());
        Ok(Pressed::of(&numbers))
    };
    let mut pressed = tasks.par_iter().map(press).collect::<Result<Vec<Pressed>, Error>>()?.into_iter();
    let (Some(fine), Some(coarse)) = (pressed.next(), pressed.next()) else {
        return Err(Error::Usage(format!("{}: no press was asked for: give places and depths", scene.file)));
    };
    // convergence is of third order in the edge under the probe, as in
    // [`crate::reference::extrapolate`]
    let gain = (COARSE.edge / FINE.edge).powi(3) - 1.0;
    let both = || fine.force_over_e_m2.iter().zip(&coarse.force_over_e_m2);
    let ratio: Vec<f64> = both().map(|(f, c)| (f + (f - c) / gain) / c).collect();
    let error = both().map(|(f, c)| (f - c).abs() / f).collect();
    let scaled = |own: &Pressed| own.force_over_e_m2.iter().zip(&ratio).map(|(f, ratio)| f * ratio).collect();
    let at_places = offsets_m.iter().zip(&places).map(|(offset_m, place)| {
        let force_over_e_m2 =
            if *place == site { scaled(&coarse) } else { pressed.next().map_or_else(Vec::new, |own| scaled(&own)) };
        PlaceForces { offset_m: *offset_m, place_m: (*place).into(), force_over_e_m2 }
    });
    let at_places: Vec<PlaceForces> = at_places.collect();
    Ok(OrganReference { places: at_places, depths_m: depths_m.to_vec(), error, nodes: fine.nodes, surface: bench.surface })
}

impl Pressed {
    fn numbers(self) -> impl Iterator<Item = f64> {
        std::iter::once(self.nodes as f64).chain(self.force_over_e_m2)
    }

    fn of(numbers: &[f64]) -> Self {
        let (nodes, forces) = numbers.split_first().map_or((0.0, &[][..]), |(nodes, forces)| (*nodes, forces));
        Self { nodes: nodes as usize, force_over_e_m2: forces.to_vec() }
    }
}

/// Inputs that are common to all presses.
struct Bench<'a> {
    scene: &'a Scene,
    placed: &'a Placed,
    layout: Layout,
    /// Shape of the tissue; `None` for a block.
    shape: Option<OrganSource>,
    surface: ShapeSurface,
    depths_m: &'a [f64],
}

impl<'a> Bench<'a> {
    fn of(scene: &'a Scene, placed: &'a Placed, depths_m: &'a [f64]) -> Result<Self, Error> {
        let rise = depths_m.first().is_some_and(|d| *d > 0.0) && depths_m.is_sorted_by(|a, b| a < b);
        if !rise || !depths_m.iter().all(|d| d.is_finite()) {
            return Err(Error::Usage(format!(
                "{}: depths {depths_m:?} do not rise from above zero: give rising metres",
                scene.file
            )));
        }
        let shape = if scene.tissue.block_m.is_some() { None } else { Some(shape_of(scene)?) };
        let surface = ShapeSurface::of(placed, shape.as_ref(), scene.probe.tip().reach_m());
        Ok(Self { scene, placed, layout: Layout::of(scene)?, shape, surface, depths_m })
    }

    /// The point at which a line along the axis, through an offset in the tangent plane, meets the
    /// surface.
    fn place(&self, offset_m: [f64; 2]) -> Result<V3, Error> {
        let site = V3::from(self.placed.tissue.site_m);
        if offset_m == [0.0; 2] {
            return Ok(site);
        }
        let (axis, [first, second]) = (V3::from(self.placed.axis), tangents(self.placed.axis).map(V3::from));
        let plane = first * offset_m[0] + second * offset_m[1];
        let height_m = self.surface.height_m(plane).ok_or_else(|| {
            let file = &self.scene.file;
            Error::Usage(format!("{file}: no surface lies {offset_m:?} m from the site in its tangent plane: press nearer to it"))
        })?;
        Ok(site + plane + axis * height_m)
    }

    /// Text of all inputs on which the forces of a press depend.
    fn problem(&self, task: &(V3, Level)) -> String {
        let (tissue, probe, own) = (&self.placed.tissue, &self.scene.probe, &self.scene.tissue);
        // an organ is identified by its name, as its shape is code
        let ratio = |pascal: f64| pascal / own.youngs_modulus_pa;
        let regions = own.region.iter().map(|region| (&region.name, ratio(region.youngs_modulus_pa)));
        let regions: Vec<_> = regions.collect();
        let own = (probe.shape, probe.radius_m, own.poisson_ratio, own.stiffening_b, &own.organ, regions, &own.inclusion);
        let presses = (self.placed.axis, tissue.site_m, self.depths_m, task);
        format!("curved\n{own:?}\n{presses:?}\n{:?}", tissue.mesh)
    }

    fn press(&self, place: V3, level: Level) -> Result<Pressed, Error> {
        let probe = &self.scene.probe;
        let smallest_m = (probe.radius_m * self.depths_m[0]).sqrt().min(LARGEST_RADII * probe.radius_m);
        let longest_m =
            |x: [f64; 3]| level.edge * smallest_m + level.growth * ((V3::from(x) - place).norm() - smallest_m).max(0.0);
        let mesh = &self.placed.tissue.mesh;
        let mesh = refine(mesh, longest_m, MOST_NODES.max(mesh.nodes_m.len()));
        let organ = self.shape.as_ref().and_then(OrganSource::organ);
        let anchors = held(&mesh, self.placed.axis, organ);
        let mesh = match &self.shape {
            Some(shape) => curved(&mesh, |at_m| shape.nearest_m(at_m)),
            None => QuadraticMesh::new(&mesh),
        };
        let mut fixed = vec![[false; 3]; mesh.nodes_m.len()];
        for n in &anchors {
            fixed[*n as usize] = [true; 3];
        }
        // the middle of an edge between two fixed nodes is fixed too
        for tet in &mesh.tets {
            for (e, [i, j]) in TET_EDGES.into_iter().enumerate() {
                if fixed[tet[i] as usize][0] && fixed[tet[j] as usize][0] {
                    fixed[tet[4 + e] as usize] = [true; 3];
                }
            }
        }
        let free = |t: &[u32; 6]| !t.iter().all(|n| fixed[*n as usize][0]);
        let touchable = (0..mesh.triangles.len()).filter(|t| free(&mesh.triangles[*t])).collect();
        let poisson_ratio = self.scene.tissue.poisson_ratio;
        // layers and balls cut through elements
        let uniform = self.layout.is_uniform();
        let rule = if uniform { TetRule::Four } else { TetRule::Eleven };
        let stiffness = |_: usize, x: &V3| Stiffness {
            ratio: if uniform { 1.0 } else { self.layout.ratio_at((*x).into()) },
            poisson_ratio,
            stiffening_b: self.layout.exponent_at((*x).into()),
        };
        let body = Body::with_stiffness(mesh, stiffness, fixed, touchable, 1.0, rule);
        let rigid = RigidProbe::new(probe.shape, probe.radius_m, place, V3::from(self.placed.axis));
        let file = &self.scene.file;
        let no_memory =
            || Error::Usage(format!("{file}: not enough memory for the finite elements of the organ: mesh it coarser"));
        let mut press = Press::new(&body, rigid, place).ok_or_else(no_memory)?;
        let mut force_over_e_m2 = Vec::with_capacity(self.depths_m.len());
        for depth_m in self.depths_m {
            press.go_to(*depth_m, |_| {}).map_err(|stalled| {
                let at: [f64; 3] = place.into();
                Error::Usage(format!(
                    "{file}: at {at:.4?} no equilibrium was found deeper than {:.5} m: press less deep",
                    stalled.reached_m
                ))
            })?;
            force_over_e_m2.push(press.force_over_e_m2());
        }
        Ok(Pressed { nodes: body.mesh.nodes_m.len(), force_over_e_m2 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::far_field::Sizes;
    use crate::far_field::whole::whole;
    use palpate_tissue::scene::Shape;

    #[test]
    fn whatever_changes_the_forces_changes_the_problem() {
        let sizes = Sizes { radius_m: 0.017, fine_m: 0.0046, fine_radius_m: 0.008, growth: 0.45 };
        let problem = |change: fn(&mut Scene), depth_m: f64, place: [f64; 3]| {
            let mut scene = Scene::load("organ-liver").unwrap();
            change(&mut scene);
            let placed = whole(&scene, &[], &sizes).unwrap();
            let depths_m = [depth_m];
            Bench::of(&scene, &placed, &depths_m).unwrap().problem(&(place.into(), COARSE))
        };
        let own = problem(|_| {}, 1e-3, [0.0; 3]);
        assert_eq!(own, problem(|_| {}, 1e-3, [0.0; 3]));
        assert!(!own.contains("0x"), "an address is another one in the next run");
        assert_eq!(own, problem(|scene| scene.tissue.youngs_modulus_pa *= 2.0, 1e-3, [0.0; 3]));
        let others = [
            problem(|_| {}, 1.1e-3, [0.0; 3]),
            problem(|_| {}, 1e-3, [1e-9, 0.0, 0.0]),
            problem(|scene| scene.tissue.poisson_ratio = 0.44, 1e-3, [0.0; 3]),
            problem(|scene| scene.probe.radius_m = 0.0081, 1e-3, [0.0; 3]),
            problem(|scene| scene.probe.shape = Shape::Flat, 1e-3, [0.0; 3]),
            problem(|scene| scene.probe.site = Some([0.001, 0.044, 0.046]), 1e-3, [0.0; 3]),
        ];
        for (n, other) in others.iter().enumerate() {
            assert!(*other != own && !others[..n].contains(other), "{n}");
        }
    }

    /// STL text of a cap of a sphere on a cylinder, in millimetres.
    fn dome(sphere: f64, rim: f64, base: f64) -> String {
        const AROUND: usize = 64;
        const RINGS: usize = 32;
        let (widest, below) = ((rim / sphere).asin(), (sphere * sphere - rim * rim).sqrt());
        let at = |ring: usize, k: usize| {
            let (polar, turn) =
                (widest * ring as f64 / RINGS as f64, std::f64::consts::TAU * (k % AROUND) as f64 / AROUND as f64);
            [sphere * polar.sin() * turn.cos(), sphere * polar.sin() * turn.sin(), sphere * polar.cos() - below + base]
        };
        let foot = |k: usize| [at(RINGS, k)[0], at(RINGS, k)[1], 0.0];
        let mut triangles = Vec::new();
        for k in 0..AROUND {
            triangles.push([at(0, 0), at(1, k), at(1, k + 1)]);
            for ring in 1..RINGS {
                triangles.push([at(ring, k), at(ring + 1, k), at(ring + 1, k + 1)]);
                triangles.push([at(ring, k), at(ring + 1, k + 1), at(ring, k + 1)]);
            }
            triangles.push([at(RINGS, k), foot(k), foot(k + 1)]);
            triangles.push([at(RINGS, k), foot(k + 1), at(RINGS, k + 1)]);
            triangles.push([[0.0; 3], foot(k + 1), foot(k)]);
        }
        let corner = |[x, y, z]: &[f64; 3]| format!("vertex {x:.6} {y:.6} {z:.6}\n");
        let facet = |t: &[[f64; 3]; 3]| {
            format!("facet normal 0 0 0\nouter loop\n{}endloop\nendfacet\n", t.iter().map(corner).collect::<String>())
        };
        format!("solid dome\n{}endsolid dome\n", triangles.iter().map(facet).collect::<String>())
    }

    /// A dome is pressed where the file says that its surface is: with the chords of its mesh, the
    /// force half a millimetre deep was 16 % lower.
    #[test]
    fn a_shallow_press_of_a_dome_is_that_of_hertz() {
        const SPHERE_MM: f64 = 45.0;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("dome.stl");
        std::fs::write(&path, dome(SPHERE_MM, 38.0, 12.0)).unwrap();
        let below_mm = (SPHERE_MM * SPHERE_MM - 38.0 * 38.0_f64).sqrt();
        let mut scene = Scene::load("block").unwrap();
        scene.tissue.block_m = None;
        scene.tissue.mesh = Some(path);
        scene.tissue.length_unit = Some(palpate_tissue::mesh::LengthUnit { metres: 1e-3 });
        scene.probe.position_m = None;
        scene.probe.site = Some([0.0, 0.0, (12.0 + SPHERE_MM - below_mm) * 1e-3]);
        let sizes = Sizes { radius_m: 0.017, fine_m: 0.0046, fine_radius_m: 0.008, growth: 0.45 };
        let placed = whole(&scene, &[], &sizes).unwrap();
        let depth_m = 0.0005;
        let found = organ_reference(&scene, &placed, &[[0.0; 2]], &[depth_m], None, |_, _| {}).unwrap();
        let force_m2 = found.places[0].force_over_e_m2[0];
        // a sphere on a sphere, both on thick ground (Johnson, Contact Mechanics, 4.2)
        let radius_m = 1.0 / (1.0 / 0.008 + 1e3 / SPHERE_MM);
        let hertz_m2 = 4.0 / 3.0 / (1.0 - 0.45_f64.powi(2)) * radius_m.sqrt() * depth_m.powf(1.5);
        println!("{force_m2:e} of {hertz_m2:e} m^2, elements within {:.3}", found.error[0]);
        assert!((force_m2 / hertz_m2 - 1.0).abs() < 0.04, "{force_m2:e} of {hertz_m2:e} m^2");
    }
}
