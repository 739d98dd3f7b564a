//! Parameters in SI units: [`Params`] as a user sets them, and [`Tuned`], the values that are
//! derived from them once for the tick.

mod probe;
mod prony;
mod ranges;
mod terms;

use nalgebra::Vector3;

use crate::fault::BuildError;
use crate::inertia::{Gains, NEIGHBOUR, NodeStep};
use crate::model::{Model, Spring};
use crate::smooth;
pub use probe::{FLAT_EDGE, Probe, ProbeShape};
pub(crate) use prony::Prony;
pub use prony::{MOST_TERMS, PronyTerm};
pub use terms::Terms;

/// Limits of the patch's guard. They can be lowered, never switched off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GuardLimits {
    /// Largest speed at which the shown probe moves [m/s].
    pub max_speed_m_per_s: f32,
    /// Largest speed at which the shown probe enters tissue in contact [m/s]. A probe that is
    /// faster than the waves in the tissue, which the mass floor slows down, would crush the first
    /// elements before the next ones move. `palpate_tissue::stable_step::limits` computes the speed
    /// that a patch's elements allow.
    pub max_sink_m_per_s: f32,
    /// Largest force that a tick outputs [N].
    pub max_force_n: f32,
}

impl GuardLimits {
    /// 1 m/s is the fastest tap of a hand holding a stylus; 12 N is the peak force of the strongest
    /// desktop devices (omega.3 class).
    pub const HIGHEST: Self = Self { max_speed_m_per_s: 1.0, max_sink_m_per_s: 1.0, max_force_n: 12.0 };
}

/// Everything a user may set, in SI.
///
/// ```
/// use palpate::{BuildError, GuardLimits, Params};
///
/// let limits = GuardLimits { max_force_n: 3.3, ..GuardLimits::HIGHEST };
/// let firm = Params { youngs_modulus_pa: 20e3, limits, ..Params::default() };
/// assert_eq!(firm.check(), Ok(()));
/// let wrong_unit = Params { youngs_modulus_pa: 0.02, ..firm };
/// let Err(BuildError::OutOfRange { parameter, .. }) = wrong_unit.check() else { panic!() };
/// assert_eq!(parameter, "youngs_modulus_pa");
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Params {
    /// Young's modulus [Pa]; with relaxation the instantaneous one.
    pub youngs_modulus_pa: f32,
    /// Poisson's ratio (1), from 0.25 (that of springs alone) to just below 0.5.
    pub poisson_ratio: f32,
    /// Density [kg/m^3].
    pub density_kg_per_m3: f32,
    /// Mass-proportional damping [1/s]: velocities shrink by this times the step.
    pub node_damping_per_s: f32,
    /// Gravity [m/s^2], patch frame. Zero means that the rest shape is the shape under gravity.
    pub gravity_m_per_s2: [f32; 3],
    /// Extra stiffness of a spring compressed beyond the threshold, as a share of its own (chi).
    pub compensation: f32,
    /// Compression at which the extra stiffness begins, as a share of the rest length (`tau_c`).
    pub compensation_threshold: f32,
    /// Mass floor factor f: the diagonal of the mass matrix is at least about `f E D T^2`, where D
    /// is the node's mean diagonal stiffness over E and T the tick. It does not affect statics.
    pub mass_floor: f32,
    /// Dashpot of the foundation between probe and node, as a share of its tangent stiffness times
    /// the substep (beta). With 1, the force is that of a probe one substep ahead of its position
    /// at the end of the substep; with 0, it lags behind that by a substep.
    pub contact_damping: f32,
    /// Stiffening exponent b of Fung and Demiray (1): the energy density w of a deformation becomes
    /// `mu/2b (exp(2 b w / mu) - 1)`. Zero leaves it out. It is a property of the tissue: one patch
    /// serves any value. If regions differ it is the largest exponent; [`Model::steepness`] relates
    /// the others to it.
    pub stiffening_b: f32,
    /// Relaxation of forces while the tissue is held; terms with a share of zero are left out. It
    /// is a property of the tissue: one patch serves any value.
    // with a named length, the compiler (1.95) fails where a closure borrows the field
    pub relaxation: [PronyTerm; 3],
    /// Coulomb's coefficient between probe and tissue (1), 0 .. 5: the force along the surface is
    /// at most this times the push. Zero leaves friction out.
    pub friction: f32,
    /// Number of integration steps per tick.
    pub substeps: u16,
    /// Period of the loop, the tick [s].
    pub tick_s: f32,
    /// Shape and size of the probe, upright: the press is against its axis.
    pub probe: Probe,
    /// Orientation of the probe: the rotation about its tip from the upright pose, a unit
    /// quaternion x, y, z, w that tilts it by at most 45 degrees.
    #[cfg(feature = "long-tips")]
    pub orientation: [f32; 4],
    /// Terms of the model that act.
    pub terms: Terms,
    /// Limits on the speeds of the shown probe and on the force of a tick.
    pub limits: GuardLimits,
}

impl Default for Params {
    /// Liver-like tissue under a fingertip. The scalars of the model were found by measurement
    /// (DECISIONS.md).
    fn default() -> Self {
        Self {
            youngs_modulus_pa: 3500.0,
            poisson_ratio: 0.45,
            density_kg_per_m3: 1060.0,
            node_damping_per_s: 40.0,
            gravity_m_per_s2: [0.0; 3],
            compensation: 1.13,
            compensation_threshold: 0.073,
            mass_floor: 5.0,
            contact_damping: 0.5,
            stiffening_b: 0.0,
            relaxation: [PronyTerm::NONE; MOST_TERMS],
            friction: 0.0,
            substeps: 1,
            tick_s: 1e-3,
            probe: Probe { shape: ProbeShape::Hemisphere, radius_m: 8e-3, axis: Vector3::new(0.0, 0.0, 1.0) },
            #[cfg(feature = "long-tips")]
            orientation: Self::UPRIGHT,
            terms: Terms::ALL,
            limits: GuardLimits::HIGHEST,
        }
    }
}

/// Safety factor for lumping the foundation's tangent stiffnesses at nodes, although the points of
/// a triangle couple its corners. With 1 the longest stable tick falls by a fifth; from 1.5 on it
/// stays the same.
const CONTACT_LUMPING: f32 = 1.5;

/// Largest exponent of stiffening (1): pig liver has 12 to 22. Boards leave the term out.
const MOST_STIFFENING: f32 = if cfg!(target_os = "none") { 0.0 } else { 100.0 };

/// Largest coefficient of friction (1): wet skin reaches 2.
const MOST_FRICTION: f32 = 5.0;

/// Visits both ends of every spring, with the inertia of the other end.
#[inline]
fn each_end(model: &Model, node_step: &mut [NodeStep], visit: impl Fn(&Spring, &mut NodeStep, NodeStep)) {
    for spring in model.springs {
        let [i, j] = [spring.i, spring.j].map(usize::from);
        for (own, other) in [(i, j), (j, i)] {
            let other = node_step.get(other).copied();
            if let (Some(node), Some(other)) = (node_step.get_mut(own), other) {
                visit(spring, node, other);
            }
        }
    }
}

/// Parameters as the tick reads them, derived once from [`Params`], so that the tick never divides
/// by a user's value.
#[derive(Debug)]
pub struct Tuned<'a> {
    pub(crate) terms: Terms,
    /// The probe as it is turned.
    pub(crate) probe: Probe,
    /// Axis of the upright probe.
    #[cfg(feature = "long-tips")]
    pub(crate) up: Vector3<f32>,
    pub(crate) limits: GuardLimits,
    /// E [Pa]: forces inside the tick are divided by it.
    pub(crate) youngs_modulus_pa: f32,
    /// Gravity times density over E [1/m]: weight over E per m^3.
    pub(crate) weight: [f32; 3],
    pub(crate) substeps: u16,
    pub(crate) substep_s: f32,
    /// One over the number of substeps.
    pub(crate) substep_share: f32,
    pub(crate) ticks_per_s: f32,
    /// Share of the velocity that remains after a substep with mass-proportional damping alpha (1):
    /// `1 - alpha dt`.
    pub(crate) keep: f32,
    /// Density over `E dt` [s/m^2].
    pub(crate) density_rate: f32,
    /// Length over rest length below which compensation acts (1): `1 - tau_c`.
    pub(crate) onset: f32,
    pub(crate) compensation: f32,
    pub(crate) contact_damping_s: f32,
    /// Displacement in a substep per velocity gained in it, including the safety factor for lumping
    /// [s].
    pub(crate) lumping_s: f32,
    /// Factor that turns a node's energy over E, divided by six times the volume of its tets, into
    /// the logarithm of the node's stiffness factor (1).
    pub(crate) steepness: f32,
    /// Constants of the relaxation filter.
    pub(crate) prony: Prony,
    /// Coulomb's coefficient (1); zero where nothing rubs.
    pub(crate) friction: f32,
    /// Ratio of the tangential to the normal stiffness of a half-space (1).
    pub(crate) along: f32,
    /// Most surface triangles that a substep presses. Further ones raise
    /// [`crate::ClampFlags::DEPTH`].
    pub most_pressed: usize,
    /// True if the tissue relaxes or the probe has friction.
    pub(crate) remembers: bool,
    /// True if some node has added mass relative to its neighbours.
    pub(crate) relative_mass: bool,
    /// True if some smooth field is used.
    pub(crate) fields: bool,
    /// Gains of the smooth fields.
    pub(crate) gains: Gains,
    /// Inertia of every node, shape \[nodes\].
    pub(crate) node_step: &'a mut [NodeStep],
}

impl Tuned<'_> {
    /// Diagonal of the mass matrix at a node [kg]; infinite for an anchor. `None` past the end.
    #[must_use]
    pub fn mass_kg(&self, node: usize) -> Option<f32> {
        self.node_step.get(node).map(|node| self.youngs_modulus_pa * self.substep_s / node.step)
    }

    /// Young's modulus [Pa].
    #[must_use]
    pub fn youngs_modulus_pa(&self) -> f32 {
        self.youngs_modulus_pa
    }

    /// Whether the tissue stiffens. Boards have no time for this term and their images leave out
    /// its code, so a controller refuses such a patch.
    #[must_use]
    #[inline(always)]
    pub fn stiffens(&self) -> bool {
        cfg!(not(target_os = "none")) && self.steepness > 0.0
    }

    /// Whether the tissue relaxes; the state then needs [`crate::State::with_relaxation`].
    #[must_use]
    #[inline]
    pub fn relaxes(&self) -> bool {
        self.prony.terms > 0
    }

    /// Whether the probe has friction; the state then needs [`crate::State::with_friction`].
    #[must_use]
    pub fn rubs(&self) -> bool {
        self.friction > 0.0
    }

    /// Substeps per tick.
    #[must_use]
    pub fn substeps(&self) -> u16 {
        self.substeps
    }

    /// Length of a substep [s].
    #[must_use]
    pub fn substep_s(&self) -> f32 {
        self.substep_s
    }

    /// Share of its velocity that a node keeps in a substep (1): one minus the node damping times
    /// the substep.
    #[must_use]
    pub fn velocity_kept(&self) -> f32 {
        self.keep
    }

    /// Inertia of every node, shape \[nodes\]; its `step` is zero for anchors, and only for them.
    #[must_use]
    pub fn node_step(&self) -> &[NodeStep] {
        self.node_step
    }

    /// Gains of the smooth fields, which [`Params::derive`] takes together with the inertia of the
    /// nodes.
    #[must_use]
    #[inline]
    pub fn gains(&self) -> Gains {
        self.gains
    }

    /// Probe that presses the patch.
    #[must_use]
    pub fn probe(&self) -> &Probe {
        &self.probe
    }

    /// Depth of the contact of a long or a turned tip below the tip, along the contact normal [m]:
    /// zero for a ball and an upright flat end, which are the tips of boards.
    #[inline(always)]
    #[cfg_attr(not(feature = "long-tips"), expect(unused_variables, reason = "no tip is long"))]
    pub(crate) fn contact_below_tip_m(&self, normal: &Vector3<f32>) -> f32 {
        #[cfg(feature = "long-tips")]
        match self.probe.shape {
            ProbeShape::Hemisphere | ProbeShape::Sphere => {}
            ProbeShape::Flat if self.probe.axis == self.up => {}
            _ => return self.probe.below_tip_m(normal),
        }
        0.0
    }

    /// Axis of the upright probe: the outward direction of the press.
    #[inline(always)]
    pub(crate) fn up(&self) -> Vector3<f32> {
        #[cfg(feature = "long-tips")]
        return self.up;
        #[cfg(not(feature = "long-tips"))]
        self.probe.axis
    }
}

impl Params {
    /// Young's modulus after an infinitely long hold [Pa]: the instantaneous modulus minus the
    /// share that relaxes.
    #[must_use]
    pub fn long_term_modulus_pa(&self) -> f32 {
        self.youngs_modulus_pa * (1.0 - prony::faded_share(self.relaxes()))
    }

    /// Relaxation terms in effect: none if relaxation is switched off.
    #[inline]
    fn relaxes(&self) -> &[PronyTerm; MOST_TERMS] {
        if self.terms.relaxation { &self.relaxation } else { &[PronyTerm::NONE; MOST_TERMS] }
    }

    /// Checks the parameters and the model and derives the values that the tick reads. `node_step`
    /// is the caller's memory, at least one entry per node.
    ///
    /// # Errors
    /// Returns the first parameter out of range or the first invalid item of the model, or reports
    /// that the memory is too small.
    #[inline]
    pub fn build<'a>(&self, model: &Model, node_step: &'a mut [NodeStep]) -> Result<Tuned<'a>, BuildError> {
        self.build_in_rounds(model, node_step, &mut || {})
    }

    /// Like [`Params::build`], for a controller that has other work to do meanwhile: `after_round`
    /// is called after each of the (at most 128) rounds in which the smooth fields are found, each
    /// of them one pass over the springs.
    ///
    /// # Errors
    /// Errors of [`Params::build`].
    #[inline]
    pub fn build_in_rounds<'a>(
        &self,
        model: &Model,
        node_step: &'a mut [NodeStep],
        after_round: &mut dyn FnMut(),
    ) -> Result<Tuned<'a>, BuildError> {
        self.check()?;
        model.check_arrays()?;
        after_round();
        model.check_neighbours()?;
        after_round();
        if let Some(law) = &model.law {
            law.check(&self.probe.axis)?;
        }
        if self.poisson_ratio != model.poisson_ratio {
            return Err(BuildError::PoissonMismatch { given: self.poisson_ratio, patch: model.poisson_ratio });
        }
        let (need, have) = (model.nodes.len(), node_step.len());
        let node_step = node_step.get_mut(..need).ok_or(BuildError::TooLarge { item: "nodes", need, have })?;
        self.weigh(model, node_step);
        after_round();
        if node_step.iter().any(|node| node.added > 0.0) {
            smooth::find(model, node_step, self.terms.relative_mass, after_round);
        }
        let gains = self.gains(model, node_step);
        Ok(self.derive(node_step, gains))
    }

    /// Rebuilds `tuned` with these parameters, which may differ from the earlier ones in Young's
    /// modulus only and must have passed [`Params::check`]; the state stays as it is. Call it
    /// between two ticks. The smooth fields remain those of the modulus that the patch was built
    /// with, because finding them anew takes longer than a tick.
    #[inline]
    pub fn retune(&self, model: &Model, tuned: &mut Tuned<'_>) {
        let node_step = core::mem::take(&mut tuned.node_step);
        self.weigh(model, node_step);
        let gains = self.gains(model, node_step);
        let most_pressed = tuned.most_pressed;
        *tuned = self.derive(node_step, gains);
        tuned.most_pressed = most_pressed;
    }

    /// Gains of the smooth fields for the masses that [`Self::weigh`] computed. Without the term of
    /// relative mass the tick has no mass between neighbours, so `added` is set to zero.
    #[inline]
    fn gains(&self, model: &Model, node_step: &mut [NodeStep]) -> Gains {
        let gains = smooth::gains(model, node_step, self.terms.relative_mass);
        if !self.terms.relative_mass {
            node_step.iter_mut().for_each(|node| node.added = 0.0);
        }
        gains
    }

    /// Computes the masses of a model that has been checked.
    #[inline]
    fn weigh(&self, model: &Model, node_step: &mut [NodeStep]) {
        let e = self.youngs_modulus_pa;
        let dt = self.tick_s / f32::from(self.substeps);
        // masses are over E T^2 [m], T the tick, to be compared with stiffnesses over E. With T
        // instead of the substep, the tissue's inertia does not depend on the number of substeps,
        // and n substeps give n times the margin.
        let tick_squared = self.tick_s * self.tick_s;
        let per_volume = self.density_kg_per_m3 / (e * tick_squared);
        // Relative to its neighbours, a node's added mass B acts through its springs with the
        // weights w = k (B_i / S_i + B_j / S_j) / 2, where S is the sum of the node's k. Until the
        // last loop `step` holds first the rim's stiffness and then the mass, and `added` first S
        // and then B / 2 S.
        for node in node_step.iter_mut() {
            (node.step, node.added) = (0.0, 0.0);
        }
        let between = self.terms.relative_mass || self.terms.smooth_mass;
        if between {
            each_end(model, node_step, |spring, node, _| node.added += spring.k);
        }
        // rim springs connect nodes to the ground, not to each other: their part of the floor stays
        // with the node itself
        if self.terms.rim {
            for rim in model.rim_nodes {
                let [xx, yy, zz, ..] = rim.block_m;
                if let Some(node) = node_step.get_mut(rim.node as usize) {
                    node.step = (xx + yy + zz) * (1.0 / 3.0);
                }
            }
        }
        for (node, rest) in node_step.iter_mut().zip(model.nodes) {
            let lumped = per_volume * rest.volume_m3;
            let floor = self.mass_floor * rest.stiffness_m;
            let added = if lumped > floor { 0.0 } else { floor - lumped };
            (node.step, node.added) = match node.added > 0.0 {
                true => {
                    let own = added * node.step / rest.stiffness_m;
                    let own = if own > 0.0 { own } else { 0.0 };
                    let own = if own < added { own } else { added };
                    (lumped + own, 0.5 * (added - own) / node.added)
                }
                false => (lumped + added, 0.0),
            };
        }
        if between {
            each_end(model, node_step, |spring, node, other| node.step += spring.k * (node.added + other.added));
        }
        for node in node_step.iter_mut() {
            node.step = dt / (node.step * tick_squared);
            node.added *= NEIGHBOUR * tick_squared / dt;
        }
        for &anchor in model.anchors {
            if let Some(step) = node_step.get_mut(usize::from(anchor)) {
                step.step = 0.0;
            }
        }
    }

    /// Derives the scalars, given the masses and gains that [`Self::build`] computed for these
    /// parameters. A caller that owns its memory derives them in every tick, at no cost.
    #[must_use]
    #[inline]
    pub fn derive<'a>(&self, node_step: &'a mut [NodeStep], gains: Gains) -> Tuned<'a> {
        let e = self.youngs_modulus_pa;
        let dt = self.tick_s / f32::from(self.substeps);
        let prony = Prony::of(self.relaxes(), dt);
        let friction = if self.terms.friction { self.friction } else { 0.0 };
        Tuned {
            terms: self.terms,
            probe: self.turned_probe(),
            #[cfg(feature = "long-tips")]
            up: self.probe.axis,
            limits: self.limits,
            youngs_modulus_pa: e,
            weight: self.gravity_m_per_s2.map(|g| g * self.density_kg_per_m3 / e),
            substeps: self.substeps,
            substep_s: dt,
            substep_share: 1.0 / f32::from(self.substeps),
            ticks_per_s: 1.0 / self.tick_s,
            keep: 1.0 - self.node_damping_per_s * dt,
            density_rate: self.density_kg_per_m3 / (e * dt),
            onset: 1.0 - self.compensation_threshold,
            compensation: self.compensation,
            contact_damping_s: self.contact_damping * dt,
            lumping_s: CONTACT_LUMPING * dt,
            most_pressed: usize::MAX,
            // a node's volume is a quarter of its tets', mu is E / (2 (1 + nu))
            steepness: if self.terms.stiffening {
                2.0 * self.stiffening_b * (2.0 * (1.0 + self.poisson_ratio)) * 24.0
            } else {
                0.0
            },
            remembers: prony.terms > 0 || friction > 0.0,
            prony,
            friction,
            along: 2.0 * (1.0 - self.poisson_ratio) / (2.0 - self.poisson_ratio),
            relative_mass: node_step.iter().any(|node| node.added > 0.0),
            fields: gains.iter().any(|gain| *gain > 0.0),
            gains,
            node_step,
        }
    }
}
