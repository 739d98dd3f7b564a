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

use cortex_m_rt::entry;
use palpate_firmware::patch;

#[entry]
fn main() -> ! {
    let patch = match patch::load() {
        Ok(patch) => patch,
        Err(error) => safety::stop(format_args!("no patch: {error:?}; pack it again with `palpate mesh pack`")),
    };
    let (haptic, background) = board::start_executors();
    let (Ok(run), Ok(report)) = (haptic_loop::run(patch, board::run_ticks()), telemetry::report()) else {
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
