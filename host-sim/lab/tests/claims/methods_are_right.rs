//! The chart's other methods are implemented as in their papers. With poor implementations of its
//! rivals, any method could be made to look best.

mod chart;
mod equilibrium;
mod linear;
mod material;
mod meshless;
mod peers;
