//! `fit --smallest`: searches for the smallest model that keeps a force tolerance on a board, so
//! that no more is modelled than a scene needs.
//!
//! Candidates ([`candidate`]) are patches with several radii, element sizes and numbers of
//! foundation points. After meshing, cutting and condensing, their cost is known before any fit.
//! They are sorted by cost and searched ([`search`]) by bisection with short fits, and with full
//! fits around the border. Their forces are compared with those of the whole organ at unseen places
//! ([`crate::scene_fit::Judging`]). For the winner, reductions are then tried: terms left out, and
//! a cheaper treatment of the rim ([`rim_treatment`]).

pub mod candidate;
pub mod judged_candidate;
pub mod outcome;
mod presses;
pub mod rim_treatment;
pub mod search;

pub use candidate::{Candidate, Supply, Weighed};
pub use judged_candidate::{Bench, Effort, JudgedCandidate};
pub use outcome::Outcome;
pub use presses::presses;
pub use rim_treatment::RimTreatment;
pub use search::search;
