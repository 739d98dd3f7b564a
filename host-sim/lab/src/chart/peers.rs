//! Comparison with other physics engines on the press of the chart.
//!
//! The engines run in separate scripts, in `host-sim/lab/peers`. `press` writes their input, `grid`
//! makes the meshes that they may use besides ours, `table` reads their output, and `compare` and
//! `picture` compare it with our results.

mod compare;
mod grid;
mod picture;
mod press;
mod searched;
mod table;

pub use compare::{Compared, Factors, RAMPS_MM_PER_S, add, compare, least, same_meshes};
pub use grid::{GRIDS, grid, grid_name};
pub use picture::figures;
pub use press::{MODULI_PA, PeerMesh, StandardPress, meshes, on_grid};
pub use searched::searched;
pub use table::{Peer, Peers, columns};
