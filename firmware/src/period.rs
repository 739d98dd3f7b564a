//! Periods of the tick timer, from its interrupt to the haptic loop.

use core::sync::atomic::{AtomicU32, Ordering};

use embassy_sync::{blocking_mutex::raw::CriticalSectionRawMutex, signal::Signal};

static PERIODS_BEGUN: AtomicU32 = AtomicU32::new(0);
static PERIOD: Signal<CriticalSectionRawMutex, u32> = Signal::new();

/// The tick timer's interrupt: a new period begins. Runs above the loop, so a tick that is still
/// busy is seen as late.
pub fn on_period() {
    let period = periods_begun().wrapping_add(1);
    PERIODS_BEGUN.store(period, Ordering::Relaxed); // only this interrupt writes it
    PERIOD.signal(period);
}

/// Periods that have begun, wrapping.
pub fn periods_begun() -> u32 {
    PERIODS_BEGUN.load(Ordering::Relaxed)
}

/// Waits for the next period of the tick timer and returns its number.
pub async fn next_period() -> u32 {
    PERIOD.wait().await
}

/// Discards a period that has begun and was not waited for.
pub fn drop_period() {
    PERIOD.reset();
}
