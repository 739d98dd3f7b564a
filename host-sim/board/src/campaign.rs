//! Contact, faults and recovery for any duration: situations that a press alone does not produce.
//!
//! Each round is a press with a slide and at most one of the disturbances below: a fault, a stop by
//! request, or a tissue that softens. After a fault or a stop the loop is cleared and armed again.
//! Random numbers come from a generator with a fixed seed, so that a run can be repeated to the
//! bit.

use palpate::haptic::mode::Mode;
use palpate::{ClampFlags, Vector3};
use palpate_controller::link::message::HostAsk;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

use super::twin::Reading;
use super::{EmulateError, Lockstep};

/// Height above the surface at which the hand waits [m].
const CLEAR_M: f32 = 1e-3;
/// Duration of one press and slide [ticks].
const PRESS_TICKS: u32 = 400;

/// Disturbance injected into a round, if any.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mishap {
    None,
    NotANumber,
    SensorFails,
    Teleport,
    Stale,
    OutsideWorkspace,
    SupplyLow,
    Softer,
    Stop,
}

const MISHAPS: [Mishap; 9] = [
    Mishap::NotANumber,
    Mishap::None,
    Mishap::Softer,
    Mishap::SensorFails,
    Mishap::Teleport,
    Mishap::Stale,
    Mishap::OutsideWorkspace,
    Mishap::SupplyLow,
    Mishap::Stop,
];

/// Counts of ticks and recoveries in a campaign.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Met {
    /// Number of ticks.
    pub ticks: u32,
    /// Ticks in contact with a force on the hand.
    pub felt: u32,
    /// Ticks in the mode `Fault`.
    pub faulted: u32,
    /// Ticks in which the force ramped down.
    pub ramping: u32,
    /// Number of times that the force returned after a fault or a stop.
    pub recovered: u32,
}

/// Runs the campaign for this many ticks; the deepest press is `deepest_m`.
///
/// # Errors
/// The board has crashed.
pub fn run(twin: &mut Lockstep<'_>, ticks: u32, deepest_m: f32, mut progress: impl FnMut(u32)) -> Result<Met, EmulateError> {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(7);
    let mut share = || (random.next_u32() >> 8) as f32 / (1 << 24) as f32;
    let mut met = Met::default();
    let mut round = 0;
    while met.ticks < ticks {
        let mishap = MISHAPS[round % MISHAPS.len()];
        round += 1;
        let depth_m = deepest_m * (0.25 + 0.75 * share());
        let (turn, slide_m) = (core::f32::consts::TAU * share(), 4e-3 * share());
        let at = (PRESS_TICKS as f32 * (0.2 + 0.6 * share())) as u32;
        let (mut calm, mut strayed) = (0, 0);
        let mut n = 0;
        let mut was_away = twin.mode() != Mode::Active;
        while met.ticks < ticks && n < PRESS_TICKS {
            let active = matches!(twin.mode(), Mode::Active | Mode::Degraded);
            // under force such a jump would be detected as too fast, so the hand jumps before it
            // presses
            let straying = mishap == Mishap::OutsideWorkspace && active && strayed < 4;
            // the hand waits outside until the force is on at full gain, then presses once
            let pressing = !straying && (n > 0 || (active && calm > 0));
            let phase = n as f32 / PRESS_TICKS as f32;
            let down = (1.0 - (2.0 * phase - 1.0).abs()) * (depth_m + CLEAR_M);
            let aside = (phase - 0.25).clamp(0.0, 0.5) * 2.0 * slide_m;
            let (s, c) = turn.sin_cos();
            let way = if pressing { Vector3::new(c * aside, s * aside, CLEAR_M - down) } else { Vector3::new(0.0, 0.0, CLEAR_M) };
            let mut reading = Reading::at(way);
            let mut ask = match twin.mode() {
                Mode::Idle => Some(HostAsk::Arm),
                Mode::Fault => Some(HostAsk::Clear),
                _ => None,
            };
            if straying {
                reading.position_m.z = 0.2;
                strayed += 1;
            }
            if pressing && (at..at + 4).contains(&n) {
                match mishap {
                    Mishap::None | Mishap::OutsideWorkspace => {}
                    // the tissue softens under the probe, and becomes stiff again once the probe
                    // has left
                    Mishap::Softer => twin.modulus(if n == at { 0.6 } else { 1.0 })?,
                    Mishap::NotANumber => reading.position_m.y = f32::NAN,
                    Mishap::SensorFails => reading.good = false,
                    Mishap::Teleport => reading.position_m.x += 0.02 * (n - at + 1) as f32,
                    Mishap::Stale => reading.fresh = false,
                    Mishap::SupplyLow => twin.supply_low()?,
                    Mishap::Stop => ask = Some(HostAsk::Stop),
                }
            }
            let record = twin.tick(reading, ask)?;
            met.ticks += 1;
            progress(met.ticks);
            let mode = record.mode();
            met.felt += u32::from(record.depth_m > 0.0 && record.applied_n != [0.0; 3]);
            met.faulted += u32::from(mode == Some(Mode::Fault));
            met.ramping += u32::from(mode == Some(Mode::SafeRamp));
            let full = mode == Some(Mode::Active) && record.limiters & ClampFlags::GAIN.bits() == 0;
            if was_away && full {
                met.recovered += 1;
                was_away = false;
            }
            calm = if full { calm + 1 } else { 0 };
            if pressing {
                n += 1;
                if !matches!(mode, Some(Mode::Active | Mode::Degraded | Mode::SafeRamp)) {
                    break; // the hand leaves the tissue, and the next round begins
                }
            }
        }
    }
    Ok(met)
}
