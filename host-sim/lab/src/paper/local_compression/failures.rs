//! Failures of the paper's formulas on the standard block: the position correction for different
//! time steps, the region for different thresholds, and the volume force.

pub mod barycentre;
pub mod correction;
pub mod region;
