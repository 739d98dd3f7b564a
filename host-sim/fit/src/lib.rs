//! Leads from a scene to a calibrated patch: computes the finite-element reference and fits a patch
//! to it.
//!
//! ```text
//! reference ─ targets ─ calibrate (statics) ─ patch
//! whole organ ─ far_field ─ rim springs of the patch
//! force_map: forces between the solved places and depths
//! settled: the force of the running patch where statics finds no equilibrium
//! law_fit: the law without nodes, held and moving
//! plan: the smallest patch that keeps a tolerance
//! half_space (relaxing), partial_slip (with friction): closed forms to compare with
//! ```
//!
//! [`reference`](mod@reference) solves the press by finite elements, and [`statics`] solves the
//! equilibrium of the patch. [`calibrate`](mod@calibrate) fits the patch to the reference,
//! [`far_field`] condenses the organ around the patch into rim springs, and [`plan`] searches for
//! the smallest patch. Stored finite-element answers are in [`solved`].

pub mod calibrate;
pub mod far_field;
pub mod force_map;
pub mod half_space;
pub mod identify;
pub mod law_fit;
pub mod partial_slip;
pub mod plan;
pub mod pressed_patch;
pub mod reference;
pub mod scene_fit;
pub mod settled;
pub mod solved;
pub mod statics;
