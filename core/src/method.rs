//! The stages that methods differ in. A method is a type, so an image holds only the one it runs.
//!
//! | stage | [`Product`] | [`VolumePreserved`], paper 000 | [`LocalCompression`], paper 004 |
//! |---|---|---|---|
//! | region | all nodes | all nodes | stress rule (7)-(8) |
//! | force | springs with compensation, volume, rim | springs (4), dampers (5), (12) | springs and dampers (1), barycentre force (2) |
//! | integrate | symplectic Euler | symplectic Euler, which is (3) | velocity Verlet (9)-(10) |
//! | correct | nothing | lengths (6)-(8), directions (9) | over-compression (11)-(13) |
//!
//! Guard, contact and output are the same for all.

mod local_compression;
mod volume_preserved;

pub use local_compression::LocalCompression;
pub use volume_preserved::VolumePreserved;

use nalgebra::Vector3;

use crate::fault::Fault;
use crate::model::Model;
use crate::params::Tuned;
use crate::stages::force::foundation::Load;
use crate::stages::region::Region;
use crate::stages::{force, integrate, region};
use crate::state::State;

/// The stages of a tick between contact and output. A stage that is not written out is the
/// product's.
pub trait Method {
    /// Once a tick: which nodes move.
    #[inline(always)]
    fn region(&mut self, tuned: &Tuned, state: &State) -> Region {
        region::select(tuned, state)
    }

    /// Sums the forces on the nodes over E [N/Pa]; the load on the probe is returned.
    #[inline(always)]
    fn force(
        &mut self,
        model: &Model,
        tuned: &Tuned,
        state: &mut State,
        tip_m: Vector3<f32>,
        velocity_m_per_s: Vector3<f32>,
    ) -> Load {
        force::accumulate(model, tuned, state, tip_m, velocity_m_per_s)
    }

    /// Moves the region's nodes by one substep; returns how many.
    ///
    /// # Errors
    /// [`Fault::Diverged`].
    #[inline(always)]
    fn advance(&mut self, model: &Model, tuned: &Tuned, state: &mut State, region: Region) -> Result<u16, Fault> {
        integrate::advance(model, tuned, state, region)
    }

    /// Moves nodes after a substep.
    #[inline(always)]
    fn correct(&mut self, _model: &Model, _tuned: &Tuned, _state: &mut State) {}
}

/// The product: every stage as [`crate::tick()`] draws it.
#[derive(Clone, Copy, Debug)]
pub struct Product;

impl Method for Product {}
