//! Parameters of the core that a scene sets.

use palpate::{Params, Probe, Terms};

use super::{Method, Scene};

impl Scene {
    /// Parameters of the core; `axis` is the unit vector from the tip to the handle.
    #[must_use]
    pub fn params(&self, axis: [f64; 3]) -> Params {
        let tissue = &self.tissue;
        Params {
            youngs_modulus_pa: tissue.youngs_modulus_pa as f32,
            poisson_ratio: tissue.poisson_ratio as f32,
            density_kg_per_m3: tissue.density_kg_per_m3 as f32,
            node_damping_per_s: tissue.node_damping_per_s as f32,
            gravity_m_per_s2: tissue.gravity_m_per_s2.map(|g| g as f32),
            stiffening_b: tissue.most_stiffening_b() as f32,
            relaxation: tissue.relaxation(),
            friction: self.probe.friction as f32,
            tick_s: crate::scene::TICK_S as f32,
            probe: Probe {
                shape: self.probe.shape.of_core(axis),
                radius_m: self.probe.radius_m as f32,
                axis: axis.map(|c| c as f32).into(),
            },
            orientation: self.probe.orientation().map(|part| part as f32),
            terms: match self.solver.method {
                Method::Palpate => Terms::ALL,
                Method::Springs => Terms::SPRINGS_ONLY,
            },
            ..Params::default()
        }
    }
}
