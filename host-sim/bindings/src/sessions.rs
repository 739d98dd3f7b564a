//! Open sessions by handle. A handle is a number that is looked up, never dereferenced: a handle
//! that was closed, or that was never returned, causes an error and no other harm.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Mutex, MutexGuard, TryLockError};

use palpate_loop::haptic_session::HapticSession;

use crate::code::Failure;

/// Largest number of sessions that can be open at once.
pub const MOST_SESSIONS: usize = 64;

/// A place that holds one session at a time.
struct Place {
    /// Number of sessions that this place has held; it is the upper half of a handle.
    count: u32,
    session: Option<Box<HapticSession>>,
}

static PLACES: [Mutex<Place>; MOST_SESSIONS] = [const { Mutex::new(Place { count: 0, session: None }) }; MOST_SESSIONS];

/// Stores a session and returns its handle, which is never zero.
pub fn insert(session: HapticSession) -> Result<u64, Failure> {
    let session = Box::new(session);
    for (n, place) in (1_u64..).zip(&PLACES) {
        if let Ok(mut place) = enter(place)
            && place.session.is_none()
        {
            place.count = place.count.wrapping_add(1);
            place.session = Some(session);
            return Ok(u64::from(place.count) << 32 | n);
        }
    }
    Err(Failure::TooMany(MOST_SESSIONS))
}

/// Removes a session.
pub fn remove(handle: u64) -> Result<(), Failure> {
    find(handle)?.session = None;
    Ok(())
}

/// Calls `work` with a session. The call never blocks: if another thread uses the session, that is
/// an error. A panic closes the session.
pub fn with<T>(handle: u64, work: impl FnOnce(&mut HapticSession) -> Result<T, Failure>) -> Result<T, Failure> {
    let mut place = find(handle)?;
    let Some(session) = place.session.as_mut() else { return Err(Failure::NoSession(handle)) };
    match catch_unwind(AssertUnwindSafe(|| work(session))) {
        Ok(done) => done,
        Err(_) => {
            place.session = None;
            Err(Failure::Internal)
        }
    }
}

fn find(handle: u64) -> Result<MutexGuard<'static, Place>, Failure> {
    let unknown = || Failure::NoSession(handle);
    let index = usize::try_from(handle & u64::from(u32::MAX)).ok().and_then(|n| n.checked_sub(1)).ok_or_else(unknown)?;
    let place = enter(PLACES.get(index).ok_or_else(unknown)?)?;
    if place.session.is_some() && u64::from(place.count) == handle >> 32 { Ok(place) } else { Err(unknown()) }
}

fn enter(place: &'static Mutex<Place>) -> Result<MutexGuard<'static, Place>, Failure> {
    match place.try_lock() {
        Ok(place) => Ok(place),
        Err(TryLockError::WouldBlock) => Err(Failure::Busy),
        // no session is left here after a panic: `with` removes it
        Err(TryLockError::Poisoned(place)) => Ok(place.into_inner()),
    }
}

#[cfg(test)]
mod tests {
    use palpate_tissue::session::calibrated;

    use super::*;
    use crate::code::PalpateCode;

    fn code<T>(result: Result<T, Failure>) -> PalpateCode {
        result.map_or_else(|failure| failure.code(), |_| PalpateCode::Ok)
    }

    // a single test, since the places are shared by the whole process
    #[test]
    fn a_handle_is_good_until_it_is_closed_and_no_other_number_is_one() {
        let fresh = HapticSession::of_patch_bytes(calibrated::bytes(130).unwrap(), "touch").unwrap();
        let open = || insert(fresh.clone());
        let handle = open().unwrap();
        assert_eq!(code(with(handle, |_| Ok(()))), PalpateCode::Ok);
        for wrong in [0, 1, u64::MAX, handle + 1, handle + (1 << 32), handle ^ (1 << 31)] {
            assert_eq!(code(with(wrong, |_| Ok(()))), PalpateCode::NoSession, "{wrong:#x}");
            assert_eq!(code(remove(wrong)), PalpateCode::NoSession, "{wrong:#x}");
        }
        let elsewhere = || std::thread::spawn(move || [code(with(handle, |_| Ok(()))), code(remove(handle))]).join();
        let inner = with(handle, |_| Ok(elsewhere().unwrap()));
        assert_eq!(inner.unwrap(), [PalpateCode::Busy; 2], "in use");

        assert_eq!(code(remove(handle)), PalpateCode::Ok);
        assert_eq!(code(remove(handle)), PalpateCode::NoSession);
        let next = open().unwrap();
        assert_ne!(next, handle, "a place that is used again has another handle");
        assert_eq!(code(with(handle, |_| Ok(()))), PalpateCode::NoSession);

        let panicked: Result<(), Failure> = with(next, |_| panic!("planted"));
        assert_eq!(code(panicked), PalpateCode::Internal);
        assert_eq!(code(with(next, |_| Ok(()))), PalpateCode::NoSession, "a panic closes the session");

        let all: Vec<u64> = (0..MOST_SESSIONS).map(|_| open().unwrap()).collect();
        assert_eq!(code(open()), PalpateCode::TooMany);
        all.into_iter().for_each(|handle| remove(handle).unwrap());
        assert_eq!(code(open()), PalpateCode::Ok);
    }
}
