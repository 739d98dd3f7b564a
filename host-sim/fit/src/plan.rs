//! `plan`: the smallest model that keeps a force tolerance on a board. No more is modelled than a
//! scene needs.
//!
//! Candidates ([`candidate`]) are patches of several radii, element sizes and foundation points;
//! meshed, cut and condensed they have a cost before any fit. Sorted by it they are searched
//! ([`search`]) by bisection with short fits, and with full ones around the border. Their forces
//! are compared with the whole organ at unseen places ([`judge`]). The winner is then tried with
//! less: terms off, a cheaper edge ([`edge`]).

pub mod candidate;
pub mod judge;
pub mod judged_candidate;
pub mod known;
pub mod outcome;
pub mod rim_treatment;
pub mod search;

pub use candidate::{Candidate, Supply, Weighed};
pub use judge::{Judge, Judged, WORST_RATIO};
pub use judged_candidate::{Bench, Effort, JudgedCandidate};
pub use known::Known;
pub use outcome::Outcome;
pub use rim_treatment::RimTreatment;
pub use search::search;
