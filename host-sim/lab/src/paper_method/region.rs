//! Region of the nodes that are active in a tick: those near the contact (paper 004, section 2.3).
//!
//! * in: the contact of the last tick
//! * out: the region
//! * cost: one comparison per node
//! * failures: none

use palpate::stages::force::foundation::Load;
use palpate::stages::integrate::FASTEST_M_PER_S;
use palpate::{Fault, Model, NodeStep, State, Tuned, Vector3};

/// Ball that contains the rest positions of the active nodes. All other nodes are frozen in place.
#[derive(Clone, Copy, Debug)]
pub struct Region {
    /// Centre of the ball: the contact, on the rest surface [m].
    pub centre_m: Vector3<f32>,
    /// Squared radius of the ball [m^2].
    pub radius_squared_m2: f32,
}

/// Moves the free nodes of the region by one substep, or all free nodes if there is no region;
/// returns their number. `velocity` returns a component of the new velocity [m/s] from the old one,
/// the force over E [N/Pa], and the change of velocity per force over E.
pub fn advance_within(
    region: Option<Region>,
    model: &Model,
    tuned: &Tuned,
    state: &mut State,
    velocity: impl Fn(f32, f32, f32) -> f32,
) -> Result<u16, Fault> {
    let mut active = 0;
    for (n, (&NodeStep { step, .. }, rest)) in tuned.node_step().iter().zip(model.nodes).enumerate() {
        if step == 0.0 {
            continue;
        }
        let node = state.nodes()[n];
        if region.is_some_and(|region| !region.contains(rest.rest_m)) {
            state.place(n, node.position_m(), Vector3::zeros());
            continue;
        }
        active += 1;
        let v = node.velocity_m_per_s().zip_map(&node.force_over_modulus(), |v, f| velocity(v, f, step));
        state.place(n, node.position_m() + v * tuned.substep_s(), v);
        #[expect(clippy::neg_cmp_op_on_partial_ord, reason = "a NaN is not slower than the limit")]
        if !(v.dot(&v) <= FASTEST_M_PER_S * FASTEST_M_PER_S) {
            return Err(Fault::Diverged);
        }
    }
    Ok(active)
}

/// Form of (8), by which the contact pressure follows from force and depth. Neither form contains
/// the radius of the contact; it is unknown which of them was printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContactPressure {
    /// Under a uniform load: `pi E^2 z^2 / (4 (1 - nu^2)^2 F)`.
    UniformLoad,
    /// Under a rigid flat punch: `4 E^2 z^2 / (pi (1 - nu^2)^2 F)`.
    RigidPunch,
}

/// Rule for the region of paper 004: a ball around the contact that reaches as deep as the vertical
/// stress stays above a threshold.
///
/// `F_perp = F_c [1 - h^3/(h^2 + r^2)^(3/2)]` (7, lost in the text: Boussinesq's stress under the
/// centre of a uniformly loaded disc) equals the threshold at `h_max = r sqrt(q/(1-q))`, `q = (1 -
/// F_min/F_c)^(2/3)`. Stress decreases as `1/h^2` but displacement as `1/h`, so the rule cannot
/// bound the error of the force.
#[derive(Clone, Copy, Debug)]
pub struct StressRule {
    /// Threshold of the vertical stress `F_min` [Pa].
    pub least_stress_pa: f32,
    /// Poisson's ratio (1).
    pub poisson_ratio: f32,
    /// Pressure distribution that (8) assumes.
    pub pressure: ContactPressure,
    /// Contact in the last substep; `None` if there was none.
    seen: Option<Seen>,
}

#[derive(Clone, Copy, Debug)]
struct Seen {
    centre_m: Vector3<f32>,
    force_n: f32,
    depth_m: f32,
}

impl StressRule {
    /// Creates the rule without a contact.
    pub fn new(least_stress_pa: f32, poisson_ratio: f32, pressure: ContactPressure) -> Self {
        Self { least_stress_pa, poisson_ratio, pressure, seen: None }
    }

    /// Contact pressure `F_c` of (8) [Pa].
    pub fn pressure_pa(&self, youngs_modulus_pa: f32, force_n: f32, depth_m: f32) -> f32 {
        let plane = youngs_modulus_pa * depth_m / (1.0 - self.poisson_ratio * self.poisson_ratio);
        let factor = match self.pressure {
            ContactPressure::UniformLoad => std::f32::consts::FRAC_PI_4,
            ContactPressure::RigidPunch => 4.0 / std::f32::consts::PI,
        };
        factor * plane * plane / force_n
    }

    /// Radius of the region by (7) [m] under a contact pressure on a disc of radius `radius_m`.
    /// Where (7) gives less than `radius_m`, or nothing because even the contact pressure is below
    /// the threshold, the result is `radius_m`: this is our addition, so that touched nodes can
    /// move.
    pub fn radius_m(&self, pressure_pa: f32, radius_m: f32) -> f32 {
        let share = self.least_stress_pa / pressure_pa;
        if share >= 1.0 {
            return radius_m;
        }
        // the cube root of 1 - s is the cosine of the half angle that the disc subtends at the
        // depth
        let cosine = libm::cbrtf(1.0 - share);
        let deep = radius_m * cosine / (1.0 - cosine * cosine).sqrt();
        if deep > radius_m { deep } else { radius_m }
    }

    /// The region of this tick; `None`, which means that all nodes are active, without contact.
    pub fn select(&self, tuned: &Tuned, state: &State) -> Option<Region> {
        let seen = self.seen.filter(|_| state.in_contact())?;
        let pressure_pa = self.pressure_pa(tuned.youngs_modulus_pa(), seen.force_n, seen.depth_m);
        let radius_m = self.radius_m(pressure_pa, tuned.probe().radius_m);
        Some(Region { centre_m: seen.centre_m, radius_squared_m2: radius_m * radius_m })
    }

    /// Records the contact from the load on the probe.
    pub fn see(&mut self, tuned: &Tuned, load: &Load, tip_m: Vector3<f32>) {
        let square = load.force.dot(&load.force);
        if !(square > 0.0 && load.push > 0.0) {
            self.seen = None;
            return;
        }
        let length = square.sqrt();
        let centre_m = load.rest * (1.0 / load.push);
        let depth_m = (tip_m - centre_m).dot(&load.force) / length;
        self.seen = (depth_m > 0.0).then_some(Seen { centre_m, force_n: length * tuned.youngs_modulus_pa(), depth_m });
    }
}

impl Region {
    /// Whether a node with this rest position is active.
    fn contains(&self, rest_m: [f32; 3]) -> bool {
        let d = Vector3::from(rest_m) - self.centre_m;
        d.dot(&d) <= self.radius_squared_m2
    }
}
