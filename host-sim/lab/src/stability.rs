//! `stability`: the limits of methods and loops, and the margin of the product.

pub mod controller;
pub mod loop_matrix;
pub mod model;
