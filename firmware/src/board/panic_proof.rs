//! An image that only links if no tick can panic: its panic handler calls a function that does not
//! exist. The image is never run.
//!
//! It contains everything that a tick contains, from the message to the outputs: frame, inbox,
//! controller with its haptic cycle, patch, converter codes. Executors and log are left out: they
//! can panic in some places, outside the tick.
#![no_std]
#![no_main]
#![expect(unsafe_code, reason = "it is never run: it only has to link")]

use core::hint::black_box;
use core::panic::PanicInfo;

use cortex_m_rt::entry;
use palpate::haptic::deadline::Deadline;
use palpate_controller::controller::Controller;
use palpate_controller::link::frame::FRAME_BYTES;
use palpate_controller::link::inbox::{Inbox, Reply};
use palpate_controller::link::{FromBoard, Receiver, Record, ToBoard, Upload, encode};
use palpate_controller::patch::PatchSlot;
use palpate_controller::probe_in::Reading;

unsafe extern "C" {
    fn a_tick_can_panic() -> !;
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    // SAFETY: never run: if it is called at all, the image does not link.
    unsafe { a_tick_can_panic() }
}

// SAFETY: the section and the name are where cortex-m-rt expects the table; no interrupt is ever
// unmasked.
#[unsafe(link_section = ".vector_table.interrupts")]
#[unsafe(no_mangle)]
static __INTERRUPTS: [usize; 32] = [0; 32];

/// A value unknown to the optimiser, which must not infer from known values that a panic cannot
/// happen.
fn unknown<T>() -> &'static mut T {
    // SAFETY: never run.
    unsafe { &mut *black_box(0x2000_0000_usize as *mut T) }
}

#[entry]
fn main() -> ! {
    loop {
        tick(unknown(), unknown(), unknown(), unknown(), unknown());
    }
}

#[inline(never)]
fn tick(
    controller: &mut Controller,
    tissue: &mut PatchSlot<'static>,
    receiver: &mut Receiver,
    inbox: &mut Inbox,
    deadline: &mut Deadline,
) {
    if let Some(Ok(message)) = receiver.push::<ToBoard<'_>>(black_box(0))
        && let Reply::Modulus(pascal) = black_box(inbox.take(&message, controller, Some(unknown::<Upload>())))
    {
        black_box(tissue.ask_modulus(pascal, controller.stiffness_ceiling_n_per_m()).is_ok());
    }
    #[cfg(feature = "panic-proof-bites")]
    assert!(black_box(true), "shows that the proof bites");
    let (reading, command) = inbox.clear();
    let reading: Reading = reading.unwrap_or(*unknown());
    let telemetry = controller.tick(tissue, reading, command, black_box(true));
    let outputs = controller.outputs();
    black_box(controller.show_home(&reading));
    black_box((deadline.judge(black_box(1)).is_ok(), controller.sound(&telemetry)));
    tissue.settle(controller.in_contact());
    let mut out = [0; FRAME_BYTES];
    let record = FromBoard::Record(Record::new(&telemetry, outputs, black_box(7)));
    black_box(encode(black_box(1), &record, &mut out).is_ok());
}
