//! Result codes of the calls, and the failures behind them.

use palpate::haptic::commission::Trouble;
use palpate::{BuildError, Fault};
use palpate_loop::haptic_session::OutOfOrder;
use palpate_tissue::error::Error;

/// Result of a call. For every code but `PALPATE_CODE_OK`, `palpate_error_text` describes the code,
/// and `palpate_last_message` says what was wrong with this particular call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub enum PalpateCode {
    /// The call succeeded.
    Ok = 0,
    /// A fault is latched and the force is zero; `palpate_read_report` gives the fault's number.
    Fault = 1,
    /// A pointer that must not be NULL is NULL.
    Null = 2,
    /// A text is not UTF-8.
    NotText = 3,
    /// The size of a struct is not that of this library, or an array is too small.
    WrongSize = 4,
    /// A number is outside its range.
    OutOfRange = 5,
    /// The handle belongs to no open session.
    NoSession = 6,
    /// Another thread is in a call with this session.
    Busy = 7,
    /// The session's state does not allow this call.
    WrongOrder = 8,
    /// The largest possible number of sessions is open.
    TooMany = 9,
    /// A file cannot be read or written.
    CannotRead = 10,
    /// A scene, mesh or device profile cannot be used.
    BadScene = 11,
    /// A patch file cannot be used.
    BadPatch = 12,
    /// The tissue cannot be computed at 1 kHz as the scene requires.
    TooSlow = 13,
    /// A defect of the library; the session was closed.
    Internal = 14,
    /// The commissioning ended without a result; the profile stays as it was.
    NotCommissioned = 15,
}

impl PalpateCode {
    /// Every code, in the order of the numbers.
    pub const ALL: [Self; 16] = [
        Self::Ok,
        Self::Fault,
        Self::Null,
        Self::NotText,
        Self::WrongSize,
        Self::OutOfRange,
        Self::NoSession,
        Self::Busy,
        Self::WrongOrder,
        Self::TooMany,
        Self::CannotRead,
        Self::BadScene,
        Self::BadPatch,
        Self::TooSlow,
        Self::Internal,
        Self::NotCommissioned,
    ];

    /// Description of the code in one line.
    #[must_use]
    pub fn text(self) -> &'static std::ffi::CStr {
        match self {
            Self::Ok => c"done",
            Self::Fault => c"a fault is latched, the force is zero: read it with palpate_read_report, then palpate_clear",
            Self::Null => c"a pointer is NULL: pass one to memory of yours",
            Self::NotText => c"a text is not UTF-8: pass a path or name in UTF-8, ended by a zero",
            Self::WrongSize => c"a size does not fit: pass sizeof of the struct, from the header of this library",
            Self::OutOfRange => c"a number is outside its range: palpate_last_message names the range",
            Self::NoSession => c"no open session has this handle: open one, and do not use it after palpate_close",
            Self::Busy => c"another thread is in a call with this session: call it from one thread at a time",
            Self::WrongOrder => c"the session's state does not allow this call: palpate_last_message says why",
            Self::TooMany => c"too many sessions are open: close one first",
            Self::CannotRead => c"a file cannot be read or written: check the path",
            Self::BadScene => c"a scene, mesh or device cannot be used: palpate_last_message says where and why",
            Self::BadPatch => c"a patch file cannot be used: pack it again",
            Self::TooSlow => c"the tissue cannot keep 1 kHz: take fewer nodes or press less deep",
            Self::NotCommissioned => c"the commissioning ended early: palpate_last_message says why; the next call begins anew",
            Self::Internal => c"a defect of the library, the session was closed: please report it",
        }
    }
}

/// Why a call failed.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    #[error("fault {}: {}; clear it with palpate_clear, then palpate_arm", *.0 as u8, .0.text())]
    Fault(Fault),
    #[error("{0} is NULL: pass a pointer to memory of yours")]
    Null(&'static str),
    #[error("{0} is not UTF-8: pass a path or name in UTF-8, ended by a zero")]
    NotText(&'static str),
    #[error("{item} = {have}, but this library has {need}: pass sizeof, from the header of this library")]
    WrongSize { item: &'static str, need: usize, have: usize },
    #[error("{item} holds {have}, but {need} are needed: pass a larger array")]
    TooSmall { item: &'static str, need: usize, have: usize },
    #[error("{0}")]
    Number(BuildError),
    #[error("no open session has the handle {0:#x}: open one, and do not use it after palpate_close")]
    NoSession(u64),
    #[error("another thread is in a call with this session: call it from one thread at a time")]
    Busy,
    #[error("{0}")]
    OutOfOrder(#[from] OutOfOrder),
    #[error("no tick has run yet: call palpate_tick first")]
    NoTick,
    #[error("{0} sessions are open: close one first")]
    TooMany(usize),
    #[error("{0}")]
    Open(#[from] Error),
    #[error("not commissioned, the profile stays as it was: {0}")]
    NotCommissioned(Trouble),
    #[error("a defect of the library, the session was closed: please report it")]
    Internal,
}

impl Failure {
    pub fn code(&self) -> PalpateCode {
        match self {
            Self::Fault(_) => PalpateCode::Fault,
            Self::Null(_) => PalpateCode::Null,
            Self::NotText(_) => PalpateCode::NotText,
            Self::WrongSize { .. } | Self::TooSmall { .. } => PalpateCode::WrongSize,
            Self::Number(_) => PalpateCode::OutOfRange,
            Self::NoSession(_) => PalpateCode::NoSession,
            Self::Busy => PalpateCode::Busy,
            Self::OutOfOrder(_) | Self::NoTick => PalpateCode::WrongOrder,
            Self::TooMany(_) => PalpateCode::TooMany,
            Self::Open(Error::Read { .. } | Error::Write { .. }) => PalpateCode::CannotRead,
            Self::Open(Error::Scene(palpate_tissue::scene::SceneError::Read { .. })) => PalpateCode::CannotRead,
            Self::Open(Error::Patch { .. } | Error::Build(_)) => PalpateCode::BadPatch,
            Self::Open(Error::TooSlow(_)) => PalpateCode::TooSlow,
            Self::Open(_) => PalpateCode::BadScene,
            Self::NotCommissioned(_) => PalpateCode::NotCommissioned,
            Self::Internal => PalpateCode::Internal,
        }
    }
}
