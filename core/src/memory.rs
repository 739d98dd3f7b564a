//! Memory of one running patch, reserved as a single object: on a board, one `static`.
//!
//! ```text
//! Model (flash) ─┐
//! Params ────────┴─ Memory::start ─┬─ Tuned  read by the tick: masses
//!                                  └─ State  written by the tick: nodes, triangles near the probe
//! ```
//!
//! A caller with a heap, or with patches of any size, passes its own slices to [`Params::build`]
//! and [`State::new`] instead.
//!
//! * in: a model and parameters
//! * out: the arguments of [`crate::tick()`]
//! * cost: nothing within the tick
//! * fails if the patch does not fit or is refused

use heapless::Vec;

use crate::bristle::Bristle;
use crate::fault::BuildError;
use crate::inertia::NodeStep;
use crate::model::Model;
use crate::params::{Params, Tuned};
use crate::state::{Faded, Node, State, TetShapes};

/// Arrays for a patch of at most `NODES` nodes and `TRIANGLES` surface triangles, on a desktop also
/// at most four tets per node. `RELAXING` is the largest number of nodes of a patch that relaxes,
/// at 36 bytes each on a board, or zero if no patch relaxes. `RUBBING` is the largest number of
/// nodes that a probe with friction holds at once, at 20 bytes each, or zero without friction.
#[derive(Debug)]
pub struct Memory<const NODES: usize, const TRIANGLES: usize, const RELAXING: usize, const RUBBING: usize> {
    nodes: Vec<Node, NODES>,
    node_step: Vec<NodeStep, NODES>,
    candidates: Vec<u16, TRIANGLES>,
    faded: Vec<Faded, RELAXING>,
    bristles: Vec<Bristle, RUBBING>,
    /// Scratch arrays for `judge`; the board uses the memory of the nodes instead.
    #[cfg(not(target_os = "none"))]
    scratch: [Vec<f32, NODES>; 2],
    /// Gradients and volumes of the tets, which the desktop keeps and the board computes twice.
    #[cfg(not(target_os = "none"))]
    shapes: Vec<TetShapes, NODES>,
}

impl<const NODES: usize, const TRIANGLES: usize, const RELAXING: usize, const RUBBING: usize>
    Memory<NODES, TRIANGLES, RELAXING, RUBBING>
{
    /// Empty memory without a patch, the initial value of a `static`.
    pub const RESERVED: Self = Self {
        nodes: Vec::new(),
        node_step: Vec::new(),
        candidates: Vec::new(),
        faded: Vec::new(),
        bristles: Vec::new(),
        #[cfg(not(target_os = "none"))]
        scratch: [Vec::new(), Vec::new()],
        #[cfg(not(target_os = "none"))]
        shapes: Vec::new(),
    };

    /// Puts a patch at rest into this memory; the previous patch is lost.
    ///
    /// # Errors
    /// Errors of [`Params::build`]; [`BuildError::TooLarge`] names the memory that is too small.
    #[inline]
    pub fn start(&mut self, model: &Model, params: &Params) -> Result<(Tuned<'_>, State<'_>), BuildError> {
        self.start_in_rounds(model, params, &mut || {})
    }

    /// Like [`Memory::start`], but calls `after_round` as [`Params::build_in_rounds`] does.
    ///
    /// # Errors
    /// Errors of [`Memory::start`].
    #[inline]
    pub fn start_in_rounds(
        &mut self,
        model: &Model,
        params: &Params,
        after_round: &mut dyn FnMut(),
    ) -> Result<(Tuned<'_>, State<'_>), BuildError> {
        fill("nodes", &mut self.nodes, model.nodes.len(), Node::ZERO)?;
        fill("surface triangles", &mut self.candidates, model.triangles.len(), 0)?;
        fill("nodes", &mut self.node_step, model.nodes.len(), NodeStep::ZERO)?;
        #[cfg(target_os = "none")]
        let shapes: &mut [TetShapes] = &mut [];
        #[cfg(not(target_os = "none"))]
        let shapes = {
            fill("tet shapes", &mut self.shapes, TetShapes::count(model), TetShapes::ZERO)?;
            &mut self.shapes[..]
        };
        let tuned = params.build_in_rounds(model, &mut self.node_step, after_round)?;
        let mut state = State::new(model, &mut self.nodes, &mut self.candidates, shapes)?;
        if tuned.relaxes() {
            fill("nodes that relax", &mut self.faded, model.nodes.len(), Faded::ZERO)?;
            state = state.with_relaxation(&mut self.faded)?;
        }
        if tuned.rubs() {
            fill("nodes that a probe with friction holds", &mut self.bristles, RUBBING.max(1), Bristle::ZERO)?;
            state = state.with_friction(&mut self.bristles);
        }
        Ok((tuned, state))
    }

    /// Derives the masses for `params` and returns them with two scratch arrays of one entry per
    /// node, for checking a patch before it is started. The patch in this memory is lost.
    /// `after_round` is that of [`Params::build_in_rounds`].
    ///
    /// # Errors
    /// Errors of [`Params::build`]; [`BuildError::TooLarge`] names the memory that is too small.
    #[inline]
    pub fn judge(
        &mut self,
        model: &Model,
        params: &Params,
        after_round: &mut dyn FnMut(),
    ) -> Result<(Tuned<'_>, [&mut [f32]; 2]), BuildError> {
        fill("nodes", &mut self.node_step, model.nodes.len(), NodeStep::ZERO)?;
        let nodes = model.nodes.len();
        #[cfg(target_os = "none")]
        let scratch = {
            fill("nodes", &mut self.nodes, nodes, Node::ZERO)?;
            // a node is fifteen floats: room for both arrays
            let (a, others) = bytemuck::cast_slice_mut(&mut self.nodes).split_at_mut(nodes);
            [a, others.get_mut(..nodes).unwrap_or_default()]
        };
        #[cfg(not(target_os = "none"))]
        let scratch = {
            let [a, b] = &mut self.scratch;
            fill("nodes", a, nodes, 0.0)?;
            fill("nodes", b, nodes, 0.0)?;
            [&mut a[..], &mut b[..]]
        };
        Ok((params.build_in_rounds(model, &mut self.node_step, after_round)?, scratch))
    }
}

/// Sets the length of an array to `need` and every entry to `value`.
#[inline]
fn fill<T: Clone, const N: usize>(item: &'static str, array: &mut Vec<T, N>, need: usize, value: T) -> Result<(), BuildError> {
    array.clear();
    array.resize(need, value).map_err(|_| BuildError::TooLarge { item, need, have: N })
}
