//! Paper 004: soft tissue under local compression.

pub mod hausdorff;
pub mod methods;
pub mod rest;
pub mod scene;
pub mod site;
pub mod truth;
