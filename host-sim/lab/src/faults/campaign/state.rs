//! State of a campaign run, and its result.

use palpate::Fault;
use palpate::haptic::cycle::{Command, Telemetry};

use crate::faults::faulty::{Faulty, FaultyTissue};
use palpate_loop::closed_loop::hand::Aim;
use palpate_loop::closed_loop::plant::Plant;
use palpate_loop::closed_loop::rig::Rig;
use palpate_loop::closed_loop::surface::Surface;
use palpate_loop::closed_loop::watch::Broken;

/// Result of a campaign run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outcome {
    /// Whether the fault was injected: in some runs its moment never comes.
    pub injected: bool,
    /// Ticks from the injection to the required reaction; 1 if the loop reacts in the same tick.
    pub reaction_ticks: Option<u32>,
    /// Fault that ended the run.
    pub fault: Option<Fault>,
    /// Largest force from the injection on [N].
    pub peak_n: f32,
    /// Invariants that were broken, each once.
    pub broken: Vec<Broken>,
    /// Deviation from the required reaction, if any.
    pub wrong: Option<&'static str>,
}

/// Everything that moves in a run.
pub(super) struct Scene<'s, S> {
    pub(super) rig: Rig,
    pub(super) device: Faulty<Plant>,
    pub(super) tissue: FaultyTissue<'s, S>,
}

impl<S: Surface> Scene<'_, S> {
    pub(super) fn cycle(&mut self, command: Command) -> Telemetry {
        self.rig.tick_on(&mut self.device, &mut self.tissue, command)
    }

    /// Moves device and hand for a tick, and checks what truly happened.
    pub(super) fn step(&mut self, aim: &Aim, touched: bool) {
        let plant = self.device.device();
        plant.step(aim, touched);
        self.rig.acted(&plant.truth());
    }

    /// The plant behind the fault injection.
    pub(super) fn plant(&mut self) -> &mut Plant {
        self.device.device()
    }
}
