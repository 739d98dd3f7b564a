//! Haptic controller: a 1 kHz task renders the tissue patch, a task below it reports. Open `haptic_loop.rs` first.
//!
//! Three priorities, by hardware preemption: tick timer > haptic loop > telemetry. Below all of them the core idles.
#![no_std]
#![no_main]
#![deny(unsafe_code)]

mod board;
mod haptic_loop;
#[cfg(feature = "planted-crash")]
mod plant;
mod safety;
mod serve;
mod telemetry;

use core::fmt;

use board::Duty;
use cortex_m_rt::entry;
use haptic_loop::HapticLoop;
use palpate_firmware::config::{self, Profile};
use palpate_firmware::controller::{Arming, Controller};
use palpate_firmware::link::{Refusal, Upload};
use palpate_firmware::patch::{self, Memory, Patch, Tissue};
use serve::Pace;
use static_cell::ConstStaticCell;

static MEMORY: ConstStaticCell<Memory> = ConstStaticCell::new(Memory::RESERVED);
static UPLOAD: ConstStaticCell<Upload> = ConstStaticCell::new(Upload::RESERVED);

#[entry]
fn main() -> ! {
    let memory = MEMORY.take();
    let (haptic, background) = board::start_executors();
    let duty = board::duty();
    let arming = match duty {
        _ if board::barred() => Arming::Barred,
        Duty::Script(_) => Arming::ByItself,
        Duty::Serve(_) => Arming::OnRequest,
    };
    let (settings, edge) = config::load(&board::ProfileMemory).map_or_else(Profile::desktop, |kept| kept.0).split();
    let controller = or_stop(Controller::build(&settings, edge, arming).map_err(Refusal::from), "no controller");
    let controller = HapticLoop::new(controller);
    match duty {
        Duty::Script(script) => {
            let patch =
                or_stop(Patch::open_within(&board::budget(), patch::in_flash(), memory, None).map_err(Refusal::from), "no patch");
            background.spawn(or_stop(telemetry::report(), "telemetry"));
            haptic.spawn(or_stop(haptic_loop::run_script(controller, Tissue(Some(patch)), script), "haptic loop"));
            board::start_tick_timer();
        }
        Duty::Serve(pace) => {
            haptic.spawn(or_stop(serve::run(controller, memory, UPLOAD.take(), pace), "haptic loop"));
            if pace == Pace::Timed {
                board::start_tick_timer();
            }
        }
    }
    loop {
        board::idle(&duty);
        #[cfg(feature = "planted-crash")]
        plant::pass(plant::Place::Thread);
    }
}

/// Nothing runs without it.
fn or_stop<T>(result: Result<T, impl fmt::Display>, what: &str) -> T {
    result.unwrap_or_else(|error| safety::stop(format_args!("{what}: {error}")))
}
