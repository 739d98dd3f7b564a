//! The emulated board in the closed loop: an emulated hand holds an emulated device and feels the
//! force that the board answers.
//!
//! The loop's own controller runs beside the board over the same patch file. Every tick must agree
//! to the last bit, so the loop's files describe the board.
//!
//! * in: a prepared tissue, a device, a hand, a stimulus
//! * out: a run of the closed loop, driven by the board
//! * fails if the board crashes, refuses the patch or the device, or differs from the desktop

use std::path::PathBuf;
use std::sync::Arc;

use palpate::haptic::cycle::{Ask, Command, Renderer, Settings, Telemetry};
use palpate::haptic::device::{DeviceSpec, Sensed, SensorStatus};
use palpate::stages::probe::ProbePose;
use palpate::{Output, Params, PatchFile, Probe, Vector3};
use palpate_controller::config::Profile;
use palpate_controller::force_out;
use palpate_controller::force_out::ActuatorCommand;
use palpate_controller::link::message::HostAsk;
use palpate_controller::link::{FromBoard, Record, Refusal, ToBoard};
use palpate_controller::patch::{Memory, Patch};

use super::{Board, EmulateError, EmulatedBoard};
use palpate_loop::closed_loop::prepared::Prepared;
use palpate_loop::closed_loop::rig::Beside;
use palpate_loop::closed_loop::run::{Run, Setup, run_beside};
use palpate_loop::closed_loop::stimulus::{Change, Site, Stimulus};
use palpate_loop::closed_loop::surface::Surface;
use palpate_loop::closed_loop::watch::{Placed, RestShape, RestSolid};
use palpate_tissue::stable_step::StableStep;

/// Ticks from power-on to `Idle`.
const START_UP_TICKS: u32 = 3;

/// An image that can take part in any number of runs.
#[derive(Clone, Debug)]
pub struct InLoop {
    image: PathBuf,
    machine: EmulatedBoard,
    /// The patch file, aligned to 4 bytes.
    words: Vec<u32>,
    bytes: usize,
    youngs_modulus_pa: f32,
    has_far_field: bool,
}

impl InLoop {
    /// Packs the tissue for the board.
    ///
    /// # Errors
    /// The patch is not stable with any number of substeps.
    pub fn new(image: PathBuf, machine: EmulatedBoard, tissue: &Prepared) -> Result<Self, EmulateError> {
        let stable = StableStep::measure(&tissue.patch.wide_model(), &tissue.params, tissue.patch.site_m())?;
        let stable = stable.ok_or(EmulateError::Refused(Refusal::PatchStep))?;
        let packed = tissue.patch.pack(&tissue.params, stable.pressed_s as f32);
        let mut words = vec![0; packed.len().div_ceil(4)];
        bytemuck::cast_slice_mut(&mut words)[..packed.len()].copy_from_slice(&packed);
        let has_far_field = !tissue.patch.model().rim_nodes.is_empty();
        Ok(Self { image, machine, words, bytes: packed.len(), youngs_modulus_pa: tissue.params.youngs_modulus_pa, has_far_field })
    }

    /// Whether the board cannot follow this stimulus: no message of the link changes the far field,
    /// which is part of the mesh.
    #[must_use]
    pub fn cannot_follow(&self, stimulus: &Stimulus) -> bool {
        self.has_far_field && stimulus.swaps_the_far_field()
    }

    /// Runs the setup without a board, on this machine's controller alone, but in the device's
    /// frame as on the board. (`palpate loop` runs in the organ's frame, where readings are
    /// quantised and rounded differently.)
    ///
    /// # Errors
    /// Inputs that the core refuses.
    pub fn desktop(&self, setup: &Setup) -> Result<Run, EmulateError> {
        let mut memory = Box::new(Memory::RESERVED);
        Ok(run_beside(setup, &mut self.surface(&mut memory)?, &mut ())?)
    }

    fn patch(&self) -> &[u8] {
        &bytemuck::cast_slice(&self.words)[..self.bytes]
    }

    fn surface<'a>(&'a self, memory: &'a mut Memory) -> Result<PatchSurface<'a>, EmulateError> {
        let params = PatchFile::open(self.patch())?.params;
        let patch = Patch::open(self.patch(), memory, None)?;
        Ok(PatchSurface { patch, params, youngs_modulus_pa: self.youngs_modulus_pa })
    }

    /// Runs the loop on a board that has just been started. Positions are in the device's frame,
    /// whose centre is the site.
    ///
    /// # Errors
    /// [`EmulateError::Differs`] if board and desktop differ.
    pub fn run(&self, setup: &Setup) -> Result<Run, EmulateError> {
        let mut memory = Box::new(Memory::RESERVED);
        let mut here = self.surface(&mut memory)?;
        let limits = setup.device.limits(Vector3::zeros());
        let board = started(Board::start(&self.image, self.machine, None)?, Some(self.patch()), &setup.settings, &limits)?;
        let mut there = There::new(board, self.youngs_modulus_pa);
        let run = run_beside(setup, &mut here, &mut there)?;
        there.ended(here.patch.state_hash())?;
        Ok(run)
    }
}

/// Brings a board to the start of a loop: a patch is uploaded if one is given, the profile is
/// loaded, and the board is about to boot.
pub(super) fn started(
    mut board: Board,
    patch: Option<&[u8]>,
    settings: &Settings,
    device: &DeviceSpec,
) -> Result<Board, EmulateError> {
    for sequence in 1..=START_UP_TICKS {
        board.send(&ToBoard::Pose { position_m: [0.0; 3], sequence, good: true })?;
        board.receive()?;
    }
    if let Some(patch) = patch {
        board.upload(patch)?;
    }
    board.send(&ToBoard::Store(Profile::of(settings, device)))?;
    match board.receive()? {
        FromBoard::Stored(_) => Ok(board),
        FromBoard::Refused(refusal) => Err(EmulateError::Refused(refusal)),
        other => Err(EmulateError::OutOfTurn(format!("{other:?}"))),
    }
}

/// The board, which receives the readings of the loop's own controller.
pub(super) struct There {
    board: Board,
    youngs_modulus_pa: f32,
    sensed: Option<Sensed>,
    asked: Option<f32>,
    /// The first error; nothing is sent after it.
    failed: Option<EmulateError>,
}

impl There {
    pub(super) fn new(board: Board, youngs_modulus_pa: f32) -> Self {
        Self { board, youngs_modulus_pa, sensed: None, asked: None, failed: None }
    }

    /// Sends another Young's modulus [Pa] with the next tick.
    pub(super) fn modulus(&mut self, youngs_modulus_pa: f32) {
        self.asked = Some(youngs_modulus_pa);
    }

    /// Checks that no error occurred, and that the board's state has this hash at the end.
    pub(super) fn ended(mut self, hash: u64) -> Result<(), EmulateError> {
        if let Some(failed) = self.failed {
            return Err(failed);
        }
        self.board.send(&ToBoard::Report)?;
        match self.board.receive()? {
            FromBoard::State { state_hash, .. } if state_hash == hash => Ok(()),
            FromBoard::State { .. } => Err(EmulateError::Differs("the state at the end has another hash".into())),
            other => Err(EmulateError::OutOfTurn(format!("{other:?}"))),
        }
    }

    fn answer(&mut self, command: Command) -> Result<Record, EmulateError> {
        if let Some(pascal) = self.asked.take() {
            self.board.send(&ToBoard::YoungsModulus(pascal))?;
            self.board.modulus_taken()?;
        }
        match command.asked {
            Some(Ask::Arm) => self.board.send(&ToBoard::Ask(HostAsk::Arm))?,
            Some(Ask::Stop) => self.board.send(&ToBoard::Ask(HostAsk::Stop))?,
            Some(Ask::Clear) => self.board.send(&ToBoard::Ask(HostAsk::Clear))?,
            // a board starts up by itself
            Some(Ask::Booted | Ask::TestPassed) | None => {}
        }
        let sensed = self.sensed.ok_or_else(|| EmulateError::OutOfTurn("no reading yet".into()))?;
        let good = sensed.status == SensorStatus::Good;
        self.board.send(&ToBoard::Pose { position_m: sensed.position_m.into(), sequence: sensed.sequence, good })?;
        match self.board.receive()? {
            FromBoard::Record(record) => Ok(record),
            FromBoard::Refused(refusal) => Err(EmulateError::Refused(refusal)),
            other => Err(EmulateError::OutOfTurn(format!("{other:?}"))),
        }
    }
}

impl Beside for There {
    fn change(&mut self, change: Change) {
        let (Change::Stiffness(ratio) | Change::FarField(ratio)) = change;
        self.asked = Some(self.youngs_modulus_pa * ratio as f32);
    }

    fn tick(
        &mut self,
        reading: Option<Sensed>,
        command: Command,
        telemetry: &Telemetry,
        got_n: Option<Vector3<f32>>,
    ) -> Option<Vector3<f32>> {
        self.sensed = reading.or(self.sensed);
        if self.failed.is_some() {
            return None;
        }
        let drive = got_n.map_or(ActuatorCommand::Off, ActuatorCommand::Force);
        let here = Record::new(telemetry, force_out::outputs(drive), 0);
        let checked = self.answer(command).and_then(|there| match there.first_difference(&here) {
            None => Ok(there),
            Some((what, [there, here])) => {
                Err(EmulateError::Differs(format!("tick {}: {what} is {there} on the board and {here} here", telemetry.tick)))
            }
        });
        match checked {
            Ok(there) => there.enabled.then(|| there.applied_n.into()),
            Err(error) => {
                self.failed = Some(error);
                None
            }
        }
    }
}

/// Geometry at rest of a patch that is placed under the device, in the device's frame.
pub(super) fn rest_shape(patch: &Patch, probe: &Probe) -> Arc<dyn RestShape> {
    let placement = patch.placement();
    let axes = [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| placement.turn_to_patch(axis).cast());
    let shape = Arc::new(RestSolid::of(patch.model(), probe));
    Arc::new(Placed { shape, turn: nalgebra::Matrix3::from_columns(&axes), shift_m: placement.to_patch(Vector3::zeros()).cast() })
}

/// The patch as it is on the board, in the device's frame.
struct PatchSurface<'a> {
    patch: Patch<'a>,
    params: Params,
    youngs_modulus_pa: f32,
}

impl Renderer for PatchSurface<'_> {
    fn render(&mut self, pose: ProbePose) -> Output {
        self.patch.render(pose)
    }

    fn reset(&mut self) {
        self.patch.reset();
    }
}

impl Surface for PatchSurface<'_> {
    fn site(&self) -> Site {
        Site::new(Vector3::zeros(), Vector3::z())
    }

    fn rest_shape(&self) -> Arc<dyn RestShape> {
        rest_shape(&self.patch, &self.params.probe)
    }

    fn creeps(&self) -> bool {
        self.params.long_term_modulus_pa() < self.params.youngs_modulus_pa
    }

    fn change(&mut self, change: Change) {
        let (Change::Stiffness(ratio) | Change::FarField(ratio)) = change;
        // the modulus is in the range that the board accepts, or the board refuses it
        let _ = self.patch.ask_modulus(self.youngs_modulus_pa * ratio as f32);
    }

    fn settle(&mut self, in_contact: bool) {
        self.patch.settle(in_contact);
    }

    fn unsound(&self) -> Option<&'static str> {
        let finite = |v: Vector3<f32>| v.iter().all(|x| x.is_finite());
        let sound = self.patch.state().nodes().iter().all(|n| finite(n.position_m()) && finite(n.velocity_m_per_s()));
        (!sound).then_some("a node is not finite")
    }
}
