//! The log: defmt's frames go to the board's debug channel and, while a host is served, into the
//! ring from which the loop sends them over the link.
//!
//! An image has one such logger: a crate for one of the two ways would leave no place for the
//! other. A line costs the haptic loop some thousand instructions with interrupts off, after the
//! force is output; its text stays in the ELF file.

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

/// The checksum, read from where hosts find it.
pub fn image() -> u32 {
    *core::hint::black_box(&PALPATE_IMAGE)
}

struct State {
    encoder: Encoder,
    ring: Ring,
    /// Frames go into the ring.
    to_link: bool,
    /// A frame is being written.
    begun: bool,
    /// Whether interrupts were on before the frame was begun.
    were_on: bool,
}

struct Shared(UnsafeCell<State>);

// SAFETY: reached only with interrupts off, on a chip of which one core runs. A fault handler that
// logs within a frame never returns to it.
unsafe impl Sync for Shared {}

static SHARED: Shared =
    Shared(UnsafeCell::new(State { encoder: Encoder::new(), ring: Ring::EMPTY, to_link: false, begun: false, were_on: false }));

#[defmt::global_logger]
struct Logger;

/// Hands on bytes of a frame. Inlined it would be in the image nine times.
#[inline(never)]
fn put(ring: Option<&mut Ring>, bytes: &[u8]) {
    if let Some(ring) = ring {
        ring.push(bytes);
    }
    family::debug_write(bytes);
}

/// Writes bytes of the frame that was begun.
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

    // SAFETY: nothing waits in the logger itself.
    unsafe fn flush() {}

    // SAFETY: defmt calls it once after each `acquire`.
    unsafe fn release() {
        // SAFETY: interrupts are off since `acquire`.
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

/// Opens the debug channel. Frames also go into the ring where a host is served in real time; in
/// lock-step the link carries no log, so that runs stay the same to the bit.
pub fn start(duty: &Duty) {
    family::debug_start(duty);
    // SAFETY: interrupts are off.
    interrupt::free(|_| unsafe { (*SHARED.0.get()).to_link = matches!(duty, Duty::Serve(Pace::Timed)) });
}

/// Takes frames that wait for the link, as many as a message holds.
pub fn take() -> Option<Log> {
    // SAFETY: interrupts are off.
    interrupt::free(|_| unsafe { (*SHARED.0.get()).ring.take() })
}

/// The board has started; `profile`: it keeps one; `barred`: arming is.
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

/// Encodes an event. Texts of modes and faults are in the image anyway; refusals go by their names.
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
