//! The implicit step in time: Wood, Bossak and Zienkiewicz's member of the generalised-alpha family
//! (*Int. J. Numer. Methods Eng.* 15, 1980; Chung and Hulbert, *J. Appl. Mech.* 60, 1993).
//!
//! Elastic, damping and contact forces are taken at the end of the step, and inertia is weighted
//! between its two ends: `M ((1-alpha) a1 + alpha a0) + c M v1 + R(u1) = 0` with Newmark's
//! `u1 = u0 + dt v0 + dt^2 ((1/2-beta) a0 + beta a1)` and `v1 = v0 + dt ((1-gamma) a0 + gamma a1)`.
//! The spectral radius rho at infinite frequency gives `alpha = (rho-1)/(rho+1)`,
//! `gamma = 1/2 - alpha`, `beta = (1-alpha)^2 / 4`: second order for every rho, and Newmark's
//! average acceleration for rho = 1.
//!
//! With rho = 1, a rigid surface that moves at constant speed makes the velocity of the nodes in
//! contact alternate between zero and twice its speed, and the force alternates too. With rho < 1
//! this oscillation decays by the factor rho per step.

use nalgebra::Vector3;

/// Coefficients of one step.
#[derive(Clone, Copy, Debug)]
pub struct Scheme {
    alpha: f64,
    beta: f64,
    gamma: f64,
}

/// State of motion of all nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct Nodes {
    /// Displacement [m].
    pub displacement_m: Vec<Vector3<f64>>,
    /// Velocity [m/s].
    pub velocity_m_per_s: Vec<Vector3<f64>>,
    /// Acceleration [m/s^2].
    pub acceleration_m_per_s2: Vec<Vector3<f64>>,
}

/// The inertia of one step, written as a spring: its force is `weight_per_s2` times the mass times
/// the distance from the centre.
pub(super) struct Anchored {
    /// Spring constant divided by mass [1/s^2].
    pub weight_per_s2: f64,
    /// Displacement at which the force of the spring is zero [m].
    pub centre_m: Vec<Vector3<f64>>,
}

impl Nodes {
    /// State of `count` nodes at rest.
    pub fn at_rest(count: usize) -> Self {
        let zero = vec![Vector3::zeros(); count];
        Self { displacement_m: zero.clone(), velocity_m_per_s: zero.clone(), acceleration_m_per_s2: zero }
    }
}

impl Scheme {
    /// The scheme with a given spectral radius at infinite frequency, from 0 to 1.
    pub fn new(spectral_radius: f64) -> Self {
        let alpha = (spectral_radius - 1.0) / (spectral_radius + 1.0);
        Self { alpha, beta: 0.25 * (1.0 - alpha) * (1.0 - alpha), gamma: 0.5 - alpha }
    }

    /// The spring that is equivalent to inertia and damping in one step.
    pub(super) fn anchored(&self, nodes: &Nodes, step_s: f64, damping_per_s: f64) -> Anchored {
        let free = self.free(nodes, step_s);
        let weight_per_s2 = (1.0 - self.alpha + damping_per_s * self.gamma * step_s) / (self.beta * step_s * step_s);
        let centre_m = (0..free.len()).map(|n| {
            let a = nodes.acceleration_m_per_s2[n];
            let drifting = nodes.velocity_m_per_s[n] + a * ((1.0 - self.gamma) * step_s);
            free[n] - (a * self.alpha + drifting * damping_per_s) / weight_per_s2
        });
        Anchored { weight_per_s2, centre_m: centre_m.collect() }
    }

    /// State at the end of a step that ends at `displacement_m`.
    pub(super) fn finish(&self, nodes: &Nodes, step_s: f64, displacement_m: Vec<Vector3<f64>>) -> Nodes {
        let free = self.free(nodes, step_s);
        let share = 1.0 / (self.beta * step_s * step_s);
        let acceleration: Vec<_> = displacement_m.iter().zip(&free).map(|(u, free)| (u - free) * share).collect();
        let velocity = nodes.velocity_m_per_s.iter().zip(&nodes.acceleration_m_per_s2).zip(&acceleration);
        let velocity = velocity.map(|((v, a0), a1)| v + (a0 * (1.0 - self.gamma) + a1 * self.gamma) * step_s);
        Nodes { displacement_m, velocity_m_per_s: velocity.collect(), acceleration_m_per_s2: acceleration }
    }

    /// Displacements at the end of the step for zero acceleration there [m].
    fn free(&self, nodes: &Nodes, step_s: f64) -> Vec<Vector3<f64>> {
        let all = nodes.displacement_m.iter().zip(&nodes.velocity_m_per_s).zip(&nodes.acceleration_m_per_s2);
        all.map(|((u, v), a)| u + v * step_s + a * (step_s * step_s * (0.5 - self.beta))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Displacement after one second of an oscillator that starts at 1 m, with a stiffness of
    /// 100/s^2 per mass.
    fn oscillator(spectral_radius: f64, damping_per_s: f64, steps: usize) -> f64 {
        const STIFFNESS_PER_S2: f64 = 100.0;
        let (scheme, step_s) = (Scheme::new(spectral_radius), 1.0 / steps as f64);
        let mut nodes = Nodes::at_rest(1);
        nodes.displacement_m[0].x = 1.0;
        nodes.acceleration_m_per_s2[0].x = -STIFFNESS_PER_S2;
        for _ in 0..steps {
            let spring = scheme.anchored(&nodes, step_s, damping_per_s);
            let u = spring.centre_m[0] * (spring.weight_per_s2 / (spring.weight_per_s2 + STIFFNESS_PER_S2));
            nodes = scheme.finish(&nodes, step_s, vec![u]);
        }
        nodes.displacement_m[0].x
    }

    #[test]
    fn every_member_is_of_second_order_with_damping() {
        let damping_per_s = 3.0_f64;
        let (half, ring) = (0.5 * damping_per_s, (100.0 - 0.25 * damping_per_s * damping_per_s).sqrt());
        let exact = (-half).exp() * (ring.cos() + half / ring * ring.sin());
        for spectral_radius in [1.0, 0.8, 0.5, 0.0] {
            let [coarse, fine] = [200, 400].map(|steps| (oscillator(spectral_radius, damping_per_s, steps) - exact).abs());
            assert!(fine < 2e-3 && (3.3..4.7).contains(&(coarse / fine)), "rho {spectral_radius}: {coarse:e} {fine:e}");
        }
    }
}
