//! The two papers this project implements, run: every figure and table of theirs that can be had
//! without their data, with what held and what did not.
//!
//! 000: *volume preserved mass-spring model* (liver and gallbladder, hung). 004: *local compression
//! deformation of soft tissue* (abdomen and foot, pressed).

pub mod local_compression;
pub mod report;
pub mod volume_preserved;

/// A display for a person who waits for a run.
pub trait Progress: Sync {
    /// The run goes on with this, in a few words.
    fn say(&self, doing: String);

    /// The run is done, and prints what it found.
    fn clear(&self);
}

/// Progress that is not shown.
impl Progress for () {
    fn say(&self, _: String) {}

    fn clear(&self) {}
}
