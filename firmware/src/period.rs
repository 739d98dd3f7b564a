//! Periods of the tick timer, from its interrupt to the haptic loop.

use core::sync::atomic::{AtomicU32, Ordering};

use embassy_sync::{blocking_mutex::raw::CriticalSectionRawMutex, signal::Signal};

static PERIODS_BEGUN: AtomicU32 = AtomicU32::new(0);
static PERIOD: Signal<CriticalSectionRawMutex, u32> = Signal::new();

/// Begins a new period; called from the tick timer's interrupt, at a higher priority than the
/// loop's, so that a tick that is still running is detected as late.
pub fn on_period() {
    let period = periods_begun().wrapping_add(1);
    PERIODS_BEGUN.store(period, Ordering::Relaxed); // only this interrupt writes it
    PERIOD.signal(period);
}

/// Number of periods that have begun; it wraps.
pub fn periods_begun() -> u32 {
    PERIODS_BEGUN.load(Ordering::Relaxed)
}

/// Waits for the next period of the tick timer and returns its number.
pub async fn next_period() -> u32 {
    PERIOD.wait().await
}

/// Discards a period that has begun but has not been waited for.
pub fn drop_period() {
    PERIOD.reset();
}
