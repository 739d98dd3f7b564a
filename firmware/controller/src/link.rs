//! The link between the controller and a host. Both sides use the types and functions of this
//! module, which needs no allocator.
//!
//! A frame is `COBS(sequence, message as postcard, CRC-32) 0`. A frame that is damaged, too long,
//! not understood or not newer than the last one is counted and dropped as a whole; its closing
//! zero byte ends it in any case.
//!
//! ```text
//! host -> board   pose (ends a lock-step tick), heartbeat, ask, lower limits, modulus,
//!                 patch begin / part / end, supply low, report, identify,
//!                 joints (as pose), store a profile, home, listen to the log
//! board -> host   record of a tick, refusal, patch taken, profile stored, state, identity, homed,
//!                 log, modulus taken, crash
//! ```

/// Speed of every board's link [baud]; a port that exists only over USB ignores it.
pub const BAUD: u32 = 921_600;

pub mod frame;
pub mod inbox;
pub mod log;
pub mod message;
pub mod queue;
pub mod receiver;
pub mod record;
mod stuffing;
pub mod upload;

pub use crate::refusal::Refusal;
pub use frame::{FRAME_BYTES, FrameError, encode};
pub use inbox::{Change, Inbox};
pub use log::Log;
pub use message::{FromBoard, Identity, ToBoard};
pub use queue::ByteQueue;
pub use receiver::Receiver;
pub use record::Record;
pub use upload::Upload;
