//! A running loop: tissue, device, cycle, and the trace of its inputs and outputs.

use palpate::haptic::cycle::{Ask, Command, Settings, Telemetry};
use palpate::haptic::device::{DeviceSpec, HapticDevice};
use palpate::haptic::mode::Mode;
use palpate::{ContactMap, Params, Vector3};

use super::choice::{Choice, axis};
use super::device::{Holding, LiveDevice};
use super::tissue::LiveTissue;
use super::trace::{Head, Recorder};
use crate::closed_loop::rig::Rig;
pub use crate::closed_loop::stimulus::CLEAR_M;
use crate::closed_loop::watch::Broken;
use palpate_tissue::error::Error;
use palpate_tissue::scene::TICK_S;

/// Time constant with which the hand follows the pointer, which jumps from frame to frame [s].
const FOLLOW_S: f64 = 8e-3;
/// Largest speed with which the hand follows the pointer [m/s].
const FASTEST_M_PER_S: f64 = 0.5;

/// Displacement of the hand per tick towards a target at this distance [m]; zero if the distance is
/// not finite.
fn followed(apart_m: Vector3<f64>) -> Vector3<f64> {
    let displacement_m = apart_m * (TICK_S / FOLLOW_S);
    let (length_m, most_m) = (displacement_m.norm(), FASTEST_M_PER_S * TICK_S);
    match length_m {
        _ if !length_m.is_finite() => Vector3::zeros(),
        _ if length_m > most_m => displacement_m * (most_m / length_m),
        _ => displacement_m,
    }
}

/// Result of a tick.
#[derive(Clone, Copy, Debug)]
pub struct Told {
    /// Position of the tip [m].
    pub at_m: Vector3<f64>,
    /// Telemetry of the loop.
    pub telemetry: Telemetry,
    /// The invariant of the loop that this tick is the first to break, if any.
    pub broken: Option<Broken>,
}

impl Told {
    /// Tangential component of the force on the device [N]: the part that friction adds to the
    /// push.
    #[must_use]
    pub fn along_n(&self) -> Vector3<f32> {
        let (force_n, normal) = (self.telemetry.applied_n, self.telemetry.output.normal);
        if normal == Vector3::zeros() { normal } else { force_n - normal * force_n.dot(&normal) }
    }
}

/// A running loop.
#[derive(Clone, Debug)]
pub struct Live {
    choice: Choice,
    holding: Holding,
    tissue: LiveTissue,
    port: LiveDevice,
    settings: Settings,
    rig: Rig,
    target_m: Vector3<f64>,
    /// Pending parameters: stiffer ones wait until nothing is touched, others until the next tick.
    waiting: Option<Params>,
    asked: Option<Ask>,
    recorder: Option<Recorder>,
}

impl Live {
    /// Creates a loop that is about to arm.
    ///
    /// # Errors
    /// A scene that does not fit, an unknown device, or parameters that the core refuses.
    pub fn new(choice: &Choice, holding: &Holding) -> Result<Self, Error> {
        Self::of_tissue(choice.clone(), choice.tissue()?, holding)
    }

    fn of_tissue(choice: Choice, tissue: LiveTissue, holding: &Holding) -> Result<Self, Error> {
        let site_m = tissue.patch().site_m();
        let start_m = site_m.cast() + axis(&tissue) * CLEAR_M;
        let (port, max_force_n) = LiveDevice::new(holding, site_m, tissue.params().probe.axis, start_m)?;
        let mut settings = Settings::safe(&port.limits());
        settings.limits.max_force_n = max_force_n;
        let rig = Rig::build(&settings, &port.limits())?.over(tissue.rest_shape());
        Ok(Self {
            choice,
            holding: holding.clone(),
            tissue,
            port,
            settings,
            rig,
            target_m: start_m,
            waiting: None,
            asked: None,
            recorder: None,
        })
    }

    /// Returns the choice of the tissue that is pressed.
    #[must_use]
    pub fn choice(&self) -> &Choice {
        &self.choice
    }

    /// Device and hand that hold the probe.
    #[must_use]
    pub fn holding(&self) -> &Holding {
        &self.holding
    }

    /// The tissue that is pressed.
    #[must_use]
    pub fn tissue(&self) -> &LiveTissue {
        &self.tissue
    }

    /// Contact map after the last tick, with the pressure on each surface triangle [Pa].
    #[must_use]
    pub fn contact(&mut self) -> (ContactMap, Vec<f32>) {
        let mut pressure_pa = vec![0.0; self.tissue.patch().model().triangles.len()];
        (self.tissue.contact(&mut pressure_pa), pressure_pa)
    }

    /// Returns the limits of the device.
    #[must_use]
    pub fn device(&self) -> DeviceSpec {
        self.port.limits()
    }

    /// Mode of the loop.
    #[must_use]
    pub fn mode(&self) -> Mode {
        self.rig.mode()
    }

    /// Whether a change of stiffness or damping waits for the probe to leave.
    #[must_use]
    pub fn waits(&self) -> bool {
        self.waiting.is_some()
    }

    /// Changes tissue or device. Stiffening waits until nothing is touched; any change beyond
    /// stiffness and damping starts a new loop and ends a recording, whose bytes are returned.
    ///
    /// # Errors
    /// Errors of [`Self::new`]; nothing changes then, and a recording continues.
    pub fn choose(&mut self, choice: &Choice, holding: &Holding) -> Result<Option<Vec<u8>>, Error> {
        if *holding == self.holding && choice.same_patch(&self.choice) {
            let scene = choice.scene()?;
            let params = Params {
                youngs_modulus_pa: scene.tissue.youngs_modulus_pa as f32,
                node_damping_per_s: scene.tissue.node_damping_per_s as f32,
                ..*self.tissue.params()
            };
            // anything that would be refused later is refused now
            self.tissue.clone().retune(params)?;
            self.waiting = (params != *self.tissue.params()).then_some(params);
            self.choice = choice.clone();
            return Ok(None);
        }
        let tissue = match choice.same_patch(&self.choice) && *choice == self.choice {
            true => self.fresh()?,
            false => choice.tissue()?,
        };
        let fresh = Self::of_tissue(choice.clone(), tissue, holding)?;
        let ended = self.finish();
        *self = fresh;
        Ok(ended)
    }

    /// Returns the patch at rest, with the pending parameters, if any.
    fn fresh(&self) -> Result<LiveTissue, Error> {
        let params = self.waiting.unwrap_or(*self.tissue.params());
        Ok(LiveTissue::new(self.tissue.patch().clone(), params)?)
    }

    /// Makes a request to the loop for the next tick; arming and recovery from a fault are
    /// requested automatically.
    pub fn ask(&mut self, ask: Ask) {
        self.asked = Some(ask);
    }

    /// Starts a new loop and records it from its first tick, since a trace begins in a known state.
    ///
    /// # Errors
    /// Errors of [`Self::new`].
    pub fn record(&mut self) -> Result<(), Error> {
        let mut fresh = Self::of_tissue(self.choice.clone(), self.fresh()?, &self.holding)?;
        let head = Head {
            scene: self.choice.scene.clone(),
            device: self.holding.device.clone().unwrap_or_else(|| "pointer".into()),
            hand: self.holding.hand.clone(),
        };
        fresh.recorder = Some(Recorder::new(&head, &fresh.settings, &fresh.port.limits(), &fresh.tissue));
        *self = fresh;
        Ok(())
    }

    /// Ticks recorded so far; `None` without a recording.
    #[must_use]
    pub fn recorded(&self) -> Option<u32> {
        self.recorder.as_ref().map(Recorder::ticks)
    }

    /// Ends the recording and returns the bytes of the trace.
    pub fn finish(&mut self) -> Option<Vec<u8>> {
        let hash = self.tissue.hash();
        self.recorder.take().map(|recorder| recorder.finish(hash))
    }

    /// Runs one tick towards a target [m]. `heard` says whether the host sent a keep-alive; without
    /// one the force ends.
    pub fn tick(&mut self, target_m: Vector3<f64>, heard: bool) -> Told {
        // softening applies at once; stiffening under the probe would create energy
        let softens = self.waiting.is_some_and(|p| p.youngs_modulus_pa <= self.tissue.params().youngs_modulus_pa);
        if (softens || !self.rig.cycle().in_contact())
            && let Some(params) = self.waiting.take()
            && self.tissue.retune(params).is_ok()
            && let Some(recorder) = &mut self.recorder
        {
            recorder.retuned(&params);
        }
        let asked = self.asked.take().or(match self.rig.mode() {
            Mode::Boot => Some(Ask::Booted),
            Mode::SelfTest => Some(Ask::TestPassed),
            Mode::Idle if heard => Some(Ask::Arm),
            _ => None,
        });
        let command = Command { heard, asked, ..Command::default() };
        let known = self.rig.broken().len();
        let telemetry = self.rig.tick(&mut self.port, &mut self.tissue, command);
        let broken = self.rig.broken().get(known).map(|(broken, _)| *broken);
        if let (Some(recorder), Some(tick)) = (&mut self.recorder, self.rig.last()) {
            recorder.row(&tick.reading, &command, &telemetry);
            if recorder.hash_due() {
                recorder.hash(self.tissue.hash());
            }
        }
        let displacement_m = followed(target_m - self.target_m);
        self.target_m += displacement_m;
        let touched = telemetry.output.depth_m > 0.0 || telemetry.applied_n != Vector3::zeros();
        self.port.step(self.target_m, displacement_m / TICK_S, touched);
        Told { at_m: self.port.at_m(), telemetry, broken }
    }
}
