//! A limit on the change of the force per tick, upwards and downwards, as many drivers have by
//! default.

use super::{Law, Seen};

#[derive(Clone, Copy, Debug)]
pub(super) struct Slew {
    n_per_tick: f32,
    sent_n: f32,
}

impl Slew {
    pub(super) fn new(n_per_tick: f32) -> Self {
        Self { n_per_tick, sent_n: 0.0 }
    }
}

impl Law for Slew {
    fn force_n(&mut self, seen: &Seen) -> f32 {
        self.sent_n = seen.model_n.clamp(self.sent_n - self.n_per_tick, self.sent_n + self.n_per_tick);
        self.sent_n
    }
}
