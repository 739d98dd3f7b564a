//! `local-compression`: the model of paper 004 on the core's tick.
//!
//! It is to be run with [`SPRINGS_ONLY`](palpate::Terms::SPRINGS_ONLY), a mass floor of 0, and
//! springs of a single stiffness: the paper has one `k` and one `d` for all edges.

use palpate::method::Method;
use palpate::stages::force::{self, foundation::Load};
use palpate::{Fault, Model, State, Tuned, Vector3};

use super::barycentre::BarycentreForce;
use super::damper::Dampers;
use super::over_compression::OverCompression;
use super::region::StressRule;
use super::velocity_verlet::VelocityVerlet;

/// Springs, dampers, volume force, a region that follows the load, and one correction.
#[derive(Debug, Default)]
pub struct LocalCompression<'a> {
    /// Dampers of the springs (1).
    pub dampers: Option<Dampers<'a>>,
    /// Volume force (2).
    pub volume: Option<BarycentreForce>,
    /// Rule of the region (7)-(8); `None` keeps all nodes active.
    pub region: Option<StressRule>,
    /// Time integration (9)-(10).
    pub step: VelocityVerlet,
    /// Over-compression correction (11)-(13).
    pub compression: Option<OverCompression>,
}

impl Method for LocalCompression<'_> {
    fn begin(&mut self, tuned: &Tuned, state: &State) {
        self.step.region = self.region.as_ref().and_then(|rule| rule.select(tuned, state));
    }

    fn force(&mut self, model: &Model, tuned: &Tuned, state: &mut State, tip_m: Vector3<f32>, speed: Vector3<f32>) -> Load {
        force::accumulate_inner(model, tuned, state);
        if let Some(dampers) = &self.dampers {
            dampers.resist(model, state);
        }
        if let Some(volume) = &self.volume {
            volume.push(model, tuned, state);
        }
        let load = force::foundation::press(model, tuned, state, tip_m, speed);
        if let Some(rule) = &mut self.region {
            rule.see(tuned, &load, tip_m);
        }
        load
    }

    fn advance(&mut self, model: &Model, tuned: &Tuned, state: &mut State) -> Result<u16, Fault> {
        self.step.advance(model, tuned, state)
    }

    fn correct(&mut self, model: &Model, tuned: &Tuned, state: &mut State) {
        if let Some(compression) = &self.compression {
            compression.correct(model, tuned, state);
        }
    }
}
