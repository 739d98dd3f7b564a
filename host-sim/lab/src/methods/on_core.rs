//! Runs explicit methods on the core: the core moves the nodes and presses the surface, and the
//! method provides the internal forces of the tissue.
//!
//! The core's tick runs with springs and volume terms off. Its force stage adds the internal forces
//! of the method to the nodes and then presses the surface with the product's contact; the core's
//! step of symplectic Euler follows.

use palpate::method::Method;
use palpate::stages::force::{self, foundation::Load};
use palpate::{Fault, Model, NodeRest, Params, ProbePose, State, Terms, Tuned, Vector3, tick_with};

use super::{Block, RunningMethod};
use palpate_tissue::error::Error;
use palpate_tissue::patch::{Material, Memory, Patch};

/// Internal forces of a material on a mesh.
pub trait Law {
    /// Writes the force on every node over E [N/Pa].
    fn forces(&mut self, position_m: &[Vector3<f32>], force: &mut [Vector3<f32>]);

    /// Mean diagonal stiffness over E of each node at rest [m], shape \[nodes\].
    fn diagonal_m(&self) -> &[f32];
}

/// A method together with the core that runs it.
#[derive(Debug)]
pub struct OnCore<'a, M> {
    /// Mesh, springs, masses and surface.
    pub model: &'a Model<'a>,
    /// Constants derived from model and parameters.
    pub tuned: &'a Tuned<'a>,
    /// Positions and velocities.
    pub state: State<'a>,
    /// Stages of the tick that the method replaces.
    pub method: M,
}

impl<M: Method> RunningMethod for OnCore<'_, M> {
    fn tick(&mut self, tip_m: Vector3<f32>) -> Result<Vector3<f32>, Fault> {
        let output = tick_with(self.model, self.tuned, &mut self.state, ProbePose { tip_m }, &mut self.method);
        output.fault.map_or(Ok(output.force_n), Err)
    }

    fn position_m(&self, node: usize) -> Vector3<f32> {
        self.state.nodes()[node].position_m()
    }
}

/// A method of the core whose internal forces are those of a law.
struct Forced<L> {
    law: L,
    position_m: Vec<Vector3<f32>>,
    force: Vec<Vector3<f32>>,
}

impl<L: Law> Method for Forced<L> {
    fn force(&mut self, model: &Model, tuned: &Tuned, state: &mut State, tip_m: Vector3<f32>, speed: Vector3<f32>) -> Load {
        force::accumulate_inner(model, tuned, state);
        let Self { law, position_m, force } = self;
        for (x, node) in position_m.iter_mut().zip(state.nodes()) {
            *x = node.position_m();
        }
        law.forces(position_m, force);
        force.iter().enumerate().for_each(|(n, f)| state.add_force(n, *f));
        force::foundation::press(model, tuned, state, tip_m, speed)
    }
}

/// Builds the core for a block with the internal forces of a law, and passes it to `work`.
pub(super) fn with_law<T>(
    block: &Block,
    params: &Params,
    law: impl Law,
    work: impl FnOnce(&mut dyn RunningMethod) -> T,
) -> Result<T, Error> {
    let patch = Patch::build(&block.tissue, &Material::default(), None);
    let whole = patch.wide_model();
    let nodes: Vec<NodeRest> =
        whole.nodes.iter().zip(law.diagonal_m()).map(|(n, &d)| NodeRest { stiffness_m: d, ..*n }).collect();
    let model = Model { nodes: &nodes, springs: &[], ..whole };
    let params = Params { terms: Terms::SPRINGS_ONLY, ..*params };
    let mut memory = Memory::for_model(&model);
    let (tuned, state) = memory.start(&model, &params)?;
    let at_origin = vec![Vector3::zeros(); nodes.len()];
    let method = Forced { law, position_m: at_origin.clone(), force: at_origin };
    Ok(work(&mut OnCore { model: &model, tuned: &tuned, state, method }))
}
