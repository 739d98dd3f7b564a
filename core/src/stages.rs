//! The stages of a tick, one file each, in the order of [`crate::tick`].

pub mod contact;
pub mod force;
pub mod integrate;
pub mod output;
pub mod presence;
pub mod probe;
