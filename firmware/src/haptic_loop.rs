//! The 1 kHz task: encoder counts in, one tick of the tissue core, converter codes out.

use core::sync::atomic::{AtomicU32, Ordering};

use embassy_sync::{blocking_mutex::raw::CriticalSectionRawMutex, signal::Signal};
use palpate::Fnv;
use palpate_firmware::{deadline::Deadline, force_out, patch::Patch, probe_in};

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

/// Renders the patch.
///
/// * **Trigger**: the hardware tick timer, every millisecond.
/// * **Deadline**: the force is on the converters before the next period begins.
/// * **Overrun**: decided here, not in a supervisor below, which a tick that never ends in time would starve. A late force is still
///   written, being fresher than the one on the converters; the periods it ran over are skipped, so the next tick starts on an edge.
///   [`palpate_firmware::deadline::LATE_IN_A_ROW`] of them in a row release the force for good and the core no longer runs.
/// * **Dead loop**: a tick that never ends holds the last force, until the watchdog releases it.
/// * **Faults**: any fault of the core gives zero force for that tick.
///
/// Nothing is logged from here: a log call blocks on its link.
#[embassy_executor::task]
pub async fn run(mut patch: Patch, run_ticks: Option<u32>) {
    let mut deadline = Deadline::new();
    let mut seen = telemetry::Snapshot::default();
    let mut forces = Fnv::default();
    while run_ticks != Some(seen.ticks) {
        let period = PERIOD.wait().await;
        board::feed_watchdog();
        let started = board::clock_counts();

        let mut output = None;
        if !deadline.released() {
            let pose = probe_in::pose(probe_in::scripted(seen.ticks));
            output = Some(patch.tick(pose));
            let late = PERIODS_BEGUN.load(Ordering::Relaxed).wrapping_sub(period);
            deadline.close(late);
            if late > 0 {
                PERIOD.reset();
            }
        }
        let force_n = match output {
            Some(output) if output.fault.is_none() && !deadline.released() => output.force_n.into(),
            _ => {
                seen.faults += 1;
                [0.0; 3]
            }
        };
        board::write_dac(force_out::codes(force_n));

        let spent = board::clock_counts().wrapping_sub(started);
        seen.longest_tick_counts = seen.longest_tick_counts.max(spent);
        forces.vector(force_n.into());
        seen.ticks = seen.ticks.wrapping_add(1);
        seen.overruns = deadline.overruns();
        seen.force_n = force_n;
        if seen.ticks.is_multiple_of(SNAPSHOT_TICKS) {
            telemetry::publish(seen);
        }
    }
    board::outputs_to_zero();
    telemetry::finish(telemetry::Result { last: seen, state_hash: patch.state_hash(), force_hash: forces.finish() });
    loop {
        PERIOD.wait().await;
        board::feed_watchdog();
    }
}
