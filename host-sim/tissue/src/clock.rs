//! Clock for the cost of a tick: CPU time of this thread if the system provides it, so that a tick
//! does not look slow because the machine is busy with other work.

use std::time::Duration;

/// CPU time that this thread has used so far.
#[cfg(unix)]
#[must_use]
pub fn thread_time() -> Duration {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    Duration::new(now.tv_sec.unsigned_abs(), now.tv_nsec as u32)
}

/// Wall-clock time since the first call, on systems without a CPU clock for threads.
#[cfg(not(unix))]
#[must_use]
pub fn thread_time() -> Duration {
    use std::sync::OnceLock;
    static START: OnceLock<std::time::Instant> = OnceLock::new();
    START.get_or_init(std::time::Instant::now).elapsed()
}
