//! The finite-element reference for the force of a press.
//!
//! It is quasi-static and in double precision. 10-node tets ([`quadratic`], [`shape`]) of
//! neo-Hookean tissue ([`body`]) are pressed by a frictionless rigid probe ([`probe`]). Newton's
//! method with line search (`minimise`) and load stepping ([`newton`]) solves the press with a
//! sparse Cholesky factor (`cholesky`); within each iteration the contact is solved for (`near`).
//! [`hang`] solves the same tissue under its weight, with several organs that are tied to each
//! other and with some nodes held or displaced, and [`glued`] solves a glued disc at small
//! displacement. All quantities are divided by Young's modulus: the modulus is 1 Pa here, and a
//! force [N] becomes an area [m^2].

pub(crate) mod assembly;
pub mod body;
mod cholesky;
pub mod condensed;
pub(crate) mod conform;
pub mod domain;
mod elimination;
pub mod extrapolate;
pub mod find_depth;
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
pub mod suspension;
pub(crate) mod task;
pub mod tie;
pub mod touch;
