//! Follows a board: the window shows the file that `palpate board` is writing.
//!
//! ```text
//! palpate board ─ growing CSV ─ tail ─ following ─┬─ screen: tip, mode, fault, force of the board
//!                                                 └─ twin: this machine's patch at the same tips
//! ```
//!
//! Nothing is sent to the board, and no value shown as the board's is computed here. The shape of
//! the tissue and a second force are computed by the [`twin`] and labelled accordingly. A thread
//! ([`feed`]) reads and computes; the [`screen`] draws. This needs a desktop, since a page has no
//! file to follow.

mod feed;
mod following;
mod panel;
mod patches;
mod screen;
mod strips;
mod tail;
mod twin;
mod words;

pub use feed::Feed;
pub use patches::Given;
pub use screen::Follow;
