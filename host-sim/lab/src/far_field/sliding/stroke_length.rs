//! Cost of a longer stroke: number of nodes, and cost of the most expensive tick on the boards.

use serde::Serialize;

use super::study_methods::{StrokeRecipe, whole_block};
use crate::error::Error;
use palpate_fit::far_field::{Cut, Sizes};
use palpate_tissue::Error as TissueError;
use palpate_tissue::budget::{MACHINES, triangles_in_reach};
use palpate_tissue::patch::{Material, Patch};
use palpate_tissue::scene::Scene;

/// Lengths of the strokes along the first side of the block [m].
const STROKES_M: [f64; 5] = [0.0, 0.01, 0.02, 0.03, 0.04];

/// A patch for a stroke. Rim springs are left out: they are 5-10 % of a tick.
#[derive(Clone, Debug, Serialize)]
pub struct StrokeLength {
    /// Length of the stroke [mm].
    pub stroke_mm: f64,
    /// Number of nodes.
    pub nodes: usize,
    /// Number of tets.
    pub tets: usize,
    /// Share of a millisecond that a tick with one substep takes on each machine, without rim
    /// springs [%].
    pub share_pct: Vec<(&'static str, f64)>,
}

/// Cuts a patch by the recipe for every stroke, without fitting it.
pub(super) fn measure(scene: &Scene, recipe: &StrokeRecipe) -> Result<Vec<StrokeLength>, Error> {
    let one = |stroke_m: &f64| {
        let sizes = Sizes { stroke_m: [*stroke_m, 0.0, 0.0], ..recipe.sizes };
        let placed = whole_block(scene, &StrokeRecipe { sizes, ..*recipe })?;
        let cut = Cut::of(&placed.tissue, &sizes).map_err(|cause| TissueError::Usage(format!("{}: {cause}", scene.file)))?;
        let material = Material { points_per_triangle: recipe.points_per_triangle, ..Material::default() };
        let patch = Patch::build(&cut.patch, &material, None);
        let model = patch.model();
        let touched = triangles_in_reach(&model, patch.site_m().into(), scene.probe.radius_m as f32);
        let share = |m: &'static palpate_tissue::budget::CostModel| {
            let cost = m.cost(&model, touched, 1);
            (m.name, 100.0 * m.load * cost.units / cost.budget)
        };
        let share_pct = MACHINES.iter().map(share).collect();
        Ok(StrokeLength { stroke_mm: stroke_m * 1e3, nodes: model.nodes.len(), tets: model.tets.len(), share_pct })
    };
    STROKES_M.iter().map(one).collect()
}
