//! The finite-element reference for the force of a press.
//!
//! It is quasi-static and in double precision. 10-node tets ([`quadratic`], [`shape`]) of
//! neo-Hookean tissue ([`body`]) are pressed by a frictionless rigid probe ([`probe`]). Newton's
//! method with line search ([`minimise`]) and load stepping ([`newton`]) solves the press with a
//! sparse Cholesky factor (`cholesky`); within each iteration the contact is solved for (`near`).
//! [`glued`] solves a glued disc at small displacement. All quantities are divided by Young's
//! modulus: the modulus is 1 Pa here, and a force [N] becomes an area [m^2].

pub mod assembly;
pub mod body;
pub(crate) mod cholesky;
pub mod condensed;
pub(crate) mod conform;
pub(crate) mod curved;
pub mod domain;
pub(crate) mod elimination;
pub mod extrapolate;
pub mod glued;
pub mod minimise;
mod near;
pub mod nearest;
pub mod newton;
pub mod probe;
pub mod quadratic;
pub mod refine;
pub mod shape;
pub mod touch;
