//! The far field: a small patch that answers like the whole organ.
//!
//! A whole organ is meshed around a site; [`cut`] takes the patch out of it; the outside is condensed to a stiffness on the patch's rim nodes
//! ([`condense`]), and [`springs`] fits to that what a tick can afford: a positive symmetric set of *rim springs*, a block a rim node and a block a rim
//! edge. Stress dies as 1/h^2 but displacement only as 1/h: an edge that is merely fixed makes the force 28-51 % too high at four contact radii.

pub mod build;
pub mod condense;
pub mod cut;
pub mod edges;
pub mod fitted;
pub mod organ_reference;
pub mod sliding;
pub mod springs;
pub mod surface_map;
pub mod table;
pub mod whole;

pub use build::{FarField, FarFieldError};
pub use cut::{Cut, CutError};
pub use edges::{Edge, Edges};
pub use springs::RimSprings;

/// How a whole organ is meshed around the patch that will be cut out of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sizes {
    /// Radius of the patch around the site [m].
    pub radius_m: f64,
    /// Edge length at the site [m].
    pub fine_m: f64,
    /// Edges are that long within this distance of the site [m].
    pub fine_radius_m: f64,
    /// Growth of the edge length per distance beyond it (1).
    pub growth: f64,
    /// How far the site travels [m], centred on the site: the patch is then all within `radius_m` of that segment. Zero for a patch that stays.
    pub stroke_m: [f64; 3],
}
