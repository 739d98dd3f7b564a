//! Advances in time: a body under a contact, and a scene under a motion.

use palpate_tissue::scene::Scene;

use super::error::DynamicError;
use super::history::{History, Sample};
use super::inertial::{Inertial, masses_m3};
use super::motion::Motion;
use super::piece::Piece;
use super::scheme::{Nodes, Scheme};
use super::settings::Settings;
use palpate_fit::reference::body::{Body, Contact};
use palpate_fit::reference::minimise::Minimiser;
use palpate_fit::reference::probe::RigidProbe;

/// Number of times that a step may be halved if it does not converge.
const MOST_HALVINGS: usize = 5;
/// Depth, divided by the radius of the probe, below which the penalty stiffness is constant (1).
const LEAST_DEPTH: f64 = 1e-2;
/// Lower limit of the force with which the residual is compared, as a share of the largest so far
/// (1).
const LEAST_FORCE: f64 = 1e-2;

/// Inertia and damping of the tissue.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inertia {
    /// Density over Young's modulus [s^2/m^2].
    pub density_s2_per_m2: f64,
    /// Damping force, divided by mass and velocity [1/s].
    pub damping_per_s: f64,
}

/// A body whose motion is computed step by step.
pub struct March<'a> {
    body: &'a Body,
    inertia: Inertia,
    scheme: Scheme,
    masses_m3: Vec<f64>,
    solver: Minimiser,
    tolerance: f64,
    /// Lower limit of the force over Young's modulus with which residuals are compared [m^2].
    pub least_force_m2: f64,
    /// Displacement, velocity and acceleration of every node.
    pub nodes: Nodes,
}

impl<'a> March<'a> {
    /// A body at rest; `None` if there is not enough memory for the factor.
    pub fn new(body: &'a Body, inertia: Inertia, spectral_radius: f64, tolerance: f64) -> Option<Self> {
        Some(Self {
            body,
            inertia,
            scheme: Scheme::new(spectral_radius),
            masses_m3: masses_m3(body),
            solver: Minimiser::new(body)?,
            tolerance,
            least_force_m2: 0.0,
            nodes: Nodes::at_rest(body.mesh.nodes_m.len()),
        })
    }

    /// Number of Newton iterations so far.
    pub fn iterations(&self) -> usize {
        self.solver.iterations
    }

    /// Advances by one time step, with `contact` at its end. Returns false, without advancing, if
    /// Newton's method does not converge.
    pub fn step(&mut self, step_s: f64, contact: Option<&Contact>) -> bool {
        let anchored = self.scheme.anchored(&self.nodes, step_s, self.inertia.damping_per_s);
        let potential = Inertial {
            body: self.body,
            contact,
            masses_m3: &self.masses_m3,
            density_s2_per_m2: self.inertia.density_s2_per_m2,
            anchored: &anchored,
            least_force_m2: self.least_force_m2,
        };
        let carried = self.nodes.displacement_m.iter().zip(&self.nodes.velocity_m_per_s).map(|(u, v)| u + v * step_s).collect();
        let starts = [carried, self.nodes.displacement_m.clone()];
        for mut displacement_m in starts {
            if self.body.energy(&displacement_m, None).is_some()
                && self.solver.relax(&potential, &mut displacement_m, self.tolerance)
            {
                self.nodes = self.scheme.finish(&self.nodes, step_s, displacement_m);
                return true;
            }
        }
        false
    }
}

/// A scene with a moving probe.
pub(super) struct MovingScene<'a> {
    scene: &'a Scene,
    motion: &'a Motion,
    settings: &'a Settings,
    piece: &'a Piece,
    march: March<'a>,
}

impl<'a> MovingScene<'a> {
    pub fn new(scene: &'a Scene, motion: &'a Motion, settings: &'a Settings, piece: &'a Piece) -> Result<Self, DynamicError> {
        let inertia = Inertia {
            density_s2_per_m2: scene.tissue.density_kg_per_m3 / scene.tissue.youngs_modulus_pa,
            damping_per_s: scene.tissue.node_damping_per_s,
        };
        let march = March::new(&piece.body, inertia, settings.spectral_radius, settings.tolerance)
            .ok_or(DynamicError::Memory { nodes: piece.body.mesh.nodes_m.len() })?;
        Ok(Self { scene, motion, settings, piece, march })
    }

    pub fn run(mut self, mut progress: impl FnMut(f64)) -> Result<History, DynamicError> {
        let mut samples = vec![self.sample(0.0, true)];
        for ends in self.motion.kinks_s().windows(2) {
            let mut t_s = ends[0];
            for step_s in self.settings.steps_s(ends[1] - ends[0]) {
                let planned = self.go(t_s, step_s, 0)?;
                t_s += step_s;
                let sample = self.sample(t_s, planned);
                let force_m2 = sample.normal_n / (self.scene.tissue.youngs_modulus_pa * self.piece.body.copies);
                self.march.least_force_m2 = self.march.least_force_m2.max(LEAST_FORCE * force_m2);
                samples.push(sample);
                progress(t_s);
            }
        }
        Ok(History {
            youngs_modulus_pa: self.scene.tissue.youngs_modulus_pa,
            nodes: self.piece.body.mesh.nodes_m.len(),
            iterations: self.march.iterations(),
            samples,
        })
    }

    /// Advances by one step, or by two halves if Newton's method does not converge. Returns whether
    /// the step was not halved.
    fn go(&mut self, t_s: f64, step_s: f64, halvings: usize) -> Result<bool, DynamicError> {
        if self.march.step(step_s, Some(&self.contact(t_s + step_s))) {
            return Ok(true);
        }
        if halvings == MOST_HALVINGS {
            return Err(DynamicError::Stalled { t_s, depth_m: self.motion.pose(t_s).depth_m });
        }
        self.go(t_s, 0.5 * step_s, halvings + 1)?;
        self.go(t_s + 0.5 * step_s, 0.5 * step_s, halvings + 1)?;
        Ok(false)
    }

    fn contact(&self, t_s: f64) -> Contact {
        let pose = self.motion.pose(t_s);
        let radius_m = self.scene.probe.radius_m;
        let probe = RigidProbe::new(self.scene.probe.shape, radius_m, self.piece.tip_m(&pose), self.piece.axis);
        let softness_m = self.settings.softness * (radius_m * pose.depth_m.max(LEAST_DEPTH * radius_m)).sqrt();
        Contact { probe, penalty_per_m: 1.0 / softness_m }
    }

    fn sample(&self, t_s: f64, at_planned_step: bool) -> Sample {
        let contact = self.contact(t_s);
        let touch = self.piece.body.touch(&self.march.nodes.displacement_m, &contact);
        let mut force = touch.force_m2 * self.scene.tissue.youngs_modulus_pa;
        // the forces on the mirror images have the opposite component
        for k in 0..2 {
            if self.piece.mirror[k] {
                force[k] = 0.0;
            }
        }
        Sample {
            t_s,
            tip_m: contact.probe.tip_m.into(),
            depth_m: self.motion.pose(t_s).depth_m,
            force_n: force.into(),
            normal_n: force.dot(&self.piece.axis),
            penetration_m: touch.penetration_m,
            at_planned_step,
        }
    }
}
