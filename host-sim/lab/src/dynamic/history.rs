//! The force on the probe as a function of time.

/// State at the end of one time step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Time since the tip left the rest surface [s].
    pub t_s: f64,
    /// Position of the tip, the foremost point of the probe [m].
    pub tip_m: [f64; 3],
    /// Depth of the tip below the rest surface, along the press [m].
    pub depth_m: f64,
    /// Force of the tissue on the probe [N].
    pub force_n: [f64; 3],
    /// Component of the force along the press [N]; positive out of the tissue.
    pub normal_n: f64,
    /// Largest penetration of the surface into the probe [m], which the penalty contact permits.
    pub penetration_m: f64,
    /// Whether Newton's method converged with the planned step; otherwise shorter steps were used.
    pub at_planned_step: bool,
}

/// Force on the probe over time.
#[derive(Clone, Debug, PartialEq)]
pub struct History {
    /// Young's modulus of the tissue [Pa].
    pub youngs_modulus_pa: f64,
    /// Number of nodes of the quadratic mesh of the piece that was computed.
    pub nodes: usize,
    /// Number of Newton iterations, summed over all steps.
    pub iterations: usize,
    /// One sample per step, after the state at rest.
    pub samples: Vec<Sample>,
}

impl History {
    /// The three components of the force over Young's modulus at a time [m^2], interpolated
    /// linearly between the samples. Before the first sample and after the last the force is
    /// constant.
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
    pub fn peak_over_e_m2(&self) -> f64 {
        self.samples.iter().map(|sample| sample.normal_n).fold(0.0, f64::max) / self.youngs_modulus_pa
    }
}
