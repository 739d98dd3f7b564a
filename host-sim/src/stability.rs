//! `stability`: where the methods fail, and how far from it the product is.

pub mod model;
