//! A haptic session: tissue and loop around a device that the caller reads and drives, for
//! programs with a device of their own and for other languages (`host-sim/bindings`).
//!
//! ```text
//! caller: position ─ HapticSession::tick ─ force: caller
//!                    gate ─ patch ─ damping ─ gains ─ limits
//! ```
//!
//! The force goes through [`Cycle::tick`] as on the board: ramp-in, passivity and limits always
//! apply. A tick allocates nothing; preparing a session does.

mod commission;
mod turn;

use std::path::Path;

use palpate::haptic::commission::{Commissioning, Wiring};
use palpate::haptic::cycle::{Ask, Command, Cycle, Settings, Telemetry};
use palpate::haptic::device::{DeviceSpec, HapticDevice, Sensed, SensorStatus};
use palpate::haptic::limits::LoopLimitSettings;
use palpate::haptic::mode::Mode;
use palpate::{BuildError, ContactMap, Output, Params, Vector3};
use palpate_tissue::budget::MACHINES;
use palpate_tissue::error::Error;
use palpate_tissue::patch::Patch;
use palpate_tissue::scene::{Scene, TICK_S};
use palpate_tissue::session::{Session, packed};
use palpate_tissue::stable_step::StableStep;

pub use self::commission::Step;
use crate::closed_loop::device::DeviceProfile;
use crate::closed_loop::prepared::{Prepared, ceiling_note};
use crate::live::LiveTissue;

/// Smallest Young's modulus that may be set, as a share of the patch's own.
const SOFTEST: f32 = 0.5;
/// Largest Young's modulus that may be set, as a share of the patch's own, if the substeps remain
/// stable: as on a board.
const STIFFEST: f32 = 2.0;

/// Input of a tick.
#[derive(Clone, Copy, Debug)]
pub struct Input {
    /// Tip of the probe [m], scene frame.
    pub tip_m: Vector3<f32>,
    /// Whether there was no new reading: the position is then that of the previous tick.
    pub stale: bool,
    /// Whether the device reports that its reading cannot be trusted.
    pub sensor_failed: bool,
    /// Whether the hand switch is open: then there is no force, and no arming.
    pub operator_absent: bool,
    /// Periods that passed without a tick since the last one.
    pub late_ticks: u16,
}

impl Input {
    /// A new, good reading at this position [m], in time.
    #[must_use]
    pub fn at(tip_m: Vector3<f32>) -> Self {
        Self { tip_m, stale: false, sensor_failed: false, operator_absent: false, late_ticks: 0 }
    }
}

/// A request that the session's mode does not allow.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum OutOfOrder {
    /// Arming was requested during a fault.
    #[error("a fault is latched: clear it before arming again")]
    Faulted,
    /// Clearing was requested without a fault.
    #[error("no fault is latched: there is nothing to clear")]
    NoFault,
    /// A commissioning was requested while a force may act.
    #[error("the loop is armed: stop it, and wait until it is idle, before commissioning")]
    Armed,
    /// The distance of a commissioning is impossible.
    #[error("distance_m of a commissioning is in metres: give one from 0.005 to 0.5")]
    Distance,
    /// A profile was asked for that was not measured.
    #[error("the device was not commissioned in this session: there is no new profile to write")]
    NotCommissioned,
}

/// Tissue, loop, and the caller's device.
#[derive(Clone, Debug)]
pub struct HapticSession {
    tissue: LiveTissue,
    device: CallersDevice,
    profile: DeviceProfile,
    wiring: Wiring,
    commissioning: Option<Commissioning>,
    /// Whether the profile was measured in this session.
    measured: bool,
    settings: Settings,
    cycle: Cycle,
    telemetry: Option<Telemetry>,
    /// Bounds of Young's modulus [Pa].
    modulus_pa: [f32; 2],
    /// Pending Young's modulus [Pa]: a higher one waits until nothing is touched, a lower one until
    /// the next tick.
    waiting_pa: Option<f32>,
    /// Largest force that the caller allows [N].
    most_force_n: f32,
    /// Request that the next tick passes on.
    asked: Option<Ask>,
    /// Whether arming is requested once the mode is idle.
    arms: bool,
}

impl HapticSession {
    /// Opens a scene, given by preset or path, for a device; `patch` replaces the scene's own.
    ///
    /// # Errors
    /// Fails if scene, patch and device do not fit together, or if the model cannot keep 1 kHz.
    pub fn open(scene: &str, patch: Option<&Path>, device: &str) -> Result<Self, Error> {
        let device = DeviceProfile::load(device)?;
        let mut scene = Scene::load(scene)?;
        if patch.is_some() {
            scene.solver.patch = patch.map(Path::to_path_buf);
            scene.check()?;
        }
        Self::of_prepared(Prepared::of(&scene, &device)?, &device)
    }

    /// Opens a patch file alone: tissue, probe and site are those with which it was packed.
    ///
    /// # Errors
    /// Errors of [`Self::open`].
    pub fn open_patch(path: &Path, device: &str) -> Result<Self, Error> {
        let bytes = std::fs::read(path).map_err(|source| Error::Read { path: path.into(), source })?;
        Self::of_patch_bytes(&bytes, device).map_err(|error| match error {
            Error::Build(cause) => Error::Patch { path: path.into(), cause },
            other => other,
        })
    }

    /// Like [`Self::open_patch`], from the file's bytes.
    ///
    /// # Errors
    /// Errors of [`Self::open`].
    pub fn of_patch_bytes(bytes: &[u8], device: &str) -> Result<Self, Error> {
        let device = DeviceProfile::load(device)?;
        let (patch, params) = packed::unpack(bytes)?;
        let Session { patch, params, .. } = Session::of_fitted(&MACHINES[0], patch, params)?;
        Self::of_prepared(Prepared::of_fitted(patch, &params, &device)?, &device)
    }

    fn of_prepared(prepared: Prepared, device: &DeviceProfile) -> Result<Self, Error> {
        let Prepared { patch, params, .. } = prepared;
        let spec = device.real_limits(patch.site_m());
        let settings = Settings { limits: device.limit_values(), ..Settings::safe(&spec) };
        let opened_pa = params.youngs_modulus_pa;
        let most_pa = if bears(&patch, &params, STIFFEST * opened_pa)? { STIFFEST * opened_pa } else { opened_pa };
        Ok(Self {
            tissue: LiveTissue::new(patch, params)?,
            device: CallersDevice::new(spec),
            profile: device.clone(),
            wiring: device.wiring.map_or(Wiring::STRAIGHT, |table| table.wiring()),
            commissioning: None,
            measured: false,
            settings,
            cycle: Cycle::build(&settings, &spec)?,
            telemetry: None,
            modulus_pa: [SOFTEST * opened_pa, most_pa],
            waiting_pa: None,
            most_force_n: f32::INFINITY,
            asked: None,
            arms: false,
        })
    }

    /// Runs one tick; the caller calls it every millisecond. The force [N] for the device is
    /// [`Self::drive_n`]; [`Telemetry::applied_n`] is the same force in the scene's frame.
    pub fn tick(&mut self, input: &Input) -> &Telemetry {
        if self.commissioning.as_ref().is_some_and(|commissioning| !commissioning.stage().ended()) {
            self.commissioning = None;
        }
        self.settle();
        let mode = self.cycle.mode();
        self.arms &= mode != Mode::Fault;
        let asked = self.asked.take().or(match mode {
            Mode::Boot => Some(Ask::Booted),
            Mode::SelfTest => Some(Ask::TestPassed),
            Mode::Idle if self.arms => Some(Ask::Arm),
            _ => None,
        });
        let Input { late_ticks, operator_absent, .. } = *input;
        // the caller is the host, and its call is the keep-alive
        let command = Command { asked, late_ticks, operator_absent, ..Command::HEARD };
        let tip_m = self.wired(input.tip_m);
        self.device.read(&Input { tip_m, ..*input });
        let telemetry = self.cycle.tick(&mut self.device, &mut self.tissue, command);
        self.arms &= telemetry.mode != Mode::Arming;
        self.telemetry.insert(telemetry)
    }

    /// Force for the motors after the last tick [N], in the order of the device's wires.
    #[must_use]
    pub fn drive_n(&self) -> Vector3<f32> {
        let applied_n = self.telemetry.map_or(Vector3::zeros(), |telemetry| telemetry.applied_n);
        self.wiring.drive(applied_n.into()).into()
    }

    /// Values that the device's profile does not state, with the cautious ones that are taken, one
    /// sentence each.
    #[must_use]
    pub fn cautions(&self) -> Vec<String> {
        self.profile.cautions()
    }

    /// A reading of the sensors as a position in the scene's frame [m]: the wiring acts about the
    /// site.
    fn wired(&self, reading: Vector3<f32>) -> Vector3<f32> {
        if self.wiring == Wiring::STRAIGHT {
            return reading;
        }
        let site_m = self.tissue.patch().site_m();
        site_m + Vector3::from(self.wiring.read((reading - site_m).into()))
    }

    /// Record of the last tick; `None` before the first.
    #[must_use]
    pub fn telemetry(&self) -> Option<&Telemetry> {
        self.telemetry.as_ref()
    }

    /// Contact of the tissue with the probe after the last tick: normal and friction force, torque
    /// about the tip, centre, axes, area and peak; `pressure_pa` receives the pressure on each
    /// surface triangle [Pa] and may be empty. It is computed when it is read, allocates nothing,
    /// and changes no tick; damping, gains and limits of the loop are not in it. There is none
    /// unless the last tick pressed the tissue without a fault.
    pub fn contact(&mut self, pressure_pa: &mut [f32]) -> ContactMap {
        let pressed = |telemetry: &Telemetry| telemetry.fault.is_none() && telemetry.output != Output::NONE;
        if self.telemetry.as_ref().is_some_and(pressed) {
            return self.tissue.contact(pressure_pa);
        }
        pressure_pa.fill(0.0);
        ContactMap::NONE
    }

    /// Mode of the loop.
    #[must_use]
    pub fn mode(&self) -> Mode {
        self.cycle.mode()
    }

    /// Tissue, with patch, parameters and nodes.
    #[must_use]
    pub fn tissue(&self) -> &LiveTissue {
        &self.tissue
    }

    /// Limits of the device.
    #[must_use]
    pub fn device(&self) -> &DeviceSpec {
        &self.device.spec
    }

    /// Note on a contact that is stiffer than the device renders, so that every force is scaled
    /// down; `None` if the hand feels the tissue as it is.
    #[must_use]
    pub fn ceiling_note(&self) -> Option<String> {
        ceiling_note(self.tissue.contact_n_per_m(), self.device.spec.ceiling_n_per_m(TICK_S as f32))
    }

    /// Limits of the loop.
    #[must_use]
    pub fn limits(&self) -> &LoopLimitSettings {
        self.cycle.limits()
    }

    /// Hash of all positions and velocities of the tissue.
    #[must_use]
    pub fn hash(&mut self) -> u64 {
        self.tissue.hash()
    }

    /// Requests arming: the force is enabled once the probe has been outside and calm for the time
    /// in [`palpate::haptic::cycle::ArmingSettings`], and its gain rises for half a second.
    ///
    /// # Errors
    /// Fails with [`OutOfOrder::Faulted`] if a fault is latched.
    pub fn arm(&mut self) -> Result<(), OutOfOrder> {
        self.arms = self.mode() != Mode::Fault;
        if self.arms { Ok(()) } else { Err(OutOfOrder::Faulted) }
    }

    /// Ramps the force down to zero, and disarms.
    pub fn stop(&mut self) {
        (self.asked, self.arms) = (Some(Ask::Stop), false);
    }

    /// Requests that the next tick clears the fault. The request is refused
    /// ([`Telemetry::refused`]) until readings have been good for a tenth of a second.
    ///
    /// # Errors
    /// Fails with [`OutOfOrder::NoFault`] if there is no fault to clear.
    pub fn clear(&mut self) -> Result<(), OutOfOrder> {
        if self.mode() != Mode::Fault {
            return Err(OutOfOrder::NoFault);
        }
        self.asked = Some(Ask::Clear);
        Ok(())
    }

    /// Sets Young's modulus [Pa] from the next tick on. A higher one waits until nothing is
    /// touched, since stiffening under the probe would give energy to the hand.
    ///
    /// # Errors
    /// [`BuildError::OutOfRange`]: the modulus is not between half and twice that of the opened
    /// tissue, or is not stable with its substeps; nothing changes then.
    pub fn set_modulus(&mut self, youngs_modulus_pa: f32) -> Result<(), BuildError> {
        let [least_pa, most_pa] = self.modulus_pa;
        BuildError::within("youngs_modulus_pa", youngs_modulus_pa, least_pa, most_pa)?;
        self.waiting_pa = (youngs_modulus_pa != self.tissue.params().youngs_modulus_pa).then_some(youngs_modulus_pa);
        Ok(())
    }

    /// Pending Young's modulus, which waits for the probe to leave or for the next tick [Pa].
    #[must_use]
    pub fn waiting_modulus_pa(&self) -> Option<f32> {
        self.waiting_pa
    }

    /// Lowers the maximum force [N], permanently.
    ///
    /// # Errors
    /// [`BuildError::OutOfRange`] if it would rise; nothing changes then.
    pub fn lower_force(&mut self, max_force_n: f32) -> Result<(), BuildError> {
        self.cycle.lower_limits(&LoopLimitSettings { max_force_n, ..*self.cycle.limits() })?;
        self.most_force_n = max_force_n;
        Ok(())
    }

    /// Restarts the session: tissue at rest, no force, no fault, not armed. Young's modulus and
    /// lowered limits are kept.
    ///
    /// # Errors
    /// Returns only errors that opening can return.
    pub fn reset(&mut self) -> Result<(), BuildError> {
        let settings = Settings { limits: *self.cycle.limits(), ..self.settings };
        self.cycle = Cycle::build(&settings, &self.device.spec)?;
        self.device = CallersDevice::new(self.device.spec);
        self.tissue.restart();
        (self.telemetry, self.asked, self.arms) = (None, None, false);
        Ok(())
    }

    /// Applies a pending modulus as soon as permitted.
    fn settle(&mut self) {
        let params = *self.tissue.params();
        let softens = |pa: &mut f32| *pa < params.youngs_modulus_pa;
        let taken = match self.cycle.in_contact() {
            true => self.waiting_pa.take_if(softens),
            false => self.waiting_pa.take(),
        };
        if let Some(youngs_modulus_pa) = taken {
            // its range was checked when it was requested
            let _in_range = self.tissue.retune(Params { youngs_modulus_pa, ..params });
        }
    }
}

/// Whether a patch is stable with its substeps at another modulus [Pa].
fn bears(patch: &Patch, params: &Params, youngs_modulus_pa: f32) -> Result<bool, BuildError> {
    let params = Params { youngs_modulus_pa, ..*params };
    if params.check().is_err() {
        return Ok(false);
    }
    let measured = StableStep::measure(&patch.wide_model(), &params, patch.site_m())?;
    Ok(measured.is_some_and(|step| step.substeps(TICK_S) <= f64::from(params.substeps)))
}

/// The device as the loop sees it: positions supplied by the caller. The force is taken from the
/// record of the tick.
#[derive(Clone, Debug)]
struct CallersDevice {
    spec: DeviceSpec,
    reading: Sensed,
}

impl CallersDevice {
    fn new(spec: DeviceSpec) -> Self {
        let reading = Sensed { position_m: Vector3::zeros(), sequence: 0, status: SensorStatus::Failed };
        Self { spec, reading }
    }

    fn read(&mut self, input: &Input) {
        let sequence = self.reading.sequence.wrapping_add(u32::from(!input.stale));
        let status = if input.sensor_failed { SensorStatus::Failed } else { SensorStatus::Good };
        self.reading = Sensed { position_m: input.tip_m, sequence, status };
    }
}

impl HapticDevice for CallersDevice {
    fn limits(&self) -> DeviceSpec {
        self.spec
    }

    fn sense(&mut self) -> Sensed {
        self.reading
    }

    fn actuate(&mut self, _force_n: Vector3<f32>) {}

    fn release(&mut self) {}
}
