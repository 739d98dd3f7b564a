//! A family of presses in which a count of the encoder can drive a limit cycle: a light hand
//! presses stiff tissue with a light handle, without friction.
//!
//! Without a bound, a flat tip on 100 kPa with counts of 55 um swings with 1 N RMS at 55 Hz for as
//! long as the hand presses.

use palpate::Params;
use palpate_tissue::finger::Impedance;

use super::case::YieldingCase;
use super::motion::{Motion, MotionKind};
use crate::faults::paths::PathGround;
use palpate_loop::closed_loop::device::DeviceProfile;

/// Most that the force may swing above 15 Hz one second after the press [N].
pub const FAMILY_QUIET_N: f64 = 0.1;
/// Most energy that a press of six seconds may give [J].
pub const FAMILY_WITHIN_J: f64 = 0.3e-3;

/// Patch that is pressed, under each of its tips.
const PATCH: &str = "block-m4f-168";
const YOUNGS_MODULI_PA: [f32; 4] = [20e3, 50e3, 80e3, 100e3];
const COUNTS_M: [f64; 5] = [0.0, 20e-6, 45e-6, 55e-6, 60e-6];
const HANDS_KG: [f64; 4] = [0.01, 0.021, 0.066, 0.2];
/// Stiffness [N/m] and damping [N s/m] of the hand.
const HAND: (f64, f64) = (287.0, 3.5);
/// The press: depth of the hand's target [m], and duration [s].
const PRESS: (f64, f64) = (4.7e-3, 0.18);
/// The hand's tremor: amplitude [m] and frequency [Hz].
const TREMOR: (f64, f64) = (0.024e-3, 5.7);

/// Every press of the family on this device, without its friction, lag and delay. Each stands for
/// `1 / share` of the family's members.
pub fn family(ground: &PathGround, base: &DeviceProfile, share: usize) -> Vec<YieldingCase> {
    let mut cases = Vec::new();
    for patch in (0..ground.patches.len()).filter(|n| ground.patches[*n].name == PATCH) {
        for youngs_modulus_pa in YOUNGS_MODULI_PA {
            for count_m in COUNTS_M {
                for mass_kg in HANDS_KG {
                    cases.push(press(ground, base, patch, youngs_modulus_pa, count_m, mass_kg));
                }
            }
        }
    }
    cases.into_iter().rev().step_by(share.max(1)).collect()
}

fn press(
    ground: &PathGround,
    base: &DeviceProfile,
    patch: usize,
    youngs_modulus_pa: f32,
    count_m: f64,
    hand_kg: f64,
) -> YieldingCase {
    let (stiffness_n_per_m, damping_n_s_per_m) = HAND;
    let (depth_m, press_s) = PRESS;
    let (tremor_m, tremor_hz) = TREMOR;
    YieldingCase {
        shipped: None,
        uncapped: false,
        missing_ticks: 0,
        stop_ticks: 0,
        patch,
        params: Params { youngs_modulus_pa, ..ground.patches[patch].params },
        device: DeviceProfile { count_m, delay_ticks: 0, amplifier_lag_s: 0.0, friction_n: 0.0, ..base.clone() },
        hand: Impedance { mass_kg: hand_kg, damping_n_s_per_m, stiffness_n_per_m },
        motion: Motion {
            kind: MotionKind::Hold,
            reach_m: depth_m,
            depth_m,
            press_s,
            share: 0.0,
            hz: 1.0,
            tremor_m,
            tremor_hz,
            aside_m_per_s: 0.0,
            place_m: [0.0; 2],
            phase: 0.0,
            shake_m_per_s2: 0.0,
            shake_hz: 1.0,
        },
    }
}
