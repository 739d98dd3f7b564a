//! Implements the controller's [`Board`] for the board that the image is built for.

use palpate::Fault;
use palpate_controller::board::{About, Board};
#[cfg(not(feature = "mps2"))]
use palpate_controller::config::{Profile, StoreError};
use palpate_controller::crash::Crash;
use palpate_controller::force_out::Outputs;
use palpate_controller::link::Log;
use palpate_controller::log::Event;
use palpate_controller::patch::Budget;
use palpate_controller::probe_in::Reading;

use super::{
    ProfileMemory, about, budget, clock_counts, count_millisecond, emergency_stop, feed_watchdog, healthy, last_crash, link_read,
    link_room, link_write, log, operator_absent, outputs, outputs_off, sense, since_period_counts, stack_used_bytes, supply_low,
    write_outputs,
};
use crate::period;

/// The board; apart from the profile memory its state is in the board's registers.
#[derive(Default)]
pub struct ThisBoard {
    profile_memory: ProfileMemory,
}

impl Board for ThisBoard {
    type ProfileMemory = ProfileMemory;

    fn clock_counts(&self) -> u32 {
        clock_counts()
    }

    fn since_period_counts(&self) -> u32 {
        since_period_counts()
    }

    fn periods_begun(&self) -> u32 {
        period::periods_begun()
    }

    async fn next_period(&mut self) -> u32 {
        period::next_period().await
    }

    fn drop_period(&mut self) {
        period::drop_period();
    }

    fn write_outputs(&mut self, outputs: Outputs) {
        write_outputs(outputs);
    }

    fn outputs(&self) -> Outputs {
        outputs()
    }

    fn outputs_off(&mut self) {
        outputs_off();
    }

    fn feed_watchdog(&mut self) {
        feed_watchdog();
    }

    fn count_millisecond(&mut self) {
        count_millisecond();
    }

    fn last_crash(&self) -> Option<Crash> {
        last_crash()
    }

    fn healthy(&self) -> bool {
        healthy()
    }

    fn supply_low(&self) -> bool {
        supply_low()
    }

    fn emergency_stop(&mut self) -> Option<Fault> {
        emergency_stop()
    }

    fn operator_absent(&self) -> Option<bool> {
        operator_absent()
    }

    fn sense(&mut self) -> Option<Reading> {
        sense()
    }

    fn budget(&self) -> Budget {
        budget()
    }

    fn about(&self) -> About {
        about()
    }

    fn stack_used_bytes(&self) -> usize {
        stack_used_bytes()
    }

    fn profile_memory(&mut self) -> &mut ProfileMemory {
        &mut self.profile_memory
    }

    #[cfg(not(feature = "mps2"))]
    fn store_profile(&mut self, profile: &Profile) -> Result<u32, StoreError> {
        super::store_by_restart(profile)
    }

    #[cfg(not(feature = "mps2"))]
    fn restarted_for(&mut self) -> Option<u32> {
        super::restarted_for()
    }

    fn link_read(&mut self, bytes: &mut [u8]) -> usize {
        link_read(bytes)
    }

    fn link_write(&mut self, frame: &[u8]) {
        link_write(frame);
    }

    fn link_room(&self) -> usize {
        link_room()
    }

    fn log(&mut self, event: Event) {
        log::event(event);
    }

    fn take_log(&mut self) -> Option<Log> {
        log::take()
    }
}
