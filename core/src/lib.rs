//! Soft tissue inside a 1 kHz haptic controller loop.
//!
//! ```text
//! patch_file ─ Model ─┬─ Tuned, State ─ tick ─ Output ─ haptic: Cycle ─ force on the hand
//!              Params ┘                 pose ┘
//! ```
//!
//! A small tetrahedral mass-spring patch with compression compensation answers each pose of a probe
//! with a force. This crate guarantees: `no_std`, no allocation, single precision only, no panic on
//! the path of a [`tick()`], and the same bits on every target.
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
//! | compensation | the term that resists over-compression |
//! | relaxation | the decay of force in tissue that is held deformed |
//! | law | the force over place, depth and speed, without nodes |
//! | far field | the rest of the organ around the patch, represented by rim springs |
//! | device, hand | the actuated handle that carries the probe; the user's hand on it |
//! | tick, substep | one period of the loop (1 ms); one integration step within it |
//!
//! # Example
//! A patch file, a device, 1 000 ticks (`examples/controller.rs`):
//!
#![doc = concat!("```\n", include_str!("../examples/controller.rs"), "```")]
//!
//! The tick alone, without a device (`examples/tick.rs`):
//!
#![doc = concat!("```\n", include_str!("../examples/tick.rs"), "```")]
//!
//! # Design principles
//! 1. A tick fits on one screen: `tick.rs`.
//! 2. Three types: the constant [`Model`], the mutable [`State`], the derived [`Tuned`].
//! 3. Everything elastic is per pascal of Young's modulus: one packed patch serves every stiffness.
//! 4. Only `+ - * / sqrt`, never fused: the desktop is the board's bit-exact oracle.
#![no_std]
#![cfg_attr(not(test), warn(clippy::default_numeric_fallback, clippy::unwrap_used, clippy::expect_used, clippy::panic))]

mod bristle;
#[cfg(feature = "contact-map")]
mod contact_map;
mod fault;
pub mod haptic;
mod inertia;
mod lanes;
mod law;
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

pub use bristle::Bristle;
#[cfg(feature = "contact-map")]
pub use contact_map::{ContactMap, Wrench};
pub use fault::{BuildError, ClampFlags, Fault};
pub use inertia::{FIELDS, Gains, NodeStep};
pub use lanes::square_root;
pub use law::{Branch, FIELDS as LAW_FIELDS, Law, LawShape, MOST_BRANCHES};
pub use memory::Memory;
pub use model::{FoundationPoint, Model, NodeRest, RimEdge, RimNode, Spring, Tet, Triangle};
pub use nalgebra::Vector3;
pub use params::{GuardLimits, MOST_TERMS, Params, Probe, ProbeShape, PronyTerm, Terms, Tuned};
pub use patch_file::PatchFile;
pub use placement::Placement;
pub use stages::output::Output;
pub use stages::probe::ProbePose;
pub use state::{Faded, Fnv, Node, Parked, State, TetShapes};
pub use tick::{tick, tick_with};
