//! `stability`: where methods and loops fail, and how far from it the product is.

pub mod loop_matrix;
pub mod model;
