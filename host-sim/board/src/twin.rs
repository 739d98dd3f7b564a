//! The emulated board and the same controller on this machine receive the same messages and are
//! compared tick by tick.

use palpate::haptic::cycle::Settings;
use palpate::haptic::device::{HapticDevice, Sensed, SensorStatus};
use palpate::haptic::mode::Mode;
use palpate::{ClampFlags, Fault, PatchFile, Vector3};
use palpate_controller::controller::{Arming, Controller};
use palpate_controller::haptic_loop::HapticLoop;

use palpate_controller::link::inbox::{Inbox, Reply};
use palpate_controller::link::message::HostAsk;
use palpate_controller::link::{FromBoard, Record, ToBoard};
use palpate_controller::patch::{Memory, Patch};
use palpate_controller::port::Port;
use palpate_controller::probe_in;

use super::desktop_board::DesktopBoard;
use super::in_loop::rest_shape;
use super::{Board, EmulateError, EmulatedBoard};
use palpate_loop::closed_loop::watch::{Broken, ByGeometry};

/// Ticks within which an undisturbed board must reach full gain.
const START_UP_TICKS: u32 = 2_000;

/// The first point at which board and desktop differ.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// Tick in which they differ.
    pub tick: u32,
    /// Name of the first quantity that differs.
    pub what: &'static str,
    /// Value on the board, and value on this machine.
    pub values: [f32; 2],
}

/// The emulated board and its twin on this machine, in lock-step.
pub struct Lockstep<'a> {
    board: Board,
    machine: EmulatedBoard,
    haptic: HapticLoop<DesktopBoard>,
    patch: Patch<'a>,
    inbox: Inbox,
    newest: Sensed,
    readings: u32,
    /// The first difference; the run continues, to show its consequences.
    pub difference: Option<Difference>,
    /// The first tick in which the board's force broke a geometric invariant, and that invariant;
    /// see [`ByGeometry`].
    pub broken: Option<(u32, Broken)>,
    watch: ByGeometry,
    /// Number of instructions of every tick so far, from reading the sensors to setting the
    /// converters.
    pub instructions: Vec<u64>,
    /// Faults that occurred, in order, one entry per occurrence.
    pub faults: Vec<Fault>,
    last_fault: Option<Fault>,
    packed_pa: f32,
}

/// Tip position that a host sent, if it sent one.
fn tip(reading: Option<probe_in::Reading>) -> Option<Sensed> {
    match reading {
        Some(probe_in::Reading::Tip(sensed)) => Some(sensed),
        Some(probe_in::Reading::Joints(_)) | None => None,
    }
}

/// Sensor reading of one tick.
#[derive(Clone, Copy, Debug)]
pub struct Reading {
    /// Tip [m], device frame.
    pub position_m: Vector3<f32>,
    /// The sensor reports no error.
    pub good: bool,
    /// The reading is new.
    pub fresh: bool,
}

impl Reading {
    /// A new and good reading.
    #[must_use]
    pub fn at(position_m: Vector3<f32>) -> Self {
        Self { position_m, good: true, fresh: true }
    }
}

impl<'a> Lockstep<'a> {
    /// Uploads a patch to a board that has just started, and opens the same patch here.
    ///
    /// # Errors
    /// The board or this machine refuses the inputs.
    pub fn new(mut board: Board, patch: &'a [u8], memory: &'a mut Memory) -> Result<Self, EmulateError> {
        let controller = Controller::build(&Settings::safe(&Port::DESKTOP.limits()), Port::DESKTOP, Arming::OnRequest)?;
        let mut haptic = HapticLoop::new(DesktopBoard::default(), controller);
        let mut patch_here = Patch::open(patch, memory, None)?;
        // a patch is accepted only in `Idle`, which is reached after three ticks of start-up
        let sensed = Sensed { position_m: Vector3::zeros(), sequence: 0, status: SensorStatus::Failed };
        let mut inbox = Inbox::default();
        let mut newest = sensed;
        for sequence in 1..=3 {
            let message = ToBoard::Pose { position_m: [0.0; 3], sequence, good: true };
            board.send(&message)?;
            inbox.take(&message, &mut haptic.controller, None);
            let (reading, command) = inbox.clear();
            newest = tip(reading).unwrap_or(newest);
            haptic.tick(&mut patch_here, newest, command, None);
            board.receive()?;
        }
        board.upload(patch)?;
        let params = PatchFile::open(patch)?.params;
        Ok(Self {
            watch: ByGeometry::over(rest_shape(&patch_here, &params.probe)),
            broken: None,
            machine: board.machine(),
            board,
            haptic,
            patch: patch_here,
            inbox,
            newest,
            readings: 3,
            difference: None,
            instructions: Vec::new(),
            faults: Vec::new(),
            last_fault: None,
            packed_pa: params.youngs_modulus_pa,
        })
    }

    /// The patch on this machine.
    #[must_use]
    pub fn patch(&self) -> &Patch<'a> {
        &self.patch
    }

    /// The kind of board that is emulated.
    #[must_use]
    pub fn machine(&self) -> EmulatedBoard {
        self.machine
    }

    /// The link to the board, for everything but ticks.
    pub fn board(&mut self) -> &mut Board {
        &mut self.board
    }

    /// Mode of the loop.
    #[must_use]
    pub fn mode(&self) -> Mode {
        self.haptic.controller.mode()
    }

    /// Runs one tick on both, with or without a request.
    ///
    /// # Errors
    /// The board has crashed.
    pub fn tick(&mut self, reading: Reading, ask: Option<HostAsk>) -> Result<Record, EmulateError> {
        if let Some(asked) = ask {
            self.ask(asked)?;
        }
        self.readings = self.readings.wrapping_add(u32::from(reading.fresh));
        let position_m = reading.position_m.into();
        self.tell(&ToBoard::Pose { position_m, sequence: self.readings, good: reading.good })?;
        let (reading, command) = self.inbox.clear();
        self.newest = tip(reading).unwrap_or(self.newest);
        let here = self.haptic.tick(&mut self.patch, self.newest, command, None);
        self.patch.settle(self.haptic.controller.in_contact());

        let there = match self.board.receive()? {
            FromBoard::Record(record) => record,
            FromBoard::Refused(refusal) => return Err(EmulateError::Refused(refusal)),
            other => return Err(EmulateError::OutOfTurn(format!("{other:?}"))),
        };
        if self.difference.is_none()
            && let Some((what, values)) = there.first_difference(&here)
        {
            self.difference = Some(Difference { tick: here.tick, what, values });
        }
        let force_n = if there.enabled { there.applied_n.into() } else { Vector3::zeros() };
        if let Err(broken) = self.watch.check(&self.newest, force_n) {
            self.broken = self.broken.or(Some((there.tick, broken)));
        }
        self.instructions.push(super::board::instructions(there.spent_counts));
        let fault = there.fault();
        if fault != self.last_fault {
            self.faults.extend(fault);
        }
        self.last_fault = fault;
        Ok(there)
    }

    /// Makes a request to the board and to its twin, before the next tick.
    ///
    /// # Errors
    /// The board has crashed.
    pub fn ask(&mut self, asked: HostAsk) -> Result<(), EmulateError> {
        self.tell(&ToBoard::Ask(asked))
    }

    /// Makes the next tick find the actuators' supply too low, on the board and on its twin.
    ///
    /// # Errors
    /// The board has crashed.
    pub fn supply_low(&mut self) -> Result<(), EmulateError> {
        self.tell(&ToBoard::SupplyLow)
    }

    /// Requests another Young's modulus of both under force: the packed one times this ratio, which
    /// is between half and two.
    ///
    /// # Errors
    /// The board has crashed.
    pub fn modulus(&mut self, ratio: f32) -> Result<(), EmulateError> {
        self.tell(&ToBoard::YoungsModulus(ratio * self.packed_pa))
    }

    fn tell(&mut self, message: &ToBoard<'_>) -> Result<(), EmulateError> {
        self.board.send(message)?;
        if let Reply::Modulus(pascal) = self.inbox.take(message, &mut self.haptic.controller, None) {
            self.patch.ask_modulus(pascal)?;
            self.board.modulus_taken()?;
        }
        Ok(())
    }

    /// Keeps the tip at a position outside the tissue until the force is on at full gain.
    ///
    /// # Errors
    /// The board has crashed, or does not reach full gain.
    pub fn arm(&mut self, outside_m: Vector3<f32>) -> Result<(), EmulateError> {
        for _ in 0..START_UP_TICKS {
            let ask = match self.mode() {
                Mode::Idle => Some(HostAsk::Arm),
                Mode::Fault => Some(HostAsk::Clear),
                _ => None,
            };
            let record = self.tick(Reading::at(outside_m), ask)?;
            let ramping = record.limiters & ClampFlags::GAIN.bits() != 0;
            if record.mode() == Some(Mode::Active) && !ramping {
                return Ok(());
            }
        }
        Err(EmulateError::OutOfTurn(format!("it is still {:?} after {START_UP_TICKS} calm ticks", self.mode())))
    }

    /// Hash of the board's state, after checking it against the one here, and the stack that was
    /// used [bytes].
    ///
    /// # Errors
    /// The board has crashed.
    pub fn state_hash(&mut self) -> Result<(u64, u32), EmulateError> {
        self.board.send(&ToBoard::Report)?;
        let FromBoard::State { state_hash, stack_used_bytes, .. } = self.board.receive()? else {
            return Err(EmulateError::OutOfTurn("no report".into()));
        };
        let here = self.patch.state_hash();
        if state_hash != here && self.difference.is_none() {
            let [board, desktop] = [state_hash, here].map(|hash| hash as f32);
            self.difference = Some(Difference { tick: 0, what: "hash of the state", values: [board, desktop] });
        }
        Ok((state_hash, stack_used_bytes))
    }
}
