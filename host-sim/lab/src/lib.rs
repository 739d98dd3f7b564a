//! Comparisons that support the project's claims: other methods, speed against accuracy, stability,
//! and the figures of the two papers.
//!
//! ```text
//! methods ─ chart (speed against accuracy)
//! methods ─ stability (where methods and loops fail)
//! paper (figures and tables of the two papers), score (equation 14)
//! faults (the loop under faults, random paths and yielding hands)
//! methods ─ suite (what each scene needs at least)
//! study (cases, rows, claims, figures: runs, writes, prints and judges all of these)
//! command (the studies of `palpate`)
//! hanging (organs under their weight), dynamic (a probe that moves): finite elements
//! paper_method (the models of the two papers on the core's tick)
//! accept (the model against raw measurements of tissue)
//! unseen (the stated error of random scenes against finite elements that no fit saw)
//! ```
//!
//! No product code depends on this crate.

// this `println` tolerates a closed pipe
#[macro_use(println)]
extern crate palpate_tissue;

pub mod accept;
pub mod chart;
pub mod command;
pub mod dynamic;
pub mod faults;
pub mod hanging;
pub mod methods;
pub mod paper;
pub mod paper_method;
pub mod score;
pub mod stability;
pub mod study;
pub mod suite;
pub mod unseen;

pub use palpate_sim::error::{self, Error};
