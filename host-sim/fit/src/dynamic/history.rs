//! The force as a function of time.

/// State at the end of one step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Time since the tip left the rest surface [s].
    pub t_s: f64,
    /// Lowest point of the probe [m].
    pub tip_m: [f64; 3],
    /// Depth of the tip along the press [m].
    pub depth_m: f64,
    /// Force of the tissue on the probe [N].
    pub force_n: [f64; 3],
    /// Component of the force along the press, positive out of the tissue [N].
    pub normal_n: f64,
    /// Deepest penetration of the surface into the probe [m], which the penalty contact allows.
    pub penetration_m: f64,
    /// Whether Newton's method converged at the planned step; if not, a shorter one was used.
    pub at_planned_step: bool,
}

/// Force against time.
#[derive(Clone, Debug, PartialEq)]
pub struct History {
    /// Young's modulus of the tissue [Pa].
    pub youngs_modulus_pa: f64,
    /// Nodes of the quadratic mesh, of the piece that was computed.
    pub nodes: usize,
    /// Newton iterations of all steps together.
    pub iterations: usize,
    /// One sample per step, the state at rest first.
    pub samples: Vec<Sample>,
}

impl History {
    /// Force at a time over Young's modulus [m^2], linear between the samples: the three
    /// components. Zero before the first sample, and constant after the last.
    #[must_use]
    pub fn force_over_e_m2(&self, t_s: f64) -> [f64; 3] {
        let next = self.samples.partition_point(|sample| sample.t_s < t_s);
        let over_e = |sample: &Sample| sample.force_n.map(|f| f / self.youngs_modulus_pa);
        match (next.checked_sub(1).and_then(|n| self.samples.get(n)), self.samples.get(next)) {
            (Some(before), Some(after)) => {
                let share = (t_s - before.t_s) / (after.t_s - before.t_s);
                let (low, high) = (over_e(before), over_e(after));
                [0, 1, 2].map(|k| low[k] + (high[k] - low[k]) * share)
            }
            (None, Some(only)) | (Some(only), None) => over_e(only),
            (None, None) => [0.0; 3],
        }
    }

    /// Largest normal force over Young's modulus [m^2].
    #[must_use]
    pub fn peak_over_e_m2(&self) -> f64 {
        self.samples.iter().map(|sample| sample.normal_n).fold(0.0, f64::max) / self.youngs_modulus_pa
    }
}
