//! The log: defmt's frames go to the board's debug channel and, while a host is served, into the
//! ring from which the loop sends them over the link.
//!
//! An image can have only one defmt logger, so an existing crate that writes to one of the two
//! would exclude the other. A line costs the haptic loop some thousand instructions with interrupts
//! off, after the force has been written; its text stays in the ELF file.

use core::cell::UnsafeCell;

use cortex_m::interrupt;
use cortex_m::register::primask;
use defmt::Encoder;
use palpate_controller::link::Log;
use palpate_controller::log::{Event, Ring};
use palpate_controller::serve::Pace;
use palpate_controller::words;

use super::{Duty, family, resets};

include!(concat!(env!("OUT_DIR"), "/image.rs"));

/// Checksum of the image's sources and features, under a name by which hosts find it in the ELF
/// file.
// SAFETY: nothing else has this name.
#[unsafe(no_mangle)]
static PALPATE_IMAGE: u32 = IMAGE;

/// The checksum, read from [`PALPATE_IMAGE`], so that the linker keeps that static.
pub fn image() -> u32 {
    *core::hint::black_box(&PALPATE_IMAGE)
}

struct State {
    encoder: Encoder,
    ring: Ring,
    /// Whether frames also go into the ring.
    to_link: bool,
    /// Whether a frame is being written.
    begun: bool,
    /// Whether interrupts were on before the frame was begun.
    were_on: bool,
}

struct Shared(UnsafeCell<State>);

// SAFETY: accessed only with interrupts off, and only one core of the chip runs. A fault handler
// that logs while a frame is being written never returns to it.
unsafe impl Sync for Shared {}

static SHARED: Shared =
    Shared(UnsafeCell::new(State { encoder: Encoder::new(), ring: Ring::EMPTY, to_link: false, begun: false, were_on: false }));

#[defmt::global_logger]
struct Logger;

/// Passes bytes of a frame on. Not inlined, since the image would otherwise contain nine copies.
#[inline(never)]
fn put(ring: Option<&mut Ring>, bytes: &[u8]) {
    if let Some(ring) = ring {
        ring.push(bytes);
    }
    family::debug_write(bytes);
}

/// Encodes and writes bytes of the current frame.
fn write(bytes: &[u8]) {
    // SAFETY: defmt calls it between `acquire`, which turns interrupts off, and `release`.
    let State { encoder, ring, to_link, .. } = unsafe { &mut *SHARED.0.get() };
    encoder.write(bytes, |bytes| put(to_link.then_some(&mut *ring), bytes));
}

// SAFETY: interrupts are off from `acquire` to `release`, so frames do not mix.
unsafe impl defmt::Logger for Logger {
    fn acquire() {
        let were_on = primask::read().is_active();
        interrupt::disable();
        // SAFETY: interrupts are off.
        let state = unsafe { &mut *SHARED.0.get() };
        if state.begun {
            state.encoder = Encoder::new(); // the old one belongs to a frame that a fault cut off
        }
        (state.begun, state.were_on) = (true, were_on);
        let State { encoder, ring, to_link, .. } = state;
        ring.begin();
        encoder.start_frame(|bytes| put(to_link.then_some(&mut *ring), bytes));
    }

    // SAFETY: the logger itself buffers nothing.
    unsafe fn flush() {}

    // SAFETY: defmt calls it once after each `acquire`.
    unsafe fn release() {
        // SAFETY: interrupts have been off since `acquire`.
        let State { encoder, ring, to_link, begun, were_on } = unsafe { &mut *SHARED.0.get() };
        encoder.end_frame(|bytes| put(to_link.then_some(&mut *ring), bytes));
        ring.end();
        *begun = false;
        if *were_on {
            // SAFETY: they were on before `acquire`.
            unsafe { interrupt::enable() };
        }
    }

    // SAFETY: defmt calls it between `acquire` and `release`.
    unsafe fn write(bytes: &[u8]) {
        write(bytes);
    }
}

/// Opens the debug channel. If a host is served in real time, frames also go into the ring; in
/// lock-step the link carries no log, so that runs are reproducible bit for bit.
pub fn start(duty: &Duty) {
    family::debug_start(duty);
    // SAFETY: interrupts are off.
    interrupt::free(|_| unsafe { (*SHARED.0.get()).to_link = matches!(duty, Duty::Serve(Pace::Timed)) });
}

/// Removes the oldest frames that wait for the link, as many as fit into a message.
pub fn take() -> Option<Log> {
    // SAFETY: interrupts are off.
    interrupt::free(|_| unsafe { (*SHARED.0.get()).ring.take() })
}

/// Logs the start of the board, whether it has a stored `profile`, and whether arming is `barred`.
pub fn started(profile: bool, barred: bool) {
    if resets::crashed() {
        defmt::warn!("started after a crash or the watchdog's reset");
    } else {
        defmt::info!("started after power-on or the reset button");
    }
    if barred {
        defmt::warn!("arming is barred until power-off: three crashes within a minute");
    }
    if profile {
        defmt::info!("profile found");
    } else {
        defmt::info!("no profile found: three axes, not homed");
    }
}

/// Encodes an event. Modes and faults are logged as text, which the image contains anyway, refusals
/// by their names.
pub fn event(event: Event) {
    match event {
        Event::PatchOpened { nodes, checksum, youngs_modulus_pa } => {
            defmt::info!(
                "patch opened: {=u32} nodes, checksum {=u32:08x}, Young's modulus {=f32} Pa",
                nodes,
                checksum,
                youngs_modulus_pa
            );
        }
        Event::UploadBegun(bytes) => defmt::info!("upload begun: {=u32} bytes", bytes),
        Event::Mode { to, from } => defmt::info!("mode {=str}, was {=str}", words::mode(to), words::mode(from)),
        Event::Fault(fault) => defmt::error!("fault {=u8}: {=str}", fault as u8, fault.text()),
        Event::Refused(refusal) => defmt::warn!("refused: {}", refusal),
        Event::Late { overruns, missed_periods } => {
            defmt::warn!("late since the start: {=u32} ticks, {=u32} periods without a tick", overruns, missed_periods);
        }
        Event::Profile(0) => defmt::info!("profile in use until power-off"),
        Event::Profile(number) => defmt::info!("profile in use, kept as number {=u32}", number),
        Event::Homed => defmt::info!("home pose taken"),
    }
}
