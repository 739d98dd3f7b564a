//! The far field: a small patch that answers like the whole organ.
//!
//! A whole organ is meshed around a site; [`cut`] separates the patch; the outside is condensed to
//! a stiffness on the patch's rim nodes ([`condense`]), to which [`springs`] fits a form that a
//! tick can afford: a positive symmetric set of *rim springs*, a block per rim node and a block per
//! rim edge. Stress decays as 1/h^2 but displacement only as 1/h: an edge that is merely fixed
//! makes the force 28-51 % too high at four contact radii.

pub mod build;
pub mod condense;
pub mod cut;
pub mod fitted;
pub mod organ_reference;
pub mod springs;
pub mod surface_map;
pub mod whole;

pub use build::{FarField, FarFieldError};
pub use cut::{Cut, CutError};
pub use palpate_tissue::mesh::block::Sizes;
pub use palpate_tissue::patch::RimSprings;
