//! One tick of a board: it takes a reading, runs one haptic cycle over the tissue core, writes
//! converter codes and feeds the watchdog.
//!
//! * in: a reading, the host's command, the number of the period that began
//! * out: levels on the output pins, a record for the host
//! * cost: that of [`crate::controller`], plus access to the board's pins and clock
//! * failures: every [`palpate::Fault`]; the actuators are off then

use palpate::haptic::commission::Trouble;
use palpate::haptic::cycle::{Ask, Command, Renderer};
use palpate::haptic::deadline::Deadline;
use palpate::haptic::mode::Mode;
use palpate::{Fault, Fnv};

use crate::board::Board;
use crate::commission::{Bench, Setup};
use crate::controller::Controller;
use crate::force_out::Outputs;
use crate::link::Record;
use crate::probe_in::Reading;
use crate::snapshot::Snapshot;

/// The controller with its deadline and counters.
pub struct HapticLoop<B> {
    /// The board that the loop runs on.
    pub board: B,
    /// The controller that computes the forces.
    pub controller: Controller,
    /// Commissioning in progress, or the last one.
    commissioning: Option<Bench>,
    deadline: Deadline,
    /// Periods that the last tick overran, which the cycle tolerates or turns into a fault.
    late_ticks: u16,
    /// Number of the last tick's period.
    period: u32,
    found: Option<Fault>,
    /// Longest tick of the patch in the tap with which it was opened [counts].
    tap_counts: u32,
    /// Longest tick in `Idle`, which does not run the patch [counts].
    idle_counts: u32,
    /// Largest sum of both with which the board arms [counts].
    most_counts: u32,
    seen: Snapshot,
    forces: Fnv,
}

/// Largest share of a period that the longest measured tick may take [%].
pub const MOST_PERCENT: u32 = 85;

impl<B: Board> HapticLoop<B> {
    /// Creates the loop before its first tick.
    #[must_use]
    pub fn new(board: B, controller: Controller) -> Self {
        Self {
            board,
            controller,
            commissioning: None,
            deadline: Deadline::default(),
            late_ticks: 0,
            period: 0,
            found: None,
            tap_counts: 0,
            idle_counts: 0,
            most_counts: u32::MAX,
            seen: Snapshot::START,
            forces: Fnv::default(),
        }
    }

    /// Runs one tick.
    ///
    /// * **Trigger**: the hardware tick timer, every millisecond; `period` is the number of the
    ///   period that began. In lock-step the host's pose is the trigger, and `period` is `None`.
    /// * **Deadline**: the force is on the converters before the next period begins.
    ///   A patch whose longest measured tick takes more than 85 % of a period is not armed: the
    ///   request becomes the fault of late ticks.
    /// * **Overrun**: handled here, not by a supervisor of lower priority, which late ticks would
    ///   starve. A late force is still written, since it is newer than the one on the converters;
    ///   the periods that the tick overran are skipped, so the next tick starts on an edge of the
    ///   timer. After one overrun the next tick gives half of the force at most; two in a row, or
    ///   five in a thousand ([`palpate::haptic::deadline`]), turn the outputs off at once and
    ///   become a fault in the next tick.
    /// * **Check**: if a force is beyond the limits, occurs in a mode without force, or differs
    ///   from the pins, the outputs are switched off at once, the next tick reports a fault, and
    ///   this tick does not feed the watchdog.
    /// * **Dead loop**: if a tick never ends, the last force persists until the watchdog turns it
    ///   off. The watchdog is fed only by completed and checked ticks, and, with the outputs off,
    ///   while a patch is opened.
    /// * **Faults**: a fault removes the force in the same tick and stays latched until the host
    ///   clears it.
    ///
    /// Nothing is logged from here: a log line takes some thousand instructions with interrupts
    /// off, so lines are written after the tick.
    pub fn tick(
        &mut self,
        tissue: &mut impl Renderer,
        reading: impl Into<Reading>,
        command: Command,
        period: Option<u32>,
    ) -> Record {
        self.answer(tissue, reading.into(), command, period)
    }

    /// Body of [`Self::tick`], compiled once for all sources of readings.
    fn answer(&mut self, tissue: &mut impl Renderer, reading: Reading, command: Command, period: Option<u32>) -> Record {
        let (missed, waited) = self.begin(period);
        let started = self.board.clock_counts();
        let supply = self.board.supply_low().then_some(Fault::SupplyLow);
        let own = self.found.take().or(self.is_too_long(command.asked, period).then_some(Fault::DeadlineMissed));
        let found = self.board.emergency_stop().or(own).or(supply).or(command.found);
        let operator_absent = self.board.operator_absent().unwrap_or(command.operator_absent);
        let command = Command { found, late_ticks: self.late_ticks.max(missed), operator_absent, ..command };
        // no other mode uses it, and to read the pins back takes 2 us
        let healthy = self.controller.mode() == Mode::SelfTest && self.board.healthy();
        let benched = self.commissioning.as_mut().filter(|bench| !bench.ended());
        let (telemetry, mut outputs) = match benched {
            None => {
                let telemetry = self.controller.tick(tissue, reading, command, healthy);
                (telemetry, self.controller.outputs())
            }
            Some(bench) => {
                // arming has to wait, and is not remembered
                let asked = command.asked.filter(|asked| *asked != Ask::Arm);
                let shown = bench.shown(&reading);
                let telemetry = self.controller.tick(tissue, shown, Command { asked, ..command }, healthy);
                let absent = self.controller.operator_switch() && command.operator_absent;
                (telemetry, bench.tick(&reading, &Command { operator_absent: absent, ..command }, &telemetry))
            }
        };
        self.board.write_outputs(outputs);
        let late = period.map_or(0, |period| self.board.periods_begun().wrapping_sub(period));
        self.late_ticks = u16::try_from(late).unwrap_or(u16::MAX);
        if self.deadline.judge(self.late_ticks).is_err() {
            self.board.outputs_off();
            outputs = Outputs::OFF;
            self.found = Some(Fault::DeadlineMissed);
        }
        if late > 0 {
            self.board.drop_period();
        }
        if self.controller.sound(&telemetry) && self.board.outputs() == outputs {
            self.board.feed_watchdog();
        } else {
            self.board.outputs_off();
            outputs = Outputs::OFF;
            self.found = Some(Fault::SelfTestFailed);
        }
        let spent = self.board.clock_counts().wrapping_sub(started);

        self.board.count_millisecond();
        let seen = &mut self.seen;
        seen.longest_tick_counts = seen.longest_tick_counts.max(spent);
        seen.ticks = seen.ticks.wrapping_add(1);
        seen.overruns = seen.overruns.saturating_add(u32::from(late > 0));
        seen.missed_periods = seen.missed_periods.saturating_add(missed.into());
        if let Some(waited) = waited {
            seen.starts = seen.starts.map_or(Some([waited; 2]), |[least, most]| Some([least.min(waited), most.max(waited)]));
        }
        seen.faults += u32::from(telemetry.mode == Mode::Fault);
        if telemetry.mode == Mode::Idle {
            self.idle_counts = self.idle_counts.max(spent);
        }
        (seen.mode, seen.fault, seen.force_n) = (telemetry.mode, telemetry.fault, telemetry.applied_n.into());
        self.forces.vector(telemetry.applied_n);
        Record::new(&telemetry, outputs, spent)
    }

    /// Returns the number of periods missed since the last tick and the time since this period
    /// began [clock counts]. Missed periods follow from the numbers of the two periods, so that one
    /// that begins while a late tick ends is noticed here at the latest.
    fn begin(&mut self, period: Option<u32>) -> (u16, Option<u32>) {
        let Some(period) = period else { return (0, None) };
        let missed = period.wrapping_sub(self.period).saturating_sub(1);
        self.period = period;
        (u16::try_from(missed).unwrap_or(u16::MAX), Some(self.board.since_period_counts()))
    }

    /// Takes the longest tick of a patch that was opened, in `Idle`, and the duration of a period
    /// [counts].
    pub fn rehearsed(&mut self, tap_counts: u32, period_counts: u32) {
        self.tap_counts = tap_counts;
        self.most_counts = period_counts / 100 * MOST_PERCENT;
    }

    /// Longest tick to be expected under force [counts], by the board's own clock and memories:
    /// that of the patch in a tap, and that of the loop around it.
    #[must_use]
    pub fn longest_counts(&self) -> u32 {
        self.tap_counts.saturating_add(self.idle_counts)
    }

    /// Whether this is a request to arm that would lead to late ticks. In lock-step no tick is
    /// late.
    fn is_too_long(&self, asked: Option<Ask>, period: Option<u32>) -> bool {
        asked == Some(Ask::Arm) && period.is_some() && self.longest_counts() > self.most_counts
    }

    /// Begins a commissioning in `Idle`.
    pub fn commission(&mut self, setup: &Setup, newest: Reading) {
        self.commissioning = Some(Bench::new(setup, newest));
    }

    /// Commissioning in progress, or the last one.
    pub fn bench(&mut self) -> Option<&mut Bench> {
        self.commissioning.as_mut()
    }

    /// Ends a commissioning at once, because patch or profile change.
    pub fn end_commissioning(&mut self) {
        if let Some(bench) = self.commissioning.as_mut().filter(|bench| !bench.ended()) {
            bench.stop(Trouble::Interrupted);
            self.board.outputs_off();
        }
    }

    /// Counters since the start.
    #[must_use]
    pub fn seen(&self) -> &Snapshot {
        &self.seen
    }

    /// Hash of all forces applied since the start.
    #[must_use]
    pub fn force_hash(&self) -> u64 {
        self.forces.finish()
    }
}
