//! The methods that the product is charted against do what their papers say: a strawman would make
//! any front.

mod chart;
mod equilibrium;
mod linear;
mod material;
mod meshless;
mod peers;
