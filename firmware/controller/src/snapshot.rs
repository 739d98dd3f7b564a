//! Counters of the haptic loop, for reports.

use palpate::Fault;
use palpate::haptic::mode::Mode;

/// Counters and state of the haptic loop after a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Snapshot {
    /// Ticks since the start.
    pub ticks: u32,
    /// Ticks that ended after their period.
    pub overruns: u32,
    /// Periods without a tick, because a late tick was still running.
    pub missed_periods: u32,
    /// Ticks that ended in the mode `Fault`.
    pub faults: u32,
    /// Longest tick so far, in counts of the board's clock.
    pub longest_tick_counts: u32,
    /// Shortest and longest delay from an edge of the tick timer to its tick so far, in counts of
    /// the board's clock; `None` in lock-step and before the first tick.
    pub starts: Option<[u32; 2]>,
    /// State of the haptic loop after the last tick.
    pub mode: Mode,
    /// Fault that is latched, in mode `Fault`.
    pub fault: Option<Fault>,
    /// Force on the hand in the last tick [N], device frame.
    pub force_n: [f32; 3],
}

impl Snapshot {
    /// State before the first tick.
    pub const START: Self = Self {
        ticks: 0,
        overruns: 0,
        missed_periods: 0,
        faults: 0,
        longest_tick_counts: 0,
        starts: None,
        mode: Mode::Boot,
        fault: None,
        force_n: [0.0; 3],
    };
}
