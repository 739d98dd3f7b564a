//! Makes a calibrated patch with its measured error from a scene: presses for the fit and for the
//! evaluation, their finite-element solution, the fit, and the errors.
//!
//! ```text
//! presses ─ solve (finite elements, press by press) ─ answer ─┬─ known ─ targets ─ fit ─ patch
//! piece (a piece of the whole, and its presses) ──────────────┴─ unseen ──────────────── judge
//! ```
//!
//! A block with inclusions is first fitted without them. Then the bump that they cause is fitted
//! (`bump`, `bump_fit`): the difference between presses with and without the inclusions.
//!
//! Unseen presses are solved at places and depths from which no target is made.

mod answer;
mod bump;
mod bump_fit;
mod check;
mod discs;
mod fit;
mod judge;
mod piece;
mod presses;
mod shifted;
mod solve;

pub use answer::{Solved, answer};
pub use bump::{Bumps, solve_bumps};
pub use bump_fit::{BumpDepth, BumpFit, BumpVerdict, Bumped};
pub use check::{check, check_block, refuse_beyond_the_guard};
pub use discs::GluedDiscs;
pub use fit::{Prepared, prepare};
pub use judge::{DepthVerdict, GluedVerdict, Judging, PLACES, SurfaceVerdict, Verdict, WORST_RATIO, judged_again};
pub use piece::{PIECE_JUDGED_RADII, PIECE_RADII, PiecePresses, element_for, tissue_of};
pub use presses::{JUDGED_RADII, Level, PressJob, Presses};
pub use solve::{Forces, PressListener, solve_all};
