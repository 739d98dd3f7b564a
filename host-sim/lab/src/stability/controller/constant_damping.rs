//! Constant damping in contact: the sampled spring and damper that Colgate and Schenkel (1997)
//! bound by `b > K T / 2 + |B|`, with the device's own damping `b` and the virtual `B`.

use super::{Law, Seen, Velocity};

#[derive(Clone, Copy, Debug)]
pub(super) struct ConstantDamping {
    n_s_per_m: f32,
    velocity: Velocity,
}

impl ConstantDamping {
    pub(super) fn new(n_s_per_m: f32) -> Self {
        Self { n_s_per_m, velocity: Velocity::new(Velocity::SHARE_50_HZ) }
    }
}

impl Law for ConstantDamping {
    fn force_n(&mut self, seen: &Seen) -> f32 {
        let in_m_per_s = self.velocity.track(seen.depth_m);
        // the damped force never pulls, and free space is not damped
        if seen.model_n > 0.0 { (seen.model_n + self.n_s_per_m * in_m_per_s).max(0.0) } else { seen.model_n }
    }
}
