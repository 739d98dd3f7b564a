//! The stages of a tick, one file each, in the order of [`crate::tick`].
//!
//! A model with a law has no nodes that move: the law answers in place of force and integrate.
//!
//! In tissue that stiffens (desktop only), the energy of springs and foundation is computed before
//! their forces. With friction, the foundation also holds the touched nodes along the surface. In
//! tissue that relaxes, the last force term fades the sum of the others at each node. The mass that
//! the floor adds slows the nodes, but the hand must not feel it: `integrate` measures the power
//! that this mass absorbs, and `output` subtracts the corresponding force.

pub mod contact;
pub mod force;
pub mod integrate;
pub mod law;
pub mod output;
pub mod presence;
pub mod probe;
