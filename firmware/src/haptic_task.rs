//! The task of the haptic loop, which preempts everything but the tick timer's interrupt.

use palpate::haptic::cycle::Command;
use palpate_controller::board::Board;
use palpate_controller::haptic_loop::HapticLoop;
use palpate_controller::link::Upload;
use palpate_controller::patch::{Memory, PatchSlot};
use palpate_controller::script::{self, Script};
use palpate_controller::serve::{self, Pace};

use crate::board::{self, ThisBoard};
use crate::flash_patch::in_flash;
use crate::period::{next_period, periods_begun};
use crate::telemetry;

/// Ticks between two snapshots. One per second is slow enough for any debug channel.
const SNAPSHOT_TICKS: u32 = 1_000;

/// Renders the patch to a scripted hand, one tick per period, then reports.
#[embassy_executor::task]
pub async fn run_script(haptic: &'static mut HapticLoop<ThisBoard>, mut slot: PatchSlot<'static>, script: Script) {
    while haptic.seen().ticks < script.ticks {
        let (period, tick) = (next_period().await, haptic.seen().ticks);
        haptic.tick(&mut slot, script::sensed(tick, script.lead_ticks), Command::HEARD, Some(period));
        if haptic.seen().ticks.is_multiple_of(SNAPSHOT_TICKS) {
            telemetry::publish(*haptic.seen());
        }
    }
    haptic.board.outputs_off();
    let (last, state_hash, force_hash) = (*haptic.seen(), slot.state().1, haptic.force_hash());
    telemetry::finish(telemetry::Result { last, state_hash, force_hash, periods: periods_begun() });
    loop {
        next_period().await;
        haptic.board.feed_watchdog();
    }
}

/// Serves a host until it disconnects.
#[embassy_executor::task]
pub async fn serve_host(
    haptic: &'static mut HapticLoop<ThisBoard>,
    memory: &'static mut Memory,
    upload: &'static mut Upload,
    pace: Pace,
) {
    serve::run(haptic, in_flash(), memory, upload, pace).await;
    board::exit(true)
}
