//! Resolution of a dynamic computation in space, time and contact.

use super::error::DynamicError;

/// Resolution in space, time and contact with which a motion is computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Number of corner nodes of the piece that is meshed: a quarter, a half or the whole of a
    /// block.
    pub corner_nodes: usize,
    /// Distance from the probe's path within which elements are smallest [m]; by default slightly
    /// more than the largest contact radius.
    pub fine_radius_m: Option<f64>,
    /// Longest time step [s].
    pub step_s: f64,
    /// First step after a kink of the motion, as a share of the longest (1).
    pub first_step_share: f64,
    /// Ratio of each step to the previous one, until the longest is reached (1).
    pub step_growth: f64,
    /// Spectral radius of the scheme at infinite frequency (1): 1 is Newmark's average
    /// acceleration, and smaller values damp unresolved motion numerically.
    pub spectral_radius: f64,
    /// Penetration at a contact pressure equal to Young's modulus, as a share of sqrt(radius x
    /// depth) (1).
    pub softness: f64,
    /// Residual at which Newton's method stops, as a share of the contact force (1).
    pub tolerance: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            corner_nodes: 500,
            fine_radius_m: None,
            step_s: 1e-3,
            first_step_share: 0.125,
            step_growth: 1.3,
            spectral_radius: 0.5,
            softness: 5e-4,
            tolerance: 3e-4,
        }
    }
}

impl Settings {
    /// Checks every setting against its range.
    pub fn check(&self) -> Result<(), DynamicError> {
        let ranges = [
            ("step_s", self.step_s, 1e-6, 1e-1, "from 1e-6 to 0.1 s"),
            ("first_step_share", self.first_step_share, 1e-3, 1.0, "from 0.001 to 1"),
            ("step_growth", self.step_growth, 1.0, 4.0, "from 1 to 4"),
            ("spectral_radius", self.spectral_radius, 0.0, 1.0, "from 0 to 1"),
            ("softness", self.softness, 1e-6, 1e-1, "from 1e-6 to 0.1"),
            ("tolerance", self.tolerance, 1e-9, 1e-1, "from 1e-9 to 0.1"),
            ("fine_radius_m", self.fine_radius_m.unwrap_or(1e-3), 1e-6, 1.0, "from 1e-6 to 1 m"),
        ];
        match ranges.into_iter().find(|(_, value, low, high, _)| !(low..=high).contains(&value)) {
            Some((key, value, _, _, range)) => Err(DynamicError::Setting { key, value, range }),
            None => Ok(()),
        }
    }

    /// Lengths of the steps between two kinks [s]. They grow from the first to the longest, and
    /// their sum is `whole_s`.
    pub fn steps_s(&self, whole_s: f64) -> Vec<f64> {
        let (mut steps_s, mut sum_s) = (Vec::new(), 0.0);
        let mut next_s = self.step_s * self.first_step_share;
        while sum_s < whole_s * (1.0 - 1e-9) {
            steps_s.push(next_s);
            sum_s += next_s;
            next_s = (next_s * self.step_growth).min(self.step_s);
        }
        // every step is shortened slightly, so that the last one ends at the kink
        steps_s.iter().map(|step_s| step_s * whole_s / sum_s).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_grow_and_end_at_the_kink() {
        let settings = Settings { step_s: 1e-3, first_step_share: 0.25, step_growth: 1.5, ..Settings::default() };
        let steps_s = settings.steps_s(0.0205);
        assert!((steps_s.iter().sum::<f64>() - 0.0205).abs() < 1e-12);
        assert!(steps_s.iter().all(|s| *s <= 1e-3) && steps_s[0] <= 0.25e-3);
        assert!(steps_s.windows(2).all(|pair| pair[1] >= pair[0] * (1.0 - 1e-12)));
    }

    #[test]
    fn a_bad_setting_is_named() {
        let refused = Settings { spectral_radius: 1.5, ..Settings::default() }.check();
        assert!(matches!(refused, Err(DynamicError::Setting { key: "spectral_radius", .. })));
        assert!(Settings { step_s: f64::NAN, ..Settings::default() }.check().is_err());
    }
}
