//! Several organs in one mesh of finite elements, and the points of one of them.

pub mod locate;
pub mod organs;
