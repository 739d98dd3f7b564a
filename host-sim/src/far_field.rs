//! A small patch that answers like the whole organ it is cut out of.

pub mod organ_reference;
pub mod whole;

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
