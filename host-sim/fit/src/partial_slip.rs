//! Closed form of a half-space on which a ball with friction is pressed and dragged, for comparison
//! with the friction of the patch.
//!
//! Cattaneo (1938) and Mindlin (1949): a Hertzian contact begins to slip at its edge. For an
//! incompressible half-space, or for a contact that was pressed without tangential force, the
//! tangential force of a drag depends only on the length of the drag divided by the length at which
//! the whole contact slips.

use std::f64::consts::TAU;

/// Numbers of points along the radius of a contact and around it.
const RADIAL: usize = 400;
const AROUND: usize = 64;

/// A ball with friction, pressed into a half-space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PartialSlip {
    /// Coefficient of Coulomb friction (1).
    pub friction: f64,
    /// Poisson's ratio (1).
    pub poisson_ratio: f64,
    /// Depth of the press [m].
    pub depth_m: f64,
}

impl PartialSlip {
    /// Length of a drag at which the whole contact slips [m]: `mu (E* / G*) d`.
    #[must_use]
    pub fn slips_m(&self) -> f64 {
        let nu = self.poisson_ratio;
        self.friction * (2.0 - nu) / (2.0 * (1.0 - nu)) * self.depth_m
    }

    /// Tangential force divided by mu N (1), after a drag of `over_slips` times the length
    /// [`slips_m`](Self::slips_m).
    #[must_use]
    pub fn share(over_slips: f64) -> f64 {
        1.0 - (1.0 - over_slips.min(1.0)).powf(1.5)
    }
}

/// Friction force of a sliding ball, divided by mu times the resultant of its normal forces (1).
/// The depth is `depth` times the radius. Normal forces act along the local normal, and slip is
/// along the local surface. Under Hertz's pressure the ratio is `1 + depth / 10` to first order.
#[must_use]
pub fn tilted(depth: f64) -> f64 {
    let (mut friction, mut push) = (0.0, 0.0);
    for n in 0..RADIAL {
        let r = (n as f64 + 0.5) / RADIAL as f64;
        let pressure = r * (1.0 - r * r).sqrt();
        let sine = r * depth.sqrt();
        push += pressure * (1.0 - sine * sine).sqrt();
        let around = (0..AROUND).map(|k| (sine * (TAU * (k as f64 + 0.5) / AROUND as f64).cos()).powi(2));
        friction += pressure * around.map(|along| (1.0 - along).sqrt()).sum::<f64>() / AROUND as f64;
    }
    friction / push
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_of_springs_slips_as_cattaneo_and_mindlin_say() {
        // dimensionality reduction: the spring at x bears E* (d - x^2 / R), and G* per tangential
        // displacement
        let slip = PartialSlip { friction: 0.3, poisson_ratio: 0.45, depth_m: 2e-3 };
        let stiffness = 2.0 * (1.0 - slip.poisson_ratio) / (2.0 - slip.poisson_ratio);
        for over_slips in [0.05, 0.3, 0.7, 0.99, 1.5] {
            let (mut force, mut limit) = (0.0, 0.0);
            for n in 0..4000 {
                let x = (f64::from(n) + 0.5) / 4000.0;
                let most = slip.friction * slip.depth_m * (1.0 - x * x);
                force += (stiffness * over_slips * slip.slips_m()).min(most);
                limit += most;
            }
            let expected = PartialSlip::share(over_slips);
            assert!((force / limit - expected).abs() < 1e-5, "{over_slips}: {} for {expected}", force / limit);
        }
    }

    #[test]
    fn tilted_pushes_bear_a_tenth_of_the_depth_more() {
        assert_eq!(tilted(0.0), 1.0);
        assert!((tilted(1e-3) - 1.0 - 1e-4).abs() < 1e-6, "{}", tilted(1e-3));
        assert!((1.026..1.029).contains(&tilted(0.25)), "{}", tilted(0.25));
    }
}
