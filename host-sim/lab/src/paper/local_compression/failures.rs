//! Failures of the paper's formulas on the standard block: the position correction against the
//! step, the region against its threshold, the volume force.

pub mod barycentre;
pub mod correction;
pub mod region;
