//! The force through one pole at 50 Hz, a common remedy against buzz.

use super::{Law, Seen, Velocity};

/// Filtered force outside the tissue below which it is set to zero [N].
const GONE_N: f32 = 1e-3;

#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LowPass {
    sent_n: f32,
}

impl Law for LowPass {
    fn force_n(&mut self, seen: &Seen) -> f32 {
        self.sent_n += Velocity::SHARE_50_HZ * (seen.model_n - self.sent_n);
        if seen.model_n == 0.0 && self.sent_n < GONE_N {
            self.sent_n = 0.0;
        }
        self.sent_n
    }
}
