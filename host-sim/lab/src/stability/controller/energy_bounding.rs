//! Energy bounding, after Kim and Ryu: the force rises no faster with displacement than the
//! device's own damping absorbs, and never while the handle retreats. Their published law was not
//! found; this is its simplest interpretation, with `c = 2 b / T`, the stiffness up to which
//! damping absorbs the energy of a held force: `b > K T / 2 + |B|` without virtual damping, `B = 0`
//! (Colgate and Schenkel, 1997).

use super::{Known, Law, Seen, TICK_S};

#[derive(Clone, Copy, Debug)]
pub(super) struct EnergyBounding {
    /// Steepest rise of the force with displacement [N/m].
    most_n_per_m: f32,
    max_force_n: f32,
    depth_m: f32,
    sent_n: f32,
}

impl EnergyBounding {
    pub(super) fn new(device: &Known) -> Self {
        let most_n_per_m = 2.0 * device.damping_n_s_per_m / TICK_S;
        Self { most_n_per_m, max_force_n: device.max_force_n, depth_m: 0.0, sent_n: 0.0 }
    }
}

impl Law for EnergyBounding {
    fn force_n(&mut self, seen: &Seen) -> f32 {
        // motion outside the tissue does not count as displacement: a touch begins at the surface
        let displacement_m = seen.depth_m.max(0.0) - self.depth_m.max(0.0);
        let most_n = self.sent_n + self.most_n_per_m * displacement_m.max(0.0);
        self.sent_n = seen.model_n.min(most_n).clamp(0.0, self.max_force_n);
        self.depth_m = seen.depth_m;
        self.sent_n
    }
}
