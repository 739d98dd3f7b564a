//! `stability`: the limits of methods and loops, and the product's margin.

pub mod loop_matrix;
pub mod model;
