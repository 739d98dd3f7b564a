//! Parameters in SI, as a user sets them ([`Params`]), and what the tick needs of them, derived
//! once ([`Tuned`]).

use nalgebra::Vector3;

use crate::fault::BuildError;
use crate::model::Model;

/// Shape of the rigid, frictionless probe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProbeShape {
    /// A cylinder with a half-sphere at its tip: what a fingertip or a rounded tool is.
    Hemisphere,
    /// A full sphere.
    Sphere,
    /// A cylinder with a flat end.
    Flat,
}

/// The probe. Its position everywhere is that of its **tip**, the point furthest along `-axis`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Probe {
    /// Shape.
    pub shape: ProbeShape,
    /// Radius [m].
    pub radius_m: f32,
    /// Unit vector from the tip to the handle.
    pub axis: Vector3<f32>,
}

/// Which terms act. All on is the product; springs alone are the papers' plain model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Terms {
    /// Nodal-averaged and per-tet volume energy.
    pub volume: bool,
    /// Compression compensation of springs and the barrier of tets.
    pub compensation: bool,
    /// Rim springs, the far field.
    pub rim: bool,
}

impl Terms {
    /// Every term.
    pub const ALL: Self = Self { volume: true, compensation: true, rim: true };
    /// Springs, masses, contact: the papers' plain mass-spring model.
    pub const SPRINGS_ONLY: Self = Self { volume: false, compensation: false, rim: false };
}

/// Limits at the patch's edge. They can be lowered, never switched off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Fastest probe the patch is shown [m/s].
    pub max_speed_m_per_s: f32,
    /// Largest speed at which the shown probe enters tissue in contact [m/s]. A probe faster than
    /// the waves of the floored masses would crush the first elements before the next ones move.
    /// `palpate_tissue::stable_step::limits` says how fast a patch's elements allow.
    pub max_sink_m_per_s: f32,
    /// Largest force that leaves the tick [N].
    pub max_force_n: f32,
}

impl Limits {
    /// 1 m/s is the fastest tap of a hand holding a stylus; 12 N is the peak force of the strongest
    /// desktop devices (omega.3 class).
    pub const HIGHEST: Self = Self { max_speed_m_per_s: 1.0, max_sink_m_per_s: 1.0, max_force_n: 12.0 };
}

/// Everything a user may set, in SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Params {
    /// Young's modulus [Pa].
    pub youngs_modulus_pa: f32,
    /// Poisson's ratio (1), 0.25 (what springs alone have) up to below 0.5.
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
    /// Mass floor factor f: no node is lighter than `f E D T^2`, D its mean diagonal stiffness over
    /// E, T the tick. Statics do not see it.
    pub mass_floor: f32,
    /// Contact mass factor: what the foundation's stiffness adds to the masses, in units of `K
    /// T^2`.
    pub contact_mass: f32,
    /// Damping of the foundation, as a share of its cap times the step (zeta).
    pub contact_damping: f32,
    /// Largest slope of the foundation, as a share of `m / T^2` of the lightest corner (eta), T the
    /// tick; substeps bear the square of their number more.
    pub contact_cap: f32,
    /// Steps per tick.
    pub substeps: u16,
    /// The tick [s].
    pub tick_s: f32,
    /// The probe.
    pub probe: Probe,
    /// Which terms act.
    pub terms: Terms,
    /// Limits.
    pub limits: Limits,
}

impl Default for Params {
    /// Liver-like tissue under a fingertip. Scalars of the model: measured, see DECISIONS.md.
    fn default() -> Self {
        Self {
            youngs_modulus_pa: 3500.0,
            poisson_ratio: 0.45,
            density_kg_per_m3: 1060.0,
            node_damping_per_s: 40.0,
            gravity_m_per_s2: [0.0; 3],
            compensation: 1.13,
            compensation_threshold: 0.073,
            mass_floor: 4.0,
            contact_mass: 5.0,
            contact_damping: 0.3,
            contact_cap: 1.0,
            substeps: 1,
            tick_s: 1e-3,
            probe: Probe { shape: ProbeShape::Hemisphere, radius_m: 8e-3, axis: Vector3::new(0.0, 0.0, 1.0) },
            terms: Terms::ALL,
            limits: Limits::HIGHEST,
        }
    }
}

/// Parameters as the tick reads them, derived once from [`Params`], so that the tick divides by no
/// user value.
#[derive(Debug)]
pub struct Tuned<'a> {
    pub(crate) terms: Terms,
    pub(crate) probe: Probe,
    pub(crate) limits: Limits,
    /// E [Pa]: forces inside the tick are divided by it.
    pub(crate) youngs_modulus_pa: f32,
    /// Gravity times density over E [1/m]: weight over E per m^3.
    pub(crate) weight: [f32; 3],
    pub(crate) substeps: u16,
    pub(crate) substep_s: f32,
    /// One over the number of substeps.
    pub(crate) substep_share: f32,
    pub(crate) ticks_per_s: f32,
    /// `1 - alpha dt`.
    pub(crate) keep: f32,
    /// `1 - tau_c`.
    pub(crate) onset: f32,
    pub(crate) compensation: f32,
    pub(crate) contact_damping_s: f32,
    /// `E dt / m` of every node [m/s per (N/Pa)], 0 for anchors, shape \[nodes\].
    pub(crate) node_step: &'a mut [f32],
    /// Largest foundation slope over E [m], one per surface triangle.
    pub(crate) cap_m: &'a mut [f32],
}

impl Tuned<'_> {
    /// Inertial mass of a node [kg], floored; infinite for an anchor. `None` past the end.
    #[must_use]
    pub fn mass_kg(&self, node: usize) -> Option<f32> {
        self.node_step.get(node).map(|&step| self.youngs_modulus_pa * self.substep_s / step)
    }

    /// Young's modulus [Pa].
    #[must_use]
    pub fn youngs_modulus_pa(&self) -> f32 {
        self.youngs_modulus_pa
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

    /// Change of every node's velocity in a substep per force over E [m/s per N/Pa], shape
    /// \[nodes\]: zero for anchors, and only for them.
    #[must_use]
    pub fn node_step(&self) -> &[f32] {
        self.node_step
    }

    /// Largest slope of the foundation over E [m], shape \[triangles\].
    #[must_use]
    pub fn cap_m(&self) -> &[f32] {
        self.cap_m
    }

    /// Probe that presses the patch.
    #[must_use]
    pub fn probe(&self) -> &Probe {
        &self.probe
    }
}

impl Params {
    /// Validates and derives. `node_step` and `cap_m` are the caller's memory, at least one entry
    /// per node and per surface triangle.
    ///
    /// # Errors
    /// The first parameter out of range, the first bad item of the model, or memory that is too
    /// small.
    pub fn build<'a>(&self, model: &Model, node_step: &'a mut [f32], cap_m: &'a mut [f32]) -> Result<Tuned<'a>, BuildError> {
        self.check()?;
        model.check()?;
        if self.poisson_ratio != model.poisson_ratio {
            return Err(BuildError::PoissonMismatch { given: self.poisson_ratio, patch: model.poisson_ratio });
        }
        let fits = |item, need, have| match need <= have {
            true => Ok(()),
            false => Err(BuildError::TooLarge { item, need, have }),
        };
        fits("nodes", model.nodes.len(), node_step.len())?;
        fits("surface triangles", model.triangles.len(), cap_m.len())?;
        let node_step = &mut node_step[..model.nodes.len()];
        let cap_m = &mut cap_m[..model.triangles.len()];

        self.weigh(model, node_step, cap_m);
        Ok(self.derive(node_step, cap_m))
    }

    /// Takes these parameters in place of those that `tuned` was built with, where only Young's
    /// modulus differs; the state stays as it is. Between two ticks. They must have passed
    /// [`Params::check`].
    pub fn retune(&self, model: &Model, tuned: &mut Tuned<'_>) {
        let (node_step, cap_m) = (core::mem::take(&mut tuned.node_step), core::mem::take(&mut tuned.cap_m));
        self.weigh(model, node_step, cap_m);
        *tuned = self.derive(node_step, cap_m);
    }

    /// Masses and caps of a model that was checked.
    fn weigh(&self, model: &Model, node_step: &mut [f32], cap_m: &mut [f32]) {
        let e = self.youngs_modulus_pa;
        let dt = self.tick_s / f32::from(self.substeps);
        // masses over E T^2 [m], T the tick: what a stiffness over E is compared with. T, not the
        // substep: the tissue's inertia then does not depend on the number of substeps, and n
        // substeps give n times the margin.
        let tick_squared = self.tick_s * self.tick_s;
        let per_volume = self.density_kg_per_m3 / (e * tick_squared);
        for (mass, node) in node_step.iter_mut().zip(model.nodes) {
            let lumped = per_volume * node.volume_m3;
            let floor = self.mass_floor * node.stiffness_m;
            *mass = (if lumped > floor { lumped } else { floor }) + self.contact_mass * node.contact_m;
        }
        for (cap, triangle) in cap_m.iter_mut().zip(model.triangles) {
            let mut least = f32::INFINITY;
            for (&n, share) in triangle.node.iter().zip(triangle.share) {
                let backed = node_step.get(usize::from(n)).map_or(0.0, |mass| mass * share);
                if backed < least {
                    least = backed;
                }
            }
            *cap = self.contact_cap * least;
        }
        for mass in node_step.iter_mut() {
            *mass = dt / (*mass * tick_squared);
        }
        for &anchor in model.anchors {
            if let Some(step) = node_step.get_mut(usize::from(anchor)) {
                *step = 0.0;
            }
        }
    }

    /// The scalars, with masses and caps as [`Self::build`] left them for these parameters: what a
    /// caller that owns its memory takes anew each tick, at no cost.
    #[must_use]
    pub fn derive<'a>(&self, node_step: &'a mut [f32], cap_m: &'a mut [f32]) -> Tuned<'a> {
        let e = self.youngs_modulus_pa;
        let dt = self.tick_s / f32::from(self.substeps);
        Tuned {
            terms: self.terms,
            probe: self.probe,
            limits: self.limits,
            youngs_modulus_pa: e,
            weight: self.gravity_m_per_s2.map(|g| g * self.density_kg_per_m3 / e),
            substeps: self.substeps,
            substep_s: dt,
            substep_share: 1.0 / f32::from(self.substeps),
            ticks_per_s: 1.0 / self.tick_s,
            keep: 1.0 - self.node_damping_per_s * dt,
            onset: 1.0 - self.compensation_threshold,
            compensation: self.compensation,
            contact_damping_s: self.contact_damping * dt,
            node_step,
            cap_m,
        }
    }

    /// Checks every parameter against its range.
    ///
    /// # Errors
    /// The first one outside, by name, with the range.
    pub fn check(&self) -> Result<(), BuildError> {
        let dt = self.tick_s / f32::from(self.substeps.max(1));
        let highest = Limits::HIGHEST;
        let substeps = f32::from(self.substeps);
        // (name, value, smallest, largest); ranges are wide: they catch a wrong unit, not a bold
        // choice
        let ranges = [
            ("youngs_modulus_pa", self.youngs_modulus_pa, 1.0, 1e9),
            ("poisson_ratio", self.poisson_ratio, 0.25, 0.4999),
            ("density_kg_per_m3", self.density_kg_per_m3, 1.0, 3e4),
            ("tick_s", self.tick_s, 1e-5, 1e-2),
            ("node_damping_per_s", self.node_damping_per_s, 0.0, 1.0 / dt),
            ("compensation", self.compensation, 0.0, 100.0),
            ("compensation_threshold", self.compensation_threshold, 0.0, 0.9),
            ("mass_floor", self.mass_floor, 0.0, 1e3),
            ("contact_mass", self.contact_mass, 0.0, 1e3),
            ("contact_damping", self.contact_damping, 0.0, 1.0),
            ("contact_cap", self.contact_cap, 1e-3, 4.0 * substeps * substeps),
            ("probe.radius_m", self.probe.radius_m, f32::MIN_POSITIVE, 1.0),
            ("limits.max_speed_m_per_s", self.limits.max_speed_m_per_s, f32::MIN_POSITIVE, highest.max_speed_m_per_s),
            ("limits.max_sink_m_per_s", self.limits.max_sink_m_per_s, f32::MIN_POSITIVE, highest.max_sink_m_per_s),
            ("limits.max_force_n", self.limits.max_force_n, 0.0, highest.max_force_n),
            ("gravity_m_per_s2[0]", self.gravity_m_per_s2[0], -100.0, 100.0),
            ("gravity_m_per_s2[1]", self.gravity_m_per_s2[1], -100.0, 100.0),
            ("gravity_m_per_s2[2]", self.gravity_m_per_s2[2], -100.0, 100.0),
            ("probe.axis length", self.probe.axis.norm(), 0.999, 1.001),
            ("substeps", f32::from(self.substeps), 1.0, 1000.0),
        ];
        for (parameter, value, min, max) in ranges {
            if !(min <= value && value <= max) {
                return Err(BuildError::OutOfRange { parameter, value, min, max });
            }
        }
        Ok(())
    }
}
