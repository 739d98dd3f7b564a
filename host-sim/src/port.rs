//! The host of a board on a serial port: it exchanges the frames of [`palpate_controller::link`]
//! over the system's port.
//!
//! ```text
//! command/board ─ session ─ line ─ serial port
//! ```
//!
//! One thread reads and sends the keep-alive messages that keep a force on: if it hangs, the host
//! is silent, and the board ends the force. Another thread writes files, since a disk may stall.

pub mod device_file;
pub mod line;
pub mod self_test;
pub mod session;

pub use line::Line;
pub use session::Session;

use palpate_controller::link::Refusal;

/// Why a request to a board on a port failed.
#[derive(Debug, thiserror::Error)]
pub enum PortError {
    /// The system has no port of this name.
    #[error("{0}: there is no such port: `palpate board list` names the boards that answer; is the cable in?")]
    Missing(String),
    /// Another program has the port open.
    #[error(
        "{0}: another program has this port open: end it with Ctrl-C, or kill it, and any force that it holds ends with it; then try again"
    )]
    InUse(String),
    /// The system does not allow opening the port.
    #[error("{0}: this user may not open the port: on Linux join the group that owns it (often dialout) and log in again")]
    Denied(String),
    /// The name is that of a file, or of a device of another kind.
    #[error("{port}: this is no serial port that can be used ({cause}): `palpate board list` names the boards that answer")]
    Unusable {
        /// Name of the port.
        port: String,
        /// Message of the operating system.
        cause: String,
    },
    /// The port stays silent.
    #[error(
        "{0}: nothing is heard, and every board of ours speaks: is it powered, flashed with an image of palpate, and is this its port?"
    )]
    Mute(String),
    /// Bytes arrived that are not frames of this protocol.
    #[error(
        "{port}: {bytes} bytes came and no frame of ours among them: this is another device, or an image of another version; flash one of this palpate's, or choose another port"
    )]
    Foreign {
        /// Name of the port.
        port: String,
        /// Number of bytes that arrived.
        bytes: usize,
    },
    /// Frames arrived, but no answer.
    #[error(
        "{0}: a board of ours speaks but does not answer: its image is older than this palpate, or the line to it is cut; flash it anew, check the wiring"
    )]
    Deaf(String),
    /// The port disappeared, or the board fell silent.
    #[error("{port}: {what} {after}")]
    Lost {
        /// Name of the port.
        port: String,
        /// Reason why the connection ended.
        what: &'static str,
        /// The force that acted, and how it ends.
        after: String,
    },
    /// The board refused.
    #[error("{port}: the board refuses: {refusal}")]
    Refused {
        /// Name of the port.
        port: String,
        /// The board's reason.
        refusal: Refusal,
    },
    /// A request was not carried out in time.
    #[error("{port}: {what}")]
    Undone {
        /// Name of the port.
        port: String,
        /// The request that was not carried out, and how to fix it.
        what: String,
    },
}
