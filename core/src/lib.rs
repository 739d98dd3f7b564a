//! Soft tissue inside a 1 kHz haptic controller loop.
//!
//! ```text
//! patch_file ─ Model ─┬─ Tuned, State ─ tick ─ Output ─ haptic: Cycle ─ force on the hand
//!              Params ┘                 pose ┘
//! ```
//!
//! A small tetrahedral mass-spring patch with compression compensation answers each pose of a probe
//! with a force. Guarantees of this crate: `no_std`, no allocation, single precision only, no panic
//! on the path of a [`tick()`], the same bits on every target.
//!
//! # Units and frame
//! SI everywhere; a scalar that crosses a module carries its unit in its name. Patch frame:
//! right-handed, x toward the operator, y to the operator's right, z up, out of the tissue.
//!
//! # Words
//! | word | means |
//! |---|---|
//! | probe | the rigid tool; its position is that of its tip |
//! | contact | surface triangles that the probe can reach |
//! | patch | tets, springs and surface of a piece of tissue |
//! | anchor | a fixed node |
//! | compensation | what resists over-compression |
//! | relaxation | the fading of forces in tissue that is held |
//! | far field | what stands in for the rest of the organ: rim springs |
//! | device, hand | what the probe is fixed to on either side of the haptic loop |
//! | tick, substep | 1 ms of the device's time, one integration step |
//!
//! # Example
//! A patch file, a device, 1 000 ticks (`examples/controller.rs`):
//!
#![doc = concat!("```\n", include_str!("../examples/controller.rs"), "```")]
//!
//! # Design principles
//! 1. The path of a tick is one screen: `tick.rs`.
//! 2. Constant [`Model`], mutable [`State`], derived [`Tuned`]: three types.
//! 3. Everything elastic is per pascal of Young's modulus: one packed patch serves every stiffness.
//! 4. One arithmetic, `+ - * / sqrt` never fused: the desktop is the board's bit-exact oracle.
#![no_std]
#![cfg_attr(not(test), warn(clippy::default_numeric_fallback, clippy::unwrap_used, clippy::expect_used, clippy::panic))]

#[cfg(feature = "contact-map")]
mod contact_map;
mod fault;
pub mod haptic;
mod inertia;
mod lanes;
mod memory;
pub mod method;
mod model;
mod params;
mod patch_file;
mod placement;
mod smooth;
pub mod stages;
mod state;
mod tick;

#[cfg(feature = "contact-map")]
pub use contact_map::ContactMap;
pub use fault::{BuildError, ClampFlags, Fault};
pub use inertia::{FIELDS, Gains, NodeStep};
pub use memory::Memory;
pub use model::{FoundationPoint, Model, NodeRest, RimEdge, RimNode, Spring, Tet, Triangle};
pub use nalgebra::Vector3;
pub use params::{GuardLimits, MOST_TERMS, Params, Probe, ProbeShape, PronyTerm, Terms, Tuned};
pub use patch_file::PatchFile;
pub use placement::Placement;
pub use stages::force::friction::Bristle;
pub use stages::output::Output;
pub use stages::probe::ProbePose;
pub use state::{Faded, Fnv, Node, Parked, State, TetShapes};
pub use tick::{tick, tick_with};
