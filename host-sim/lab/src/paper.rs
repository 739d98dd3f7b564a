//! Runs the two papers that this project implements: every figure and table that can be reproduced
//! without their data, with the claims that held and those that did not.
//!
//! 000: *volume preserved mass-spring model* (liver and gallbladder, hung). 004: *local compression
//! deformation of soft tissue* (abdomen and foot, pressed).

pub mod local_compression;
pub mod report;
pub mod volume_preserved;

/// A progress display for a waiting person.
pub trait Progress: Sync {
    /// The next part of the run, in a few words.
    fn say(&self, doing: String);

    /// The run is done and prints its findings.
    fn clear(&self);
}

/// Progress that is not shown.
impl Progress for () {
    fn say(&self, _: String) {}

    fn clear(&self) {}
}
