//! Haptic controller: a 1 kHz task renders the tissue patch, and a task of lower priority reports.
//! Open `haptic_task.rs` first.
//!
//! Three priorities, by hardware preemption: tick timer > haptic loop > telemetry. Below all of
//! them the core idles.
#![no_std]
#![no_main]
#![deny(unsafe_code)]

mod board;
mod flash_patch;
mod haptic_task;
mod period;
#[cfg(feature = "self-test")]
mod self_test;
mod telemetry;

use board::{Duty, ThisBoard};
use cortex_m_rt::entry;
use palpate_controller::board::Board;
use palpate_controller::config::Profile;
use palpate_controller::controller::{Arming, Controller};
use palpate_controller::crash::Crash;
use palpate_controller::haptic_loop::HapticLoop;
use palpate_controller::link::{Refusal, Upload};
use palpate_controller::patch::{Memory, Patch, PatchSlot};
use palpate_controller::serve::Pace;
use static_cell::{ConstStaticCell, StaticCell};

static MEMORY: ConstStaticCell<Memory> = ConstStaticCell::new(Memory::RESERVED);
static UPLOAD: ConstStaticCell<Upload> = ConstStaticCell::new(Upload::RESERVED);
/// The haptic loop of the one task that runs.
static LOOP: StaticCell<HapticLoop<ThisBoard>> = StaticCell::new();

#[entry]
fn main() -> ! {
    let memory = MEMORY.take();
    let (haptic, background) = board::start_executors();
    let duty = board::duty();
    board::log::start(&duty);
    let arming = match duty {
        _ if board::barred() => Arming::Barred,
        Duty::Script(_) => Arming::ByItself,
        #[cfg(feature = "self-test")]
        Duty::SelfTest => Arming::Barred, // the self-test has a controller of its own
        Duty::Serve(_) => Arming::OnRequest,
    };
    let controller = haptic_loop(arming);
    match duty {
        Duty::Script(script) => {
            let (bytes, ceiling_n_per_m) = (flash_patch::in_flash(), controller.controller.stiffness_ceiling_n_per_m());
            let patch = or_stop(Patch::open_for(&board::budget(), ceiling_n_per_m, bytes, memory, None, &mut || {}), "no patch");
            background.spawn(or_stop(telemetry::report(), "telemetry"));
            haptic.spawn(or_stop(haptic_task::run_script(controller, PatchSlot(Some(patch)), script), "haptic loop"));
            board::start_tick_timer();
        }
        #[cfg(feature = "self-test")]
        Duty::SelfTest => {
            haptic.spawn(or_stop(self_test::run(ThisBoard::default(), memory), "self-test"));
            board::start_tick_timer();
        }
        Duty::Serve(pace) => {
            haptic.spawn(or_stop(haptic_task::serve_host(controller, memory, UPLOAD.take(), pace), "haptic loop"));
            if pace == Pace::Timed {
                board::start_tick_timer();
            }
        }
    }
    loop {
        board::idle(&duty);
    }
}

/// The loop with the profile that the board keeps. Without one the encoders are treated as three
/// orthogonal axes, and the board arms only after it was homed or received a profile, so that a
/// reset cannot make one device run as another. Not inlined into `main`, whose stack frame exists
/// as long as the image runs.
#[inline(never)]
fn haptic_loop(arming: Arming) -> &'static mut HapticLoop<ThisBoard> {
    let mut this = ThisBoard::default();
    let kept = board::kept_profile(this.profile_memory());
    let known = kept.is_some();
    board::log::started(known, arming == Arming::Barred);
    let (settings, edge) = kept.unwrap_or_else(Profile::desktop).split();
    let edge = if known { edge } else { edge.without_home() };
    let controller = or_stop(Controller::build(&settings, edge, arming).map_err(Refusal::from), "no controller");
    LOOP.init(HapticLoop::new(this, controller))
}

/// Returns the value, or stops the program, which cannot run without it. Only the log names the
/// error, because its words are stored on the host: as text on the board they take 2 KB of flash.
fn or_stop<T, E: defmt::Format>(result: Result<T, E>, what: &str) -> T {
    result.unwrap_or_else(|error| {
        defmt::error!("{}: {}", what, error);
        stop_without(what)
    })
}

/// Not inlined, since each caller would contain it.
#[inline(never)]
fn stop_without(what: &str) -> ! {
    board::stop(&Crash::panic(what, 0), format_args!("{}: the log says why", board::Plain(what)))
}
