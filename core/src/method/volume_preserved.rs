//! `volume-preserved`: the model of paper 000 on the core's tick.
//!
//! Run it with [`Terms::SPRINGS_ONLY`](crate::Terms::SPRINGS_ONLY), mass floor and contact mass 0.
//! Springs joining two organs are springs of the model; attached nodes are anchors that the caller
//! places before every tick.

use nalgebra::Vector3;

use super::Method;
use crate::model::Model;
use crate::params::Tuned;
use crate::stages::correct::direction::SpringDirection;
use crate::stages::correct::length::SpringLength;
use crate::stages::force::damper::Dampers;
use crate::stages::force::{self, foundation::Load};
use crate::state::State;

/// Springs, dampers and three corrections of positions.
#[derive(Debug)]
pub struct VolumePreserved<'a> {
    /// A damper for each spring (5); `None` for none.
    pub dampers: Option<Dampers<'a>>,
    /// Over-stretching and over-compressing corrections (6)-(8).
    pub length: Option<SpringLength>,
    /// Direction correction (9).
    pub direction: Option<SpringDirection<'a>>,
}

impl Method for VolumePreserved<'_> {
    fn force(&mut self, model: &Model, tuned: &Tuned, state: &mut State, tip_m: Vector3<f32>, speed: Vector3<f32>) -> Load {
        let load = force::accumulate(model, tuned, state, tip_m, speed);
        if let Some(dampers) = &self.dampers {
            dampers.resist(model, state);
        }
        load
    }

    fn correct(&mut self, model: &Model, tuned: &Tuned, state: &mut State) {
        if let Some(length) = &self.length {
            length.correct(model, tuned, state);
        }
        if let Some(direction) = &mut self.direction {
            direction.correct(model, tuned, state);
        }
    }
}
