//! Extension point of the tick: a method replaces the stages in which it differs from the product.
//!
//! | hook | when | [`Product`] |
//! |---|---|---|
//! | [`Method::begin`] | once per tick, after the contact was found | nothing |
//! | [`Method::force`] | once per substep | every term of [`force`], or a [`Law`] |
//! | [`Method::advance`] | once per substep | symplectic Euler ([`integrate`]), if no law answers |
//! | [`Method::correct`] | once per substep | nothing |
//!
//! Guard, contact and output are those of the product. A method is a type, so an image contains
//! only the method that it runs. A method reads [`State::nodes`], [`State::in_contact`] and the
//! accessors of [`Tuned`]; it acts through [`State::add_force`] and [`State::place`]:
//!
//! ```
//! use palpate::method::Method;
//! use palpate::stages::force::{self, foundation::Load};
//! use palpate::{Model, State, Tuned, Vector3};
//!
//! /// The product with the same wind force on every node.
//! struct Wind(Vector3<f32>);
//!
//! impl Method for Wind {
//!     fn force(
//!         &mut self,
//!         model: &Model,
//!         tuned: &Tuned,
//!         state: &mut State,
//!         tip_m: Vector3<f32>,
//!         m_per_s: Vector3<f32>,
//!     ) -> Load {
//!         force::accumulate_inner(model, tuned, state);
//!         (0..state.nodes().len()).for_each(|node| state.add_force(node, self.0));
//!         force::foundation::press(model, tuned, state, tip_m, m_per_s)
//!     }
//! }
//! ```

use nalgebra::Vector3;

use crate::fault::Fault;
use crate::law::Law;
use crate::model::Model;
use crate::params::Tuned;
use crate::stages::force::foundation::Load;
use crate::stages::{force, integrate};
use crate::state::State;

/// The stages of a tick between contact and output. A stage that is not overridden is the
/// product's.
pub trait Method {
    /// Prepares a tick, before its first substep.
    #[inline(always)]
    fn begin(&mut self, _tuned: &Tuned, _state: &State) {}

    /// Sums the forces on the nodes over E [N/Pa] and returns the probe's load on the tissue.
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

    /// Moves the nodes by one substep; returns how many free nodes moved.
    ///
    /// # Errors
    /// Fails with [`Fault::Diverged`] if a node is not finite or too fast.
    #[inline(always)]
    fn advance(&mut self, model: &Model, tuned: &Tuned, state: &mut State) -> Result<u16, Fault> {
        integrate::advance(model, tuned, state)
    }

    /// Moves nodes after a substep.
    #[inline(always)]
    fn correct(&mut self, _model: &Model, _tuned: &Tuned, _state: &mut State) {}
}

/// The product's own method: every stage as drawn in [`crate::tick()`].
#[derive(Clone, Copy, Debug)]
pub struct Product;

impl Method for Product {
    #[inline(always)]
    fn force(
        &mut self,
        model: &Model,
        tuned: &Tuned,
        state: &mut State,
        tip_m: Vector3<f32>,
        velocity_m_per_s: Vector3<f32>,
    ) -> Load {
        match law(model, tuned) {
            Some(law) => law.load(model, tuned, state, tip_m, velocity_m_per_s),
            None => force::accumulate(model, tuned, state, tip_m, velocity_m_per_s),
        }
    }

    #[inline(always)]
    fn advance(&mut self, model: &Model, tuned: &Tuned, state: &mut State) -> Result<u16, Fault> {
        if law(model, tuned).is_some() { Ok(0) } else { integrate::advance(model, tuned, state) }
    }
}

/// The law that answers in place of the nodes.
#[inline(always)]
fn law<'a>(model: &'a Model, tuned: &Tuned) -> Option<&'a Law<'a>> {
    model.law.as_ref().filter(|_| tuned.terms.law)
}
