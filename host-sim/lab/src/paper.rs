//! The two papers this project implements, run: every figure and table of theirs that can be had
//! without their data, with what held and what did not.
//!
//! 000: *volume preserved mass-spring model* (liver and gallbladder, hung). 004: *local compression
//! deformation of soft tissue* (abdomen and foot, pressed).

pub mod local_compression;
pub mod report;
pub mod volume_preserved;
