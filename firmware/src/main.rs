//! Haptic controller: a 1 kHz task renders the tissue patch, a task below it reports. Open `haptic_loop.rs` first.
//!
//! Three priorities, by hardware preemption: tick timer > haptic loop > telemetry. Idle is `wfi`.
#![no_std]
#![no_main]
#![deny(unsafe_code)]

mod board;
mod haptic_loop;
mod safety;
mod telemetry;

use core::fmt;

use cortex_m_rt::entry;
use palpate::haptic::cycle::Settings;
use palpate_firmware::controller::{Arming, Controller};
use palpate_firmware::edge::Edge;
use palpate_firmware::patch::{self, Memory, Patch};
use static_cell::ConstStaticCell;

static MEMORY: ConstStaticCell<Memory> = ConstStaticCell::new(Memory::RESERVED);

#[entry]
fn main() -> ! {
    let memory = MEMORY.take();
    let patch = or_stop(Patch::open(patch::in_flash(), memory), "no patch");
    let controller = or_stop(Controller::build(&Settings::safe(1), Edge::DESKTOP, Arming::ByItself), "no controller");
    let (haptic, background) = board::start_executors();
    let (Ok(run), Ok(report)) = (haptic_loop::run(controller, patch, board::script()), telemetry::report()) else {
        safety::stop(format_args!("a task was spawned twice"));
    };
    background.spawn(report);
    haptic.spawn(run);
    board::start_tick_timer();
    loop {
        // wfe is a no-op in the emulator and would burn through its virtual time
        cortex_m::asm::wfi();
    }
}

fn or_stop<T>(result: Result<T, impl fmt::Display>, what: &str) -> T {
    result.unwrap_or_else(|error| safety::stop(format_args!("{what}: {error}")))
}
