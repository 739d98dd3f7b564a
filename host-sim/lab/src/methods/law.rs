//! The product's law without nodes, fitted to a tissue or, if none was, to the stored answer of the
//! preset block.

use palpate::method::Product;
use palpate::{ClampFlags, Fault, Params, Vector3};
use palpate_fit::force_map::BlockForces;
use palpate_fit::law_fit::{LawPresses, STORED_RADII, block_shape, fit, stored};
use palpate_tissue::error::Error;
use palpate_tissue::patch::{Memory, Patch};
use palpate_tissue::scene::Scene;

use super::on_core::OnCore;
use super::{BLOCK_M, Block, RunningMethod};

/// A running law; the nodes of the chart's mesh stay where they are.
struct Running<'a> {
    core: OnCore<'a, Product>,
    nodes_m: &'a [[f64; 3]],
}

impl RunningMethod for Running<'_> {
    fn tick(&mut self, tip_m: Vector3<f32>) -> Result<Vector3<f32>, Fault> {
        self.core.tick(tip_m)
    }

    fn position_m(&self, node: usize) -> Vector3<f32> {
        self.nodes_m.get(node).map_or_else(Vector3::zeros, |at| Vector3::from(at.map(|c| c as f32)))
    }

    fn has_surface(&self) -> bool {
        false
    }

    fn limiters(&self) -> ClampFlags {
        self.core.limiters()
    }
}

/// The law of the standard block.
pub fn law() -> Result<Patch, Error> {
    let scene = Scene::load("block")?;
    let lacks = || Error::Check("the stored answer of the block lacks presses that a law needs: take it as it ships".into());
    let (known, _, depths_m) = stored(&scene).ok_or_else(lacks)?;
    let known = BlockForces::of(&known).ok_or_else(lacks)?;
    let depths_m = [depths_m.first(), depths_m.last()].map(|m| m.copied().unwrap_or_default());
    let presses = LawPresses { known: &known, depths_m, reach_radii: STORED_RADII };
    Ok(fit(&scene, &block_shape(BLOCK_M, [0.0; 3], depths_m[1]), [0.0, 0.0, 1.0], &presses)?.0)
}

/// Runs the law under the probe and with the modulus of a block.
pub(super) fn with<T>(block: &Block, params: &Params, work: impl FnOnce(&mut dyn RunningMethod) -> T) -> Result<T, Error> {
    let patch = block.fitted.law.clone().map_or_else(law, Ok)?;
    let model = patch.wide_model();
    let mut memory = Memory::for_model(&model);
    let (tuned, state) = memory.start(&model, params)?;
    let core = OnCore { model: &model, tuned: &tuned, state, method: Product };
    Ok(work(&mut Running { core, nodes_m: &block.tissue.mesh.nodes_m }))
}
