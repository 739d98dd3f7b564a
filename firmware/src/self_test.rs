//! Self-test: a scripted hand presses, no motor is driven, no host is needed. It is the first image
//! to flash on a new board.
//!
//! It runs the whole controller at 1 kHz on the board's own clock and watchdog, with outputs that
//! are never enabled ([`Motorless`]), measures the stages of the tick, and then reports its
//! findings over the log and the link, repeatedly: `palpate board self-test` compares them with the
//! desktop's. The light is on during the test; afterwards it blinks once a second if the test was
//! passed, five times a second if not.

mod motorless;
mod report;
mod stages;

use palpate::Fnv;
use palpate::haptic::cycle::Command;
use palpate::haptic::mode::Mode;
use palpate_controller::board::Board;
use palpate_controller::config::Profile;
use palpate_controller::controller::{Arming, Controller};
use palpate_controller::haptic_loop::HapticLoop;
use palpate_controller::link::BAUD;
use palpate_controller::patch::{Memory, Patch, PatchSlot};
use palpate_controller::script::{self, LEAD_TICKS};
use static_cell::{ConstStaticCell, StaticCell};

use crate::board::{self, ThisBoard};
use crate::flash_patch::in_flash;
use crate::period::next_period;
use motorless::Motorless;
use report::{CHECKS, Check, Findings, Report};

/// Ticks of the run: start-up, then the script's tap, hold, release and slide once, and a margin.
const TICKS: u32 = 4_000;
/// Ticks between two fingerprints.
const CHECK_TICKS: u32 = TICKS / CHECKS as u32;
/// Ticks between two reports.
const REPEAT_TICKS: u32 = 2_000;
/// Bytes per tick that the link carries, less a fifth; a byte takes ten bits.
const BYTES_PER_TICK: usize = (BAUD / 10_000 * 4 / 5) as usize;

// kept in statics and filled by separate functions, so that each call can reuse the stack of the
// previous one
static LOOP: StaticCell<HapticLoop<Motorless>> = StaticCell::new();
static FINDINGS: ConstStaticCell<Findings> = ConstStaticCell::new(Findings::NONE);
static REPORT: ConstStaticCell<Report> = ConstStaticCell::new(Report::EMPTY);

/// Runs the test, then reports indefinitely.
#[embassy_executor::task]
pub async fn run(this: ThisBoard, memory: &'static mut Memory) {
    board::led(true);
    let (findings, report) = (FINDINGS.take(), REPORT.take());
    if let Err(error) = test(this, memory, findings).await {
        findings.error = error;
    }
    report.fill(findings);
    loop {
        board::print(format_args!("{}", report.text()));
        board::after_report(findings.passed());
        let mut left = report.line().chunks(BYTES_PER_TICK);
        for tick in 0..REPEAT_TICKS {
            next_period().await;
            board::feed_watchdog();
            board::link_write(left.next().unwrap_or_default()); // an empty write keeps bytes moving
            let half_period = if findings.passed() { 500 } else { 100 };
            board::led(tick / half_period % 2 == 0);
        }
    }
}

/// Measures the stages and runs the script.
async fn test(this: ThisBoard, memory: &'static mut Memory, findings: &mut Findings) -> Result<(), &'static str> {
    findings.ticks = TICKS;
    stages::time(in_flash(), memory, &mut findings.stages);
    let haptic = start(this).ok_or("no controller")?;
    let mut slot = open(memory).ok_or("the patch was refused")?;
    (findings.nodes, findings.checksum) = (slot.state().0, slot.identity().0);
    let mut forces = Fnv::default();
    for tick in 0..TICKS {
        let period = next_period().await;
        haptic.tick(&mut slot, script::sensed(tick, LEAD_TICKS), Command::HEARD, Some(period));
        forces.vector(haptic.seen().force_n.into());
        if (tick + 1).is_multiple_of(CHECK_TICKS) {
            let at = (tick / CHECK_TICKS) as usize;
            let check = Check { tick: tick + 1, state_hash: slot.state().1, force_hash: forces.finish() };
            if let Some(place) = findings.checks.get_mut(at) {
                *place = check;
            }
        }
    }
    findings.seen = *haptic.seen();
    findings.reached_force = haptic.seen().mode == Mode::Active;
    findings.stack_used_bytes = haptic.board.stack_used_bytes();
    Ok(())
}

/// Creates the haptic loop, armed as for a script.
#[inline(never)]
fn start(this: ThisBoard) -> Option<&'static mut HapticLoop<Motorless>> {
    let (settings, edge) = Profile::desktop().split();
    let controller = Controller::build(&settings, edge, Arming::ByItself).ok()?;
    Some(LOOP.init_with(|| HapticLoop::new(Motorless::new(this), controller)))
}

/// Opens the patch of the image.
#[inline(never)]
fn open(memory: &'static mut Memory) -> Option<PatchSlot<'static>> {
    let patch = Patch::open_within(&board::budget(), in_flash(), memory, None, &mut board::feed_watchdog);
    Some(PatchSlot(Some(patch.ok()?)))
}
