//! A patch that owns its memory, so that it can live as long as a window.

use std::sync::Arc;

use palpate::haptic::cycle::Renderer;
use palpate::{
    Bristle, BuildError, ContactMap, FIELDS, Faded, Fault, Gains, Node, NodeStep, Output, Params, Parked, ProbePose, State,
    TetShapes, tick,
};

use crate::closed_loop::surface::tangent_m;
use crate::closed_loop::watch::{RestShape, RestSolid};
use palpate_tissue::patch::Patch;

/// A patch with its parameters and state, which owns all of its arrays.
#[derive(Clone, Debug)]
pub struct LiveTissue {
    patch: Patch,
    params: Params,
    /// Orientation that the probe is turned to.
    turns_to: [f32; 4],
    nodes: Vec<Node>,
    candidates: Vec<u16>,
    shapes: Vec<TetShapes>,
    node_step: Vec<NodeStep>,
    gains: Gains,
    faded: Vec<Faded>,
    bristles: Vec<Bristle>,
    held: Parked,
    /// Whether the next tick resets the patch to rest and returns no force, as on the board;
    /// otherwise the two would differ by that tick.
    resting: bool,
    /// Tangent stiffness of the contact at the depth limit, per pascal of Young's modulus [m].
    tangent_m: f32,
}

impl LiveTissue {
    /// Creates the tissue at rest.
    ///
    /// # Errors
    /// Propagates errors from [`Params::build`].
    pub fn new(patch: Patch, params: Params) -> Result<Self, BuildError> {
        let (nodes, triangles, shapes) = {
            let model = patch.wide_model();
            (model.nodes.len(), model.triangles.len(), TetShapes::count(&model))
        };
        let mut tissue = Self {
            params,
            turns_to: params.orientation,
            nodes: vec![Node::ZERO; nodes],
            candidates: vec![0; triangles],
            shapes: vec![TetShapes::ZERO; shapes],
            node_step: vec![NodeStep::ZERO; nodes],
            gains: [0.0; FIELDS],
            faded: vec![Faded::ZERO; nodes],
            bristles: vec![Bristle::ZERO; nodes],
            held: Parked::default(),
            resting: false,
            tangent_m: tangent_m(&patch, &params)?,
            patch,
        };
        tissue.gains = params.build(&tissue.patch.wide_model(), &mut tissue.node_step)?.gains();
        tissue.rest();
        Ok(tissue)
    }

    /// The patch with its mesh and springs.
    #[must_use]
    pub fn patch(&self) -> &Patch {
        &self.patch
    }

    /// Parameters of the patch.
    #[must_use]
    pub fn params(&self) -> &Params {
        &self.params
    }

    /// Geometry at rest, for the checks.
    #[must_use]
    pub fn rest_shape(&self) -> Arc<dyn RestShape> {
        Arc::new(RestSolid::of(&self.patch.model(), &self.params.turned_probe()))
    }

    /// Nodes of the patch, in the patch's order.
    #[must_use]
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// Stiffness of the contact at the depth limit [N/m].
    #[must_use]
    pub fn contact_n_per_m(&self) -> f32 {
        self.tangent_m * self.params.youngs_modulus_pa
    }

    /// Sets another stiffness or damping without stopping the motion. The smooth fields of the mass
    /// matrix remain those of the original parameters, as on a board.
    ///
    /// # Errors
    /// Fails if a parameter is out of range; nothing changes then.
    pub fn retune(&mut self, params: Params) -> Result<(), BuildError> {
        params.check()?;
        let model = self.patch.wide_model();
        let mut tuned = self.params.derive(&mut self.node_step, self.gains);
        params.retune(&model, &mut tuned);
        (self.gains, self.params) = (tuned.gains(), params);
        Ok(())
    }

    /// Turns the probe about its tip, from the next tick on, to the rotation from its upright pose
    /// that a unit quaternion x, y, z, w gives. As the guard limits the speed into the tissue, the
    /// probe turns no faster than its farthest point may sink.
    ///
    /// # Errors
    /// Fails if the quaternion is not one or tilts the probe by more than 45 degrees, or if a law
    /// answers, which was measured upright; nothing changes then.
    pub fn turn(&mut self, orientation: [f32; 4]) -> Result<(), BuildError> {
        Params { orientation, ..self.params }.check()?;
        if self.patch.model().law.is_some() {
            let tilt = orientation[0].hypot(orientation[1]).hypot(orientation[2]);
            BuildError::within("sine of half of the tilt over a law", tilt, 0.0, 0.0)?;
        }
        self.turns_to = orientation;
        Ok(())
    }

    /// Turns the probe by what a tick allows.
    fn follow(&mut self) {
        let (to, from) = (self.turns_to, self.params.orientation);
        if to == from {
            return;
        }
        // a quaternion and its opposite are the same rotation; the chord is half of the angle
        let near = if (0..4).map(|k| to[k] * from[k]).sum::<f32>() < 0.0 { to.map(|part| -part) } else { to };
        let chord = (0..4).map(|k| (near[k] - from[k]).powi(2)).sum::<f32>().sqrt();
        let reach_m = self.params.probe.reach_m();
        let most = 0.5 * self.params.limits.max_sink_m_per_s * self.params.tick_s / reach_m;
        self.params.orientation = if chord <= most {
            to
        } else {
            let between = [0, 1, 2, 3].map(|k| from[k] + (near[k] - from[k]) * (most / chord));
            let length = between.iter().map(|part| part * part).sum::<f32>().sqrt();
            between.map(|part| part / length)
        };
    }

    /// Contact map after the last tick; `pressure_pa` receives the pressure on each surface
    /// triangle [Pa] and may be empty. It allocates nothing and changes no tick.
    pub fn contact(&mut self, pressure_pa: &mut [f32]) -> ContactMap {
        let Self { patch, params, nodes, candidates, shapes, node_step, gains, faded, bristles, held, .. } = self;
        let model = patch.wide_model();
        let tuned = params.derive(node_step, *gains);
        let state = State::resume(&model, nodes, candidates, shapes, *held).and_then(|state| state.with_relaxation(faded));
        // sizes were checked when the tissue was created
        state.map_or(ContactMap::NONE, |state| {
            let mut state = state.with_friction(bristles);
            ContactMap::read(&model, &tuned, &mut state, pressure_pa)
        })
    }

    /// Hash of all positions and velocities.
    #[must_use]
    pub fn hash(&mut self) -> u64 {
        self.with_state(|_, state| state.hash()).unwrap_or_default()
    }

    /// Puts the tissue to rest at once, as when it was created.
    pub fn restart(&mut self) {
        self.resting = false;
        self.rest();
    }

    fn rest(&mut self) {
        // sizes were checked when the tissue was created
        let _fits = self.with_state(|model, state| state.reset(model));
    }

    fn with_state<T>(&mut self, work: impl FnOnce(&palpate::Model, &mut State) -> T) -> Result<T, BuildError> {
        let model = self.patch.wide_model();
        let mut state = State::resume(&model, &mut self.nodes, &mut self.candidates, &mut self.shapes, self.held)?
            .with_relaxation(&mut self.faded)?
            .with_friction(&mut self.bristles);
        let done = work(&model, &mut state);
        self.held = state.held();
        Ok(done)
    }
}

impl Renderer for LiveTissue {
    fn render(&mut self, pose: ProbePose) -> Output {
        if std::mem::take(&mut self.resting) {
            self.rest();
            return Output::NONE;
        }
        self.follow();
        let Self { patch, params, nodes, candidates, shapes, node_step, gains, faded, bristles, held, .. } = self;
        let model = patch.wide_model();
        let tuned = params.derive(node_step, *gains);
        let state = State::resume(&model, nodes, candidates, shapes, *held)
            .and_then(|state| state.with_relaxation(faded))
            .map(|state| state.with_friction(bristles));
        match state {
            Ok(mut state) => {
                let output = tick(&model, &tuned, &mut state, pose);
                *held = state.held();
                output
            }
            Err(_) => Output { fault: Some(Fault::SizeMismatch), ..Output::NONE },
        }
    }

    fn reset(&mut self) {
        self.resting = true;
    }

    fn stiffness_n_per_m(&self) -> f32 {
        self.contact_n_per_m()
    }
}
