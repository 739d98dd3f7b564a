//! Where the loop fails, with the margin.

pub mod loop_matrix;
