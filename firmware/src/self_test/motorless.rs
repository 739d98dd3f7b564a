//! The board without its outputs: the loop's outputs are written to memory and read back from
//! there. Stop circuit, supply and operator's switch are not read, since nothing is connected yet.

use palpate::Fault;
use palpate_controller::board::{About, Board};
use palpate_controller::crash::Crash;
use palpate_controller::force_out::Outputs;
use palpate_controller::patch::Budget;
use palpate_controller::probe_in::Reading;

use crate::board::ThisBoard;

/// A board whose pins stay off.
pub struct Motorless {
    this: ThisBoard,
    written: Outputs,
}

impl Motorless {
    /// Wraps a board whose outputs are off.
    pub fn new(this: ThisBoard) -> Self {
        Self { this, written: Outputs::OFF }
    }
}

impl Board for Motorless {
    type ProfileMemory = <ThisBoard as Board>::ProfileMemory;

    fn clock_counts(&self) -> u32 {
        self.this.clock_counts()
    }

    fn since_period_counts(&self) -> u32 {
        self.this.since_period_counts()
    }

    fn periods_begun(&self) -> u32 {
        self.this.periods_begun()
    }

    async fn next_period(&mut self) -> u32 {
        self.this.next_period().await
    }

    fn drop_period(&mut self) {
        self.this.drop_period();
    }

    fn write_outputs(&mut self, outputs: Outputs) {
        self.written = outputs;
    }

    /// The written outputs while the pins themselves are off; otherwise a disagreement.
    fn outputs(&self) -> Outputs {
        if self.this.outputs() == Outputs::OFF { self.written } else { Outputs { enabled: true, codes: Outputs::UNKNOWN } }
    }

    fn outputs_off(&mut self) {
        self.written = Outputs::OFF;
        self.this.outputs_off();
    }

    fn feed_watchdog(&mut self) {
        self.this.feed_watchdog();
    }

    fn count_millisecond(&mut self) {
        self.this.count_millisecond();
    }

    fn last_crash(&self) -> Option<Crash> {
        self.this.last_crash()
    }

    fn healthy(&self) -> bool {
        self.this.healthy()
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
        self.this.budget()
    }

    fn about(&self) -> About {
        self.this.about()
    }

    fn stack_used_bytes(&self) -> usize {
        self.this.stack_used_bytes()
    }

    fn profile_memory(&mut self) -> &mut Self::ProfileMemory {
        self.this.profile_memory()
    }

    fn link_read(&mut self, bytes: &mut [u8]) -> usize {
        self.this.link_read(bytes)
    }

    fn link_write(&mut self, frame: &[u8]) {
        self.this.link_write(frame);
    }

    fn link_room(&self) -> usize {
        self.this.link_room()
    }
}
