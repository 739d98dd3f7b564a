//! Paper 004: soft tissue under local compression.

pub mod checkpoint;
pub mod fit;
pub mod hausdorff;
pub mod identifiability;
pub mod methods;
pub mod rest;
pub mod scene;
pub mod site;
pub mod steps;
pub mod truth;
