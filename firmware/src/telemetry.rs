//! Reports of a run, from a task of lower priority than the haptic loop.

use embassy_sync::{blocking_mutex::raw::CriticalSectionRawMutex, signal::Signal};

use palpate_controller::snapshot::Snapshot;
use palpate_controller::words;

use crate::board;

/// The outcome of a run of limited length.
#[derive(Clone, Copy)]
pub struct Result {
    /// Snapshot after the last tick.
    pub last: Snapshot,
    /// Hash of the state after the last tick.
    pub state_hash: u64,
    /// Hash of the forces of all ticks.
    pub force_hash: u64,
    /// Number of periods that the tick timer began.
    pub periods: u32,
}

#[derive(Clone, Copy)]
enum Message {
    Running(Snapshot),
    Finished(Result),
}

// only the newest message is kept: a slow reader must not delay the loop or fill a queue
static NEWEST: Signal<CriticalSectionRawMutex, Message> = Signal::new();

/// Hands a snapshot to the reporting task; never blocks.
pub fn publish(snapshot: Snapshot) {
    NEWEST.signal(Message::Running(snapshot));
}

/// Hands over the outcome; the reporting task prints it and ends the run.
pub fn finish(result: Result) {
    NEWEST.signal(Message::Finished(result));
}

/// Prints snapshots and the outcome. The outcome is printed twice, as a defmt frame and as plain
/// text, so that no log decoder can hide it.
#[embassy_executor::task]
pub async fn report() {
    loop {
        let newest = NEWEST.wait().await;
        match newest {
            Message::Running(snapshot) => running(&snapshot),
            Message::Finished(result) => finished(&result),
        }
    }
}

fn running(seen: &Snapshot) {
    let [x, y, z] = seen.force_n;
    defmt::info!(
        "ticks={=u32} mode={=str} fault={=str} force_n=[{=f32} {=f32} {=f32}] longest_tick_ns={=u32} overruns={=u32} faults={=u32} stack={=usize}",
        seen.ticks,
        words::mode(seen.mode),
        words::fault(seen.fault),
        x,
        y,
        z,
        board::counts_to_ns(seen.longest_tick_counts),
        seen.overruns,
        seen.faults,
        board::stack_used_bytes()
    );
}

fn finished(Result { last, state_hash, force_hash, periods }: &Result) {
    running(last);
    let Snapshot { ticks, overruns, faults, .. } = *last;
    defmt::info!(
        "state_hash={=u64:016x} force_hash={=u64:016x} ticks={=u32} overruns={=u32} faults={=u32}",
        *state_hash,
        *force_hash,
        ticks,
        overruns,
        faults
    );
    board::print(format_args!("longest_tick_ns={}", board::counts_to_ns(last.longest_tick_counts)));
    let [earliest, latest] = last.starts.unwrap_or_default().map(board::counts_to_ns);
    board::print(format_args!("earliest_start_ns={earliest} latest_start_ns={latest}"));
    board::print(format_args!("periods={periods} missed_periods={}", last.missed_periods));
    board::print(format_args!("stack_used={} stack_bytes={}", board::stack_used_bytes(), board::STACK_BYTES));
    let [mode, fault] = [words::mode(last.mode), words::fault(last.fault)].map(board::Plain);
    board::print(format_args!("mode={mode} fault={fault}"));
    board::print(format_args!(
        "state_hash={state_hash:016x} force_hash={force_hash:016x} ticks={ticks} overruns={overruns} faults={faults}"
    ));
    board::exit(faults == 0);
}
