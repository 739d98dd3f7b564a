//! A virtual coupling (Colgate, Stanley and Brown, IROS 1995): the hand feels a spring and a damper
//! to a proxy, and the proxy rests where the model balances the spring. The proxy has no mass: one
//! Newton step per tick brings it to its equilibrium, at once on a plain spring.

use super::{Law, Seen, Velocity};

/// Stiffness of the coupling, the largest that the hand can feel [N/m].
const N_PER_M: f32 = 500.0;
/// Damping of the coupling [N s/m].
const N_S_PER_M: f32 = 2.0;

#[derive(Clone, Copy, Debug)]
pub(super) struct VirtualCoupling {
    velocity: Velocity,
    /// Depth of the proxy [m], and the model's force [N] and stiffness [N/m] at that depth.
    proxy_m: f32,
    model_n: f32,
    tangent_n_per_m: f32,
}

impl Default for VirtualCoupling {
    fn default() -> Self {
        Self { velocity: Velocity::new(Velocity::SHARE_50_HZ), proxy_m: 0.0, model_n: 0.0, tangent_n_per_m: 0.0 }
    }
}

impl Law for VirtualCoupling {
    fn shown_m(&mut self, depth_m: f32) -> f32 {
        let wants_n = N_PER_M * (depth_m - self.proxy_m) - self.model_n;
        self.proxy_m = if depth_m > 0.0 { self.proxy_m + wants_n / (N_PER_M + self.tangent_n_per_m) } else { depth_m };
        self.proxy_m
    }

    fn force_n(&mut self, seen: &Seen) -> f32 {
        let in_m_per_s = self.velocity.track(seen.depth_m);
        (self.model_n, self.tangent_n_per_m) = (seen.model_n, seen.tangent_n_per_m);
        let stretched_m = seen.depth_m - self.proxy_m;
        if seen.model_n > 0.0 { (N_PER_M * stretched_m + N_S_PER_M * in_m_per_s).max(0.0) } else { 0.0 }
    }
}
