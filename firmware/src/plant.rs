//! Crashes on purpose, for the tests: what turns the outputs off when the firmware itself fails? Only with the feature `planted-crash`.

use core::hint::black_box;
use core::sync::atomic::{AtomicU32, Ordering};

use palpate_firmware::force_out::{DacCode, Outputs};

use crate::board;

/// Where control comes past.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// Before the haptic cycle.
    Tick,
    /// After the converters were written.
    Written,
    /// The reporting task.
    Report,
    /// The tick timer's interrupt.
    Timer,
    /// The thread under every interrupt.
    Thread,
}

/// Every site: where, and what goes wrong.
const SITES: [(Place, fn()); 18] = [
    (Place::Tick, panics),
    (Place::Written, indexes_past_the_end),
    (Place::Report, unwraps_nothing),
    (Place::Timer, divides_by_zero),
    (Place::Thread, panics),
    (Place::Tick, board::crash::reads_nowhere),
    (Place::Report, board::crash::runs_an_undefined_instruction),
    (Place::Timer, board::crash::jumps_nowhere),
    (Place::Tick, overflows_the_stack),
    (Place::Thread, overflows_the_stack),
    (Place::Timer, overflows_the_stack),
    (Place::Written, board::crash::pends_a_stray_interrupt),
    (Place::Tick, hangs),
    (Place::Thread, board::crash::stops_the_timer),
    (Place::Tick, dawdles_once),
    (Place::Written, leaves_a_force),
    (Place::Written, leaves_a_force_once),
    (Place::Tick, overflows_a_sum),
];

/// Ticks before the crash.
const AFTER_TICKS: u32 = 3;

static TICKS: AtomicU32 = AtomicU32::new(0);

/// Crashes if the site that the command line names is here, with the outputs on.
pub fn pass(place: Place) {
    if place == Place::Tick {
        TICKS.fetch_add(1, Ordering::Relaxed);
    }
    if TICKS.load(Ordering::Relaxed) < AFTER_TICKS {
        return;
    }
    let site = board::planted_site().and_then(|site| SITES.get(site));
    if let Some((at, crash)) = site
        && *at == place
    {
        board::write_outputs(Outputs { enabled: true, codes: [DacCode(1_000); 3] });
        crash();
    }
}

#[inline(never)]
fn panics() {
    panic!("planted");
}

#[inline(never)]
fn indexes_past_the_end() {
    let codes = [1, 2, 3];
    black_box(codes[black_box(3)]);
}

#[inline(never)]
fn unwraps_nothing() {
    black_box(None::<u32>).expect("planted");
}

#[inline(never)]
fn divides_by_zero() {
    black_box(1 / black_box(0));
}

/// Wraps silently, but for an image with overflow checks.
#[inline(never)]
fn overflows_a_sum() {
    black_box(black_box(i8::MIN) + black_box(-1));
}

#[inline(never)]
fn overflows_the_stack() {
    let room = black_box([1_u8; 256]);
    if black_box(true) {
        overflows_the_stack();
    }
    black_box(room);
}

/// `pass` has put it there.
#[inline(never)]
fn leaves_a_force() {
    black_box(());
}

/// The same in one tick: the others take it away again.
#[inline(never)]
fn leaves_a_force_once() {
    if TICKS.load(Ordering::Relaxed) != AFTER_TICKS {
        board::write_outputs(Outputs::OFF);
    }
}

/// One tick of a press takes half a period too long; no crash, and nothing before or after it is late.
#[inline(never)]
fn dawdles_once() {
    const TICK: u32 = 900;
    let begun = board::clock_counts();
    while TICKS.load(Ordering::Relaxed) == TICK && board::counts_to_ns(board::clock_counts().wrapping_sub(begun)) < 1_000_000 {}
}

#[inline(never)]
fn hangs() {
    loop {
        black_box(());
    }
}
