//! The far field: makes a small patch respond like the whole organ.
//!
//! A whole organ is meshed around a site, and [`cut`] separates the patch from it. The outside is
//! condensed to a stiffness on the rim nodes of the patch ([`condense`]), to which [`springs`] fits
//! a form that the tick can afford: a positive definite symmetric set of *rim springs*, one block
//! per rim node and one per rim edge. Stress decays as 1/h^2 but displacement only as 1/h: a rim
//! that is simply fixed makes the force 28-51 % too high at four contact radii.

pub mod build;
pub mod condense;
pub mod cut;
pub mod organ_reference;
pub mod prepared;
pub mod shape_surface;
pub mod springs;
pub mod whole;

pub use build::{FarField, FarFieldError};
pub use cut::{Cut, CutError};
pub use palpate_tissue::mesh::block::Sizes;
pub use palpate_tissue::patch::RimSprings;
