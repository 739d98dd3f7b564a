//! Devices that are set up wrongly: an axis has the wrong sign, or the readings come in another
//! unit. [`first_touches`] follows such a device from arming through its first touches. It returns
//! the fault that detected the mistake, the time, and the force that the hand had felt by then.
//!
//! The sign in question is that of a motor relative to its encoder: whichever of the two is wired
//! wrongly, the force is mirrored in the frame of the readings. A frame in which encoders *and*
//! motors are mirrored conserves power and has no effect that a loop can measure.

use palpate::haptic::cycle::{Ask, Command, Cycle, Telemetry};
use palpate::haptic::device::{DeviceSpec, HapticDevice, Sensed};
use palpate::haptic::mode::Mode;
use palpate::{BuildError, Fault, Vector3};

use super::plant::Plant;
use super::run::{ARMING_TICKS, Setup, Watched, trajectory_of};
use super::stimulus::CLEAR_M;
use super::surface::Surface;
use palpate_tissue::scene::TICK_S;

/// Number of touches in a run.
pub const TOUCHES: usize = 4;
/// Duration of a touch [ticks], speed of the retreat after it [m/s], and pause before the next
/// touch [ticks].
const PRESSED_TICKS: u32 = 600;
const BACK_M_PER_S: f64 = 0.1;
const PAUSE_TICKS: u32 = 100;
/// Time constant with which the hand brakes before it retreats [s].
const BRAKE_S: f64 = 0.02;
/// Tremor of a hand at rest: amplitude [m] and angular frequency [rad/s].
const TREMOR: (f64, f64) = (80e-6, 56.5);

/// A mistake in the set-up of a device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mistake {
    /// Name in tables.
    pub name: &'static str,
    /// Sign of the force along each axis (1).
    pub sign: [f32; 3],
    /// Metres read per metre moved (1).
    pub unit: f32,
}

const fn mirrored(name: &'static str, sign: [f32; 3]) -> Mistake {
    Mistake { name, sign, unit: 1.0 }
}

const fn unit(name: &'static str, unit: f32) -> Mistake {
    Mistake { name, sign: [1.0; 3], unit }
}

/// All mistakes that are tried; the first entry is a loop without one.
pub const MISTAKES: [Mistake; 10] = [
    mirrored("none", [1.0; 3]),
    mirrored("x mirrored", [-1.0, 1.0, 1.0]),
    mirrored("y mirrored", [1.0, -1.0, 1.0]),
    mirrored("z mirrored", [1.0, 1.0, -1.0]),
    mirrored("x and z mirrored", [-1.0, 1.0, -1.0]),
    mirrored("all mirrored", [-1.0; 3]),
    unit("unit x 10", 10.0),
    unit("unit / 10", 0.1),
    unit("unit x 1000", 1e3),
    unit("unit / 1000", 1e-3),
];

/// Outcome of the first touches.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FirstTouches {
    /// Fault that ended the touches.
    pub fault: Option<Fault>,
    /// Ticks from the first force until the loop removed it, by a fault or for the rest of a
    /// contact. Zero if a fault came before any force; `None` if the force was never removed.
    pub ended_ticks: Option<u32>,
    /// Largest force on the hand until then [N].
    pub peak_n: f32,
    /// Largest distance of the handle until then from its position at the first force [m].
    pub way_m: f64,
}

/// A device with a mistake.
struct Mistaken<'a> {
    plant: &'a mut Plant,
    mistake: Mistake,
    site_m: Vector3<f32>,
}

impl HapticDevice for Mistaken<'_> {
    fn limits(&self) -> DeviceSpec {
        self.plant.limits()
    }

    fn sense(&mut self) -> Sensed {
        let mut sensed = self.plant.sense();
        if self.mistake.unit != 1.0 {
            sensed.position_m = self.site_m + (sensed.position_m - self.site_m) * self.mistake.unit;
        }
        sensed
    }

    fn actuate(&mut self, force_n: Vector3<f32>) {
        self.plant.actuate(force_n.component_mul(&Vector3::from(self.mistake.sign)));
    }

    fn release(&mut self) {
        self.plant.release();
    }
}

/// Arms the loop, then touches the surface [`TOUCHES`] times; `see` is called for every tick of
/// these touches, but not of the retreats.
///
/// # Errors
/// Propagates errors from [`Cycle::build`].
pub fn first_touches(
    setup: &Setup,
    mistake: Mistake,
    surface: &mut impl Surface,
    mut see: impl FnMut(&Telemetry),
) -> Result<FirstTouches, BuildError> {
    let site = surface.site();
    let trajectory = trajectory_of(setup, surface);
    let start_m = site.point_m(-CLEAR_M, 0.0, 0.0);
    surface.reset();
    let mut plant = Plant::new(setup.device, setup.hand, site.at_m.cast(), site.normal.cast(), start_m);
    let limits = plant.limits();
    let mut cycle = Cycle::build(&setup.settings, &limits)?;
    let mut watched = Watched::of(&setup.settings, &limits, surface);
    let mut outcome = FirstTouches::default();
    let mut tick = |plant: &mut Plant, asked: Option<Ask>| {
        let mut device = Mistaken { plant, mistake, site_m: site.at_m.cast() };
        watched.cycle(&mut cycle, &mut device, surface, Command { asked, ..Command::HEARD })
    };
    for n in 0..ARMING_TICKS {
        let asked = [Ask::Booted, Ask::TestPassed, Ask::Arm].get(n as usize).copied();
        let phase = TREMOR.1 * f64::from(n) * TICK_S;
        plant.put(start_m + (site.normal + site.along * 0.3) * (TREMOR.0 * phase.sin()));
        let telemetry = tick(&mut plant, asked);
        if telemetry.mode == Mode::Fault {
            return Ok(FirstTouches { fault: telemetry.fault, ended_ticks: Some(0), ..outcome });
        }
    }
    // ticks since the first force, and the position of the handle at that moment
    let mut felt: Option<(u32, Vector3<f64>)> = None;
    for _ in 0..TOUCHES {
        plant.put(start_m);
        plant.set_velocity_m_per_s(-site.normal * trajectory.entry_m_per_s());
        let mut pressed_ticks = 0;
        for n in 0.. {
            let t_s = f64::from(n) * TICK_S;
            if t_s > trajectory.seconds() || pressed_ticks > PRESSED_TICKS {
                break;
            }
            let telemetry = tick(&mut plant, None);
            see(&telemetry);
            let forced = telemetry.applied_n != Vector3::zeros();
            let touches = telemetry.output.depth_m > 0.0;
            pressed_ticks += u32::from(touches || pressed_ticks > 0);
            if forced && felt.is_none() {
                felt = Some((0, plant.at_m()));
            }
            if let Some((ticks, at_m)) = &mut felt
                && outcome.ended_ticks.is_none()
            {
                outcome.peak_n = outcome.peak_n.max(telemetry.applied_n.norm());
                outcome.way_m = outcome.way_m.max((plant.at_m() - *at_m).norm());
                let taken_away = touches && !forced && telemetry.mode == Mode::Degraded;
                outcome.ended_ticks = (taken_away || telemetry.mode == Mode::Fault).then_some(*ticks);
                *ticks += 1;
            }
            if telemetry.mode == Mode::Fault {
                outcome.fault = telemetry.fault;
                outcome.ended_ticks = outcome.ended_ticks.or(Some(0));
                return Ok(outcome);
            }
            plant.step(&trajectory.aim(t_s), forced || touches);
        }
        // the hand withdraws the probe, whatever force acts on it
        let (from_m, drift_m) = (plant.at_m(), plant.velocity_m_per_s() * BRAKE_S);
        let ticks = ((start_m - from_m).norm() / (BACK_M_PER_S * TICK_S)).ceil() as u32;
        for n in 1..=ticks + PAUSE_TICKS {
            let share = f64::from(n.min(ticks)) / f64::from(ticks.max(1));
            let braked = 1.0 - (-f64::from(n) * TICK_S / BRAKE_S).exp();
            plant.put(from_m + (start_m - from_m) * share + drift_m * (braked * (1.0 - share)));
            let telemetry = tick(&mut plant, None);
            if telemetry.mode == Mode::Fault {
                outcome.fault = telemetry.fault;
                return Ok(outcome);
            }
        }
    }
    Ok(outcome)
}
