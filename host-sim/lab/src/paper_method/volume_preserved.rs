//! `volume-preserved`: the model of paper 000 on the core's tick.
//!
//! It is to be run with [`SPRINGS_ONLY`](palpate::Terms::SPRINGS_ONLY) and a mass floor of 0.
//! Springs that join two organs are springs of the model; attached nodes are anchors that the
//! caller places before every tick.

use palpate::method::Method;
use palpate::stages::force::{self, foundation::Load};
use palpate::{Model, State, Tuned, Vector3};

use super::averaged::Averaged;
use super::damper::Dampers;
use super::direction::SpringDirection;
use super::length::SpringLength;

/// Springs, dampers and three corrections of positions.
#[derive(Debug, Default)]
pub struct VolumePreserved<'a> {
    /// Dampers of the springs (5).
    pub dampers: Option<Dampers<'a>>,
    /// Over-stretching and over-compressing corrections (6)-(8).
    pub length: Option<SpringLength>,
    /// Direction correction (9).
    pub direction: Option<SpringDirection<'a>>,
    /// Scratch memory for the averages of (7); callers never read it.
    pub averaged: Averaged,
}

impl Method for VolumePreserved<'_> {
    fn force(&mut self, model: &Model, tuned: &Tuned, state: &mut State, tip_m: Vector3<f32>, speed: Vector3<f32>) -> Load {
        force::accumulate_inner(model, tuned, state);
        if let Some(dampers) = &self.dampers {
            dampers.resist(model, state);
        }
        force::foundation::press(model, tuned, state, tip_m, speed)
    }

    fn correct(&mut self, model: &Model, tuned: &Tuned, state: &mut State) {
        if let Some(length) = &self.length {
            length.correct(model, tuned, state, &mut self.averaged);
        }
        if let Some(direction) = &mut self.direction {
            direction.correct(model, tuned, state, &mut self.averaged);
        }
    }
}
