//! A board whose pins, clock and supply are set by the test.

use std::cell::Cell;
use std::collections::VecDeque;

use palpate::haptic::cycle::{Renderer, Settings};
use palpate::haptic::device::{HapticDevice, Sensed, SensorStatus};
use palpate::{Fault, Output, ProbePose, Vector3};
use palpate_controller::board::{About, Board};
use palpate_controller::config::{Flash, FlashError, SLOT_BYTES, Slot};
use palpate_controller::controller::{Arming, Controller};
use palpate_controller::crash::Crash;
use palpate_controller::force_out::Outputs;
use palpate_controller::haptic_loop::HapticLoop;
use palpate_controller::link::Log;
use palpate_controller::log::{Event, Ring};
use palpate_controller::patch::Budget;
use palpate_controller::port::Port;
use palpate_controller::probe_in::Reading;

/// Pins, clock and link as the test sets them, and the controller's actions on them.
pub struct Mock {
    /// Pins that keep this state, whatever is written.
    pub stuck: Option<Outputs>,
    pub pins: Outputs,
    /// Periods that begin while a tick runs.
    pub late: u32,
    pub period: u32,
    pub dropped: u32,
    pub fed: u32,
    pub milliseconds: u32,
    pub supply_low: bool,
    pub stop: Option<Fault>,
    pub operator_absent: Option<bool>,
    pub healthy: bool,
    /// Number of times that the outputs were checked before anything is switched on.
    pub checks: Cell<u32>,
    pub from_host: VecDeque<Vec<u8>>,
    pub to_host: Vec<Vec<u8>>,
    /// Period of each frame to the host.
    pub sent_at: Vec<u32>,
    pub slots: Slots,
    /// Number of bytes that the link would accept now.
    pub room: usize,
    /// All events that were logged, and the frames that wait for the link.
    pub events: Vec<Event>,
    pub ring: Ring,
    /// Number of periods after which the timer stops; `None` if it never does.
    pub last_period: Option<u32>,
    /// Whether the board logs a line in every period.
    pub chatty: bool,
    /// Clock, and its steps between two readings [counts].
    pub clock: Cell<u32>,
    pub clock_step: u32,
    /// Whether the board keeps no frame of the log for the link.
    pub quiet: bool,
}

/// Two slots of memory that keep what is written.
#[derive(Default)]
pub struct Slots([Option<[u8; SLOT_BYTES]>; 2]);

impl Default for Mock {
    fn default() -> Self {
        Self {
            stuck: None,
            pins: Outputs::OFF,
            late: 0,
            period: 0,
            dropped: 0,
            fed: 0,
            milliseconds: 0,
            supply_low: false,
            stop: None,
            operator_absent: None,
            healthy: true,
            checks: Cell::new(0),
            from_host: VecDeque::new(),
            to_host: Vec::new(),
            sent_at: Vec::new(),
            slots: Slots::default(),
            room: 1024,
            events: Vec::new(),
            ring: Ring::EMPTY,
            last_period: None,
            chatty: false,
            clock: Cell::new(0),
            clock_step: 0,
            quiet: false,
        }
    }
}

impl Flash for Slots {
    fn read(&self, slot: Slot, bytes: &mut [u8; SLOT_BYTES]) {
        *bytes = self.0[slot as usize].unwrap_or([0xFF; SLOT_BYTES]);
    }

    fn erase(&mut self, slot: Slot) -> Result<(), FlashError> {
        self.0[slot as usize] = None;
        Ok(())
    }

    fn write(&mut self, slot: Slot, bytes: &[u8; SLOT_BYTES]) -> Result<(), FlashError> {
        self.0[slot as usize] = Some(*bytes);
        Ok(())
    }
}

impl Board for Mock {
    type ProfileMemory = Slots;

    fn clock_counts(&self) -> u32 {
        self.clock.set(self.clock.get().wrapping_add(self.clock_step));
        self.clock.get()
    }

    fn since_period_counts(&self) -> u32 {
        7
    }

    fn periods_begun(&self) -> u32 {
        self.period + self.late
    }

    async fn next_period(&mut self) -> u32 {
        if self.last_period == Some(self.period) {
            std::future::pending::<()>().await;
        }
        self.period += 1;
        if self.chatty {
            self.log(Event::Homed);
        }
        self.period
    }

    fn drop_period(&mut self) {
        self.dropped += 1;
    }

    fn write_outputs(&mut self, outputs: Outputs) {
        self.pins = outputs;
    }

    fn outputs(&self) -> Outputs {
        self.stuck.unwrap_or(self.pins)
    }

    fn outputs_off(&mut self) {
        self.pins = Outputs::OFF;
    }

    fn feed_watchdog(&mut self) {
        self.fed += 1;
    }

    fn count_millisecond(&mut self) {
        self.milliseconds += 1;
    }

    fn last_crash(&self) -> Option<Crash> {
        None
    }

    fn healthy(&self) -> bool {
        self.checks.update(|checks| checks + 1);
        self.healthy
    }

    fn supply_low(&self) -> bool {
        self.supply_low
    }

    fn emergency_stop(&mut self) -> Option<Fault> {
        self.stop
    }

    fn operator_absent(&self) -> Option<bool> {
        self.operator_absent
    }

    fn sense(&mut self) -> Option<Reading> {
        None
    }

    fn budget(&self) -> Budget {
        Budget::M7_480
    }

    fn about(&self) -> About {
        About { name: "mock 1.2.3", built_day: 20_000, clock_hz: 1_000_000, image: 77 }
    }

    fn stack_used_bytes(&self) -> usize {
        4321
    }

    fn profile_memory(&mut self) -> &mut Slots {
        &mut self.slots
    }

    fn link_read(&mut self, bytes: &mut [u8]) -> usize {
        let Some(frame) = self.from_host.pop_front() else { return 0 };
        bytes[..frame.len()].copy_from_slice(&frame);
        frame.len()
    }

    fn link_write(&mut self, frame: &[u8]) {
        self.to_host.push(frame.to_vec());
        self.sent_at.push(self.period);
    }

    fn link_room(&self) -> usize {
        self.room
    }

    fn log(&mut self, event: Event) {
        self.events.push(event);
        if self.quiet {
            return;
        }
        // a frame of a length that occurs with defmt
        self.ring.begin();
        self.ring.push(&[[self.events.len() as u8; 40].as_slice(), &[0]].concat());
        self.ring.end();
    }

    fn take_log(&mut self) -> Option<Log> {
        self.ring.take()
    }
}

/// A tissue that pushes with a constant force while the tip is below the surface.
pub struct Slab;

impl Renderer for Slab {
    fn render(&mut self, pose: ProbePose) -> Output {
        let depth_m = -pose.tip_m.z;
        if depth_m <= 0.0 {
            return Output::NONE;
        }
        Output {
            force_n: Vector3::new(0.0, 0.0, 300.0 * depth_m),
            normal: Vector3::z(),
            point_m: pose.tip_m,
            depth_m,
            ..Output::NONE
        }
    }

    fn reset(&mut self) {}
}

/// A haptic loop on a mock board with the desktop stylus.
pub fn haptic_loop(arming: Arming) -> HapticLoop<Mock> {
    haptic_loop_on(Port::DESKTOP, arming)
}

/// A haptic loop on a mock board with the device `port`.
pub fn haptic_loop_on(port: Port, arming: Arming) -> HapticLoop<Mock> {
    let settings = Settings::safe(&port.limits());
    HapticLoop::new(Mock::default(), Controller::build(&settings, port, arming).unwrap())
}

/// A good reading of a tip at a height above the surface [m].
pub fn at(z_m: f32, sequence: u32) -> Sensed {
    Sensed { position_m: Vector3::new(0.0, 0.0, z_m), sequence, status: SensorStatus::Good }
}
