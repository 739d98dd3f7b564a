//! Finds the equilibrium under the probe, in steps of depth.

use nalgebra::Vector3;

use super::body::Contact;
use super::body::{Assembled, Body};
use super::minimise::{Minimiser, Potential};
use super::probe::RigidProbe;
use super::touch::Touch;

/// Penetration of the surface into the probe at a contact pressure equal to Young's modulus, as a
/// share of sqrt(radius x depth) (1). As the pressure of a round probe rises with sqrt(depth /
/// radius), the penetration remains about this share of the depth.
const SOFTNESS: f64 = 1.5e-4;
/// Depth, divided by the radius, below which the penalty stiffness is constant (1).
const LEAST_DEPTH: f64 = 1e-3;
/// Largest step of depth [probe radii].
const STEP_RADII: f64 = 0.125;
/// Smallest step of depth, as a share of the largest (1).
const LEAST_STEP: f64 = 1.0 / 32.0;
/// Norm of the residual divided by the contact force, at holds and in between (1).
const TOLERANCE: f64 = 1e-8;
const LOOSE: f64 = 1e-2;

/// A body that is pressed by a probe.
pub struct Press<'a> {
    body: &'a Body,
    probe: RigidProbe,
    place_m: Vector3<f64>,
    /// Unit vector against the press.
    up: Vector3<f64>,
    solver: Minimiser,
    /// Displacement of every node [m].
    pub displacement_m: Vec<Vector3<f64>>,
    before_m: Vec<Vector3<f64>>,
    depth_m: f64,
    last_step_m: f64,
}

/// Error of a press that cannot go deeper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stalled {
    /// Depth of the deepest equilibrium that was found [m].
    pub reached_m: f64,
}

impl<'a> Press<'a> {
    /// Places the tip of the probe at `place_m` on the surface of the tissue at rest; `None` if
    /// there is not enough memory for the factor.
    #[must_use]
    pub fn new(body: &'a Body, probe: RigidProbe, place_m: Vector3<f64>) -> Option<Self> {
        let rest = vec![Vector3::zeros(); body.mesh.nodes_m.len()];
        Some(Self {
            body,
            probe,
            place_m,
            up: probe.axis,
            solver: Minimiser::new(body)?,
            displacement_m: rest.clone(),
            before_m: rest,
            depth_m: 0.0,
            last_step_m: 0.0,
        })
    }

    /// Presses against this unit vector instead of along the probe, which may be tilted.
    #[must_use]
    pub fn against(self, up: Vector3<f64>) -> Self {
        Self { up, ..self }
    }

    /// Number of entries of the Cholesky factor.
    #[must_use]
    pub fn factor_entries(&self) -> usize {
        self.solver.factor_entries()
    }

    /// Number of Newton iterations so far.
    #[must_use]
    pub fn iterations(&self) -> usize {
        self.solver.iterations
    }

    /// Depth of the tip [m].
    #[must_use]
    pub fn depth_m(&self) -> f64 {
        self.depth_m
    }

    /// Contact with the probe at a depth.
    #[must_use]
    pub fn contact(&self, depth_m: f64) -> Contact {
        let probe = RigidProbe { tip_m: self.place_m - self.up * depth_m, ..self.probe };
        let softness_m = SOFTNESS * (self.probe.radius_m * depth_m.abs().max(LEAST_DEPTH * self.probe.radius_m)).sqrt();
        Contact { probe, penalty_per_m: 1.0 / softness_m }
    }

    /// Returns force, penetration and contact area of the probe in the present state.
    #[must_use]
    pub fn touch(&self) -> Touch {
        self.body.touch(&self.displacement_m, &self.contact(self.depth_m))
    }

    /// Force along the press over Young's modulus [m^2], positive out of the tissue.
    #[must_use]
    pub fn force_over_e_m2(&self) -> f64 {
        self.touch().force_m2.dot(&self.up)
    }

    /// Presses or releases to a depth, in as many steps as necessary, and calls `progress` with the
    /// depth [m] after each.
    ///
    /// # Errors
    /// Fails if no equilibrium is found beyond some depth; the last one remains.
    pub fn go_to(&mut self, target_m: f64, mut progress: impl FnMut(f64)) -> Result<(), Stalled> {
        let largest_m = STEP_RADII * self.probe.radius_m;
        let mut step_m = largest_m;
        while self.depth_m != target_m {
            let left_m = target_m - self.depth_m;
            let last = left_m.abs() <= step_m * 1.001;
            let to_m = if last { target_m } else { self.depth_m + step_m * left_m.signum() };
            let kept = self.displacement_m.clone();
            self.predict(to_m);
            let mut found = self.settle(to_m, if last { TOLERANCE } else { LOOSE });
            if !found {
                // second attempt, without the prediction
                self.displacement_m.clone_from(&kept);
                found = self.settle(to_m, if last { TOLERANCE } else { LOOSE });
            }
            if found {
                self.last_step_m = to_m - self.depth_m;
                self.depth_m = to_m;
                self.before_m = kept;
                step_m = (2.0 * step_m).min(largest_m);
                progress(to_m);
            } else {
                self.displacement_m = kept;
                step_m = 0.5 * step_m.min(left_m.abs());
                if step_m < LEAST_STEP * largest_m {
                    return Err(Stalled { reached_m: self.depth_m });
                }
            }
        }
        Ok(())
    }

    /// Moves directly to a depth, starting from the equilibrium of an almost identical body at that
    /// depth. Returns false if no equilibrium is found; the state is then unchanged.
    pub fn start_from(&mut self, displacement_m: &[Vector3<f64>], depth_m: f64) -> bool {
        let kept = std::mem::replace(&mut self.displacement_m, displacement_m.to_vec());
        let (last_step_m, before_m) = (self.last_step_m, self.depth_m);
        self.last_step_m = if depth_m == before_m { depth_m } else { depth_m - before_m };
        if self.settle(depth_m, TOLERANCE) {
            (self.before_m, self.depth_m) = (kept, depth_m);
            return true;
        }
        (self.displacement_m, self.last_step_m) = (kept, last_step_m);
        false
    }

    /// Extrapolates the displacement of the last step.
    fn predict(&mut self, to_m: f64) {
        if self.last_step_m == 0.0 {
            return;
        }
        let share = (to_m - self.depth_m) / self.last_step_m;
        let ahead: Vec<_> =
            self.displacement_m.iter().zip(&self.before_m).map(|(now, before)| now + (now - before) * share).collect();
        if self.body.energy(&ahead, None).is_some() {
            self.displacement_m = ahead;
        }
    }

    /// Runs Newton's method at one depth; returns false if it does not converge.
    fn settle(&mut self, depth_m: f64, tolerance: f64) -> bool {
        let contact = self.contact(depth_m);
        self.solver.relax(&Pressed { body: self.body, contact: &contact }, &mut self.displacement_m, tolerance)
    }
}

/// Potential of the body under the probe.
struct Pressed<'a> {
    body: &'a Body,
    contact: &'a Contact,
}

impl Potential for Pressed<'_> {
    fn body(&self) -> &Body {
        self.body
    }

    fn contact(&self) -> Option<&Contact> {
        Some(self.contact)
    }

    fn energy(&self, displacement_m: &[Vector3<f64>]) -> Option<f64> {
        self.body.energy(displacement_m, None)
    }

    fn assemble(&self, displacement_m: &[Vector3<f64>], tangent: bool) -> Option<Assembled> {
        self.body.derive(displacement_m, tangent)
    }

    fn force_m2(&self, displacement_m: &[Vector3<f64>], _: &Assembled) -> f64 {
        self.body.touch(displacement_m, self.contact).force_m2.norm() / self.body.copies
    }
}
