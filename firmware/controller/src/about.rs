//! Image and clock of a board.

/// Image and clock of a board, for hosts that search for one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct About {
    /// Board and version of the image, separated by a space, in ASCII; truncated after
    /// [`crate::link::message::NAME_BYTES`].
    pub name: &'static str,
    /// Day on which the image was built, counted from 1970-01-01; 0 if unknown.
    pub built_day: u16,
    /// Frequency of [`crate::board::Board::clock_counts`] [Hz].
    pub clock_hz: u32,
    /// Checksum of the image's sources and features; 0 if unknown.
    pub image: u32,
}
