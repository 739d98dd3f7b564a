//! The 1 kHz task: a reading in, one haptic cycle over the tissue core, converter codes out.

use core::sync::atomic::{AtomicU32, Ordering};

use embassy_sync::{blocking_mutex::raw::CriticalSectionRawMutex, signal::Signal};
use palpate::haptic::cycle::Command;
use palpate::haptic::mode::Mode;
use palpate::{Fault, Fnv};
use palpate_firmware::controller::Controller;
use palpate_firmware::deadline::Deadline;
use palpate_firmware::force_out::{self, Outputs};
use palpate_firmware::patch::Patch;
use palpate_firmware::script;

use crate::{board, telemetry};

/// Ticks between two snapshots: one a second, slow enough for any log link.
const SNAPSHOT_TICKS: u32 = 1_000;

static PERIODS_BEGUN: AtomicU32 = AtomicU32::new(0);
static PERIOD: Signal<CriticalSectionRawMutex, u32> = Signal::new();

/// The tick timer's interrupt: a new period begins. Runs above the loop, so a tick that is still busy is seen as late.
pub fn on_period() {
    let period = PERIODS_BEGUN.load(Ordering::Relaxed).wrapping_add(1);
    PERIODS_BEGUN.store(period, Ordering::Relaxed); // only this interrupt writes it
    PERIOD.signal(period);
}

/// How long the scripted hand presses.
#[derive(Clone, Copy)]
pub struct Script {
    /// Ticks until the run ends.
    pub ticks: u32,
    /// Ticks outside the tissue before the first press.
    pub lead_ticks: u32,
}

/// Renders the patch to a scripted hand.
///
/// * **Trigger**: the hardware tick timer, every millisecond.
/// * **Deadline**: the force is on the converters before the next period begins.
/// * **Overrun**: decided here, not in a supervisor below, which a tick that never ends in time would starve. A late force is still
///   written, being fresher than the one on the converters; the periods it ran over are skipped, so the next tick starts on an edge.
///   Two in a row, or five in a thousand ([`palpate_firmware::deadline`]), turn the outputs off at once and are the next tick's fault.
/// * **Dead loop**: a tick that never ends holds the last force until the watchdog, fed by completed and checked ticks alone, turns it off.
/// * **Faults**: no force in the same tick, latched until the host clears it.
///
/// Nothing is logged from here: a log call blocks on its link.
#[embassy_executor::task]
pub async fn run(mut controller: Controller, mut patch: Patch<'static>, script: Script) {
    let mut deadline = Deadline::default();
    let mut found = None;
    let mut seen = telemetry::Snapshot::START;
    let mut forces = Fnv::default();
    while seen.ticks < script.ticks {
        let period = PERIOD.wait().await;
        let started = board::clock_counts();

        let sensed = script::sensed(seen.ticks, script.lead_ticks);
        let command = Command { found: found.take(), ..Command::HEARD };
        let record = controller.step(&mut patch, sensed, command, board::healthy());
        let mut outputs = force_out::outputs(controller.drive());
        board::write_outputs(outputs);
        let late = PERIODS_BEGUN.load(Ordering::Relaxed).wrapping_sub(period);
        if deadline.close(late) {
            board::outputs_off();
            outputs = Outputs::OFF;
            found = Some(Fault::DeadlineMissed);
        }
        if controller.sound(&record) && board::outputs() == outputs {
            board::feed_watchdog();
        }
        if late > 0 {
            PERIOD.reset();
        }

        let spent = board::clock_counts().wrapping_sub(started);
        seen.longest_tick_counts = seen.longest_tick_counts.max(spent);
        forces.vector(record.applied_n);
        seen.ticks = seen.ticks.wrapping_add(1);
        seen.overruns = deadline.overruns();
        seen.faults += u32::from(record.mode == Mode::Fault);
        (seen.mode, seen.fault, seen.force_n) = (record.mode, record.fault, record.applied_n.into());
        if seen.ticks.is_multiple_of(SNAPSHOT_TICKS) {
            telemetry::publish(seen);
        }
    }
    board::outputs_off();
    telemetry::finish(telemetry::Result { last: seen, state_hash: patch.state_hash(), force_hash: forces.finish() });
    loop {
        PERIOD.wait().await;
        board::feed_watchdog();
    }
}
