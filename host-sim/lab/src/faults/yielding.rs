//! Yielding hands on patches: a hand with mass, stiffness and damping holds a device of any count,
//! delay and lag, and does what people do. A run is a list of numbers ([`Genes`]), so that the same
//! code draws a run at random and lets an adversary search for the worst one.
//!
//! ```text
//! genes ─ case ─┬─ motion ─ hand ─ plant ─ cycle ─ patch below the stiffness ceiling
//!               │            truth ─┬─ energy ─┐
//!               │                   └─ felt ───┴─ outcome ─ table
//!               └────── mutated by the adversary ────┘
//! ```
//!
//! Energy, contact and vibration are judged from the true position of the tip and the force that
//! acts, never from what the loop reports.

mod adversary;
mod case;
mod ceiling;
mod energy;
mod family;
mod felt;
mod genes;
mod hands;
mod motion;
mod row;
mod run;
mod table;
mod target;
mod trade;
mod truth;

pub use adversary::{Adversary, Aim, Found};
pub use case::{Bounds, YieldingCase};
pub use energy::{GivenEnergy, Ledger};
pub use family::{FAMILY_QUIET_N, FAMILY_WITHIN_J, family};
pub use felt::Felt;
pub use genes::{GENES, Genes};
pub use hands::Hands;
pub use motion::{Motion, MotionKind};
pub use row::HandsRow;
pub use run::{Outcome, RunLength, Seen};
pub use table::{HandsTable, Worst};
pub use trade::{TradePoint, trade};
