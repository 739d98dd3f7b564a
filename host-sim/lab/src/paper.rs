//! Reproduces the two papers that this project implements: every figure and table that does not
//! need their data, with a verdict on each claim.
//!
//! Paper 000 is *volume preserved mass-spring model* (a liver and a gallbladder, suspended), paper
//! 004 *local compression deformation of soft tissue* (an abdomen and a foot, pressed).

pub mod local_compression;
pub mod volume_preserved;

/// A progress display.
pub trait Progress: Sync {
    /// Shows the part of the run that begins, in a few words.
    fn say(&self, doing: String);

    /// Removes the display, because the run has finished and prints its findings.
    fn clear(&self);
}

/// Shows no progress.
impl Progress for () {
    fn say(&self, _: String) {}

    fn clear(&self) {}
}
