//! The finite-element reference for the force of a press.
//!
//! Quasi-static and in double precision: 10-node tets ([`quadratic`], [`shape`]) of neo-Hookean
//! tissue ([`body`]) against a frictionless rigid probe ([`probe`]), solved by Newton's method with
//! line search (`minimise`) and load stepping ([`newton`]) on a sparse Cholesky factor
//! (`cholesky`), the contact solved for within each iteration (`near`). The same tissue under its
//! weight, with several organs tied to each other, held and moved at some nodes: [`hang`]. A glued
//! disc, at small displacement: [`glued`]. All quantities are divided by Young's modulus: the
//! modulus is 1 Pa here, and a force [N] is an area [m^2].

pub(crate) mod assembly;
pub mod body;
mod cholesky;
pub mod condensed;
pub(crate) mod conform;
pub mod domain;
mod elimination;
pub mod glued;
pub mod hang;
pub mod locate;
pub(crate) mod minimise;
mod near;
pub mod nearest;
pub mod newton;
pub mod organs;
pub mod probe;
pub mod quadratic;
pub mod refine;
pub mod shape;
pub mod shipped;
pub mod study;
pub mod suspension;
pub(crate) mod task;
pub mod tie;
pub mod touch;
