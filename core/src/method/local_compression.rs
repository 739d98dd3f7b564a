//! `local-compression`: the model of paper 004 on the core's tick.
//!
//! Run it with [`Terms::SPRINGS_ONLY`](crate::Terms::SPRINGS_ONLY), mass floor and contact mass 0,
//! springs of one stiffness: the paper has one `k` and one `d` for all edges.

use nalgebra::Vector3;

use super::Method;
use crate::fault::Fault;
use crate::model::Model;
use crate::params::Tuned;
use crate::stages::correct::over_compression::OverCompression;
use crate::stages::force::barycentre::BarycentreForce;
use crate::stages::force::damper::Dampers;
use crate::stages::force::{self, foundation::Load};
use crate::stages::integrate::velocity_verlet::VelocityVerlet;
use crate::stages::region::{Region, StressRule};
use crate::state::State;

/// Springs, dampers, volume force, a region that follows the load, and one correction.
#[derive(Debug)]
pub struct LocalCompression<'a> {
    /// A damper for each spring (1).
    pub dampers: Option<Dampers<'a>>,
    /// Volume force (2).
    pub volume: Option<BarycentreForce>,
    /// How far the region reaches (7)-(8); all nodes without it.
    pub region: Option<StressRule>,
    /// The step (9)-(10).
    pub step: VelocityVerlet,
    /// Over-compression correction (11)-(13).
    pub compression: Option<OverCompression>,
}

impl Method for LocalCompression<'_> {
    fn region(&mut self, tuned: &Tuned, state: &State) -> Region {
        self.region.as_ref().map_or(Region::All, |rule| rule.select(tuned, state))
    }

    fn force(&mut self, model: &Model, tuned: &Tuned, state: &mut State, tip_m: Vector3<f32>, speed: Vector3<f32>) -> Load {
        let load = force::accumulate(model, tuned, state, tip_m, speed);
        if let Some(dampers) = &self.dampers {
            dampers.resist(model, state);
        }
        if let Some(volume) = &self.volume {
            volume.push(model, tuned, state);
        }
        if let Some(rule) = &mut self.region {
            rule.see(tuned, &load, tip_m);
        }
        load
    }

    fn advance(&mut self, model: &Model, tuned: &Tuned, state: &mut State, region: Region) -> Result<u16, Fault> {
        self.step.advance(model, tuned, state, region)
    }

    fn correct(&mut self, model: &Model, tuned: &Tuned, state: &mut State) {
        if let Some(compression) = &self.compression {
            compression.correct(model, tuned, state);
        }
    }
}
