//! Engines of other people at the press of the chart.
//!
//! They run elsewhere, in scripts of `host-sim/lab/peers`: `press` is what those are given, `grid`
//! the meshes that they may take besides ours, `table` what they give back, `compare` and
//! `picture` set it beside ours.

mod compare;
mod grid;
mod picture;
mod press;
mod searched;
mod table;

pub use compare::{Compared, Factors, RAMPS_MM_PER_S, compare, least, same_meshes, write_compared};
pub use grid::{GRIDS, grid, grid_name};
pub use picture::draw_peers;
pub use press::{MODULI_PA, PeerMesh, StandardPress, meshes, on_grid};
pub use searched::searched;
pub use table::{Peer, PeerError, Peers, columns};
