//! Checks parameters against their ranges.

use super::{GuardLimits, MOST_FRICTION, MOST_STIFFENING, Params, prony};
use crate::fault::BuildError;
use crate::lanes::square_root;

const HIGHEST: GuardLimits = GuardLimits::HIGHEST;
/// Name of each parameter, its smallest and its largest value, in the order of [`Params::ranged`].
/// The ranges are wide: they catch a wrong unit, not a bold choice.
const RANGES: [(&str, f32, f32); 19] = [
    ("youngs_modulus_pa", 1.0, 1e9),
    ("poisson_ratio", 0.25, 0.4999),
    ("density_kg_per_m3", 1.0, 3e4),
    ("tick_s", 1e-5, 1e-2),
    ("compensation", 0.0, 100.0),
    ("compensation_threshold", 0.0, 0.9),
    ("mass_floor", 0.0, 1e3),
    ("contact_damping", 0.0, 1.0),
    ("friction", 0.0, MOST_FRICTION),
    ("stiffening_b", 0.0, MOST_STIFFENING),
    ("probe.radius_m", f32::MIN_POSITIVE, 1.0),
    ("limits.max_speed_m_per_s", f32::MIN_POSITIVE, HIGHEST.max_speed_m_per_s),
    ("limits.max_sink_m_per_s", f32::MIN_POSITIVE, HIGHEST.max_sink_m_per_s),
    ("limits.max_force_n", 0.0, HIGHEST.max_force_n),
    ("gravity_m_per_s2[0]", -100.0, 100.0),
    ("gravity_m_per_s2[1]", -100.0, 100.0),
    ("gravity_m_per_s2[2]", -100.0, 100.0),
    ("probe.axis length", 0.999, 1.001),
    ("substeps", 1.0, 1000.0),
];

impl Params {
    fn ranged(&self) -> [f32; RANGES.len()] {
        let [gravity_x, gravity_y, gravity_z] = self.gravity_m_per_s2;
        [
            self.youngs_modulus_pa,
            self.poisson_ratio,
            self.density_kg_per_m3,
            self.tick_s,
            self.compensation,
            self.compensation_threshold,
            self.mass_floor,
            self.contact_damping,
            self.friction,
            self.stiffening_b,
            self.probe.radius_m,
            self.limits.max_speed_m_per_s,
            self.limits.max_sink_m_per_s,
            self.limits.max_force_n,
            gravity_x,
            gravity_y,
            gravity_z,
            square_root(self.probe.axis.dot(&self.probe.axis)),
            f32::from(self.substeps),
        ]
    }

    /// Checks every parameter against its range.
    ///
    /// # Errors
    /// Returns the name and the range of the first parameter outside its range.
    #[inline]
    pub fn check(&self) -> Result<(), BuildError> {
        for (value, (parameter, min, max)) in self.ranged().into_iter().zip(RANGES) {
            BuildError::within(parameter, value, min, max)?;
        }
        let dt = self.tick_s / f32::from(self.substeps);
        BuildError::within("node_damping_per_s", self.node_damping_per_s, 0.0, 1.0 / dt)?;
        #[cfg(feature = "long-tips")]
        self.probe.check_shape()?;
        #[cfg(feature = "long-tips")]
        self.probe.check_turn(self.orientation)?;
        prony::check(self.relaxes(), self.tick_s)
    }
}
