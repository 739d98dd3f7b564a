//! Interface of the model that answers a pose with a force, and the patch as such a model.

use crate::haptic::damping::hertz_slope_n_per_m;
use crate::model::Model;
use crate::params::Tuned;
use crate::stages::output::Output;
use crate::stages::probe::ProbePose;
use crate::state::State;
use crate::tick::tick;

/// A model that answers a pose with a force: the patch, or a simpler one to compare it with.
pub trait Renderer {
    /// Computes the output for a pose; called once per tick.
    fn render(&mut self, pose: ProbePose) -> Output;

    /// Returns to rest and clears a fault of the renderer.
    fn reset(&mut self);

    /// Tangent stiffness along the normal for the latest output [N/m]; by default that of a Hertz
    /// contact.
    fn tangent_n_per_m(&self, output: &Output) -> f32 {
        hertz_slope_n_per_m(output)
    }

    /// Stiffness of the contact at the depth limit [N/m], to which the loop fits its gain
    /// ([`crate::haptic::ceiling`]); zero for a model that was found soft enough before, as on a
    /// board.
    fn stiffness_n_per_m(&self) -> f32 {
        0.0
    }
}

/// The product's patch as a renderer.
#[derive(Debug)]
pub struct PatchRenderer<'a, 'm> {
    /// Constant model of the patch.
    pub model: &'a Model<'m>,
    /// Parameters derived from the model for this tissue and tick.
    pub tuned: &'a Tuned<'m>,
    /// State of the patch, which every tick changes.
    pub state: &'a mut State<'m>,
}

impl Renderer for PatchRenderer<'_, '_> {
    fn render(&mut self, pose: ProbePose) -> Output {
        tick(self.model, self.tuned, self.state, pose)
    }

    fn reset(&mut self) {
        self.state.reset(self.model);
    }
}
