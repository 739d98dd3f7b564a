//! The 1 kHz task: a reading in, one haptic cycle over the tissue core, converter codes out.

use core::sync::atomic::{AtomicU32, Ordering};

use embassy_sync::{blocking_mutex::raw::CriticalSectionRawMutex, signal::Signal};
use palpate::haptic::cycle::Command;
use palpate::haptic::deadline::Deadline;
use palpate::haptic::device::Sensed;
use palpate::haptic::mode::Mode;
use palpate::{Fault, Fnv};
use palpate_firmware::controller::Controller;
use palpate_firmware::force_out::{self, Outputs};
use palpate_firmware::link::Record;
use palpate_firmware::patch::Tissue;
use palpate_firmware::script::{self, Script};

#[cfg(feature = "planted-crash")]
use crate::plant::{self, Place};
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
    #[cfg(feature = "planted-crash")]
    plant::pass(Place::Timer);
}

/// Waits for the next period of the tick timer; its number.
pub async fn next_period() -> u32 {
    PERIOD.wait().await
}

/// The controller with its deadline and what it has seen.
pub struct HapticLoop {
    pub controller: Controller,
    deadline: Deadline,
    /// Periods that the last tick ran over, for the cycle to bear or to refuse.
    late_ticks: u16,
    /// The period of the last tick.
    period: u32,
    found: Option<Fault>,
    seen: telemetry::Snapshot,
    forces: Fnv,
}

impl HapticLoop {
    /// Before its first tick.
    pub fn new(controller: Controller) -> Self {
        Self {
            controller,
            deadline: Deadline::default(),
            late_ticks: 0,
            period: 0,
            found: None,
            seen: telemetry::Snapshot::START,
            forces: Fnv::default(),
        }
    }

    /// One tick.
    ///
    /// * **Trigger**: the hardware tick timer, every millisecond; `period` is the one that began. In lock-step the host's pose, and no period.
    /// * **Deadline**: the force is on the converters before the next period begins.
    /// * **Overrun**: decided here, not in a supervisor below, which a tick that never ends in time would starve. A late force is still
    ///   written, being fresher than the one on the converters; the periods it ran over are skipped, so the next tick starts on an edge.
    ///   After one the next tick gives half of the force at most; two in a row, or five in a thousand ([`palpate::haptic::deadline`]), turn
    ///   the outputs off at once and are the next tick's fault.
    /// * **Check**: a force beyond the limits, in a mode without one, or not what is on the pins: outputs off at once, fault in the next tick, and the
    ///   watchdog is not fed by this one.
    /// * **Dead loop**: a tick that never ends holds the last force until the watchdog, fed by completed and checked ticks alone, turns it off.
    /// * **Faults**: no force in the same tick, latched until the host clears it.
    ///
    /// Nothing is logged from here: a log call blocks on its link.
    pub fn tick(&mut self, tissue: &mut Tissue<'_>, sensed: Sensed, command: Command, period: Option<u32>) -> Record {
        let (missed, waited) = self.begin(period);
        let started = board::clock_counts();
        #[cfg(feature = "planted-crash")]
        plant::pass(Place::Tick);
        let supply = board::supply_low().then_some(Fault::SupplyLow);
        let own = self.found.take();
        let found = board::emergency_stop().or(own).or(supply).or(command.found);
        let operator_absent = board::operator_absent().unwrap_or(command.operator_absent);
        let command = Command { found, late_ticks: self.late_ticks.max(missed), operator_absent, ..command };
        let told = self.controller.step(tissue, sensed, command, board::healthy());
        let mut outputs = force_out::outputs(self.controller.drive());
        board::write_outputs(outputs);
        #[cfg(feature = "planted-crash")]
        plant::pass(Place::Written);
        let late = period.map_or(0, |period| PERIODS_BEGUN.load(Ordering::Relaxed).wrapping_sub(period));
        self.late_ticks = u16::try_from(late).unwrap_or(u16::MAX);
        if self.deadline.judge(self.late_ticks).is_err() {
            board::outputs_off();
            outputs = Outputs::OFF;
            self.found = Some(Fault::DeadlineMissed);
        }
        if late > 0 {
            PERIOD.reset();
        }
        if self.controller.sound(&told) && board::outputs() == outputs {
            board::feed_watchdog();
        } else {
            board::outputs_off();
            outputs = Outputs::OFF;
            self.found = Some(Fault::SelfTestFailed);
        }
        let spent = board::clock_counts().wrapping_sub(started);

        board::count_millisecond();
        let seen = &mut self.seen;
        seen.longest_tick_counts = seen.longest_tick_counts.max(spent);
        seen.ticks = seen.ticks.wrapping_add(1);
        seen.overruns = seen.overruns.saturating_add(u32::from(late > 0));
        seen.missed_periods = seen.missed_periods.saturating_add(missed.into());
        if let Some(waited) = waited {
            seen.starts = seen.starts.map_or(Some([waited; 2]), |[least, most]| Some([least.min(waited), most.max(waited)]));
        }
        seen.faults += u32::from(told.mode == Mode::Fault);
        (seen.mode, seen.fault, seen.force_n) = (told.mode, told.fault, told.applied_n.into());
        self.forces.vector(told.applied_n);
        Record::new(&told, outputs, spent)
    }

    /// Periods that went by since the last tick's, and how long ago this one began. By the numbers of both: a period that begins while a late
    /// tick ends is seen here at the latest.
    fn begin(&mut self, period: Option<u32>) -> (u16, Option<u32>) {
        let Some(period) = period else { return (0, None) };
        let missed = period.wrapping_sub(self.period).saturating_sub(1);
        self.period = period;
        (u16::try_from(missed).unwrap_or(u16::MAX), Some(board::since_period_counts()))
    }
}

/// Renders the patch to a scripted hand, a tick a period, then reports.
#[embassy_executor::task]
pub async fn run_script(mut haptic: HapticLoop, mut tissue: Tissue<'static>, script: Script) {
    while haptic.seen.ticks < script.ticks {
        let period = PERIOD.wait().await;
        haptic.tick(&mut tissue, script::sensed(haptic.seen.ticks, script.lead_ticks), Command::HEARD, Some(period));
        if haptic.seen.ticks.is_multiple_of(SNAPSHOT_TICKS) {
            telemetry::publish(haptic.seen);
        }
    }
    board::outputs_off();
    let (last, state_hash, force_hash) = (haptic.seen, tissue.state().1, haptic.forces.finish());
    let periods = PERIODS_BEGUN.load(Ordering::Relaxed);
    telemetry::finish(telemetry::Result { last, state_hash, force_hash, periods });
    loop {
        PERIOD.wait().await;
        board::feed_watchdog();
    }
}
