//! A tissue with an injected fault.

use std::sync::Arc;

use palpate::haptic::cycle::Renderer;
use palpate::stages::probe::ProbePose;
use palpate::{Output, Vector3};

use super::TissueFault;
use palpate_loop::closed_loop::stimulus::{Change, Site};
use palpate_loop::closed_loop::surface::Surface;
use palpate_loop::closed_loop::watch::RestShape;

/// Any surface, with a fault in it.
#[derive(Debug)]
pub struct FaultyTissue<'a, S> {
    surface: &'a mut S,
    fault: Option<TissueFault>,
    last_m: Vector3<f32>,
}

impl<'a, S: Surface> FaultyTissue<'a, S> {
    /// Wraps a surface, at first without a fault.
    pub fn new(surface: &'a mut S) -> Self {
        Self { surface, fault: None, last_m: Vector3::zeros() }
    }

    /// Applies a fault from the next tick on; `None` ends it. A change of nodes is applied once.
    pub fn break_it(&mut self, fault: Option<TissueFault>) {
        match fault {
            Some(TissueFault::NodeSpeed(speed)) => self.surface.strike(None, Some(speed), false),
            Some(TissueFault::NodeAt(at)) => self.surface.strike(Some(at), None, false),
            Some(TissueFault::Denormal(speed)) => self.surface.strike(None, Some(speed), true),
            _ => {}
        }
        self.fault = fault;
    }
}

impl<S: Surface> Renderer for FaultyTissue<'_, S> {
    fn render(&mut self, pose: ProbePose) -> Output {
        let mut output = self.surface.render(pose);
        let normal: Vector3<f32> = self.surface.site().normal.cast();
        let displacement_m = pose.tip_m - std::mem::replace(&mut self.last_m, pose.tip_m);
        match self.fault {
            Some(TissueFault::Force(force_n)) => {
                output.force_n = normal * force_n;
                output.normal = normal;
                // nothing of it comes from the guard, whose share the plausibility check leaves out
                output.continuation_n = 0.0;
            }
            Some(TissueFault::Aside(force_n)) => {
                output.force_n += self.surface.site().along.cast() * force_n;
                output.normal = output.force_n.normalize();
            }
            Some(TissueFault::Scaled(ratio)) => {
                output.force_n *= ratio;
                output.continuation_n *= ratio;
            }
            Some(TissueFault::Active(force_n)) if output.depth_m > 0.0 && displacement_m.dot(&normal) > 0.0 => {
                output.force_n += normal * force_n;
            }
            _ => {}
        }
        output
    }

    fn reset(&mut self) {
        self.surface.reset();
    }

    fn tangent_n_per_m(&self, output: &Output) -> f32 {
        self.surface.tangent_n_per_m(output)
    }

    fn stiffness_n_per_m(&self) -> f32 {
        self.surface.stiffness_n_per_m()
    }
}

impl<S: Surface> Surface for FaultyTissue<'_, S> {
    fn site(&self) -> Site {
        self.surface.site()
    }

    fn rest_shape(&self) -> Arc<dyn RestShape> {
        self.surface.rest_shape()
    }

    fn creeps(&self) -> bool {
        self.surface.creeps()
    }

    fn change(&mut self, change: Change) {
        self.surface.change(change);
    }

    fn settle(&mut self, in_contact: bool) {
        self.surface.settle(in_contact);
    }

    fn unsound(&self) -> Option<&'static str> {
        self.surface.unsound()
    }
}
