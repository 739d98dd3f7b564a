//! Starts a fault: in the device, the tissue, the plant, or the host's messages.

use palpate::haptic::cycle::Command;
use palpate::haptic::limits::LoopLimitSettings;

use super::state::Scene;
use crate::faults::faulty::{ForceFault, Host, Injection};
use palpate_loop::closed_loop::surface::Surface;

/// Starts the fault; returns an immediate violation, if any.
pub(super) fn begin<S: Surface>(injection: Injection, scene: &mut Scene<'_, S>) -> Option<&'static str> {
    match injection {
        Injection::Reading(fault) => scene.device.break_reading(Some(fault)),
        Injection::ForceFault(fault) => {
            scene.device.break_drive(Some(fault));
            match fault {
                ForceFault::Lag(lag_s) => scene.plant().device_mut().amplifier_lag_s = lag_s,
                ForceFault::Friction(ratio) => scene.plant().device_mut().friction_n *= ratio,
                _ => {}
            }
        }
        Injection::Tissue(fault) => scene.tissue.break_it(Some(fault)),
        Injection::Host(Host::Lowers) => {
            let now = *scene.rig.cycle().limits();
            let asked = LoopLimitSettings { max_force_n: 0.5 * now.max_force_n, ..now };
            if scene.rig.lower_limits(&asked).is_err() || *scene.rig.cycle().limits() != asked {
                return Some("a lowered limit was not taken");
            }
        }
        Injection::Host(Host::Raises(which)) => {
            let now = *scene.rig.cycle().limits();
            let asked = match which {
                0 => LoopLimitSettings { max_force_n: now.max_force_n * 1.05, ..now },
                1 => LoopLimitSettings { max_force_n: f32::NAN, ..now },
                2 => LoopLimitSettings { max_slew_n_per_s: now.max_slew_n_per_s * 2.0, ..now },
                _ => LoopLimitSettings { max_speed_m_per_s: -1.0, ..now },
            };
            if scene.rig.lower_limits(&asked).is_ok() || *scene.rig.cycle().limits() != now {
                return Some("a limit was raised");
            }
        }
        _ => {}
    }
    None
}

/// Returns the command to the loop in the tick that is `since` ticks after the fault began; `since`
/// is `None` before the fault begins and after it ends.
pub(super) fn command(injection: Injection, since: Option<u32>) -> Command {
    let Some(since) = since else { return Command::HEARD };
    match injection {
        Injection::Host(Host::Silent) => Command { heard: false, ..Command::HEARD },
        Injection::Host(Host::Asks(asked)) => Command { asked: Some(asked), ..Command::HEARD },
        Injection::Found(fault) => Command { found: Some(fault), ..Command::HEARD },
        Injection::Late { ticks, every } if since.is_multiple_of(every) => Command { late_ticks: ticks, ..Command::HEARD },
        _ => Command::HEARD,
    }
}
