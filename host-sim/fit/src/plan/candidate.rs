//! Search space of the plan: radius of the patch, size of its elements, number of foundation
//! points. The cost of each candidate is computed here too.

use palpate::Params;
use rayon::prelude::{IntoParallelRefIterator, ParallelIterator};
use serde::Serialize;

use crate::far_field::FarField;
use crate::far_field::prepared::{Prepared, Recipe};
use palpate_tissue::budget::{CostModel, Counts, triangles_in_reach};
use palpate_tissue::error::Error;
use palpate_tissue::patch::{Material, Patch};
use palpate_tissue::scene::Scene;
use palpate_tissue::session::Session;
use palpate_tissue::tissue::Tissue;
use palpate_tissue::tissue::{Placed, place};

/// Radii of the patch, small first, and edge lengths at the site, coarse first [probe radii].
const RADII: [f64; 5] = [1.5, 1.75, 2.0, 2.25, 2.5];
const ELEMENTS: [f64; 10] = [1.1, 1.0, 0.88, 0.78, 0.68, 0.58, 0.52, 0.48, 0.43, 0.4];
/// Radii and edge lengths of a quick search, in the order of those above [probe radii].
const QUICK_RADII: [f64; 3] = [1.5, 1.75, 2.0];
const QUICK_ELEMENTS: [f64; 7] = [1.0, 0.88, 0.78, 0.68, 0.58, 0.48, 0.4];
/// Numbers of nodes of whole blocks, which are tried as a last resort.
const WHOLE_NODES: [usize; 4] = [60, 130, 250, 410];

/// One point of the search space.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Candidate {
    /// Radius of the patch [probe radii]; infinite for a whole block.
    pub radius_radii: f64,
    /// Edge length at the site [probe radii]; zero for a whole block, which is given by its number
    /// of nodes.
    pub element_radii: f64,
    /// Number of foundation points per triangle.
    pub points_per_triangle: usize,
}

/// A candidate with its mesh, its far field and its cost, before the fit.
#[derive(Clone, Debug)]
pub struct Weighed {
    /// Point of the search space.
    pub candidate: Candidate,
    /// Mesh of the whole organ, with site and axis.
    pub placed: Placed,
    /// Far field of the patch; `None` for a whole block.
    pub far: Option<FarField>,
    /// Constants of the material.
    pub material: Material,
    /// Parameters of the scene.
    pub params: Params,
    /// Numbers of nodes, springs, tets and the other items that cost time.
    pub counts: Counts,
    /// Number of substeps per tick that the unfitted patch needs.
    pub substeps: u16,
    /// Cost per tick on the board of the plan [units of the board].
    pub units: f64,
    /// Size of the patch file [bytes].
    pub patch_bytes: usize,
}

impl Weighed {
    /// Returns the tissue to be fitted: the patch that was cut out, or the whole block without a
    /// far field.
    #[must_use]
    pub fn tissue(&self) -> &Tissue {
        self.far.as_ref().map_or(&self.placed.tissue, |far| &far.cut.patch)
    }

    /// Whether the candidate meets the limits of the board on time and memory.
    #[must_use]
    pub fn fits(&self, machine: &CostModel) -> bool {
        self.units <= machine.budget() && machine.has_room(&self.counts, self.patch_bytes)
    }

    fn of(
        candidate: Candidate,
        placed: Placed,
        far: Option<FarField>,
        material: Material,
        params: Params,
        machine: &CostModel,
    ) -> Result<Self, Error> {
        let patch = match &far {
            Some(far) => far.patch(&material),
            None => Patch::build(&placed.tissue, &material, None),
        };
        let touched = triangles_in_reach(&patch.model(), patch.site_m().into(), params.probe.reach_m());
        let counts = Counts::of(&patch.model(), touched);
        let session = Session::of_fitted(machine, patch, params)?;
        let params = machine.adapt(&params);
        let substeps = session.params.substeps;
        let units = machine.cost_of(&counts, &params, substeps).units;
        let patch_bytes = session.patch.pack(&session.params, 0.0).len();
        Ok(Self { candidate, placed, far, material, params, counts, substeps, units, patch_bytes })
    }
}

/// Generates the candidates of a scene, one element size after the other.
pub struct Supply<'a> {
    scene: &'a Scene,
    machine: &'a CostModel,
    radii: &'static [f64],
    elements: &'static [f64],
    next: usize,
    both_foundations: bool,
    /// First error of a refused candidate, which is reported if there is no candidate at all.
    pub refused: Option<Error>,
}

impl<'a> Supply<'a> {
    /// Prepares the candidates for a scene on a board.
    #[must_use]
    pub fn of(scene: &'a Scene, machine: &'a CostModel, quick: bool) -> Self {
        let (radii, elements): (&[f64], &[f64]) = if quick { (&QUICK_RADII, &QUICK_ELEMENTS) } else { (&RADII, &ELEMENTS) };
        Self { scene, machine, radii, elements, next: 0, both_foundations: !quick, refused: None }
    }

    /// Patches of all radii with the next smaller elements, except those of more than `most_nodes`
    /// nodes or `most_units` per substep. Returns `None` if all patches are too large or there are
    /// no smaller elements.
    pub fn next(&mut self, most_units: f64, most_nodes: usize) -> Option<Vec<Weighed>> {
        let element_radii = *self.elements.get(self.next)?;
        let made: Vec<Result<Vec<Weighed>, Error>> =
            self.radii.par_iter().map(|r| self.weigh(*r, element_radii, most_units, most_nodes)).collect();
        let mut found = Vec::new();
        let mut smaller = false;
        for one in made {
            match one {
                Ok(list) => {
                    smaller |= !list.is_empty();
                    found.extend(list);
                }
                Err(cause) => {
                    // a radius may be too large for the organ, and a patch may fail in a press
                    smaller = true;
                    self.refused.get_or_insert(cause);
                }
            }
        }
        if !smaller {
            return None;
        }
        self.next += 1;
        Some(found)
    }

    fn weigh(&self, radius_radii: f64, element_radii: f64, most_units: f64, most_nodes: usize) -> Result<Vec<Weighed>, Error> {
        let probe_m = self.scene.probe.radius_m;
        let recipe = Recipe::new(radius_radii * probe_m, element_radii * probe_m, probe_m);
        let prepared = Prepared::of(self.scene, &recipe)?;
        let usual = recipe.points_per_triangle;
        let foundations: &[usize] = if self.both_foundations { &[4, 9] } else { &[usual][..] };
        let mut found = Vec::new();
        let mut refused = None;
        for &points_per_triangle in foundations {
            let material = Material { points_per_triangle, ..prepared.material };
            let patch = prepared.far.patch(&material);
            let touched = triangles_in_reach(&patch.model(), patch.site_m().into(), prepared.params.probe.reach_m());
            let counts = Counts::of(&patch.model(), touched);
            if counts.nodes > most_nodes || self.machine.cost_of(&counts, &prepared.params, 1).units > most_units {
                continue;
            }
            let candidate = Candidate { radius_radii, element_radii, points_per_triangle };
            let (placed, far) = (prepared.placed.clone(), Some(prepared.far.clone()));
            match Weighed::of(candidate, placed, far, material, prepared.params, self.machine) {
                Ok(weighed) => found.push(weighed),
                Err(cause) => refused = Some(cause),
            }
        }
        match refused {
            Some(cause) if found.is_empty() => Err(cause),
            _ => Ok(found),
        }
    }

    /// Whole blocks that fit the board, largest first; empty for an organ.
    pub fn whole_blocks(&self) -> Vec<Weighed> {
        if self.scene.tissue.block_m.is_none() {
            return Vec::new();
        }
        let sized = |nodes: &usize| {
            let mut scene = self.scene.clone();
            scene.tissue.nodes = Some(*nodes);
            let placed = place(&scene, &[]).ok()?;
            let params = scene.params(placed.axis);
            let material = Material { poisson_ratio: scene.tissue.poisson_ratio, ..Material::default() };
            let points_per_triangle = material.points_per_triangle;
            let candidate = Candidate { radius_radii: f64::INFINITY, element_radii: 0.0, points_per_triangle };
            let weighed = Weighed::of(candidate, placed, None, material, params, self.machine).ok()?;
            weighed.fits(self.machine).then_some(weighed)
        };
        WHOLE_NODES.iter().rev().filter_map(sized).collect()
    }
}
