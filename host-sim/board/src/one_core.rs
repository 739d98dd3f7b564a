//! Keeps emulator and host on one core. They take turns, so neither then waits for another core to
//! wake up, which would take as long as a tick of a small patch.

/// Keeps this thread and the programs that it starts on their present core, until this value is
/// dropped.
#[derive(Debug)]
pub struct OneCore {
    #[cfg(target_os = "linux")]
    before: Option<rustix::thread::CpuSet>,
}

impl OneCore {
    /// Keeps this thread on its core from now on; does nothing on a system without this function.
    #[must_use]
    pub fn stay() -> Self {
        #[cfg(target_os = "linux")]
        {
            let before = rustix::thread::sched_getaffinity(None).ok();
            let mut here = rustix::thread::CpuSet::new();
            here.set(rustix::thread::sched_getcpu());
            // a run that cannot choose its core is only slower
            let stays = before.filter(|_| rustix::thread::sched_setaffinity(None, &here).is_ok());
            Self { before: stays }
        }
        #[cfg(not(target_os = "linux"))]
        Self {}
    }
}

#[cfg(target_os = "linux")]
impl Drop for OneCore {
    fn drop(&mut self) {
        if let Some(before) = &self.before {
            let _ = rustix::thread::sched_setaffinity(None, before);
        }
    }
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::OneCore;

    #[test]
    fn the_cores_of_before_come_back() {
        let cores = || rustix::thread::sched_getaffinity(None).unwrap();
        let before = cores();
        let staying = OneCore::stay();
        assert_eq!(cores().count(), 1);
        drop(staying);
        assert_eq!(cores(), before);
    }
}
