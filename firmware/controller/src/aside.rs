//! A profile that is set aside until the board has restarted, in memory that a reset does not
//! clear.
//!
//! Erasing flash takes longer than the watchdog's time. The board therefore sets a new profile
//! aside, restarts, and stores it before the watchdog runs and anything can be armed.

use crate::config::{self, Profile, SLOT_BYTES};

/// Memory for one profile, with any content after power-on.
#[repr(C)]
pub struct Aside([u8; SLOT_BYTES]);

impl Aside {
    /// Nothing is set aside.
    pub const EMPTY: Self = Self([0; SLOT_BYTES]);

    /// Sets a profile aside. Returns false if it does not fit.
    pub fn keep(&mut self, profile: &Profile) -> bool {
        config::format(&mut self.0, profile, 0).is_some()
    }

    /// Takes the profile that was set aside. It is gone then, so that a crash in storing it does
    /// not repeat at every start.
    pub fn take(&mut self) -> Option<Profile> {
        let profile = config::parse(&self.0).map(|kept| kept.0);
        *self = Self::EMPTY;
        profile
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_profile_is_taken_once_and_nothing_else_is() {
        let mut aside = Aside([0xA5; SLOT_BYTES]);
        assert_eq!(aside.take(), None, "after power-on");
        let mut bad = Profile::desktop();
        bad.max_force_n = 1e3;
        for (profile, taken) in [(Profile::desktop(), Some(Profile::desktop())), (bad, None)] {
            assert!(aside.keep(&profile));
            assert_eq!((aside.take(), aside.take()), (taken, None));
        }
        for byte in 0..60 {
            assert!(aside.keep(&Profile::desktop()));
            aside.0[byte] ^= 1;
            assert_eq!(aside.take(), None, "{byte}");
        }
    }
}
