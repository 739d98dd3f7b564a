//! The methods in the chart besides the product are implemented as in their papers: with strawmen
//! any front could be obtained.

mod chart;
mod equilibrium;
mod linear;
mod material;
mod meshless;
mod peers;
