//! A board emulated by this machine: its pins keep the state that was set, and it has no clock and
//! no link. The tick of the controller runs on it in lock-step.

use palpate::Fault;
use palpate_controller::board::{About, Board};
use palpate_controller::config::{Flash, FlashError, SLOT_BYTES, Slot};
use palpate_controller::crash::Crash;
use palpate_controller::force_out::Outputs;
use palpate_controller::patch::Budget;
use palpate_controller::probe_in::Reading;

/// The emulated board.
#[derive(Clone, Copy, Debug)]
pub struct DesktopBoard {
    outputs: Outputs,
    profiles: NoProfiles,
}

/// A memory that stores nothing.
#[derive(Clone, Copy, Debug)]
pub struct NoProfiles;

impl Default for DesktopBoard {
    fn default() -> Self {
        Self { outputs: Outputs::OFF, profiles: NoProfiles }
    }
}

impl Flash for NoProfiles {
    fn read(&self, _: Slot, bytes: &mut [u8; SLOT_BYTES]) {
        *bytes = [0xFF; SLOT_BYTES];
    }

    fn erase(&mut self, _: Slot) -> Result<(), FlashError> {
        Err(FlashError)
    }

    fn write(&mut self, _: Slot, _: &[u8; SLOT_BYTES]) -> Result<(), FlashError> {
        Err(FlashError)
    }
}

impl Board for DesktopBoard {
    type ProfileMemory = NoProfiles;

    fn clock_counts(&self) -> u32 {
        0
    }

    fn since_period_counts(&self) -> u32 {
        0
    }

    fn periods_begun(&self) -> u32 {
        0
    }

    async fn next_period(&mut self) -> u32 {
        0
    }

    fn drop_period(&mut self) {}

    fn write_outputs(&mut self, outputs: Outputs) {
        self.outputs = outputs;
    }

    fn outputs(&self) -> Outputs {
        self.outputs
    }

    fn outputs_off(&mut self) {
        self.outputs = Outputs::OFF;
    }

    fn feed_watchdog(&mut self) {}

    fn count_millisecond(&mut self) {}

    fn last_crash(&self) -> Option<Crash> {
        None
    }

    fn healthy(&self) -> bool {
        self.outputs == Outputs::OFF
    }

    fn supply_low(&self) -> bool {
        false
    }

    fn emergency_stop(&mut self) -> Option<Fault> {
        None
    }

    fn operator_absent(&self) -> Option<bool> {
        None
    }

    fn sense(&mut self) -> Option<Reading> {
        None
    }

    fn budget(&self) -> Budget {
        Budget::M7_480
    }

    fn about(&self) -> About {
        About { name: concat!("desktop ", env!("CARGO_PKG_VERSION")), built_day: 0, clock_hz: 0, image: 0 }
    }

    fn stack_used_bytes(&self) -> usize {
        0
    }

    fn profile_memory(&mut self) -> &mut NoProfiles {
        &mut self.profiles
    }

    fn link_read(&mut self, _: &mut [u8]) -> usize {
        0
    }

    fn link_write(&mut self, _: &[u8]) {}

    fn link_room(&self) -> usize {
        0
    }
}
