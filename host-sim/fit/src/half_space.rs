//! Closed form of a relaxing half-space under a ball, for comparison with a patch that relaxes.
//!
//! The method of dimensionality reduction (Popov, Willert, Hess, Handbook of Contact Mechanics,
//! 2018) maps a paraboloid on a viscoelastic half-space *exactly* to a row of independent Maxwell
//! chains: element x is pressed by `d - x^2 / R`, loses contact where its force would become
//! tensile, and then relaxes by itself. Loading and hold are Lee and Radok's solution (1960),
//! unloading is Ting's (1966). Both are also implemented as integrals, to verify the row.
//!
//! All computations are in double precision and use no code of the patch.

/// A ball that is pressed into a relaxing half-space.
#[derive(Clone, Debug, PartialEq)]
pub struct HalfSpace {
    /// Radius of the ball [m].
    pub radius_m: f64,
    /// Instantaneous modulus, `E / (1 - nu^2)` [Pa].
    pub plane_modulus_pa: f64,
    /// Share (1) and relaxation time [s] of each Prony term.
    pub terms: Vec<(f64, f64)>,
}

/// Number of elements on half of the row.
const ELEMENTS: usize = 400;

/// A spring with parallel Maxwell elements, one per Prony term.
#[derive(Clone, Debug, Default)]
pub(crate) struct Chain {
    /// Compression at the end of the last step [m]: imposed by the probe, or the free one without
    /// contact.
    before_m: f64,
    /// Part of the compression that the spring of each term still carries [m].
    borne_m: Vec<f64>,
}

impl HalfSpace {
    /// Share of the response to a step that remains `t_s` seconds later (1).
    #[must_use]
    pub fn left(&self, t_s: f64) -> f64 {
        self.terms.iter().fold(1.0, |left, (share, time_s)| left - share * (1.0 - (-t_s / time_s).exp()))
    }

    /// Forces of the row [N] at the depths `depths_m`, which are `dt_s` apart, for any motion from
    /// rest.
    #[must_use]
    pub fn forces_n(&self, depths_m: &[f64], dt_s: f64) -> Vec<f64> {
        let deepest_m = depths_m.iter().copied().fold(0.0, f64::max);
        let dx_m = (self.radius_m * deepest_m).sqrt() / ELEMENTS as f64;
        let chain = Chain::new(self.terms.len());
        let mut row = vec![chain; ELEMENTS];
        let mut force_n = |depth_m: &f64| {
            let pushes_m = row.iter_mut().enumerate().map(|(n, chain)| {
                let x_m = (n as f64 + 0.5) * dx_m;
                chain.step(&self.terms, depth_m - x_m * x_m / self.radius_m, dt_s)
            });
            2.0 * self.plane_modulus_pa * dx_m * pushes_m.sum::<f64>()
        };
        depths_m.iter().map(&mut force_n).collect()
    }

    /// Hertz's force [N] at a depth, which is the instantaneous response of the half-space.
    #[must_use]
    pub fn hertz_n(&self, depth_m: f64) -> f64 {
        4.0 / 3.0 * self.plane_modulus_pa * self.radius_m.sqrt() * depth_m.max(0.0).powf(1.5)
    }

    /// Lee and Radok's force [N] at the end of a motion without reversal. `elastic_n` are the
    /// forces of an elastic body during the motion, `dt_s` apart: Hertz's, or those of any other
    /// body.
    #[must_use]
    pub fn loaded_n(&self, elastic_n: &[f64], dt_s: f64) -> f64 {
        self.history(elastic_n, dt_s, elastic_n.len())
    }

    /// Ting's force [N] at the end of a motion with one reversal. It takes the history up to the
    /// time at which the contact had the same radius during loading.
    #[must_use]
    pub fn retreating_n(&self, elastic_n: &[f64], depths_m: &[f64], dt_s: f64) -> f64 {
        let mut relaxed_m = 0.0;
        let end = depths_m.len();
        for n in (1..end).rev() {
            relaxed_m += self.left(((end - n) as f64 - 0.5) * dt_s) * (depths_m[n] - depths_m[n - 1]);
            if relaxed_m >= 0.0 {
                return self.history(elastic_n, dt_s, n);
            }
        }
        0.0
    }

    /// Depth [m] at which the ball loses contact during unloading: the first at which the relaxed
    /// depth, `int G(t - s) d'(s) ds`, returns to zero. `None` if it never does.
    #[must_use]
    pub fn lifts_off_m(&self, depths_m: &[f64], dt_s: f64) -> Option<f64> {
        let mut chain = Chain::new(self.terms.len());
        let mut loaded = false;
        depths_m.iter().copied().find(|depth_m| {
            let push_m = chain.step(&self.terms, *depth_m, dt_s);
            loaded |= push_m > 0.0;
            loaded && push_m <= 0.0
        })
    }

    /// `int G(t - s) dF` over the first `until` forces of an elastic body, evaluated at the end of
    /// the motion.
    fn history(&self, elastic_n: &[f64], dt_s: f64, until: usize) -> f64 {
        let end = elastic_n.len();
        (1..until).map(|n| self.left(((end - n) as f64 - 0.5) * dt_s) * (elastic_n[n] - elastic_n[n - 1])).sum()
    }
}

impl Chain {
    /// A chain at rest with this number of Maxwell elements.
    pub(crate) fn new(terms: usize) -> Self {
        Self { before_m: 0.0, borne_m: vec![0.0; terms] }
    }

    /// Advances by one step with the probe at a depth of `probe_m`; returns the force divided by
    /// the stiffness [m].
    pub(crate) fn step(&mut self, terms: &[(f64, f64)], probe_m: f64, dt_s: f64) -> f64 {
        let steps = |time_s: f64| {
            let kept = (-dt_s / time_s).exp();
            (kept, (1.0 - kept) * time_s / dt_s)
        };
        // force over stiffness = at_once * compression + memory
        let (mut at_once, mut memory_m) = (1.0, 0.0);
        for ((share, time_s), borne_m) in terms.iter().zip(&self.borne_m) {
            let (kept, rise) = steps(*time_s);
            at_once += share * (rise - 1.0);
            memory_m += kept * borne_m - share * rise * self.before_m;
        }
        let free_m = -memory_m / at_once;
        let stretch_m = probe_m.max(free_m);
        for ((share, time_s), borne_m) in terms.iter().zip(&mut self.borne_m) {
            let (kept, rise) = steps(*time_s);
            *borne_m = kept * *borne_m + share * rise * (stretch_m - self.before_m);
        }
        self.before_m = stretch_m;
        at_once * (stretch_m - free_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DT_S: f64 = 1e-3;

    fn meat() -> HalfSpace {
        HalfSpace { radius_m: 8e-3, plane_modulus_pa: 4e3, terms: vec![(0.26, 0.4), (0.31, 4.4)] }
    }

    /// Depths of a press to 4 mm in 0.4 s, a hold of 2 s and a retraction in 0.4 s.
    fn motion() -> Vec<f64> {
        (0..2900).map(|n| 1e-5 * f64::from(n.min(400)).min(f64::from(2800 - n)).max(-50.0)).collect()
    }

    #[test]
    fn the_row_loads_and_holds_as_lee_and_radok_and_retreats_as_ting() {
        let (space, depths_m) = (meat(), motion());
        let row_n = space.forces_n(&depths_m, DT_S);
        let hertz_n: Vec<f64> = depths_m.iter().map(|d| space.hertz_n(*d)).collect();
        let peak_n = row_n.iter().copied().fold(0.0, f64::max);
        for (until, integral) in [(200, true), (401, true), (2000, true), (2450, false), (2500, false), (2600, false)] {
            let (past, elastic_n) = (&depths_m[..until], &hertz_n[..until]);
            let expected_n = if integral { space.loaded_n(elastic_n, DT_S) } else { space.retreating_n(elastic_n, past, DT_S) };
            let found_n = row_n[until - 1];
            assert!((found_n - expected_n).abs() < 3e-3 * peak_n, "tick {until}: {found_n} N for {expected_n} N");
        }
    }

    #[test]
    fn it_lifts_off_where_the_row_has_no_force_left() {
        let (space, depths_m) = (meat(), motion());
        let off_m = space.lifts_off_m(&depths_m, DT_S).unwrap();
        let last = space.forces_n(&depths_m, DT_S).iter().rposition(|n| *n > 0.0).unwrap();
        assert!((depths_m[last] - off_m).abs() < 3e-5, "{} and {off_m}", depths_m[last]);
        assert!((1e-3..3e-3).contains(&off_m), "{off_m} m of 4 mm");
    }

    #[test]
    fn without_terms_it_is_hertz_in_and_out() {
        let space = HalfSpace { terms: Vec::new(), ..meat() };
        let depths_m = motion();
        for (n, force_n) in space.forces_n(&depths_m, DT_S).iter().enumerate().step_by(100) {
            let hertz_n = 4.0 / 3.0 * 4e3 * 8e-3_f64.sqrt() * depths_m[n].max(0.0).powf(1.5);
            assert!((space.hertz_n(depths_m[n]) - hertz_n).abs() < 1e-12);
            assert!((force_n - hertz_n).abs() < 1e-6 + 1e-3 * hertz_n, "{force_n} {hertz_n}");
        }
    }
}
